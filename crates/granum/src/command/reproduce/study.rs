//! The networks of a reproduction: training, evaluation and output.

use granum_antony2006::figures::figures;
use granum_antony2006::files::save_study;
use granum_antony2006::reproduction::SUMMARY_FILE;
use granum_antony2006::summary::{DemSummary, MappingSummary, RunSummary};
use granum_antony2006::times::SummaryTimes;
use granum_antony2006::training_checkpoints::files_of_networks;
use granum_antony2006::{
    SizeStudy, SizeStudyOptions, Study, StudyData, StudyDataOptions, StudyOptions, Summary,
};
use granum_antony2006::{StudyReport, study_report};
use granum_antony2006::{interpretation, speed};
use granum_io::run::TEST;
use granum_io::sealed::write_sealed;
use granum_io::{OutputFolder, Run};
use granum_learn::NamedRecord;
use granum_learn::runs::{RunRole, StudyRun};
use granum_report::{Role, RunReport};

use super::Reproduce;
use super::many;
use super::plan::{Plan, Role as PlannedRole};
use super::runs::Done;
use crate::command::summary_file::write_speed_page;
use crate::command::train::Show;
use crate::context::Context;
use crate::failure::Failure;

/// Folder for the networks of the study of network sizes while it runs.
const SIZES: &str = "sizes";
/// Number of repetitions when the time of a prediction is measured.
const REPETITIONS: usize = 50;

/// Trains and evaluates the networks, and writes models, figures, report and summary.
pub fn all(
    context: &Context,
    folder: &OutputFolder,
    plan: &Plan,
    all_runs: &[Done],
    arguments: &Reproduce,
) -> Result<Summary, Failure> {
    let runs = &all_runs[..plan.paper()];
    let reports: Vec<RunReport> = runs
        .iter()
        .map(|run| {
            let role = if run.role == PlannedRole::Training { Role::Training } else { Role::Unseen };
            Ok(RunReport::read(&Run::at(&run.folder)?, role)?)
        })
        .collect::<Result<_, Failure>>()?;
    let named: Vec<NamedRecord> = reports
        .iter()
        .zip(runs)
        .map(|(report, run)| NamedRecord { name: &report.name, seed: run.seed, record: &report.record })
        .collect();
    let count = runs.iter().filter(|run| run.role == PlannedRole::Training).count();
    let dataset = StudyData::new(&named[..count], &named[count..], &StudyDataOptions::default())?;
    let threads = arguments.hardware.hardware()?.threads;
    let trainer = granum_nets::trainer::by_name(&arguments.trainer, &Default::default())?;
    let options = StudyOptions { trainer, threads, ..StudyOptions::default() };

    let every = arguments.checkpoints.every()?;
    let models = folder.subfolder("models")?;
    for inside in ["models", "figures", SIZES] {
        folder.remove_unfinished_inside(inside)?;
    }
    let show = Show::new(context, "networks", &models, every);
    let mut study =
        Study::train(&dataset, &options, &show).map_err(|error| show.failure(error, folder.path()))?;
    show.checkpoints.add_seconds(&mut study);
    let networks: usize = study.mappings.iter().map(|m| m.surrogate.networks().len()).sum();
    show.end(|| format!("{networks} networks and as many strain-only networks"));
    save_study(&models, &study, &known(runs)?)?;

    // The folder is only needed until the summary contains the results.
    let sizes_folder = folder.subfolder(SIZES)?;
    let show = Show::new(context, "sizes", &sizes_folder, every);
    let sizes = size_options(arguments.quick, threads);
    let size_study =
        SizeStudy::run(&dataset, &sizes, &show).map_err(|error| show.failure(error, folder.path()))?;
    show.end(|| format!("F1 and F3 at {} sizes from {} seeds", sizes.neurons.len(), sizes.seeds));

    let many = many::curve(context, folder, plan, all_runs, &options)?;

    let judged = dataset.unseen_runs.first().or(dataset.training_runs.first());
    let dem_seconds = reports.get(count).and_then(|r| r.run.wall_seconds.get(TEST)).copied().unwrap_or(0.0);
    let speed = match judged {
        Some(run) => speed::measure(&study, run, dem_seconds, REPETITIONS)?,
        None => Default::default(),
    };
    let evaluations = study.evaluate(&dataset)?;
    let summary = Summary {
        dem: dem_summary(&reports, runs),
        mappings: evaluations.iter().map(|e| (e.mapping.name.clone(), MappingSummary::new(e))).collect(),
        reading: interpretation::read(&evaluations, Some(&size_study)),
        speed,
        size_study: Some(size_study),
        learning_curve: many,
    };
    let report = StudyReport {
        summary,
        figures: figures(&study, &dataset)?,
        command: arguments.options().command_line(None),
        runs: reports,
        dataset_hash: dataset.hash()?,
        network_seed: options.seed,
    };
    study_report(&report).write(folder.path())?;
    SummaryTimes::of(&report.summary).write(folder.path())?;
    write_speed_page(folder.path(), &report)?;
    write_sealed(&folder.file(SUMMARY_FILE), &report.summary)?;
    tidy(folder)?;
    Ok(report.summary)
}

/// Removes the networks of the study of network sizes, whose results are in the summary, also those of a reproduction with or
/// without `--quick` that this one replaced.
pub fn tidy(folder: &OutputFolder) -> Result<(), Failure> {
    let names: Vec<String> =
        [false, true].iter().flat_map(|&quick| size_options(quick, 0).networks()).collect();
    Ok(folder.clear_inside(SIZES, &files_of_networks(&names))?)
}

/// Options of the study of network sizes. Sizes are compared with the default trainer, since that of the paper would take an hour
/// and give the same result.
fn size_options(quick: bool, threads: usize) -> SizeStudyOptions {
    let options = SizeStudyOptions {
        study: StudyOptions { threads, ..StudyOptions::default() },
        ..SizeStudyOptions::default()
    };
    if quick { SizeStudyOptions { neurons: vec![1, 2, 4, 8, 20], seeds: 3, ..options } } else { options }
}

/// The descriptions of the runs that the study stores.
fn known(runs: &[Done]) -> Result<Vec<StudyRun>, Failure> {
    let role = |run: &Done| match run.role {
        PlannedRole::Training => RunRole::Training,
        PlannedRole::Unseen => RunRole::Unseen,
    };
    runs.iter().map(|run| Ok(StudyRun::read(&Run::at(&run.folder)?, role(run))?)).collect()
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
