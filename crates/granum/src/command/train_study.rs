//! `granum train --input ... --output ...`: a study of surrogates of any columns.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use clap::Args;
use granum::contents::{FolderKind, check_free};
use granum_io::run::RunRecord;
use granum_io::shell::quoted_path;
use granum_io::{OutputFolder, Run};
use granum_learn::dataset::CatalogueEntry;
use granum_learn::runs::{RunRole, differences_but_seed};
use granum_learn::study::{self, STUDY_FILE, Study, StudyDefinition, StudyObserver, StudyPlan, StudyScores};
use granum_learn::surrogate::{Surrogate, save};
use granum_learn::{Dataset, FitSpec, LearnError, RunStates, Split, SurrogateMethods};
use granum_run::laboratory::Field;
use granum_run::runs_table::{RunEntry, differing_keys};
use granum_sensors::Sensors;
use serde_json::json;

use super::records::{self, Recorded};
use super::study_scores;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::output;
use crate::progress::Progress;
use crate::surrogate_methods::surrogate_methods;

/// The flags of a study of any columns.
#[derive(Args, Clone, Default)]
#[command(next_help_heading = "Any columns instead of the mappings of the paper")]
pub struct StudyFlags {
    /// Columns that are inputs: of the series (stress_ratio), of the case (grains.material.friction, contact.normal), of the sample
    /// (sample.void_ratio), the bin of a histogram (probability_density_0.125), or the name of a histogram for all of its
    /// bins (probability_density). --columns lists them. A word such as contact.normal becomes a column of zeros and ones
    /// for each law that the training runs have.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', requires = "output",
          conflicts_with_all = ["trainer", "form", "epoch_factor", "mixed"])]
    input: Vec<String>,
    /// Columns that are predicted, each by a surrogate of its own; any column of numbers.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', requires = "input")]
    output: Vec<String>,
    /// The column along which a test runs, such as deviator_strain or arc_length; it is an input as well. Without it, means and
    /// intervals do not vary along the test, and the inputs of runs cannot be exchanged.
    #[arg(long, value_name = "COLUMN", requires = "input")]
    coordinate: Option<String>,
    #[arg(long, value_name = "NAME", value_delimiter = ',', default_value = "feed-forward", help = methods())]
    method: Vec<String>,
    /// List the columns that all of the runs have, with their units and meanings; train nothing.
    #[arg(long, conflicts_with_all = ["input", "output", "trainer", "form", "epoch_factor", "mixed"])]
    columns: bool,
}

/// The help text of `--method`: the names of all methods.
fn methods() -> String {
    let names = surrogate_methods().names().join(", ");
    format!("Methods: {names}; the last one for the inputs and outputs of one of the paper's mappings")
}

impl StudyFlags {
    /// True if the columns are to be listed.
    pub fn lists_columns(&self) -> bool {
        self.columns
    }

    /// True if a study of columns was asked for.
    pub fn is_given(&self) -> bool {
        !self.input.is_empty()
    }

    fn fits(&self, seed: u64) -> Vec<FitSpec> {
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
        self.output.iter().map(fit).collect()
    }
}

/// What is trained, and where.
pub struct Training<'a> {
    pub runs: &'a [PathBuf],
    pub unseen: &'a [PathBuf],
    pub out: &'a Path,
    pub threads: usize,
}

/// Trains a study that was asked for by flags.
pub fn train(context: &Context, training: &Training, flags: &StudyFlags, seed: u64) -> Result<(), Failure> {
    run(context, training, flags.fits(seed), flags.method.clone())
}

/// Continues the training in a folder.
pub fn resume(context: &Context, folder: &Path, threads: usize) -> Result<(), Failure> {
    let StudyPlan { runs, unseen, definition, .. } = StudyPlan::read(folder)?;
    let training = Training { runs: &runs, unseen: &unseen, out: folder, threads };
    run(context, &training, definition.fits, definition.methods)
}

fn run(
    context: &Context,
    training: &Training,
    fits: Vec<FitSpec>,
    names: Vec<String>,
) -> Result<(), Failure> {
    let reading = context.nothing_written(Some("reading the runs"));
    let learned = records::read(context, training.runs, RunRole::Training)?;
    let unseen = records::read(context, training.unseen, RunRole::Unseen)?;
    let all: Vec<&Recorded> = learned.iter().chain(&unseen).collect();
    records::check_different(&all)?;
    let folders: Vec<&PathBuf> = training.runs.iter().chain(training.unseen).collect();
    let dataset = dataset(&all, &folders)?;
    note_differences(context, &all, &fits);
    let names_of_unseen = dataset.runs()[learned.len()..].iter().map(|run| run.name().to_owned());
    let mut definition = StudyDefinition::new(fits, names, Split::default().unseen(names_of_unseen));
    definition.fits.iter_mut().for_each(|fit| fit.threads = training.threads);
    let methods = surrogate_methods();
    definition.check(&dataset, &methods)?;
    let plan = StudyPlan::new(training.runs, training.unseen, dataset.digest(), definition.clone());
    drop(reading);
    let folder = folder(context, training.out, &plan)?;
    let show = Show::new(context, folder.path(), &methods);
    let mut study = match Study::train(&dataset, &definition, &methods, &show) {
        Ok(study) => study,
        Err(LearnError::Stopped { done, total }) => {
            let (name, quoted) = (training.out.display(), quoted_path(training.out));
            let left =
                format!("{done} of {total} surrogates are in {name}; continue with `granum resume {quoted}`");
            return Err(Interrupted { left }.into());
        }
        Err(error) => {
            // It would fail again in the same way, so that the folder is cleared for a corrected command.
            folder.clear(&plan.files().iter().map(String::as_str).collect::<Vec<_>>())?;
            return Err(error.into());
        }
    };
    show.end(study.members().count());
    study.runs = all.iter().map(|run| run.known.clone()).collect();
    let scores = study::save(folder.path(), &study, &dataset)?;
    print(context, training.out, &study, &scores)
}

/// The data set of run folders. A run has the name of its folder, or its whole path if two folders have the same name.
pub fn dataset(runs: &[&Recorded], folders: &[&PathBuf]) -> Result<Dataset, Failure> {
    let own = |run: &Recorded| runs.iter().filter(|other| other.known.name == run.known.name).count() == 1;
    let read = |(run, folder): (&&Recorded, &&PathBuf)| {
        let name = if own(run) { &run.known.name } else { &run.name };
        RunStates::read(name, &Run::at(folder)?)
    };
    Ok(Dataset::new(runs.iter().zip(folders).map(read).collect::<Result<_, LearnError>>()?)?)
}

/// Lists the columns that runs have.
pub fn list_columns(context: &Context, runs: &[PathBuf], unseen: &[PathBuf]) -> Result<(), Failure> {
    let reading = context.nothing_written(Some("reading the runs"));
    let all =
        [records::read(context, runs, RunRole::Training)?, records::read(context, unseen, RunRole::Unseen)?];
    let all: Vec<&Recorded> = all.iter().flatten().collect();
    records::check_different(&all)?;
    let folders: Vec<&PathBuf> = runs.iter().chain(unseen).collect();
    let sections = dataset(&all, &folders)?.catalogue(&Sensors::standard());
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

/// The output folder: a new one, that of an unfinished training of the same study, or, with `--force`, that of any training.
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
            out.display(),
            differences.join(", "),
            quoted_path(out)
        )));
    }
    check_free(out, FolderKind::Training, context.force)?;
    let folder = OutputFolder::create(out, context.force)?;
    folder.clear(&plan.files().iter().map(String::as_str).collect::<Vec<_>>())?;
    plan.write(folder.path())?;
    Ok(folder)
}

/// Shows which surrogate is fitted, stores each, and stops when the user asks for it.
struct Show<'a> {
    context: &'a Context,
    folder: &'a Path,
    methods: &'a SurrogateMethods,
    progress: Mutex<Progress>,
}

impl<'a> Show<'a> {
    fn new(context: &'a Context, folder: &'a Path, methods: &'a SurrogateMethods) -> Show<'a> {
        let mut progress = context.progress();
        progress.phase("surrogates");
        Show { context, folder, methods, progress: Mutex::new(progress) }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.json"))
    }

    fn end(self, count: usize) {
        let mut progress = self.progress.into_inner().unwrap_or_else(PoisonError::into_inner);
        progress.end(|| format!("{count} surrogates with their baselines"));
    }
}

impl StudyObserver for Show<'_> {
    fn begins(&self, name: &str, number: usize, all: usize) {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress.update(Some((number - 1) as f64 / all as f64), |_| vec![Field::new(0, name.to_owned())]);
    }
    fn finished(&self, name: &str) -> granum_learn::Result<Option<Box<dyn Surrogate>>> {
        let file = self.file(name);
        if file.is_file() { self.methods.load(&file).map(Some) } else { Ok(None) }
    }
    fn fitted(&self, name: &str, surrogate: &dyn Surrogate) -> granum_learn::Result<()> {
        save(&self.file(name), surrogate)
    }
    fn stop(&self) -> bool {
        self.context.stopped()
    }
}

fn print(context: &Context, out: &Path, study: &Study, scores: &StudyScores) -> Result<(), Failure> {
    let remarks: Vec<&String> = study.fits.iter().flat_map(|fit| &fit.remarks).collect();
    let result = json!({
        "study": output::path(out),
        "dataset_digest": study.dataset_digest,
        "fits": scores.fits.iter().map(study_scores::as_json).collect::<Vec<_>>(),
        "remarks": remarks,
    });
    output::say_complete(context, out, &result, || {
        let mut lines = study_scores::lines(scores);
        lines.extend(remarks.iter().map(ToString::to_string));
        lines.push(format!("wrote {}", out.display()));
        lines.join("\n")
    })
}
