//! The training of a study by the program: its folder, its progress, and its end by the user or a full disk.

use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use granum::contents::{FolderKind, check_free};
use granum_core::observer::Progress as Step;
use granum_io::OutputFolder;
use granum_io::shell::{ShowPath, quoted_path};
use granum_learn::networks::{KeptNetworks, NetworkCheckpoints, NoCheckpoints};
use granum_learn::study::{KeptStudy, STUDY_FILE, Study, StudyObserver, StudyPlan};
use granum_learn::{Dataset, LearnError, Surrogate, SurrogateMethods};
use granum_run::laboratory::ProgressField;

use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::progress::Progress;

/// What is kept of a training.
pub enum Kept {
    /// Its surrogates and networks.
    Study(KeptStudy),
    /// Its networks.
    Networks(KeptNetworks),
    /// Nothing, since it takes less time than a test.
    Nothing,
}

/// Shows the progress of training, keeps what is trained, and stops when the user asks for it.
pub struct Show<'a> {
    context: &'a Context,
    kept: Kept,
    progress: Mutex<Progress>,
}

impl<'a> Show<'a> {
    pub fn new(context: &'a Context, phase: &str, kept: Kept) -> Show<'a> {
        let mut progress = context.progress();
        progress.phase(phase);
        Show { context, kept, progress: Mutex::new(progress) }
    }

    /// Ends the phase with a permanent line.
    pub fn end(self, text: impl FnOnce() -> String) {
        self.progress.into_inner().unwrap_or_else(PoisonError::into_inner).end(text);
    }

    fn networks_kept(&self) -> Option<&KeptNetworks> {
        match &self.kept {
            Kept::Study(study) => Some(&study.networks),
            Kept::Networks(networks) => Some(networks),
            Kept::Nothing => None,
        }
    }

    fn write_failed(&self) -> bool {
        self.networks_kept().is_some_and(KeptNetworks::failed)
    }

    /// True if a training that ended with this error can be resumed, that is if the user stopped it or the disk was full.
    pub fn can_go_on(&self, error: &LearnError) -> bool {
        matches!(error, LearnError::Stopped { .. }) || self.write_failed()
    }

    /// The reason why a training ended early: a file that could not be written, an interruption by the user, or another
    /// error.
    pub fn failure(&self, error: LearnError, folder: &Path) -> Failure {
        let failed = self.networks_kept().and_then(KeptNetworks::take_failure);
        match (failed, error) {
            (Some(failure), _) => failure.into(),
            (None, LearnError::Stopped { done, total }) => {
                let (name, quoted) = (folder.shown(), quoted_path(folder));
                let left = match self.kept {
                    Kept::Nothing => {
                        format!("{name} holds what is trained; continue with `granum resume {quoted}`")
                    }
                    _ => format!(
                        "{done} of {total} surrogates are in {name}; continue with `granum resume {quoted}`"
                    ),
                };
                Interrupted { left }.into()
            }
            (None, other) => other.into(),
        }
    }
}

impl StudyObserver for Show<'_> {
    fn begins(&self, name: &str, number: usize, all: usize) {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress
            .update(Some((number - 1) as f64 / all as f64), |_| vec![ProgressField::new(0, name.to_owned())]);
    }
    fn progress(&self, name: &str, step: &Step) {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        let network = step.part.as_deref().unwrap_or(name);
        let text = match (step.value("error"), step.of) {
            (Some(error), _) => format!("{network} epoch {} error {error:.2e}", step.done),
            (None, Some(all)) => format!("{network} {} of {all}", step.done),
            (None, None) => format!("{network} {}", step.done),
        };
        progress.update(None, |_| vec![ProgressField::new(0, text)]);
    }
    fn finished(&self, name: &str) -> granum_learn::Result<Option<Box<dyn Surrogate>>> {
        match &self.kept {
            Kept::Study(study) => study.finished(name),
            _ => Ok(None),
        }
    }
    fn fitted(&self, name: &str, surrogate: &dyn Surrogate) -> granum_learn::Result<()> {
        if let Kept::Study(study) = &self.kept {
            // A file that cannot be written stops the training, which can be resumed.
            study.networks.note(study.fitted(name, surrogate));
        }
        Ok(())
    }
    fn networks(&self) -> &dyn NetworkCheckpoints {
        match self.networks_kept() {
            Some(networks) => networks,
            None => &NoCheckpoints,
        }
    }
    fn stop(&self) -> bool {
        self.context.stopped() || self.write_failed()
    }
}

/// Trains the study of a plan in its folder, or continues it there.
pub fn fit(
    context: &Context,
    out: &Path,
    (plan, dataset, methods): (&StudyPlan, &Dataset, &SurrogateMethods),
    every: Duration,
) -> Result<(OutputFolder, Study), Failure> {
    let begun = StudyPlan::is_in(out) && !context.force;
    let folder = folder(context, out, plan)?;
    let kept = KeptStudy::begin(folder.path(), plan, methods, every)?;
    let show = Show::new(context, "surrogates", Kept::Study(kept));
    let trained = Study::train(dataset, &plan.definition, methods, &show);
    match trained {
        Ok(study) if !show.write_failed() => {
            let count = study.members().count();
            show.end(|| format!("{count} surrogates with their baselines"));
            Ok((folder, study))
        }
        Ok(study) => {
            let (done, total) = (study.members().count() - 1, study.members().count());
            Err(show.failure(LearnError::Stopped { done, total }, folder.path()))
        }
        Err(error) => {
            if !begun && !show.can_go_on(&error) {
                // It would fail again in the same way, so that the folder is cleared for a corrected command.
                folder.clear(&plan.files_in(folder.path()).iter().map(String::as_str).collect::<Vec<_>>())?;
            }
            Err(show.failure(error, folder.path()))
        }
    }
}

/// The output folder: a new one, that of an unfinished training of the same study, which is continued, or, with `--force`, that
/// of any study. The plan of the training is written to it first.
fn folder(context: &Context, out: &Path, plan: &StudyPlan) -> Result<OutputFolder, Failure> {
    if StudyPlan::is_in(out) && !out.join(STUDY_FILE).exists() && !context.force {
        let folder = OutputFolder::open(out)?;
        let differences = StudyPlan::read(out)?.differences(plan);
        if differences.is_empty() {
            return Ok(folder);
        }
        return Err(Failure::new(format!(
            "{}: it contains an unfinished training that differs in {}; continue that one (`granum resume {}`), choose another \
             --out, or give --force to replace it",
            out.shown(),
            differences.join(", "),
            quoted_path(out)
        )));
    }
    check_free(out, FolderKind::Training, context.force, context.vocabulary())?;
    let folder = OutputFolder::create(out, context.force)?;
    let known = StudyPlan::read(folder.path()).ok();
    let mut old = plan.files_in(folder.path());
    old.extend(known.iter().flat_map(|known| known.files_in(folder.path())));
    old.extend(granum_antony2006::files_of_earlier_versions());
    folder.replace(&old, || plan.write(folder.path()))?;
    Ok(folder)
}
