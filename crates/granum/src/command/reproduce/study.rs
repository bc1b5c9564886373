//! The networks of a reproduction: training, evaluation and output.

use std::time::Duration;

use granum_antony2006::evaluation::networks;
use granum_antony2006::figures::figures;
use granum_antony2006::reproduction::{ReproductionOptions, SUMMARY_FILE};
use granum_antony2006::summary::{DemSummary, MappingSummary, RunSummary};
use granum_antony2006::times::SummaryTimes;
use granum_antony2006::{
    Evaluation, PaperData, PaperDataOptions, PaperOptions, PaperSummary, SizeStudy, SizeStudyOptions,
};
use granum_antony2006::{StudyReport, study_report};
use granum_antony2006::{interpretation, speed};
use granum_io::OutputFolder;
use granum_io::run::TEST;
use granum_io::sealed::write_sealed;
use granum_learn::NamedRecord;
use granum_learn::networks::KeptNetworks;
use granum_learn::runs::{RunRole, StudyRun};
use granum_learn::study::{self, KeptStudy, PLAN_FILE, Study, StudyPlan};
use granum_report::RunReport;

use super::many;
use super::plan::ReproductionPlan;
use super::runs::Done;
use crate::command::show_training::{Kept, Show};
use crate::command::summary_file::write_speed_page;
use crate::context::Context;
use crate::failure::Failure;

/// Folder for the networks of the study of network sizes while it runs.
const SIZES: &str = "sizes";
/// Number of repetitions when the time of a prediction is measured.
const REPETITIONS: usize = 50;

/// How the networks are trained.
pub struct TrainingSettings {
    /// The options of the reproduction.
    pub options: ReproductionOptions,
    /// Interval of the checkpoints.
    pub every: Duration,
    /// Number of threads.
    pub threads: usize,
}

/// Trains and evaluates the networks, and writes models, figures, report and summary.
pub fn all(
    context: &Context,
    folder: &OutputFolder,
    plan: &ReproductionPlan,
    all_runs: &[Done],
    settings: &TrainingSettings,
) -> Result<PaperSummary, Failure> {
    let runs = &all_runs[..plan.paper()];
    let reports: Vec<RunReport> = runs
        .iter()
        .map(|run| Ok(RunReport::read(&context.run_at(&run.folder)?, run.role.into())?))
        .collect::<Result<_, Failure>>()?;
    let named: Vec<NamedRecord> = reports
        .iter()
        .zip(runs)
        .map(|(report, run)| NamedRecord { name: &report.name, seed: run.seed, record: &report.record })
        .collect();
    let count = runs.iter().filter(|run| run.role == RunRole::Training).count();
    let data = PaperData::from_records(&named[..count], &named[count..], &PaperDataOptions::default())?;
    let threads = settings.threads;
    let trainer = granum_nets::trainer::by_name(&settings.options.trainer, &Default::default())?;
    let options = PaperOptions { trainer, threads, ..PaperOptions::default() };

    let every = settings.every;
    let models = folder.subfolder("models")?;
    for inside in ["models", "figures", SIZES] {
        folder.remove_unfinished_inside(inside)?;
    }
    for path in granum_antony2006::files_of_earlier_versions().iter().map(|name| models.join(name)) {
        if path.is_file() {
            std::fs::remove_file(&path).map_err(granum_io::Error::file("remove", &path))?;
        }
    }
    let (definition, methods) = (options.definition(&data), options.methods());
    // The runs are those of the folder, wherever it is.
    let study_plan = StudyPlan::new(&[], &[], data.dataset.digest(), definition.clone())?;
    let kept = KeptStudy::begin(&models, &study_plan, &methods, every)?;
    let show = Show::new(context, "networks", Kept::Study(kept));
    let mut study = Study::train(&data.dataset, &definition, &methods, &show)
        .map_err(|error| show.failure(error, folder.path()))?;
    let counts = study.fits.iter().map(|fit| Ok(networks(&study, &fit.name)?.networks().len()));
    let count_of_networks = counts.sum::<Result<usize, granum_learn::LearnError>>()?;
    show.end(|| format!("{count_of_networks} networks and as many strain-only networks"));
    study.runs = known(context, runs)?;
    study::save(&models, &study, &data.dataset)?;

    // The folder is only needed until the summary contains the results.
    let sizes_folder = folder.subfolder(SIZES)?;
    let show = Show::new(context, "sizes", Kept::Networks(KeptNetworks::new(&sizes_folder, every)));
    let sizes = size_options(settings.options.quick, threads);
    let size_study =
        SizeStudy::run(&data, &sizes, &show).map_err(|error| show.failure(error, folder.path()))?;
    show.end(|| format!("F1 and F3 at {} sizes from {} seeds", sizes.neurons.len(), sizes.seeds));

    let many = many::curve(context, folder, plan, all_runs, &options)?;

    let judged = data.parts.unseen.runs().first().or(data.parts.training_runs.runs().first());
    let dem_seconds = reports.get(count).and_then(|r| r.run.wall_seconds.get(TEST)).copied().unwrap_or(0.0);
    let speed = match judged {
        Some(run) => speed::measure(&study, run, dem_seconds, REPETITIONS)?,
        None => Default::default(),
    };
    let evaluations = Evaluation::of_study(&study, &data)?;
    let summary = PaperSummary {
        dem: dem_summary(&reports, runs),
        mappings: evaluations.iter().map(|e| (e.mapping.name.clone(), MappingSummary::new(e))).collect(),
        reading: interpretation::read(&evaluations, Some(&size_study)),
        speed,
        size_study: Some(size_study),
        learning_curve: many,
    };
    let report = StudyReport {
        summary,
        figures: figures(&study, &data)?,
        command: settings.options.command_line(None),
        runs: reports,
        dataset_hash: data.hash()?,
        network_seed: options.seed,
    };
    study_report(&report).write(folder.path())?;
    SummaryTimes::from_summary(&report.summary).write(folder.path())?;
    write_speed_page(folder.path(), &report)?;
    write_sealed(&folder.file(SUMMARY_FILE), &report.summary)?;
    tidy(folder)?;
    Ok(report.summary)
}

/// Removes the plan of the networks, and the networks of the study of network sizes, whose results are in the summary, also those of a reproduction with or
/// without `--quick` that this one replaced.
pub fn tidy(folder: &OutputFolder) -> Result<(), Failure> {
    let names: Vec<String> =
        [false, true].iter().flat_map(|&quick| size_options(quick, 0).networks()).collect();
    let plan = folder.file("models").join(PLAN_FILE);
    if plan.is_file() {
        std::fs::remove_file(&plan).map_err(granum_io::Error::file("remove", &plan))?;
    }
    Ok(folder.clear_inside(SIZES, &KeptNetworks::files(&names))?)
}

/// Options of the study of network sizes. Sizes are compared with the default trainer, since that of the paper would take an hour
/// and give the same result.
fn size_options(quick: bool, threads: usize) -> SizeStudyOptions {
    let options = SizeStudyOptions {
        study: PaperOptions { threads, ..PaperOptions::default() },
        ..SizeStudyOptions::default()
    };
    if quick { SizeStudyOptions { neurons: vec![1, 2, 4, 8, 20], seeds: 3, ..options } } else { options }
}

/// The descriptions of the runs that the study stores.
fn known(context: &Context, runs: &[Done]) -> Result<Vec<StudyRun>, Failure> {
    runs.iter().map(|run| Ok(StudyRun::read(&context.run_at(&run.folder)?, run.role)?)).collect()
}

fn dem_summary(reports: &[RunReport], runs: &[Done]) -> DemSummary {
    let sample = reports.first().map(|r| &r.run);
    let measure = |name: &str| sample.and_then(|s| s.measures.get(name)).copied().unwrap_or(f64::NAN);
    DemSummary {
        grains: sample.map_or(0, |s| s.grains),
        solid_fraction: measure("solid_fraction"),
        coordination_number: measure("coordination_number"),
        mechanical_coordination_number: measure("mechanical_coordination_number"),
        runs: reports
            .iter()
            .zip(runs)
            .map(|(report, run)| RunSummary {
                role: run.role.name().to_string(),
                seed: run.seed,
                wall_seconds: report.wall_seconds(),
                grain_steps: report.run.grain_steps() as f64,
            })
            .collect(),
    }
}
