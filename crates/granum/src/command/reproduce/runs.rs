//! The DEM runs of a reproduction. They are executed by a queue, and finished runs are used again.

use std::path::{Path, PathBuf};

use granum_io::inner_folder;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_run::laboratory::{Laboratory, Source};
use granum_run::queue::{Outcome, Queue, QueueError, QueuedRun};

use super::plan::ReproductionPlan;
use crate::command::show_queue::ShowQueue;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use granum_learn::runs::RunRole;

/// Folder of the runs.
const FOLDER: &str = granum_antony2006::reproduction::RUNS;

/// A finished run.
pub struct Done {
    pub role: RunRole,
    pub seed: u64,
    pub folder: PathBuf,
}

/// The queue of the runs in the folder of a reproduction.
fn queue(folder: &Path, plan: &ReproductionPlan) -> Result<Queue, QueueError> {
    let run = |planned: &super::plan::Planned| {
        let path = folder.join(FOLDER).join(&planned.name);
        QueuedRun::test(&planned.name, planned.case.clone(), Source::Case, path)
    };
    Queue::new(plan.runs.iter().map(run).collect())
}

/// True if all runs are finished.
pub fn are_finished(laboratory: &Laboratory, folder: &Path, plan: &ReproductionPlan) -> bool {
    queue(folder, plan).is_ok_and(|queue| queue.is_finished(laboratory))
}

/// Executes all runs that are not finished.
pub fn all(
    context: &Context,
    laboratory: &Laboratory,
    plan: &ReproductionPlan,
    folder: &Path,
) -> Result<Vec<Done>, Failure> {
    let runs = inner_folder(folder, FOLDER)?;
    for planned in &plan.runs {
        inner_folder(&runs, &planned.name)?;
    }
    let queue = queue(folder, plan)?;
    queue.check(laboratory, context.force).map_err(refusal)?;
    if context.force {
        queue.replace_others(laboratory)?;
    }
    let labels = plan.runs.iter().map(|planned| format!("seed {}", planned.seed)).collect();
    let show = ShowQueue::new(context, &queue, "DEM", labels);
    let outcomes = queue.run(laboratory, &show);
    let stopped = outcomes.iter().any(Outcome::is_stopped);
    let count = outcomes.len();
    for outcome in outcomes {
        if let Outcome::Failed(error) = outcome {
            return Err(error.into());
        }
    }
    if stopped {
        let (name, quoted) = (folder.shown(), quoted_path(folder));
        let left = format!("{name} contains the results so far; continue with `granum resume {quoted}`");
        return Err(Interrupted { left }.into());
    }
    show.end(|| format!("{count} runs"));
    let done = plan.runs.iter().zip(queue.runs());
    Ok(done
        .map(|(planned, run)| Done { role: planned.role, seed: planned.seed, folder: run.folder.clone() })
        .collect())
}

/// Refuses a folder with a run of another case or version, or whose record cannot be read, since the run of this
/// reproduction would replace it.
fn refusal(error: QueueError) -> Failure {
    let otherwise = "give --force to run it again, or reproduce in another folder";
    match error {
        QueueError::OtherRun { folder, version } => Failure::new(format!(
            "{}: its run has another case or version (granum {version}) than this reproduction; {otherwise}",
            folder.shown()
        )),
        QueueError::File(error) => Failure::new(format!("{error}; {otherwise}")),
        other => other.into(),
    }
}
