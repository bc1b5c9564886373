//! `granum train`: the networks of the six mappings from run folders.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use granum_antony2006::evaluation::training_seconds;
use granum_antony2006::mapping::{PAPER_STRAIN, paper_mappings_to};
use granum_antony2006::summary::MappingSummary;
use granum_antony2006::{Evaluation, PAPER_TRAINER, PaperData, PaperDataOptions, PaperOptions, is_of_paper};
use granum_io::case::Difference;
use granum_io::shell::ShowPath;
use granum_learn::networks::Form;
use granum_learn::runs::{RunRole, StudyRun};
use granum_learn::study::{self, Study, StudyPlan};
use granum_nets::trainer;
use serde_json::json;

use super::checkpoints::CheckpointFlags;
use super::records::{self, Recorded};
use super::scores;
use super::show_training::fit;
use super::spread::Spread;
use super::train_family;
use super::train_study::{self, StudyFlags, Training};
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::apart;
use crate::output;

/// Train the eighteen networks of the six mappings of the paper, and for each a strain-only network of the same size; with
/// --input and --output surrogates of any columns.
///
/// Every second state of the training runs is used for training, and the others are held out for evaluation; unseen runs are
/// used for evaluation only. All runs must have the same case and differ only in preparation.seed, unless --mixed is given.
/// With --input and --output runs may differ in anything, and every method is compared with ridge regression, with itself on
/// the coordinate alone, and with the mean curve of the training runs.
/// The same command, or `granum resume`, continues an interrupted training.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum train run-1 --unseen run-2 run-3 --out study\n  granum train run-1 --trainer traingdx \
                  --epoch-factor 0.1 --out quick-study\n  granum train run-1 run-2 --unseen run-3 --input deviator_fabric,probability_density \\\n    --output stress_ratio --coordinate deviator_strain --method feed-forward,ridge -o columns\n  granum train study --input grains.material.friction,sample.void_ratio --output stress_ratio \\\n    --coordinate arc_length --unseen-share 0.2 -o surrogate\n  granum train run-1 run-2 --columns\n  granum train study \
                  --family sand --unseen other-study -o sand.json"
)]
pub struct Train {
    /// Run folders for training; campaigns and data sets stand for all of their runs.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Folder of the study; with --family the file of the fitted family.
    #[arg(short, long, default_value = "study", value_name = "DIR")]
    out: PathBuf,
    /// Run folders, campaigns or data sets that are used for evaluation only.
    #[arg(long, num_args = 1.., value_name = "RUN")]
    unseen: Vec<PathBuf>,
    /// Accept runs that differ in more than the seed. The keys that differ are printed, and the difference between the
    /// runs is not called the scatter between samples.
    #[arg(long)]
    mixed: bool,
    #[arg(long, default_value = trainer::NAMES[0], value_name = "NAME", help = trainers())]
    trainer: String,
    /// Form in which P(f), or another histogram, enters the networks of sub-models: as single points f, P (as in the paper), or as
    /// all bins at once.
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
    /// Fit the surrogate of this family of tests (sand), which `granum predict --family` asks, and score it on the unseen runs.
    #[arg(
        long,
        value_name = "NAME",
        conflicts_with_all = ["input", "output", "columns", "trainer", "form", "epoch_factor", "mixed"]
    )]
    family: Option<String>,
    /// Path of the tests of --family; its first one by default. Runs along other paths are left out.
    #[arg(long, value_name = "NAME", requires = "family")]
    path: Option<String>,
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

impl From<FormName> for Form {
    fn from(name: FormName) -> Form {
        match name {
            FormName::Point => Form::Point,
            FormName::Histogram => Form::Histogram,
        }
    }
}

impl Train {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let mut options = self.options()?;
        if let Some(family) = &self.family {
            let data = (&self.runs[..], &self.unseen[..]);
            let family = (family.as_str(), self.path.as_deref());
            return train_family::train(context, family, data, &self.out, options.threads);
        }
        if self.study.lists_columns() {
            return train_study::list_columns(context, &self.runs, &self.unseen);
        }
        if self.study.is_given() {
            let settings = (self.seed, self.trainer.as_str(), options.form);
            return train_study::train(context, &self.training(options.threads)?, &self.study, settings);
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
        let mut runs = train_study::dataset(&all)?.runs().to_vec();
        let unseen = runs.split_off(training.len());
        let data = PaperData::new(runs, unseen, &PaperDataOptions::default())?;
        let (definition, methods) = (options.definition(&data), options.methods());
        // This check comes before a folder is created and before an older one is replaced.
        definition.check(&data.dataset, &methods)?;
        let every = self.checkpoints.every()?;
        let mut plan = StudyPlan::new(&self.runs, &self.unseen, data.dataset.digest(), definition)?;
        plan.mixed = self.mixed;
        drop(reading);
        let (folder, mut study) = fit(context, &self.out, (&plan, &data.dataset, &methods), every)?;
        study.runs = all.iter().map(|run| run.known.clone()).collect::<Vec<StudyRun>>();
        study::save(folder.path(), &study, &data.dataset)?;
        self.print(context, &study, &data, &differences)
    }

    fn training(&self, threads: usize) -> Result<Training<'_>, Failure> {
        Ok(Training {
            runs: &self.runs,
            unseen: &self.unseen,
            out: &self.out,
            unseen_share: self.study.unseen_share()?,
            threads,
            checkpoints: &self.checkpoints,
        })
    }

    fn options(&self) -> Result<PaperOptions, Failure> {
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
        Ok(PaperOptions {
            form: self.form.into(),
            trainer,
            epoch_factor: self.epoch_factor.unwrap_or(1.0),
            seed: self.seed,
            threads: self.threads.unwrap_or(0),
            ..PaperOptions::default()
        })
    }

    /// Continues the training in a folder, with the options that the folder records.
    pub fn resume(
        context: &Context,
        out: &Path,
        threads: Option<usize>,
        checkpoints: CheckpointFlags,
    ) -> Result<(), Failure> {
        let plan = StudyPlan::read(out)?;
        let form = match plan.definition.networks.form {
            Form::Point => FormName::Point,
            Form::Histogram => FormName::Histogram,
        };
        let train = Train {
            runs: plan.runs.clone(),
            out: out.to_path_buf(),
            unseen: plan.unseen.clone(),
            mixed: plan.mixed,
            trainer: plan.definition.networks.trainer.clone(),
            form,
            seed: plan.definition.fits.first().map_or(1, |fit| fit.seed),
            epoch_factor: plan.definition.networks.epoch_factor,
            threads,
            family: None,
            path: None,
            study: StudyFlags::resumed(plan.unseen_share),
            checkpoints,
        };
        if is_of_paper(&plan.definition) {
            return train.run(context);
        }
        train_study::resume(context, &train.training(threads.unwrap_or(0))?, plan)
    }

    /// True if the folder holds a training, finished or not.
    pub fn is_in(folder: &Path) -> bool {
        folder.join(study::PLAN_FILE).is_file()
    }

    fn print(
        &self,
        context: &Context,
        study: &Study,
        data: &PaperData,
        differences: &[Difference],
    ) -> Result<(), Failure> {
        let spread = Spread::new(differences);
        let mappings: BTreeMap<String, MappingSummary> = Evaluation::of_study(study, data)?
            .iter()
            .map(|evaluation| (evaluation.mapping.name.clone(), MappingSummary::new(evaluation)))
            .collect();
        let result = json!({
            "study": output::path(&self.out),
            "dataset_hash": data.hash()?,
            "training_seconds": training_seconds(study),
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
