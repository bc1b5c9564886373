//! Training of the mappings with more runs than the single run of the paper.

use granum_antony2006::learning_curve::PaperLearningCurve;
use granum_antony2006::{PaperData, PaperDataOptions, PaperOptions};
use granum_io::OutputFolder;
use granum_io::shell::quoted_path;
use granum_learn::{LearnError, NamedRecord};
use granum_run::record::read_record;

use super::plan::ReproductionPlan;
use super::runs::Done;
use crate::command::show_training::{Kept, Show};
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use granum_learn::runs::RunRole;

/// Trains with 1, 2, 4, ... of the additional training runs and scores on the additional unseen runs; `None` if there are
/// none.
pub fn curve(
    context: &Context,
    folder: &OutputFolder,
    plan: &ReproductionPlan,
    runs: &[Done],
    options: &PaperOptions,
) -> Result<Option<PaperLearningCurve>, Failure> {
    if plan.many.is_empty() {
        return Ok(None);
    }
    let mut records = Vec::new();
    for &k in &plan.many {
        records.push((&plan.runs[k], read_record(&context.run_at(&runs[k].folder)?)?));
    }
    let of = |role: RunRole| -> Vec<NamedRecord> {
        let these = records.iter().filter(|(planned, _)| planned.role == role);
        these
            .map(|(planned, record)| NamedRecord { name: &planned.name, seed: planned.seed, record })
            .collect()
    };
    let (training, unseen) = (of(RunRole::Training), of(RunRole::Unseen));
    let grains = plan.many.first().map_or(0, |&k| plan.runs[k].case.grains.count);
    let data = PaperData::from_records(&training, &unseen, &PaperDataOptions::default())?;
    // There are no checkpoints, because all networks together take less time than one run.
    let show = Show::new(context, "more runs", Kept::Nothing);
    let curve = PaperLearningCurve::measure(&data, grains, options, &show);
    let curve = curve.map_err(|error| match error {
        LearnError::Stopped { .. } => {
            let quoted = quoted_path(folder.path());
            let left = format!("all runs are finished; continue with `granum resume {quoted}`");
            Failure::from(Interrupted { left })
        }
        other => other.into(),
    })?;
    show.end(|| format!("networks from up to {} runs, scored on {}", training.len(), unseen.len()));
    Ok(Some(curve))
}
