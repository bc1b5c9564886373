//! The observers with which the laboratory follows its runs: one passes on the progress and stops for checkpoints, one
//! records the measurements and tells each state, and one writes snapshots.

use std::cell::RefCell;

use granum_core::ObservedState;
use granum_core::assembly::Assembly;
use granum_core::observer::Event;
use granum_core::quantity::format_number;
use granum_dem::config::RecordedColumns;
use granum_dem::loading::{Measure, StageProgress};
use granum_dem::observer::{Flow, SimulationObserver, SimulationProgress, Work};
use granum_sensors::{RecordedState, Recorder};

use super::pace::Interval;
use crate::task::sink::Sink;
use crate::task::status::Speedometer;

/// Passes on the progress to the observer of the run, and stops the current part at its request or for a checkpoint.
pub(super) struct Follow<'a, 's> {
    pub(super) observer: &'a RefCell<&'s mut dyn SimulationObserver>,
    pub(super) speedometer: &'a mut Speedometer,
    pub(super) checkpoint: Interval,
    /// Name of the current stage of a test.
    pub(super) stage: Option<&'a str>,
    /// Axis about which the current stage is axisymmetric.
    pub(super) axis: Option<usize>,
    /// Index of the stage and number of stages.
    pub(super) place: [usize; 2],
    /// True after the observer has requested a stop.
    pub(super) stopped: bool,
}

impl<'a> Follow<'a, '_> {
    /// The progress in the whole test, with its speed.
    fn announced<'p>(&mut self, progress: &SimulationProgress<'p>) -> SimulationProgress<'p>
    where
        'a: 'p,
    {
        let [at, all] = self.place;
        let mut announced = *progress;
        announced.stage = self.stage.or(progress.stage);
        announced.axis = self.axis.or(progress.axis);
        announced.fraction = progress.fraction.map(|part| (at as f64 + part) / all.max(1) as f64);
        announced.grain_steps_per_second = self.speedometer.rate(progress.state);
        announced
    }
}

impl SimulationObserver for Follow<'_, '_> {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        let announced = self.announced(progress);
        self.stopped = self.observer.borrow_mut().progress(&announced) == Flow::Stop;
        if self.stopped || self.checkpoint.is_over() { Flow::Stop } else { Flow::Continue }
    }
    fn work(&mut self, work: &Work) -> Flow {
        let flow = match work {
            Work::Steps(progress) => {
                let announced = self.announced(progress);
                self.observer.borrow_mut().work(&Work::Steps(&announced))
            }
            other => self.observer.borrow_mut().work(other),
        };
        self.stopped = flow == Flow::Stop;
        flow
    }
    fn work_every(&self) -> u64 {
        self.observer.borrow().work_every()
    }
    fn next_observation(&self) -> f64 {
        self.observer.borrow().next_observation()
    }
    fn observe(&mut self, state: &dyn ObservedState) {
        self.observer.borrow_mut().observe(state);
    }
}

/// Calls the recorder of a stage, and tells the states that it has recorded.
pub(super) struct StageRecording<'a, 's> {
    recorder: &'a mut Recorder,
    /// Number of the stage, from 1.
    stage: usize,
    columns: RecordedColumns,
    outlet: &'a Outlet<'s>,
    /// Number of the states that have been told.
    told: usize,
    /// The assembly of the last observation, whose memory the next one uses.
    assembly: Assembly,
    /// The error of a state that could not be written; the test then stops.
    pub(super) failed: Option<granum_io::Error>,
}

impl<'a, 's> StageRecording<'a, 's> {
    pub(super) fn new(
        recorder: &'a mut Recorder,
        stage: usize,
        columns: RecordedColumns,
        outlet: &'a Outlet<'s>,
    ) -> StageRecording<'a, 's> {
        let told = recorder.complete_states();
        StageRecording { recorder, stage, columns, outlet, told, assembly: Assembly::default(), failed: None }
    }

    /// Tells the states up to a number of them.
    fn tell(&mut self, count: usize) {
        for index in self.told..count {
            if let Err(error) = self.outlet.tell(&self.recorder.state(index, self.stage, self.columns)) {
                self.failed.get_or_insert(error);
            }
        }
        self.told = self.told.max(count);
    }

    /// Ends the recording of a stage: the state under way is complete.
    pub(super) fn end(&mut self) {
        self.recorder.end();
        self.tell(self.recorder.states());
    }
}

impl SimulationObserver for StageRecording<'_, '_> {
    fn next_observation(&self) -> f64 {
        self.recorder.next_observation()
    }
    fn observe(&mut self, state: &dyn ObservedState) {
        state.assembly_into(&mut self.assembly);
        self.recorder.observe(&self.assembly);
        self.tell(self.recorder.complete_states());
    }
    fn progress(&mut self, _: &SimulationProgress) -> Flow {
        if self.failed.is_some() { Flow::Stop } else { Flow::Continue }
    }
}

/// Where the recorder and the snapshots of a test go: the sink of the run, and its observer.
pub(super) struct Outlet<'s> {
    pub(super) sink: RefCell<&'s mut dyn Sink>,
    pub(super) observer: RefCell<&'s mut dyn SimulationObserver>,
}

impl Outlet<'_> {
    /// Tells a state that was recorded.
    fn tell(&self, state: &RecordedState) -> granum_io::Result<()> {
        self.sink.borrow_mut().add_state(state)?;
        self.observer.borrow_mut().event(&Event::StateRecorded { values: state.values.clone() });
        Ok(())
    }
}

/// Writes the snapshots that a case requests.
pub(super) struct Snapshots<'a, 's> {
    /// Values of the measure at which snapshots are still due.
    pub(super) due: &'a mut Vec<f64>,
    pub(super) measure: Measure,
    pub(super) stage_progress: &'a StageProgress,
    pub(super) outlet: &'a Outlet<'s>,
    /// The error of a snapshot that could not be written; the test then stops.
    pub(super) failed: Option<granum_io::Error>,
}

impl SimulationObserver for Snapshots<'_, '_> {
    fn next_observation(&self) -> f64 {
        self.due.first().copied().unwrap_or(f64::INFINITY)
    }
    fn observe(&mut self, state: &dyn ObservedState) {
        let here = self.measure.value(&state.macro_state()) - self.stage_progress.origin(self.measure);
        while self.due.first().is_some_and(|due| *due <= here) {
            let name = snapshot_name(self.due.remove(0));
            if let Err(error) = self.outlet.sink.borrow_mut().save_snapshot(&name, &state.assembly()) {
                self.failed.get_or_insert(error);
            }
        }
    }
    fn progress(&mut self, _: &SimulationProgress) -> Flow {
        if self.failed.is_some() { Flow::Stop } else { Flow::Continue }
    }
}

/// Name of the snapshot at a strain, e.g. `strain-0_05`.
pub(in crate::engine) fn snapshot_name(strain: f64) -> String {
    format!("strain-{}", format_number(strain).replace('.', "_"))
}

/// Name of the snapshot at the end of a stage that is followed by another.
pub(in crate::engine) fn stage_snapshot(number: usize) -> String {
    format!("stage-{number}")
}
