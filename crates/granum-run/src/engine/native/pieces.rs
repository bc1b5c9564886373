//! A run in memory that goes on a piece at a time.

use std::collections::BTreeMap;
use std::io::{Result as IoResult, Write};
use std::sync::Arc;

use granum_core::observer::Event;
use granum_core::{Assembly, ObservedState, Table};
use granum_dem::observer::{Flow, SimulationObserver, SimulationProgress, Work};
use granum_io::Case;
use granum_io::Result as FileResult;
use granum_io::run::{RunRecord, RunStatus};
use granum_sensors::{Record, RecordedState};

use super::run::{self, Begun, Left};
use super::run_state::RunState;
use super::task_execution::TaskExecution;
use crate::digest;
use crate::task::definition::Task;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::saved_run::SavedRun;
use crate::task::sink::Sink;

/// A run in memory that goes on a piece at a time: between two pieces whoever holds it can look at its state, show it, save it, or leave it. Its
/// results have the bits of a run in one piece.
///
/// ```
/// use granum_core::observer::{Flow, Observer, Progress};
/// use granum_dem::observer::NoObserver;
/// use granum_io::{Case, RunKind, RunStatus};
/// use granum_run::{Laboratory, Source};
///
/// /// Stops at once.
/// struct Impatient;
/// impl Observer for Impatient {
///     fn progress(&mut self, _: &Progress) -> Flow {
///         Flow::Stop
///     }
/// }
///
/// let case = "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n\
///             shear.deviator_strain = 0.01\nshear.inertial_number = 0.01\nrecording.states = 2";
/// let case = Case::parse(case, "case")?;
/// let laboratory = Laboratory::here();
/// let mut run = laboratory.in_pieces(RunKind::Test, &case, &Source::Case, &mut NoObserver)?;
/// let mut pieces = 1;
/// while run.go_on(&mut Impatient)? != RunStatus::Finished {
///     pieces += 1;
/// }
/// assert!(pieces > 10);
/// assert_eq!(run.measurements(), &laboratory.test(&case)?.record);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct RunInPieces {
    execution: TaskExecution,
    case: Case,
    /// The state from which it goes on; `None` once it is complete, and after an error.
    run_state: Option<RunState>,
    kept: Kept,
}

impl RunInPieces {
    /// Reads and checks the inputs of a run, and places its grains. Nothing is written.
    ///
    /// # Errors
    /// As for a run of granum's own engine.
    pub(crate) fn new(
        task: &Task,
        observer: &mut dyn SimulationObserver,
    ) -> Result<RunInPieces, LaboratoryError> {
        let Begun { execution, run_state, record } = run::begin(task, true, observer)?;
        let kept = Kept {
            record,
            states: Vec::new(),
            measurements: Record::default(),
            snapshots: BTreeMap::new(),
            preparation: None,
            end: None,
        };
        Ok(RunInPieces { execution, case: task.case.clone(), run_state: Some(run_state), kept })
    }

    /// Goes on until the run is complete or the observer stops it, and returns which of both. A run that is complete stays as it is.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the run fails, after which it cannot go on.
    pub fn go_on(&mut self, observer: &mut dyn SimulationObserver) -> Result<RunStatus, LaboratoryError> {
        let Some(run_state) = self.run_state.take() else { return Ok(self.kept.record.status) };
        self.kept.record.status = RunStatus::Failed;
        let mut observer = AfterTheFirst { observer, is_first: true };
        match self.execution.go_on_to(&self.case, run_state, false, &mut self.kept, &mut observer)? {
            Left::Stopped(run_state) | Left::Sample(run_state) => {
                self.run_state = Some(run_state);
                self.kept.record.status = RunStatus::Running;
            }
            Left::Complete => self.kept.record.status = RunStatus::Finished,
        }
        Ok(self.kept.record.status)
    }

    /// The case.
    pub fn case(&self) -> &Case {
        &self.case
    }

    /// The record of the run: status, steps, notes, and at its end measures and quality.
    pub fn record(&self) -> &RunRecord {
        &self.kept.record
    }

    /// The states of the test that have been recorded so far.
    pub fn states(&self) -> &[RecordedState] {
        &self.kept.states
    }

    /// The series of the test and its histograms, as they were at the end of the last piece; empty before the test.
    pub fn measurements(&self) -> &Record {
        &self.kept.measurements
    }

    /// The snapshots that have been written so far, by their names.
    pub fn snapshots(&self) -> &BTreeMap<String, Assembly> {
        &self.kept.snapshots
    }

    /// The state as it is now; `None` after an error.
    pub fn state(&self) -> Option<&dyn ObservedState> {
        match (&self.run_state, &self.kept.end) {
            (Some(run_state), _) => Some(&run_state.simulation),
            (None, Some(end)) => Some(end.as_ref()),
            (None, None) => None,
        }
    }

    /// The digest that the folder of this run would have: [`digest::of_run`]. It identifies the result once the run is complete.
    ///
    /// # Errors
    /// If there are no measurements yet.
    pub fn digest(&self) -> Result<String, LaboratoryError> {
        let test = (!self.kept.measurements.histograms.is_empty()).then_some(&self.kept.measurements);
        let case_digest = self.case.digest_with(self.kept.record.packing_digest());
        Ok(digest::of_results(&case_digest, test, &self.kept.snapshots)?)
    }

    /// The run as it is now, from which the program goes on; `None` if it is complete.
    ///
    /// # Errors
    /// If its checkpoint cannot be written.
    pub fn saved(&self) -> Result<Option<SavedRun>, LaboratoryError> {
        let Some(run_state) = &self.run_state else { return Ok(None) };
        let mut bytes = Bytes(Vec::new(), self.kept.record.clone());
        run_state.write(&mut bytes)?;
        let Kept { record, snapshots, preparation, .. } = &self.kept;
        let (record, snapshots) = (record.clone(), snapshots.clone());
        Ok(Some(SavedRun::new(&self.case, record, snapshots, preparation.clone(), &bytes.0)))
    }
}

/// An observer that cannot stop a piece at its first report, which comes before the first step: it would never end.
struct AfterTheFirst<'a> {
    observer: &'a mut dyn SimulationObserver,
    is_first: bool,
}

impl SimulationObserver for AfterTheFirst<'_> {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        let flow = self.observer.progress(progress);
        if std::mem::take(&mut self.is_first) { Flow::Continue } else { flow }
    }
    fn work(&mut self, work: &Work) -> Flow {
        let flow = self.observer.work(work);
        // While grains are placed there is no state yet in which a run could wait.
        if matches!(work, Work::Placing { .. }) { Flow::Continue } else { flow }
    }
    fn work_every(&self) -> u64 {
        self.observer.work_every()
    }
    fn next_observation(&self) -> f64 {
        self.observer.next_observation()
    }
    fn observe(&mut self, state: &dyn ObservedState) {
        self.observer.observe(state);
    }
    fn stage(&mut self, number: usize) {
        self.observer.stage(number);
    }
    fn event(&mut self, event: &Event) {
        self.observer.event(event);
    }
    fn warn(&mut self, text: &str) {
        self.observer.warn(text);
    }
}

/// What a run has found so far.
struct Kept {
    record: RunRecord,
    states: Vec<RecordedState>,
    measurements: Record,
    snapshots: BTreeMap<String, Assembly>,
    preparation: Option<Table>,
    end: Option<Arc<dyn ObservedState + Send + Sync>>,
}

impl Sink for Kept {
    fn record(&mut self) -> &mut RunRecord {
        &mut self.record
    }
    fn begin_states(&mut self, states: &[RecordedState]) -> FileResult<()> {
        self.states = states.to_vec();
        Ok(())
    }
    fn add_state(&mut self, state: &RecordedState) -> FileResult<()> {
        self.states.push(state.clone());
        Ok(())
    }
    fn save_measurements(&mut self, record: &Record) -> FileResult<()> {
        self.measurements = record.clone();
        Ok(())
    }
    fn save_preparation(&mut self, history: &Table) -> FileResult<()> {
        self.preparation = Some(history.clone());
        Ok(())
    }
    fn save_snapshot(&mut self, name: &str, assembly: &Assembly) -> FileResult<()> {
        self.snapshots.insert(name.to_string(), assembly.clone());
        Ok(())
    }
    fn keep(&mut self, state: Arc<dyn ObservedState + Send + Sync>) {
        self.end = Some(state);
    }
}

/// Takes nothing but a checkpoint.
struct Bytes(Vec<u8>, RunRecord);

impl Sink for Bytes {
    fn record(&mut self) -> &mut RunRecord {
        &mut self.1
    }
    fn save_checkpoint(&mut self, write: &mut dyn FnMut(&mut dyn Write) -> IoResult<()>) -> FileResult<()> {
        let written = write(&mut self.0);
        written.map_err(|error| granum_io::Error::content("the checkpoint".as_ref(), error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use granum_core::observer::{Observer, Progress};
    use granum_dem::observer::NoObserver;
    use granum_io::run::{RunFolder, RunKind};

    use super::*;
    use crate::{Laboratory, Source};

    const CASE: &str = "grains.count = 60\ngrains.material.interface_energy = 0\npreparation.solid_fraction = 'none'\n\
                        preparation.unbalanced_force = 0.05\nshear.deviator_strain = 0.02\nshear.inertial_number = 0.01\nrecording.states = 4\n\
                        recording.snapshots = [0.01]\n[[bond]]\nlaw = 'parallel'\nmodulus = '1 GPa'\n\
                        tensile_strength = '1 MPa'\ncohesion = '1 MPa'";

    /// Stops at every so many calls.
    struct Every(u32, u32);

    impl Observer for Every {
        fn progress(&mut self, _: &Progress) -> Flow {
            self.1 += 1;
            if self.1.is_multiple_of(self.0) { Flow::Stop } else { Flow::Continue }
        }
    }

    fn folder_of(case: &Case, place: &std::path::Path) -> String {
        let folder = RunFolder::create(place.join("whole"), false).unwrap();
        Laboratory::here().run(RunKind::Test, case, &Source::Case, &folder, &mut NoObserver).unwrap();
        digest::of_run(&folder.run()).unwrap()
    }

    #[test]
    fn pieces_have_the_digest_of_the_folder_of_a_run() {
        let case = Case::parse(CASE, "case").unwrap();
        let place = tempfile::tempdir().unwrap();
        let whole = folder_of(&case, place.path());
        for every in [1, 7] {
            let mut run =
                Laboratory::here().in_pieces(RunKind::Test, &case, &Source::Case, &mut NoObserver).unwrap();
            let mut observer = Every(every, 0);
            while run.go_on(&mut observer).unwrap() != RunStatus::Finished {
                assert!(run.state().is_some());
            }
            assert_eq!(run.snapshots().keys().collect::<Vec<_>>(), ["end", "start", "strain-0_01"]);
            assert_eq!(run.states().len(), run.measurements().series.rows());
            assert_eq!(run.digest().unwrap(), whole);
            assert_eq!(run.saved().unwrap(), None);
            assert_eq!(run.go_on(&mut observer).unwrap(), RunStatus::Finished);
        }
    }

    #[test]
    fn the_program_goes_on_from_a_saved_run() {
        let case = Case::parse(CASE, "case").unwrap();
        let place = tempfile::tempdir().unwrap();
        let whole = folder_of(&case, place.path());
        let laboratory = Laboratory::here();
        // While the sample is made, and in the test with a snapshot behind it.
        for states in [0, 3] {
            let mut run = laboratory.in_pieces(RunKind::Test, &case, &Source::Case, &mut NoObserver).unwrap();
            let mut observer = Every(1, 0);
            assert_eq!(run.go_on(&mut observer).unwrap(), RunStatus::Running);
            while run.states().len() < states {
                assert_eq!(run.go_on(&mut observer).unwrap(), RunStatus::Running);
            }
            let text = run.saved().unwrap().unwrap().to_json().unwrap();
            let folder = RunFolder::create(place.path().join(format!("from-{states}")), false).unwrap();
            SavedRun::from_json(&text, "run.json".as_ref()).unwrap().write_into(&folder).unwrap();
            assert!(folder.run().faults().unwrap().is_empty());
            laboratory.resume(&folder, &mut NoObserver).unwrap();
            assert_eq!(digest::of_run(&folder.run()).unwrap(), whole);
            assert!(folder.run().preparation().unwrap().is_some());
        }
    }

    #[test]
    fn what_is_no_saved_run_is_refused_by_reason() {
        let case = Case::parse(CASE, "case").unwrap();
        let laboratory = Laboratory::here();
        let mut run = laboratory.in_pieces(RunKind::Test, &case, &Source::Case, &mut NoObserver).unwrap();
        run.go_on(&mut Every(1, 0)).unwrap();
        let text = run.saved().unwrap().unwrap().to_json().unwrap();
        let of = |text: &str| SavedRun::from_json(text, "own.json".as_ref()).map(|_| ());
        of(&text).unwrap();
        let changed = |change: &dyn Fn(&mut serde_json::Value)| {
            let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
            change(&mut value);
            of(&value.to_string()).unwrap_err().to_string()
        };
        let packing = serde_json::json!({ "sample": "/etc" });
        for (message, said) in [
            (of("{}").unwrap_err().to_string(), "no saved run"),
            (changed(&|run| run["format"] = "granum run 9".into()), "its format is \"granum run 9\""),
            (changed(&|run| run["record"]["source"] = packing.clone()), "made from its case"),
            (changed(&|run| run["record"]["case_digest"] = "0".into()), "another case"),
            (changed(&|run| run["checkpoint"] = "no base64".into()), "no base64"),
            (changed(&|run| run["snapshots"] = serde_json::json!({ "../out": {} })), "saved run"),
        ] {
            assert!(message.contains("own.json") && message.contains(said), "{message}");
        }
        let mut other: serde_json::Value = serde_json::from_str(&text).unwrap();
        let assembly = serde_json::to_value(run.state().unwrap().assembly()).unwrap();
        other["snapshots"] = serde_json::json!({ "../out": assembly });
        let message = of(&other.to_string()).unwrap_err().to_string();
        assert!(message.contains("\"../out\" is no name of a snapshot"), "{message}");
    }
}
