//! Consolidation: brings a sample to the mean stress of its test, if that differs from the mean stress of the sample.

use granum_dem::config::Preparation;
use granum_dem::observer::SimulationObserver;
use granum_dem::preparation::{Phase, PreparationOutcome, Preparing};
use granum_io::Case;

use super::quality;
use super::run_state::{RunPart, RunState};
use super::sample::measure_sample;
use super::segment::Segment;
use super::task_execution::TaskExecution;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::status::Speedometer;

/// The settings of the consolidation of a case before its first stage; `None` if this begins at the mean stress of the sample.
pub(super) fn wanted(case: &Case) -> Option<Preparation> {
    let initial = case.test_definition().initial_mean_stress;
    let mean_stress = initial.filter(|stress| *stress != case.preparation.mean_stress)?;
    Some(case.preparation.clone().with(|preparation| preparation.mean_stress = mean_stress))
}

impl TaskExecution {
    /// Begins the consolidation of a sample.
    pub(super) fn begin_consolidation(
        &self,
        case: &Case,
        run_state: RunState,
        preparation: &Preparation,
    ) -> RunState {
        let specification = self.specification(case, preparation, run_state.results.grains);
        let preparing = Preparing::consolidating(run_state.simulation, &specification);
        RunState {
            simulation: preparing.simulation,
            part: RunPart::Consolidation(preparing.progress),
            ..run_state
        }
    }

    /// Continues a consolidation until the sample is at rest, until a checkpoint is due, or until the observer stops it.
    pub(super) fn consolidate_on(
        &self,
        case: &Case,
        run_state: RunState,
        speedometer: &mut Speedometer,
        observer: &mut dyn SimulationObserver,
    ) -> Result<(RunState, Segment), LaboratoryError> {
        let RunState { simulation, part, mut results, older } = run_state;
        let (RunPart::Consolidation(progress), Some(preparation)) = (&part, wanted(case)) else {
            return Ok((RunState { simulation, part, results, older }, Segment::GoOn));
        };
        let preparing = Preparing { simulation, progress: progress.clone() };
        let specification = self.specification(case, &preparation, results.grains);
        let (outcome, stopped) =
            self.compress(preparing, &specification, &mut results.curve, speedometer, observer)?;
        let (simulation, part) = match outcome {
            PreparationOutcome::Stopped(at) => (at.simulation, RunPart::Consolidation(at.progress)),
            // A consolidation does not search for a friction coefficient and therefore has a single trial.
            PreparationOutcome::Again(_) => {
                return Err(LaboratoryError::Packing("its consolidation has only one trial".into()));
            }
            PreparationOutcome::Sample(sample) => {
                results.curve.end(&sample, Phase::Consolidation);
                results.steps.insert(Phase::Consolidation.name().into(), sample.steps);
                results.quality.extend(quality::judge_rest(
                    Phase::Consolidation.name(),
                    &sample.simulation,
                    sample.unbalanced_force,
                    &preparation,
                ));
                measure_sample(&sample.simulation, &mut results);
                (sample.simulation, RunPart::Consolidated)
            }
        };
        let segment = if stopped { Segment::Stop } else { Segment::GoOn };
        Ok((RunState { simulation, part, results, older }, segment))
    }
}
