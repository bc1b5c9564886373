//! The observers with which the laboratory follows its runs: one passes on the progress and stops for checkpoints, one
//! records the measurements, and one writes snapshots.

use granum_core::assembly::Assembly;
use granum_core::quantity::format_number;
use granum_dem::loading::{Measure, StageProgress};
use granum_dem::observer::{Flow, Observer, Progress, Work};
use granum_dem::simulation::Simulation;
use granum_sensors::Recorder;

use super::pace::Interval;
use super::store::Store;
use crate::laboratory::status::Speedometer;

/// Passes on the progress to the observer of the run, and stops the current part at its request or for a checkpoint.
pub(super) struct Follow<'a> {
    pub(super) observer: &'a mut dyn Observer,
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

impl<'a> Follow<'a> {
    /// The progress in the whole test, with its speed.
    fn announced<'p>(&mut self, progress: &Progress<'p>) -> Progress<'p>
    where
        'a: 'p,
    {
        let [at, all] = self.place;
        let mut announced = *progress;
        announced.stage = self.stage.or(progress.stage);
        announced.axis = self.axis.or(progress.axis);
        announced.fraction = progress.fraction.map(|part| (at as f64 + part) / all.max(1) as f64);
        announced.grain_steps_per_second = self.speedometer.rate(progress.simulation);
        announced
    }
}

impl Observer for Follow<'_> {
    fn progress(&mut self, progress: &Progress) -> Flow {
        let announced = self.announced(progress);
        self.stopped = self.observer.progress(&announced) == Flow::Stop;
        if self.stopped || self.checkpoint.is_over() { Flow::Stop } else { Flow::Continue }
    }
    fn work(&mut self, work: &Work) -> Flow {
        let flow = match work {
            Work::Steps(progress) => {
                let announced = self.announced(progress);
                self.observer.work(&Work::Steps(&announced))
            }
            other => self.observer.work(other),
        };
        self.stopped = flow == Flow::Stop;
        flow
    }
    fn work_every(&self) -> u64 {
        self.observer.work_every()
    }
    fn next_observation(&self) -> f64 {
        self.observer.next_observation()
    }
    fn observe(&mut self, simulation: &Simulation) {
        self.observer.observe(simulation);
    }
}

/// Calls the recorder of a stage.
pub(super) struct Record<'a> {
    recorder: &'a mut Recorder,
    /// The assembly of the last observation, whose memory the next one uses.
    assembly: Assembly,
}

impl<'a> Record<'a> {
    pub(super) fn new(recorder: &'a mut Recorder) -> Record<'a> {
        Record { recorder, assembly: Assembly::default() }
    }
}

impl Observer for Record<'_> {
    fn next_observation(&self) -> f64 {
        self.recorder.next_observation()
    }
    fn observe(&mut self, simulation: &Simulation) {
        simulation.assembly_into(&mut self.assembly);
        self.recorder.observe(&self.assembly);
    }
}

/// Writes the snapshots that a case requests.
pub(super) struct Snapshots<'a> {
    /// Values of the measure at which snapshots are still due.
    pub(super) due: &'a mut Vec<f64>,
    pub(super) measure: Measure,
    pub(super) stage_progress: &'a StageProgress,
    pub(super) store: Store<'a>,
    /// The error of a snapshot that could not be written; the test then stops.
    pub(super) failed: Option<granum_io::Error>,
}

impl Observer for Snapshots<'_> {
    fn next_observation(&self) -> f64 {
        self.due.first().copied().unwrap_or(f64::INFINITY)
    }
    fn observe(&mut self, simulation: &Simulation) {
        let here =
            self.measure.of(&simulation.state().macro_state()) - self.stage_progress.origin(self.measure);
        while self.due.first().is_some_and(|due| *due <= here) {
            let name = snapshot_name(self.due.remove(0));
            if let Err(error) = self.store.snapshot(&name, &simulation.assembly()) {
                self.failed.get_or_insert(error);
            }
        }
    }
    fn progress(&mut self, _: &Progress) -> Flow {
        if self.failed.is_some() { Flow::Stop } else { Flow::Continue }
    }
}

/// Name of the snapshot at a strain, e.g. `strain-0_05`.
pub(super) fn snapshot_name(strain: f64) -> String {
    format!("strain-{}", format_number(strain).replace('.', "_"))
}

/// Name of the snapshot at the end of a stage that is followed by another.
pub(super) fn stage_snapshot(number: usize) -> String {
    format!("stage-{number}")
}
