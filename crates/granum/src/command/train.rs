//! `granum train`: the networks of the six mappings from run folders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use clap::{Args, ValueEnum};
use granum::contents::{FolderKind, check_free};
use granum_antony2006::files::save_study;
use granum_antony2006::layout::{PLAN_FILE, STUDY_FILE};
use granum_antony2006::mapping::{PAPER_STRAIN, paper_mappings_to};
use granum_antony2006::sufficiency::check_states;
use granum_antony2006::summary::MappingSummary;
use granum_antony2006::training_checkpoints::{TrainingCheckpoints, TrainingManifest};
use granum_antony2006::{
    Form, Study, StudyData, StudyDataOptions, StudyObserver, StudyOptions, StudyProgress,
};
use granum_io::OutputFolder;
use granum_io::case::Difference;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_learn::LearnError;
use granum_learn::runs::{RunRole, StudyRun};
use granum_nets::Model;
use granum_nets::trainer::{self, TrainerState};
use granum_run::laboratory::Field;
use serde_json::json;

use super::checkpoints::CheckpointFlags;
use super::records::{self, Recorded};
use super::scores;
use super::spread::Spread;
use super::train_study::{self, StudyFlags, Training};
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::numbers::apart;
use crate::output;
use crate::progress::Progress;

/// The trainer that uses the numbers of epochs in the tables of the paper.
const PAPER_TRAINER: &str = "traingdx";

/// Train the eighteen networks of the six mappings of the paper, and for each a strain-only network of the same size; with
/// --input and --output surrogates of any columns.
///
/// Every second state of the training runs is used for training, and the others are held out for evaluation; unseen runs are
/// used for evaluation only. All runs must have the same case and differ only in preparation.seed, unless --mixed is given.
/// With --input and --output runs may differ in anything, and every method is compared with ridge regression, with itself on
/// the coordinate alone, and with the mean curve of the training runs.
/// The same command continues an interrupted training.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum train run-1 --unseen run-2 run-3 --out study\n  granum train run-1 --trainer traingdx \
                  --epoch-factor 0.1 --out quick-study\n  granum train run-1 run-2 --unseen run-3 --input deviator_fabric,probability_density \\\n    --output stress_ratio --coordinate deviator_strain --method feed-forward,ridge -o columns\n  granum train run-1 run-2 --columns"
)]
pub struct Train {
    /// Run folders for training.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Folder of the study.
    #[arg(short, long, default_value = "study", value_name = "DIR")]
    out: PathBuf,
    /// Run folders that are used for evaluation only.
    #[arg(long, num_args = 1.., value_name = "RUN")]
    unseen: Vec<PathBuf>,
    /// Accept runs that differ in more than the seed. The keys that differ are printed, and the difference between the
    /// runs is not called the scatter between samples.
    #[arg(long)]
    mixed: bool,
    #[arg(long, default_value = trainer::NAMES[0], value_name = "NAME", help = trainers())]
    trainer: String,
    /// Form in which P(f) enters a network: as single points f, P (as in the paper), or as all bins at once.
    #[arg(long, value_enum, default_value_t = FormName::Point)]
    form: FormName,
    /// Seed of the initial weights.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Factor on the numbers of epochs in the tables of the paper, for traingdx; other trainers have their own stopping
    /// rule.
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    epoch_factor: Option<f64>,
    /// Number of threads, each of which trains one network at a time; all processors by default. Results do not depend on
    /// it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    #[command(flatten)]
    study: StudyFlags,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
}

/// The help text of `--trainer`: the names of all trainers with their descriptions.
pub(super) fn trainers() -> String {
    let each: Vec<String> =
        trainer::ALL.iter().map(|kind| format!("{} ({})", kind.name, kind.help)).collect();
    format!("Trainer: {}", each.join(" or "))
}

/// The values of the flag for [`Form`].
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum FormName {
    Point,
    Histogram,
}

/// Shows the progress of training, stores each network when it is trained, and stops when the user asks for it.
pub(super) struct Show<'a> {
    context: &'a Context,
    pub checkpoints: TrainingCheckpoints,
    progress: Mutex<Progress>,
}

impl<'a> Show<'a> {
    /// Stores networks in an existing folder.
    pub fn new(context: &'a Context, phase: &str, folder: &Path, every: Duration) -> Show<'a> {
        let mut progress = context.progress();
        progress.phase(phase);
        Show { context, checkpoints: TrainingCheckpoints::new(folder, every), progress: Mutex::new(progress) }
    }

    /// Ends the phase with a permanent line.
    pub fn end(self, text: impl FnOnce() -> String) {
        self.progress.into_inner().unwrap_or_else(PoisonError::into_inner).end(text);
    }

    /// Ends the training of a study and adds the training times of the networks that were read from the folder.
    fn finish(self, mut study: Study) -> Study {
        self.checkpoints.add_seconds(&mut study);
        let networks: usize = study.mappings.iter().map(|m| m.surrogate.networks().len()).sum();
        self.end(|| format!("{networks} networks and as many strain-only networks"));
        study
    }

    /// True if a training that ended with this error can be resumed, that is if the user stopped it or the disk was full.
    fn can_go_on(&self, error: &LearnError) -> bool {
        matches!(error, LearnError::Stopped { .. }) || self.checkpoints.failed()
    }

    /// The reason why a training ended early: a file that could not be written, an interruption by the user, or another
    /// error.
    pub fn failure(&self, error: LearnError, folder: &Path) -> Failure {
        match (self.checkpoints.take_failure(), error) {
            (Some(failure), _) => failure.into(),
            (None, LearnError::Stopped { done, total }) => {
                let left = format!(
                    "{done} of {total} networks are in {}; continue with `granum resume {}`",
                    folder.shown(),
                    quoted_path(folder)
                );
                Interrupted { left }.into()
            }
            (None, other) => other.into(),
        }
    }
}

impl StudyObserver for Show<'_> {
    fn progress(&self, p: &StudyProgress) {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress.update(None, |_| {
            vec![Field::new(0, format!("{} epoch {} error {:.2e}", p.network, p.epoch, p.error))]
        });
    }
    fn trained(&self, network: &str, model: &Model, seconds: f64) {
        self.checkpoints.trained(network, model, seconds);
    }
    fn finished(&self, network: &str) -> Option<Model> {
        self.checkpoints.finished(network)
    }
    fn keeps_state(&self, network: &str) -> bool {
        self.checkpoints.is_due(network)
    }
    fn under_way(&self, network: &str, key: &str, state: &TrainerState) {
        self.checkpoints.under_way(network, key, state);
    }
    fn state(&self, network: &str, key: &str) -> Option<TrainerState> {
        self.checkpoints.state(network, key)
    }
    fn stop(&self) -> bool {
        self.context.stopped() || self.checkpoints.failed()
    }
}

impl Train {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let mut options = self.options()?;
        if self.study.lists_columns() {
            return train_study::list_columns(context, &self.runs, &self.unseen);
        }
        if self.study.is_given() {
            let (runs, unseen, out, threads) = (&self.runs, &self.unseen, &self.out, options.threads);
            return train_study::train(
                context,
                &Training { runs, unseen, out, threads },
                &self.study,
                self.seed,
            );
        }
        let reading = context.nothing_written(Some("reading the runs"));
        let training = records::read(context, &self.runs, RunRole::Training)?;
        let unseen = records::read(context, &self.unseen, RunRole::Unseen)?;
        let all: Vec<&Recorded> = training.iter().chain(&unseen).collect();
        records::check_different(&all)?;
        let differences = records::check_one_test(&all, self.mixed)?;
        let end = training.iter().map(|run| run.end).fold(f64::INFINITY, f64::min);
        options.mappings = paper_mappings_to(end);
        if end != PAPER_STRAIN {
            let [end, paper] = apart(end, PAPER_STRAIN);
            context.note(&format!(
                "the tests end at a deviator strain of {end}, not {paper}; the strain ranges of the \
                 paper's tables are scaled accordingly"
            ));
        }
        let dataset = StudyData::new(
            &records::named(&training),
            &records::named(&unseen),
            &StudyDataOptions::default(),
        )?;
        // This check comes before a folder is created and before an older one is replaced.
        check_states(&dataset, &options.mappings)?;
        let every = self.checkpoints.every()?;
        let mut plan = TrainingManifest::new(&self.runs, &self.unseen, dataset.hash()?, &options)?;
        plan.mixed = self.mixed;
        drop(reading);
        let begun = Train::is_in(&self.out) && !context.force;
        let folder = self.folder(context, &plan)?;
        let show = Show::new(context, "networks", folder.path(), every);
        let study = match Study::train(&dataset, &options, &show) {
            Ok(study) => show.finish(study),
            Err(error) => {
                if !begun && !show.can_go_on(&error) {
                    // The training cannot be resumed, so that the folder is cleared for a corrected command.
                    folder.clear(&plan.files().iter().map(String::as_str).collect::<Vec<_>>())?;
                }
                return Err(show.failure(error, folder.path()));
            }
        };
        let known: Vec<StudyRun> = all.iter().map(|run| run.known.clone()).collect();
        save_study(folder.path(), &study, &known)?;
        self.print(context, &study, &dataset, &differences)
    }

    fn options(&self) -> Result<StudyOptions, Failure> {
        let trainer = trainer::by_name(&self.trainer, &Default::default())?;
        if let Some(factor) = self.epoch_factor {
            if self.trainer != PAPER_TRAINER {
                return Err(Failure::new(format!(
                    "--epoch-factor {factor}: only {PAPER_TRAINER} trains for the epochs of the paper's tables; {} has \
                     its own stopping rule",
                    self.trainer
                )));
            }
            if !(factor > 0.0 && factor <= 1e3) {
                return Err(Failure::new(format!(
                    "--epoch-factor {factor}: it must be more than 0 and at most 1000"
                )));
            }
        }
        if let Some(threads @ (0 | 1025..)) = self.threads {
            return Err(Failure::new(format!("--threads {threads}: it must be from 1 to 1024")));
        }
        Ok(StudyOptions {
            form: match self.form {
                FormName::Point => Form::Point,
                FormName::Histogram => Form::Histogram,
            },
            trainer,
            epoch_factor: self.epoch_factor.unwrap_or(1.0),
            seed: self.seed,
            threads: self.threads.unwrap_or(0),
            ..StudyOptions::default()
        })
    }

    /// The training in a folder, with the options that the folder records.
    pub fn resumed(
        out: &Path,
        threads: Option<usize>,
        checkpoints: CheckpointFlags,
    ) -> Result<Train, Failure> {
        let plan = TrainingManifest::read(out)?;
        let form = match plan.form {
            Form::Point => FormName::Point,
            Form::Histogram => FormName::Histogram,
        };
        let epoch_factor = (plan.trainer == PAPER_TRAINER).then_some(plan.epoch_factor);
        let (runs, unseen, mixed, trainer, seed) =
            (plan.runs, plan.unseen, plan.mixed, plan.trainer, plan.seed);
        let out = out.to_path_buf();
        let study = StudyFlags::default();
        Ok(Train { runs, out, unseen, mixed, trainer, form, seed, epoch_factor, threads, study, checkpoints })
    }

    /// True if the folder holds a training, finished or not.
    pub fn is_in(folder: &Path) -> bool {
        folder.join(PLAN_FILE).is_file()
    }

    /// The output folder: a new one, that of an unfinished training, which is continued, or, with `--force`, that of any
    /// study. The manifest of the training is written to it first.
    fn folder(&self, context: &Context, plan: &TrainingManifest) -> Result<OutputFolder, Failure> {
        let unfinished = Train::is_in(&self.out) && !self.out.join(STUDY_FILE).exists();
        if !unfinished || context.force {
            check_free(&self.out, FolderKind::Training, context.force)?;
        } else {
            let folder = OutputFolder::open(&self.out)?;
            let differences = TrainingManifest::read(&self.out)?.differences(plan);
            if !differences.is_empty() {
                return Err(Failure::new(format!(
                    "{}: it contains an unfinished training that differs in {}; continue that one (`granum resume \
                     {}`), choose another --out, or give --force to replace it",
                    self.out.shown(),
                    differences.join(", "),
                    quoted_path(&self.out)
                )));
            }
            return Ok(folder);
        }
        let folder = OutputFolder::create(&self.out, context.force)?;
        folder.replace(&plan.files(), || plan.write(folder.path()))?;
        Ok(folder)
    }

    fn print(
        &self,
        context: &Context,
        study: &Study,
        dataset: &StudyData,
        differences: &[Difference],
    ) -> Result<(), Failure> {
        let spread = Spread::new(differences);
        let mappings: BTreeMap<String, MappingSummary> = study
            .evaluate(dataset)?
            .iter()
            .map(|evaluation| (evaluation.mapping.name.clone(), MappingSummary::new(evaluation)))
            .collect();
        let result = json!({
            "study": output::path(&self.out),
            "dataset_hash": study.dataset_hash,
            "training_seconds": study.training_seconds(),
            "runs_differ_in": spread.keys(),
            "mappings": spread.renamed(json!(mappings)),
        });
        output::say(context, &result, || {
            let mut lines = scores::lines(&mappings, spread.name());
            lines.extend(spread.explanation());
            lines.push(format!("wrote {}", self.out.shown()));
            lines.join("\n")
        })
    }
}
