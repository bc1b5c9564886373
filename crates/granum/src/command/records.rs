//! Run folders as records, for the commands that train or judge networks.

use std::path::{Path, PathBuf};

use granum_io::case::Difference;
use granum_io::shell::quoted_path;
use granum_io::{Run, RunRecord, RunStatus};
use granum_learn::NamedRecord;
use granum_learn::runs::{RunRole, StudyRun, differences_but_seed};
use granum_run::record::read_record;
use granum_sensors::Record;

use crate::context::Context;
use crate::failure::Failure;

/// What a run folder holds.
pub struct Recorded {
    /// Its folder, as the user named it.
    pub name: String,
    /// Seed of its sample; none if that is made of a packing.
    pub seed: Option<u64>,
    /// Deviator strain at the end of its case.
    pub end: f64,
    /// What the sensors saw.
    pub record: Record,
    /// What a study remembers of it.
    pub known: StudyRun,
}

impl Recorded {
    pub fn named(&self) -> NamedRecord<'_> {
        NamedRecord { name: &self.name, seed: self.seed.unwrap_or_default(), record: &self.record }
    }
}

/// Refuses a run that has not come to its test: there is nothing to draw, learn from or compare yet.
pub fn check_begun(run: &Run, about: &RunRecord) -> Result<(), Failure> {
    if about.kind == "prepare" || run.series_path().is_file() {
        return Ok(());
    }
    let (name, quoted) = (run.path().display(), quoted_path(run.path()));
    let place = if about.phase.is_empty() { "the start" } else { about.phase.as_str() };
    Err(Failure::new(format!(
        "{name}: was interrupted in {place}, before its test began; continue it with `granum resume {quoted}`"
    )))
}

/// Runs as a data set takes them.
pub fn named(runs: &[Recorded]) -> Vec<NamedRecord<'_>> {
    runs.iter().map(Recorded::named).collect()
}

/// Reads run folders; one that did not reach its end is taken with a warning.
pub fn read(context: &Context, folders: &[PathBuf], role: RunRole) -> Result<Vec<Recorded>, Failure> {
    folders.iter().map(|folder| read_one(context, folder, role)).collect()
}

fn read_one(context: &Context, folder: &Path, role: RunRole) -> Result<Recorded, Failure> {
    let run = Run::at(folder)?;
    let (case, about) = (run.case()?, run.record()?);
    if about.kind == "prepare" {
        return Err(Failure::new(format!(
            "{}: is a sample, not a test; shear it first: granum shear CASE --sample {}",
            folder.display(),
            quoted_path(folder)
        )));
    }
    check_begun(&run, &about)?;
    let record = read_record(&run)?;
    if about.status != RunStatus::Finished && !context.json {
        eprintln!("warning: {} did not reach its end; the states that it has are taken", folder.display());
    }
    // A test that is given as stages ends where its record does.
    let last = record.series.values("deviator_strain").and_then(|strains| strains.last().copied());
    let end = last.filter(|_| case.has_stages()).unwrap_or(case.shear.deviator_strain);
    Ok(Recorded {
        known: StudyRun::read(&run, role)?,
        name: folder.display().to_string(),
        seed: about.seed,
        end,
        record,
    })
}

/// Refuses runs that hold the same states: what was learned from one would be judged by itself.
pub fn check_different(runs: &[&Recorded]) -> Result<(), Failure> {
    for (k, run) in runs.iter().enumerate() {
        if let Some(same) = runs[..k].iter().find(|other| other.record == run.record) {
            let (a, b) = (&same.name, &run.name);
            return Err(Failure::new(format!(
                "{a} and {b} are the same run; training and unseen runs must differ in the seed at least"
            )));
        }
    }
    Ok(())
}

/// In what runs differ besides their seeds. That is refused unless the user asks for it: the difference between such runs
/// is no scatter between samples, and a network that learned one test is not judged by another.
pub fn check_one_test(runs: &[&Recorded], mixed: bool) -> Result<Vec<Difference>, Failure> {
    let known: Vec<(&str, &StudyRun)> = runs.iter().map(|run| (run.name.as_str(), &run.known)).collect();
    let found = differences_but_seed(&known);
    if found.is_empty() || mixed {
        return Ok(found);
    }
    let lines: Vec<String> = found.iter().map(|difference| format!("\n  {difference}")).collect();
    Err(Failure::new(format!(
        "the runs differ in more than the seed of their samples:{}\ntake runs of one case that differ in preparation.seed \
         alone, or give --mixed to train and judge on all of them",
        lines.concat()
    )))
}
