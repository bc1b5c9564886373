//! Brings a sample to the mean stress of its test, where that is another than the sample's.

use granum_dem::config::Preparation;
use granum_dem::preparation::{Outcome, Phase, Preparing};
use granum_io::Case;

use super::sample::measure_sample;
use super::standing::{Stage, Standing};
use super::{Laboratory, LaboratoryError, RunObserver, Speedometer, Stretch, quality};

/// How the sample of a case is consolidated; none if its test is at the mean stress of the sample, or is
/// given as stages, which consolidate themselves.
pub(super) fn wanted(case: &Case) -> Option<Preparation> {
    if case.has_stages() {
        return None;
    }
    let mean_stress = case.shear.mean_stress.filter(|stress| *stress != case.preparation.mean_stress)?;
    Some(Preparation { mean_stress, ..case.preparation.clone() })
}

impl Laboratory {
    /// Begins to consolidate a sample.
    pub(super) fn begin_consolidation(
        &self,
        case: &Case,
        standing: Standing,
        preparation: &Preparation,
    ) -> Standing {
        let recipe = self.recipe(case, preparation, standing.found.grains);
        let preparing = Preparing::consolidating(standing.simulation, &recipe);
        Standing {
            simulation: preparing.simulation,
            stage: Stage::Consolidation(preparing.course),
            ..standing
        }
    }

    /// Goes on with a consolidation until the sample is at rest, a checkpoint is due or the observer stops it.
    pub(super) fn consolidate_on(
        &self,
        case: &Case,
        standing: Standing,
        speedometer: &mut Speedometer,
        observer: &mut dyn RunObserver,
    ) -> Result<(Standing, Stretch), LaboratoryError> {
        let Standing { simulation, stage, mut found, older } = standing;
        let (Stage::Consolidation(course), Some(preparation)) = (&stage, wanted(case)) else {
            return Ok((Standing { simulation, stage, found, older }, Stretch::GoOn));
        };
        let preparing = Preparing { simulation, course: course.clone() };
        let recipe = self.recipe(case, &preparation, found.grains);
        let (outcome, stopped) =
            self.compress(preparing, &recipe, &mut found.curve, speedometer, observer)?;
        let (simulation, stage) = match outcome {
            Outcome::Stopped(at) => (at.simulation, Stage::Consolidation(at.course)),
            // A consolidation searches no friction.
            Outcome::Again(_) => return Err(LaboratoryError::Packing("it is not needed twice".into())),
            Outcome::Sample(sample) => {
                found.curve.end(&sample, Phase::Consolidation);
                found.steps.insert(Phase::Consolidation.name().into(), sample.steps);
                found.quality.extend(quality::judge_rest(
                    Phase::Consolidation.name(),
                    &sample.simulation,
                    sample.unbalanced_force,
                    &preparation,
                ));
                measure_sample(&sample.simulation, &mut found);
                (sample.simulation, Stage::Consolidated)
            }
        };
        let stretch = if stopped { Stretch::Stop } else { Stretch::GoOn };
        Ok((Standing { simulation, stage, found, older }, stretch))
    }
}
