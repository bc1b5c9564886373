//! The DEM runs of a reproduction. They are executed in parallel, one on each core, and finished runs are used again.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use granum_core::parallel;
use granum_dem::preparation::Phase;
use granum_io::shell::quoted_path;
use granum_io::{Case, Run, RunFolder, RunRecord, RunStatus, inner_folder};
use granum_run::laboratory::{self, Field, GRAINS_PER_THREAD, Laboratory, LaboratoryError, Shared, Source};
use granum_run::{Flow, Observer, Progress as RunProgress};

use super::plan::{Plan, Role};
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::progress::{Progress, Room};

/// Folder of the runs.
const FOLDER: &str = granum_antony2006::reproduction::RUNS;
/// Share of the preparation in the work of a run, for the display of progress.
const PREPARATION_SHARE: f64 = 0.15;

/// A finished run.
pub struct Done {
    pub role: Role,
    pub seed: u64,
    pub folder: PathBuf,
}

/// The progress of all runs.
struct ProgressOfRuns<'a> {
    context: &'a Context,
    plan: &'a Plan,
    progress: Mutex<(Progress, Vec<f64>)>,
}

/// The observer of one run.
struct ProgressOfRun<'a> {
    progress_of_runs: &'a ProgressOfRuns<'a>,
    number: usize,
}

impl Observer for ProgressOfRun<'_> {
    fn progress(&mut self, status: &RunProgress) -> Flow {
        let mut held = self.progress_of_runs.progress.lock().unwrap_or_else(PoisonError::into_inner);
        let (progress, done) = &mut *held;
        done[self.number] = match status.phase {
            Phase::Shear => PREPARATION_SHARE + (1.0 - PREPARATION_SHARE) * status.fraction.unwrap_or(0.0),
            _ => done[self.number].max(PREPARATION_SHARE * status.simulation.state().solid_fraction()),
        };
        let all = share_done(self.progress_of_runs.plan, done);
        let (seed, phase) = (self.progress_of_runs.plan.runs[self.number].seed, status.phase.name());
        progress.update(Some(all), |room| match room {
            Room::Line => vec![Field::new(0, format!("seed {seed} {phase}  {}", laboratory::line(status)))],
            Room::Screen => {
                let mut fields = vec![Field::new(0, format!("seed {seed}")), Field::new(4, phase)];
                fields.extend(laboratory::fields(status));
                fields
            }
        });
        self.progress_of_runs.context.flow()
    }
    fn warn(&mut self, text: &str) {
        self.progress_of_runs.context.warn(text);
    }
}

/// Completed share of all runs, weighted by their numbers of grains.
fn share_done(plan: &Plan, done: &[f64]) -> f64 {
    let grains = |k: usize| plan.runs[k].case.grains.count as f64;
    let all: f64 = (0..done.len()).map(grains).sum();
    done.iter().enumerate().map(|(k, share)| share * grains(k)).sum::<f64>() / all
}

/// True if all runs are finished.
pub fn are_finished(folder: &Path, plan: &Plan, version: &str) -> bool {
    plan.runs.iter().all(|planned| {
        let record = Run::at(folder.join(FOLDER).join(&planned.name)).and_then(|run| run.record());
        record.is_ok_and(|record| record.answers(&planned.case, version))
    })
}

/// Executes all runs that are not finished.
pub fn all(
    context: &Context,
    laboratory: &Laboratory,
    plan: &Plan,
    folder: &Path,
) -> Result<Vec<Done>, Failure> {
    let shared = Arc::new(Shared::default());
    let laboratory = Laboratory {
        shared: Some(shared.clone()),
        grains_per_thread: GRAINS_PER_THREAD,
        ..laboratory.clone()
    };
    let runs = inner_folder(folder, FOLDER)?;
    let jobs: Vec<(&Case, PathBuf)> = plan
        .runs
        .iter()
        .map(|planned| Ok((&planned.case, inner_folder(&runs, &planned.name)?)))
        .collect::<granum_io::Result<_>>()?;
    for (case, path) in &jobs {
        match check_own(&laboratory, case, path) {
            // All such folders are replaced first, so that after a kill no run is left that would be refused when the
            // reproduction is resumed without --force.
            Err(_) if context.force => drop(RunFolder::create(path, true)?),
            other => other?,
        }
    }
    let mut progress = context.progress();
    progress.phase("DEM");
    let progress_of_runs =
        ProgressOfRuns { context, plan, progress: Mutex::new((progress, vec![0.0; jobs.len()])) };
    let threads = laboratory.hardware.threads.max(1);
    // A run that fails does not stop the others, which then need not be repeated.
    let records = parallel::map(jobs.len(), threads, |number| {
        let (case, path): &(&Case, PathBuf) = &jobs[number];
        let _entered = shared.enter();
        let record =
            one(&laboratory, case, path, &mut ProgressOfRun { progress_of_runs: &progress_of_runs, number });
        progress_of_runs.progress.lock().unwrap_or_else(PoisonError::into_inner).1[number] = 1.0;
        Ok::<_, Failure>(record)
    })?;
    for record in records {
        if record?.status == RunStatus::Interrupted {
            let (name, quoted) = (folder.display(), quoted_path(folder));
            let left = format!("{name} contains the results so far; continue with `granum resume {quoted}`");
            return Err(Interrupted { left }.into());
        }
    }
    let (mut progress, _) = progress_of_runs.progress.into_inner().unwrap_or_else(PoisonError::into_inner);
    progress.end(|| format!("{} runs", jobs.len()));
    let done = plan.runs.iter().zip(jobs);
    Ok(done.map(|(planned, (_, folder))| Done { role: planned.role, seed: planned.seed, folder }).collect())
}

/// Refuses a folder with a run of another case or version, or whose record cannot be read, since the run of this
/// reproduction would replace it.
fn check_own(laboratory: &Laboratory, case: &Case, path: &Path) -> Result<(), Failure> {
    if !path.join("run.json").is_file() {
        return Ok(());
    }
    let otherwise = "give --force to run it again, or reproduce in another folder";
    match Run::at(path)?.record() {
        Ok(record) if is_of(&record, laboratory, case) => Ok(()),
        Ok(record) => Err(Failure::new(format!(
            "{}: its run has another case or version (granum {}) than this reproduction; {otherwise}",
            path.display(),
            record.granum_version
        ))),
        Err(error) => Err(Failure::new(format!("{error}; {otherwise}"))),
    }
}

/// True if a record, finished or not, is that of a run of this case with this version.
fn is_of(record: &RunRecord, laboratory: &Laboratory, case: &Case) -> bool {
    record.is_of(case) && record.granum_version == laboratory.version
}

/// Executes one run: a finished run is used again, an unfinished one is resumed, and otherwise a new one is started.
fn one(
    laboratory: &Laboratory,
    case: &Case,
    path: &Path,
    progress_of_run: &mut ProgressOfRun,
) -> Result<RunRecord, Failure> {
    if let Ok(record) = Run::at(path).and_then(|run| run.record()) {
        if record.answers(case, &laboratory.version) {
            return Ok(record);
        }
        if is_of(&record, laboratory, case) {
            let folder = RunFolder::open(path)?;
            match laboratory.resume(&folder, progress_of_run) {
                // After damage to a checkpoint the run is repeated, which costs time but does not end the study.
                Err(LaboratoryError::Checkpoint { .. } | LaboratoryError::Unusable { .. }) => {}
                other => return Ok(other?),
            }
        }
    }
    let folder = RunFolder::create(path, true)?;
    Ok(laboratory.shear(case, &Source::Case, &folder, progress_of_run)?)
}
