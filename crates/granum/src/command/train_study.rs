//! `granum train --input ... --output ...`: a study of surrogates of any columns.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use granum_io::run::RunRecord;
use granum_learn::curve::range;
use granum_learn::dataset::{CatalogueEntry, unseen_runs};
use granum_learn::learning_curve::{LearningCurve, doubled};
use granum_learn::networks::{Form, NetworkSettings, SubModel};
use granum_learn::runs::{RunRole, differences_but_seed};
use granum_learn::study::{self, Study, StudyDefinition, StudyPlan, StudyScores};
use granum_learn::{Dataset, FitSpec, LearnError, RunStates, Split, SurrogateMethods};
use granum_run::runs_table::{RunEntry, differing_keys};
use serde_json::json;

use super::checkpoints::CheckpointFlags;
use super::records::{self, Recorded};
use super::show_training::{Kept, Show, fit};
use super::study_scores;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Name of the method with sub-models.
const SUB_MODELS: &str = "sub-models";
/// Largest number of different sets of training runs of one size in a learning curve.
const MOST_SETS: usize = 2;

/// The flags of a study of any columns.
#[derive(Args, Clone, Default)]
#[command(next_help_heading = "Any columns instead of the mappings of the paper")]
pub struct StudyFlags {
    /// Columns that are inputs: of the series (stress_ratio), of the case (grains.material.friction, contact.normal), of the sample
    /// (sample.void_ratio), the bin of a histogram (probability_density_0.125), or the name of a histogram for all of its
    /// bins (probability_density). --columns lists them. A word such as contact.normal becomes a column of zeros and ones
    /// for each law that the training runs have.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', requires = "output",
          conflicts_with_all = ["epoch_factor", "mixed"])]
    input: Vec<String>,
    /// Columns that are predicted, each by a surrogate of its own; any column of numbers.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', requires = "input")]
    output: Vec<String>,
    /// The column along which a test runs, such as deviator_strain or arc_length; it is an input as well. Without it, means and
    /// intervals do not vary along the test, and the inputs of runs cannot be exchanged.
    #[arg(long, value_name = "COLUMN", requires = "input")]
    coordinate: Option<String>,
    /// Methods.
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    method: Vec<String>,
    /// List the columns that all of the runs have, with their units and meanings; train nothing.
    #[arg(long, conflicts_with_all = ["input", "output", "trainer", "form", "epoch_factor", "mixed"])]
    columns: bool,
    /// Values of the coordinate at which sub-models meet: the method sub-models, which is then the default, has a network for
    /// each range between them.
    #[arg(
        long,
        value_name = "X",
        value_delimiter = ',',
        requires = "coordinate",
        allow_negative_numbers = true
    )]
    sub_models: Vec<f64>,
    /// Numbers of neurons of the hidden layers of the methods feed-forward and sub-models; by default 10 and 10.
    #[arg(long, value_name = "N", value_delimiter = ',', requires = "input",
          value_parser = clap::value_parser!(u64).range(1..=1000))]
    hidden: Vec<u64>,
    /// Largest number of training states: if there are more, every n-th of each run is used, with a different first one in each
    /// run. Methods with memory learn from all states.
    #[arg(long, value_name = "N", requires = "input", value_parser = clap::value_parser!(u64).range(1..))]
    most_states: Option<u64>,
    /// Keep this share of the runs unseen, as whole runs: they are chosen by their names and --seed, and used for evaluation only.
    #[arg(long, value_name = "X", requires = "input", allow_negative_numbers = true)]
    unseen_share: Option<f64>,
    /// Train also on 1, 2, 4, ... of the training runs, and score on the unseen runs how the error depends on their number.
    #[arg(long, requires = "input")]
    learning_curve: bool,
}

/// The same command, with the methods that the program knows in the help of `--method`.
pub fn described(command: clap::Command, methods: &SurrogateMethods) -> clap::Command {
    let names = methods.names().join(", ");
    let each: Vec<String> =
        methods.all().map(|method| format!("- {}: {}", method.name(), method.help())).collect();
    let (help, usual) = (format!("Methods: {names} [default: feed-forward]"), "[default: feed-forward]");
    let long = format!("Methods:\n{}\n{usual}", each.join("\n"));
    command.mut_arg("method", |argument| argument.help(help).long_help(long))
}

impl StudyFlags {
    /// Those of a training that is resumed, whose plan has everything else.
    pub fn resumed(unseen_share: f64) -> StudyFlags {
        StudyFlags { unseen_share: Some(unseen_share).filter(|share| *share > 0.0), ..StudyFlags::default() }
    }

    /// The share of the runs that are kept unseen; 0 if none was asked for.
    pub fn unseen_share(&self) -> Result<f64, Failure> {
        match self.unseen_share {
            None => Ok(0.0),
            Some(share) if share > 0.0 && share < 1.0 => Ok(share),
            Some(share) => Err(Failure::new(format!("--unseen-share {share}: it must be between 0 and 1"))),
        }
    }

    /// True if the columns are to be listed.
    pub fn lists_columns(&self) -> bool {
        self.columns
    }

    /// True if a study of columns was asked for.
    pub fn is_given(&self) -> bool {
        !self.input.is_empty()
    }

    /// What is asked for, without the data.
    fn asked(&self, seed: u64, trainer: &str, form: Form) -> Result<Asked, Failure> {
        let mut inputs = self.input.clone();
        if let Some(coordinate) = self.coordinate.as_ref().filter(|name| !inputs.contains(name)) {
            inputs.insert(0, coordinate.clone());
        }
        let fit = |output: &String| {
            let spec = FitSpec::new(inputs.clone(), [output.clone()]).with_seed(seed);
            match &self.coordinate {
                Some(coordinate) => spec.with_coordinate(coordinate),
                None => spec,
            }
        };
        let usual = if self.sub_models.is_empty() { "feed-forward" } else { SUB_MODELS };
        let methods = if self.method.is_empty() { vec![usual.to_string()] } else { self.method.clone() };
        if !self.sub_models.is_empty() && !methods.iter().any(|name| name == SUB_MODELS) {
            let list = methods.join(", ");
            return Err(Failure::new(format!(
                "--sub-models: {list} has no sub-models; ask for --method {SUB_MODELS} as well"
            )));
        }
        if let Some(pair) = self.sub_models.windows(2).find(|pair| pair[1] <= pair[0] || pair[0].is_nan()) {
            return Err(Failure::new(format!(
                "--sub-models: {} follows {}; the values must increase",
                pair[1], pair[0]
            )));
        }
        let mut networks =
            NetworkSettings { trainer: trainer.to_owned(), form, ..NetworkSettings::default() };
        if !self.hidden.is_empty() {
            networks.hidden = self.hidden.iter().map(|neurons| *neurons as usize).collect();
        }
        Ok(Asked {
            fits: self.output.iter().map(fit).collect(),
            methods,
            sub_models: self.sub_models.clone(),
            networks,
            most_states: self.most_states.map(|most| most as usize),
            learning_curve: self.learning_curve,
        })
    }
}

/// What a study of columns is asked for by flags.
struct Asked {
    fits: Vec<FitSpec>,
    methods: Vec<String>,
    /// Values of the coordinate at which sub-models meet.
    sub_models: Vec<f64>,
    networks: NetworkSettings,
    most_states: Option<usize>,
    learning_curve: bool,
}

impl Asked {
    /// The study of a data set.
    fn definition(mut self, dataset: &Dataset, split: Split) -> Result<StudyDefinition, Failure> {
        for fit in self.fits.iter_mut().filter(|_| !self.sub_models.is_empty()) {
            let Some(coordinate) = &fit.coordinate else { continue };
            let xs = dataset.column(coordinate)?;
            let ends = range(xs.iter().copied());
            if let Some(beyond) = self.sub_models.iter().find(|x| !(**x > ends[0] && **x < ends[1])) {
                let [low, high] = ends;
                return Err(Failure::new(format!(
                    "--sub-models {beyond}: the runs have {coordinate} from {low} to {high}, and sub-models meet in between"
                )));
            }
            fit.sub_models = SubModel::divided(ends, &self.sub_models, &self.networks.hidden);
        }
        let mut definition = StudyDefinition::new(self.fits, self.methods, split);
        definition.networks = self.networks;
        definition.most_states = self.most_states;
        definition.learning_curve = self.learning_curve;
        Ok(definition)
    }
}

/// What is trained, and where.
pub struct Training<'a> {
    pub runs: &'a [PathBuf],
    pub unseen: &'a [PathBuf],
    pub out: &'a Path,
    /// Share of the runs that are kept unseen.
    pub unseen_share: f64,
    pub threads: usize,
    pub checkpoints: &'a CheckpointFlags,
}

/// Trains a study that was asked for by flags.
pub fn train(
    context: &Context,
    training: &Training,
    flags: &StudyFlags,
    (seed, trainer, form): (u64, &str, Form),
) -> Result<(), Failure> {
    let asked = flags.asked(seed, trainer, form)?;
    let fits = asked.fits.clone();
    run(context, training, &fits, |dataset, split| asked.definition(dataset, split))
}

/// Continues the training of a plan.
pub fn resume(context: &Context, training: &Training, plan: StudyPlan) -> Result<(), Failure> {
    let mut definition = plan.definition;
    let fits = definition.fits.clone();
    run(context, training, &fits, |_, split| {
        definition.split = split;
        Ok(definition)
    })
}

fn run(
    context: &Context,
    training: &Training,
    fits: &[FitSpec],
    define: impl FnOnce(&Dataset, Split) -> Result<StudyDefinition, Failure>,
) -> Result<(), Failure> {
    let reading = context.nothing_written(Some("reading the runs"));
    let mut learned = records::read(context, training.runs, RunRole::Training)?;
    let mut unseen = records::read(context, training.unseen, RunRole::Unseen)?;
    if training.unseen_share > 0.0 {
        let seed = fits.first().map_or(1, |fit| fit.seed);
        unseen.splice(0..0, kept_unseen(&mut learned, training.unseen_share, seed));
    }
    let all: Vec<&Recorded> = learned.iter().chain(&unseen).collect();
    records::check_different(&all)?;
    if all.len() < 2 {
        return Err(Failure::new(
            "a study of columns needs two or more runs: some to learn from, and others to be scored on",
        ));
    }
    let dataset = dataset(&all)?;
    let names_of_unseen = dataset.runs()[learned.len()..].iter().map(|run| run.name().to_owned());
    let mut definition = define(&dataset, Split::default().unseen(names_of_unseen))?;
    definition.threads = training.threads;
    if definition.learning_curve && (learned.len() < 2 || unseen.is_empty()) {
        return Err(Failure::new(
            "--learning-curve: it needs two or more training runs, and unseen runs to score on",
        ));
    }
    note_differences(context, &all, fits);
    let methods = context.methods().with_networks(&definition.networks)?;
    definition.check(&dataset, &methods)?;
    let mut plan = StudyPlan::new(training.runs, training.unseen, dataset.digest(), definition.clone())?;
    plan.unseen_share = training.unseen_share;
    let every = training.checkpoints.every()?;
    drop(reading);
    let (folder, mut study) = fit(context, training.out, (&plan, &dataset, &methods), every)?;
    study.runs = all.iter().map(|run| run.known.clone()).collect();
    if definition.learning_curve {
        let show = Show::new(context, "learning curve", Kept::Nothing);
        let numbers = doubled(learned.len());
        let curve = LearningCurve::measure(&dataset, &definition, &methods, (&numbers, MOST_SETS), &show);
        study.learning_curve = Some(curve.map_err(|error| show.failure(error, folder.path()))?);
        show.end(|| format!("learning curve to {} training runs", learned.len()));
    }
    let scores = study::save(folder.path(), &study, &dataset)?;
    print(context, training.out, &study, &scores)
}

/// The data set of runs. A run has the name of its folder, or its whole path if two folders have the same name.
pub fn dataset(runs: &[&Recorded]) -> Result<Dataset, Failure> {
    let mut alike: BTreeMap<&str, usize> = BTreeMap::new();
    runs.iter().for_each(|run| *alike.entry(&run.known.name).or_default() += 1);
    let states = |run: &&Recorded| {
        let is_alone = alike.get(run.known.name.as_str()) == Some(&1);
        RunStates::of_case(if is_alone { &run.known.name } else { &run.name }, &run.case, run.record.clone())
    };
    Ok(Dataset::new(runs.iter().map(states).collect::<Result<_, LearnError>>()?)?)
}

/// Takes out of the training runs those that are kept unseen.
pub(super) fn kept_unseen(learned: &mut Vec<Recorded>, share: f64, seed: u64) -> Vec<Recorded> {
    let names: Vec<&str> = learned.iter().map(|run| run.known.name.as_str()).collect();
    let mut chosen = unseen_runs(&names, share, seed);
    chosen.reverse();
    let mut unseen: Vec<Recorded> = chosen.into_iter().map(|number| learned.remove(number)).collect();
    unseen.reverse();
    unseen.iter_mut().for_each(|run| run.known.role = RunRole::Unseen);
    unseen
}

/// Lists the columns that runs have.
pub fn list_columns(context: &Context, runs: &[PathBuf], unseen: &[PathBuf]) -> Result<(), Failure> {
    let reading = context.nothing_written(Some("reading the runs"));
    let all =
        [records::read(context, runs, RunRole::Training)?, records::read(context, unseen, RunRole::Unseen)?];
    let all: Vec<&Recorded> = all.iter().flatten().collect();
    records::check_different(&all)?;
    let sections = dataset(&all)?.catalogue(context.vocabulary().sensors());
    drop(reading);
    let entry = |kind: &str, entry: &CatalogueEntry| {
        let CatalogueEntry { name, unit, meaning, .. } = entry;
        json!({ "kind": kind, "name": name, "unit": unit, "meaning": meaning })
    };
    let each =
        sections.iter().flat_map(|section| section.entries.iter().map(move |one| entry(section.title, one)));
    output::say(context, &json!({ "columns": each.collect::<Vec<_>>() }), || {
        let mut lines = Vec::new();
        for section in &sections {
            lines.push(format!("{}:", section.title));
            lines.extend(section.entries.iter().map(|CatalogueEntry { name, unit, meaning, .. }| {
                let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
                let meaning = if meaning.is_empty() { String::new() } else { format!(": {meaning}") };
                format!("  {name}{unit}{meaning}")
            }));
        }
        lines.join("\n")
    })
}

/// Says which keys differ between the runs without being an input, since the surrogates cannot know about them.
fn note_differences(context: &Context, runs: &[&Recorded], fits: &[FitSpec]) {
    let named: Vec<_> = runs.iter().map(|run| (run.name.as_str(), &run.known)).collect();
    let entry = |run: &&Recorded| RunEntry::new(&run.name, &run.name, run.case.clone(), RunRecord::default());
    let parameters = differing_keys(&runs.iter().map(entry).collect::<Vec<_>>());
    // Of stages and materials each parameter can be an input.
    let parts = |whole: String| -> Vec<String> {
        let inside = format!("{whole}.");
        let found = parameters.iter().filter(|found| found.key.starts_with(&inside));
        let found: Vec<String> = found.map(|found| found.key.clone()).collect();
        if found.is_empty() { vec![whole] } else { found }
    };
    let unknown: Vec<String> = differences_but_seed(&named)
        .into_iter()
        .flat_map(|difference| parts(difference.key))
        .filter(|key| !fits.iter().all(|fit| fit.inputs.contains(key)))
        .collect();
    if !unknown.is_empty() {
        context.note(&format!(
            "the runs differ in {}, which is not an input: the surrogates see its effect as a difference between samples",
            unknown.join(", ")
        ));
    }
}

fn print(context: &Context, out: &Path, study: &Study, scores: &StudyScores) -> Result<(), Failure> {
    let remarks: Vec<&String> = study.fits.iter().flat_map(|fit| &fit.remarks).collect();
    let result = json!({
        "study": output::path(out),
        "dataset_digest": study.dataset_digest,
        "fits": scores.fits.iter().map(study_scores::as_json).collect::<Vec<_>>(),
        "remarks": remarks,
        "learning_curve": study.learning_curve,
    });
    output::say_complete(context, out, &result, || {
        let mut lines = study_scores::lines(scores);
        lines.extend(study.learning_curve.iter().flat_map(study_scores::learning_lines));
        lines.extend(remarks.iter().map(ToString::to_string));
        lines.push(format!("wrote {}", out.display()));
        lines.join("\n")
    })
}
