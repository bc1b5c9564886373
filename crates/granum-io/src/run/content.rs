//! The names of the files of a run.

use std::path::Path;

use super::file_digest::RECORD;
use super::record::RunRecord;
use super::states::STATES;
use super::times;
use crate::folder::check_name;
use crate::snapshot::{PARTS, bonds, list_snapshots, pieces};

pub(crate) const CASE: &str = "case.toml";
pub(super) const SERIES: &str = "series.parquet";
pub(super) const FORCES: &str = "forces.parquet";
pub(super) const PREPARATION: &str = "preparation.parquet";
pub(super) const SNAPSHOTS: &str = "snapshots";
pub(super) const HISTOGRAMS: &str = "histograms";
pub(super) const REPORT: &str = "report.html";
pub(super) const FIGURES: &str = "figures";
/// Inner folders, in whose places links are refused.
pub(super) const FOLDERS: [&str; 3] = [SNAPSHOTS, HISTOGRAMS, FIGURES];

/// Name of the checkpoint in a run folder.
pub const CHECKPOINT: &str = "checkpoint";
/// Name of the previous checkpoint.
pub const PREVIOUS_CHECKPOINT: &str = "checkpoint.previous";
/// Name given to a checkpoint that could not be used, so that it does not replace the previous valid one.
pub const REFUSED_CHECKPOINT: &str = "checkpoint.refused";

/// The tables of a run beside its histograms.
pub(super) const TABLES: [&str; 3] = [SERIES, FORCES, PREPARATION];

/// True for a name that a file with the content of a run can have: a record that names any other file was not written by granum.
pub(super) fn is_of_a_run(name: &str) -> bool {
    let word = |word: &str| check_name("file", word).is_ok();
    match name.split_once('/') {
        None => TABLES.contains(&name),
        Some((HISTOGRAMS, file)) => file.strip_suffix(".parquet").is_some_and(word),
        Some((SNAPSHOTS, file)) => file.split_once('.').is_some_and(|(name, end)| {
            word(name) && (PARTS.contains(&end) || [pieces::FILE, bonds::FILE].contains(&end))
        }),
        Some(_) => false,
    }
}

/// The name of a histogram in a run folder.
pub(super) fn histogram_file(name: &str) -> String {
    format!("{HISTOGRAMS}/{name}.parquet")
}

/// The names of the files that a snapshot in a run folder may have beside those that every snapshot has.
pub(super) fn further_snapshot_files(name: &str) -> [String; 2] {
    [pieces::FILE, bonds::FILE].map(|end| format!("{SNAPSHOTS}/{name}.{end}"))
}

/// The names of the three files of every snapshot in a run folder.
pub(super) fn snapshot_files(name: &str) -> [String; 3] {
    PARTS.map(|end| format!("{SNAPSHOTS}/{name}.{end}"))
}

/// True for a file of a snapshot.
pub(super) fn is_of_snapshot(name: &str) -> bool {
    name.strip_prefix(SNAPSHOTS).is_some_and(|rest| rest.starts_with('/'))
}

/// The snapshots that a folder of an earlier version holds: its record does not list them, but their names are known.
pub(super) fn usual_snapshots(folder: &Path) -> Vec<String> {
    let usual = |name: &String| {
        let numbered = |rest: &str| rest.chars().all(|c| c.is_ascii_digit() || matches!(c, '_' | 'e' | '-'));
        let after = |start| name.strip_prefix(start).is_some_and(numbered);
        name == "start" || name == "end" || after("stage-") || after("strain-")
    };
    list_snapshots(&folder.join(SNAPSHOTS)).unwrap_or_default().into_iter().filter(usual).collect()
}

/// Every file in a folder that a run or its report wrote, the record last: what `--force` replaces. A file that granum did not
/// write is not among them.
pub(super) fn written(folder: &Path, record: Option<&RunRecord>) -> Vec<String> {
    let mut names: Vec<String> = TABLES.map(String::from).to_vec();
    names.extend(
        [CASE, CHECKPOINT, PREVIOUS_CHECKPOINT, REFUSED_CHECKPOINT, REPORT, STATES, times::TIMES]
            .map(String::from),
    );
    if let Some(record) = record {
        names.extend(record.content.keys().chain(record.replaced.keys()).cloned());
    }
    if record.is_none_or(|record| !record.lists_all()) {
        names.extend(usual_snapshots(folder).iter().flat_map(|name| snapshot_files(name)));
    }
    names.extend(
        crate::figure_list::names(&folder.join(FIGURES)).iter().map(|name| format!("{FIGURES}/{name}")),
    );
    names.sort();
    names.dedup();
    names.push(RECORD.to_string());
    names
}
