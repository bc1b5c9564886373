//! Whether the files in a folder are those that granum wrote there, and what cannot be checked.

use std::path::Path;

use granum::contents::Contents;
use granum_io::shell::{ShowPath, quoted_path};
use granum_io::{OutputFolder, Run};
use granum_learn::study::{self, STUDY_FILE};

use super::summary_file::read_summary;
use crate::context::Context;
use crate::failure::Failure;

/// Largest number of file names in a sentence.
const MOST_NAMES: usize = 3;

/// The run in a folder, for reading. Files that cannot be checked are noted.
pub fn open_run(context: &Context, folder: &Path) -> Result<Run, Failure> {
    let run = context.run_at(folder)?;
    if run.record().is_ok() {
        let names = run.uncheckable()?;
        if !names.is_empty() {
            let rest = match names.len().saturating_sub(MOST_NAMES) {
                0 => String::new(),
                rest => format!(" and {rest} more"),
            };
            let names: Vec<&str> = names.iter().take(MOST_NAMES).map(String::as_str).collect();
            context.note(&format!(
                "{}: its run.json is of an earlier version without the SHA-256 of {}{rest}, which cannot be checked",
                folder.shown(),
                names.join(", ")
            ));
        }
    }
    Ok(run)
}

/// A sentence for each file of a folder that is missing or is not the one that granum wrote. A run on which a process works is
/// left to it.
pub fn faults(context: &Context, folder: &Path, contents: &Contents) -> Result<Vec<String>, Failure> {
    match contents {
        Contents::Training { .. } => of_study(folder),
        Contents::Reproduction { finished, .. } => faults_of_reproduction(folder, *finished),
        Contents::Run(_) => faults_of_run(&context.run_at(folder)?),
        _ => Ok(Vec::new()),
    }
}

/// As [`faults`], for a run; what reads it next through the same value does not compare its files again.
pub fn faults_of_run(run: &Run) -> Result<Vec<String>, Failure> {
    if OutputFolder::is_in_use(run.path()) {
        return Ok(Vec::new());
    }
    Ok(run.faults()?.iter().map(ToString::to_string).collect())
}

/// As [`faults`], for the networks and the summary of a reproduction.
pub fn faults_of_reproduction(folder: &Path, finished: bool) -> Result<Vec<String>, Failure> {
    let models = folder.join("models");
    let mut all = of_study(&models)?;
    if finished && !models.join(STUDY_FILE).exists() {
        all.push(format!("{} is missing", models.join(STUDY_FILE).shown()));
    }
    if finished && let Err(error) = read_summary(folder) {
        all.push(error.message());
    }
    Ok(all)
}

fn of_study(folder: &Path) -> Result<Vec<String>, Failure> {
    if !granum_io::is_there(&folder.join(STUDY_FILE))? || OutputFolder::is_in_use(folder) {
        return Ok(Vec::new());
    }
    Ok(study::faults(folder)?.iter().map(ToString::to_string).collect())
}

/// An error with all of these faults; nothing if there are none.
pub fn check(folder: &Path, faults: &[String]) -> Result<(), Failure> {
    if faults.is_empty() {
        return Ok(());
    }
    Err(Failure::new(format!(
        "{}: what is in the folder is not what granum wrote there:\n  {}\nput the files back, or compute them again with --force \
         (`granum resume {}` writes again what it can)",
        folder.shown(),
        faults.join("\n  "),
        quoted_path(folder)
    )))
}
