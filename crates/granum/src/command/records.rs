//! Reads run folders for the commands that train or evaluate networks.

use granum_io::RunKind;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use granum_campaign::data_set::{DataSet, DataSetRun};
use granum_core::digest::Digest;
use granum_io::case::Difference;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_io::{Case, Run, RunRecord, RunStatus};
use granum_learn::runs::{RunRole, StudyRun, differences_but_seed};
use granum_run::record::read_record;
use granum_sensors::Record;

use super::whole::open_run;
use crate::context::Context;
use crate::failure::Failure;

/// The contents of a run folder.
pub struct Recorded {
    /// The folder, as the user named it.
    pub name: String,
    /// Seed of the sample; `None` if the sample is made from a packing.
    pub seed: Option<u64>,
    /// Deviator strain at the end of the test, according to the case.
    pub end: f64,
    /// The case.
    pub case: Case,
    /// The measurements.
    pub record: Record,
    /// The description of the run that a study stores.
    pub known: StudyRun,
}

/// Refuses a run whose test has not begun, since there are no data to draw, learn from or compare yet.
pub fn check_begun(run: &Run, about: &RunRecord) -> Result<(), Failure> {
    if about.kind == RunKind::Sample || run.has_series() {
        return Ok(());
    }
    let (name, quoted) = (run.path().shown(), quoted_path(run.path()));
    if about.status == RunStatus::Finished {
        return Err(Failure::new(format!(
            "{name}: the test is finished, but its series.parquet is missing; put the file back, or run the case again"
        )));
    }
    let place = if about.phase.is_empty() { "the start" } else { about.phase.as_str() };
    Err(Failure::new(format!(
        "{name}: it was interrupted in {place}, before its test began; continue it with `granum resume {quoted}`"
    )))
}

/// Reads run folders, campaigns and data sets, whose runs stand for them; a run that did not reach its end is used, with a warning.
pub fn read(context: &Context, folders: &[PathBuf], role: RunRole) -> Result<Vec<Recorded>, Failure> {
    let mut all = Vec::new();
    for folder in folders {
        match DataSet::meant_by(folder)? {
            Some(inside) => {
                let data_set = DataSet::read(&inside, context.reading())?;
                all.extend(data_set.each_run()?.into_iter().map(|run| of_data_set(folder, run, role)));
            }
            None => all.push(read_one(context, folder, role)?),
        }
    }
    Ok(all)
}

/// A run of a data set.
fn of_data_set(folder: &Path, run: DataSetRun, role: RunRole) -> Recorded {
    let DataSetRun { name, case, record, digest, measured } = run;
    Recorded {
        known: StudyRun::of_case(&name, role, &case, record.packing_digest(), &digest),
        name: folder.join(&name).shown(),
        seed: record.seed,
        end: end(&case, &measured),
        case,
        record: measured,
    }
}

/// The deviator strain at the end of a test; one that does not end at a deviator strain goes as far as its record.
fn end(case: &Case, record: &Record) -> f64 {
    let last = || record.series.values("deviator_strain").and_then(|strains| strains.last().copied());
    case.test_definition().deviator_strain_end().or_else(last).unwrap_or_default()
}

fn read_one(context: &Context, folder: &Path, role: RunRole) -> Result<Recorded, Failure> {
    let run = open_run(context, folder)?;
    let (case, about) = (run.case()?, run.record()?);
    if about.kind == RunKind::Sample {
        return Err(Failure::new(format!(
            "{}: this is a sample, not a test; test it first: granum run CASE --sample {}",
            folder.shown(),
            quoted_path(folder)
        )));
    }
    check_begun(&run, &about)?;
    let record = read_record(&run)?;
    if about.status != RunStatus::Finished {
        context
            .warn(&format!("{} did not reach its end; the states recorded so far are used", folder.shown()));
    }
    Ok(Recorded {
        known: StudyRun::read(&run, role)?,
        name: folder.shown(),
        seed: about.seed,
        end: end(&case, &record),
        case,
        record,
    })
}

/// Refuses runs with identical states, since networks would be evaluated on the data from which they learned.
pub fn check_different(runs: &[&Recorded]) -> Result<(), Failure> {
    let mut known: BTreeMap<String, &Recorded> = BTreeMap::new();
    for run in runs {
        if let Some(same) = known.insert(content(&run.record), run) {
            let (a, b) = (&same.name, &run.name);
            return Err(Failure::new(format!(
                "{a} and {b} are the same run; training and unseen runs must differ at least in the seed"
            )));
        }
    }
    Ok(())
}

/// A digest of the measurements of a run.
fn content(record: &Record) -> String {
    let mut digest = Digest::new();
    for column in record.series.columns() {
        digest.text(&column.name);
        digest.numbers(&column.values);
    }
    for histogram in record.histograms.iter().flat_map(|histograms| &histograms.states) {
        histogram.counts.iter().for_each(|count| digest.count(*count as usize));
    }
    digest.finish()
}

/// The differences between runs other than their seeds. They are refused unless the user allows them, because the difference
/// between such runs is not the scatter between samples, and a network should not be evaluated on another test than it
/// learned.
pub fn check_one_test(runs: &[&Recorded], mixed: bool) -> Result<Vec<Difference>, Failure> {
    let known: Vec<(&str, &StudyRun)> = runs.iter().map(|run| (run.name.as_str(), &run.known)).collect();
    let found = differences_but_seed(&known);
    if found.is_empty() || mixed {
        return Ok(found);
    }
    let lines: Vec<String> = found.iter().map(|difference| format!("\n  {difference}")).collect();
    Err(Failure::new(format!(
        "the runs differ in more than the seed of their samples:{}\nuse runs of one case that differ only in \
         preparation.seed, or give --mixed to train and score on all of them",
        lines.concat()
    )))
}
