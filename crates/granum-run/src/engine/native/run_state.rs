//! The state of a run, in memory and in its checkpoint.
//!
//! A checkpoint holds everything that determines how the run continues and nothing else (no wall times, no properties of the
//! computer), so that two runs of one case write the same bytes.

use std::collections::BTreeMap;
use std::path::Path;

use granum_dem::observer::SimulationObserver;
use granum_dem::preparation::{Phase, PreparationState};
use granum_dem::simulation::Simulation;
use granum_io::Case;
use granum_io::case::Vocabulary;
use granum_io::run::{
    CHECKPOINT, PREVIOUS_CHECKPOINT, QualityFlag, REFUSED_CHECKPOINT, RunFolder, RunRecord, TEST,
};
use granum_io::shell::ShowPath;
use granum_sensors::Sensors;
use serde::{Deserialize, Serialize};

use super::preparation_curve::PreparationCurve;
use super::test_state::{SavedTest, Test};
use crate::task::laboratory_error::LaboratoryError;
use crate::task::sink::Sink;

/// The state of a run.
pub(super) struct RunState {
    pub(super) simulation: Simulation,
    pub(super) part: RunPart,
    pub(super) results: RunResults,
    /// True if it comes from an older checkpoint than the last one written.
    pub(super) older: bool,
}

/// The current part of a run, with the state that it needs in addition to that of the simulation.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RunPart<T = Test> {
    /// The sample is being prepared.
    Preparation(PreparationState),
    /// The sample is complete.
    Sample,
    /// The sample is being brought to the mean stress of its test.
    Consolidation(PreparationState),
    /// The sample is complete and at the mean stress of its test.
    Consolidated,
    /// The sample is being tested.
    Test(Box<T>),
}

impl RunPart<SavedTest> {
    /// The same part with the sensors of a test.
    fn with_sensors(self, sensors: &Sensors) -> Result<RunPart, String> {
        Ok(match self {
            RunPart::Preparation(progress) => RunPart::Preparation(progress),
            RunPart::Sample => RunPart::Sample,
            RunPart::Consolidation(progress) => RunPart::Consolidation(progress),
            RunPart::Consolidated => RunPart::Consolidated,
            RunPart::Test(test) => {
                let test = test.with_sensors(sensors);
                RunPart::Test(Box::new(
                    test.map_err(|error| format!("its test uses an unknown sensor: {error}"))?,
                ))
            }
        })
    }
}

/// Results of a run so far that belong in its record.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct RunResults {
    pub(super) grains: usize,
    pub(super) steps: BTreeMap<String, u64>,
    #[serde(deserialize_with = "granum_io::run::nulls_are_nan")]
    pub(super) measures: BTreeMap<String, f64>,
    pub(super) quality: Vec<QualityFlag>,
    /// The history of the preparation.
    #[serde(default)]
    pub(super) curve: PreparationCurve,
    /// Digest of the case of the run, by which the checkpoint of another run is recognised; checkpoints of earlier versions have
    /// none.
    #[serde(default)]
    pub(super) case_digest: String,
}

impl RunState {
    pub(super) fn new(simulation: Simulation, part: RunPart) -> RunState {
        let results = RunResults { grains: simulation.state().grains(), ..RunResults::default() };
        RunState { simulation, part, results, older: false }
    }

    /// The name under which the wall time of the part is recorded; `None` for a complete sample, which takes no time.
    pub(super) fn phase(&self) -> Option<&'static str> {
        match self.part {
            RunPart::Preparation(_) => Some("prepare"),
            RunPart::Sample | RunPart::Consolidated => None,
            RunPart::Consolidation(_) => Some(Phase::Consolidation.name()),
            RunPart::Test(_) => Some(TEST),
        }
    }

    /// Writes the checkpoint.
    pub(super) fn write(&self, sink: &mut dyn Sink) -> Result<(), LaboratoryError> {
        Ok(sink.save_checkpoint(&mut |out| {
            let text = serde_json::to_string(&(&self.part, &self.results)).map_err(std::io::Error::other)?;
            self.simulation.write_checkpoint(&text, out)
        })?)
    }

    /// Copies the results so far into the record.
    pub(super) fn write_into(&self, record: &mut RunRecord) {
        let results = &self.results;
        record.grains = results.grains;
        record.steps = results.steps.clone();
        record.measures = results.measures.clone();
        record.quality = results.quality.clone();
        let step = self.simulation.state().step();
        match &self.part {
            RunPart::Preparation(progress) => {
                record.steps.insert("prepare".into(), progress.steps().saturating_add(step));
                record.phase = progress.phase().name().to_string();
                if progress.trial() > 1 {
                    record.phase += &format!(", trial {}", progress.trial());
                }
            }
            RunPart::Sample | RunPart::Consolidated => record.phase.clear(),
            RunPart::Consolidation(_) => {
                record.steps.insert(Phase::Consolidation.name().into(), step);
                record.phase = Phase::Consolidation.name().to_string();
            }
            RunPart::Test(test) => {
                record.steps.insert(TEST.into(), test.steps(step));
                record.phase = test.stage_name().to_string();
                record.stage_ends.clone_from(&test.stage_ends);
            }
        }
    }

    /// True if a snapshot will be written, again or for the first time, when the run goes on from this state.
    pub(super) fn will_write(&self, snapshot: &str) -> bool {
        match &self.part {
            RunPart::Test(test) => test.will_write(snapshot),
            _ => true,
        }
    }

    /// Reads a checkpoint, which must be one of the run with this record; `None` if there is no such file. If a case is given,
    /// the checkpoint must also be possible in a run of it.
    pub(super) fn read(
        path: &Path,
        record: &RunRecord,
        case: Option<&Case>,
        vocabulary: &Vocabulary,
    ) -> Result<Option<RunState>, LaboratoryError> {
        let bad = |what: String| LaboratoryError::Checkpoint { path: path.to_path_buf(), what };
        let bytes = match granum_core::input::read(path, u64::MAX) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(bad(format!("it cannot be read: {error}"))),
        };
        let laws = vocabulary.laws();
        let (simulation, text) = Simulation::restore_among(&bytes, laws).map_err(|e| bad(e.to_string()))?;
        let (part, results) = beside(&text, case, vocabulary.sensors()).map_err(bad)?;
        if !results.case_digest.is_empty() && results.case_digest != record.case_digest {
            return Err(bad("it belongs to a run of another case".into()));
        }
        Ok(Some(RunState { simulation, part, results, older: false }))
    }
}

/// Reads the part of a checkpoint that follows the simulation. If a case is given, the checkpoint must be able to belong to
/// a run of it.
fn beside(text: &str, case: Option<&Case>, sensors: &Sensors) -> Result<(RunPart, RunResults), String> {
    let (part, results): (RunPart<SavedTest>, RunResults) =
        serde_json::from_str(text).map_err(|e| format!("its run state cannot be read ({e})"))?;
    let part = match (part, case) {
        (RunPart::Test(test), Some(case)) => RunPart::Test(Box::new(test.of_this_version(case))),
        (other, _) => other,
    };
    let part = part.with_sensors(sensors)?;
    if let RunPart::Test(test) = &part
        && case.is_some_and(|case| !test.is_of(case, sensors))
    {
        return Err("its run state belongs to a test of another case".into());
    }
    Ok((part, results))
}

/// Checks that the text which accompanies the simulation in a checkpoint can belong to a run of the case.
///
/// # Errors
/// If it cannot, a sentence that gives the reason.
pub fn check_beside(text: &str, case: &Case) -> Result<(), String> {
    beside(text, Some(case), case.vocabulary.sensors()).map(|_| ())
}

/// The last usable checkpoint of a folder; `None` if none was ever written. A checkpoint that cannot be used is renamed, and
/// the observer is warned.
pub(super) fn last_good(
    folder: &RunFolder,
    record: &RunRecord,
    case: &Case,
    vocabulary: &Vocabulary,
    observer: &mut dyn SimulationObserver,
) -> Result<Option<RunState>, LaboratoryError> {
    let current = match RunState::read(&folder.path().join(CHECKPOINT), record, Some(case), vocabulary) {
        Ok(Some(run_state)) => return Ok(Some(run_state)),
        Ok(None) => None,
        Err(error) => Some(error),
    };
    let previous = folder.path().join(PREVIOUS_CHECKPOINT);
    let older = match (RunState::read(&previous, record, Some(case), vocabulary), &current) {
        (Ok(Some(older)), _) => older,
        (Ok(None), None) => return Ok(None),
        (Ok(None), Some(why)) => {
            return Err(no_way_on(folder, format!("{why}; there is no {PREVIOUS_CHECKPOINT}")));
        }
        (Err(too), None) => return Err(no_way_on(folder, too.to_string())),
        (Err(too), Some(why)) => return Err(no_way_on(folder, format!("{why}; {too}"))),
    };
    let path = previous.shown();
    match current {
        // The run was killed between the two renames, and hardly any work is lost.
        None => observer
            .warn(&format!("there is no {CHECKPOINT}; the run continues from the previous one, {path}")),
        Some(why) => {
            observer.warn(&format!(
                "{why}; the run continues from the previous one, {path}, and the refused one is kept as \
                 {REFUSED_CHECKPOINT}"
            ));
            folder.put_checkpoint_aside()?;
        }
    }
    Ok(Some(RunState { older: true, ..older }))
}

fn no_way_on(folder: &RunFolder, what: String) -> LaboratoryError {
    LaboratoryError::Unusable { folder: folder.path().to_path_buf(), what }
}
