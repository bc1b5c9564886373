//! Training of the mappings with more runs than the single run of the paper.

use std::sync::{Mutex, PoisonError};

use granum_antony2006::learning_curve::LearningCurve;
use granum_antony2006::{StudyObserver, StudyOptions, StudyProgress};
use granum_io::shell::quoted_path;
use granum_io::{OutputFolder, Run};
use granum_learn::{LearnError, NamedRecord};
use granum_run::laboratory::Field;
use granum_run::record::read_record;

use super::plan::{Plan, Role};
use super::runs::Done;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::progress::Progress;

/// Shows the progress of training and stops it when the user asks for it. There are no checkpoints, because all networks
/// together take less time than one run.
struct Show<'a> {
    context: &'a Context,
    progress: Mutex<Progress>,
}

impl StudyObserver for Show<'_> {
    fn progress(&self, p: &StudyProgress) {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress.update(None, |_| {
            vec![Field::new(0, format!("{} epoch {} error {:.2e}", p.network, p.epoch, p.error))]
        });
    }
    fn stop(&self) -> bool {
        self.context.stopped()
    }
}

/// Trains with 1, 2, 4, ... of the additional training runs and scores on the additional unseen runs; `None` if there are
/// none.
pub fn curve(
    context: &Context,
    folder: &OutputFolder,
    plan: &Plan,
    runs: &[Done],
    options: &StudyOptions,
) -> Result<Option<LearningCurve>, Failure> {
    if plan.many.is_empty() {
        return Ok(None);
    }
    let mut records = Vec::new();
    for &k in &plan.many {
        records.push((&plan.runs[k], read_record(&Run::at(&runs[k].folder)?)?));
    }
    let of = |role: Role| -> Vec<NamedRecord> {
        let these = records.iter().filter(|(planned, _)| planned.role == role);
        these
            .map(|(planned, record)| NamedRecord { name: &planned.name, seed: planned.seed, record })
            .collect()
    };
    let (training, unseen) = (of(Role::Training), of(Role::Unseen));
    let grains = plan.many.first().map_or(0, |&k| plan.runs[k].case.grains.count);
    let mut progress = context.progress();
    progress.phase("more runs");
    let show = Show { context, progress: Mutex::new(progress) };
    let curve = LearningCurve::new(&training, &unseen, grains, options, &show);
    let curve = curve.map_err(|error| match error {
        LearnError::Stopped { .. } => {
            let quoted = quoted_path(folder.path());
            let left = format!("all runs are finished; continue with `granum resume {quoted}`");
            Failure::from(Interrupted { left })
        }
        other => other.into(),
    })?;
    let mut progress = show.progress.into_inner().unwrap_or_else(PoisonError::into_inner);
    progress.end(|| format!("networks from up to {} runs, scored on {}", training.len(), unseen.len()));
    Ok(Some(curve))
}
