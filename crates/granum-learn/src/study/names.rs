//! Names of the files of a study, and how files of earlier versions are recognised.

use std::path::Path;

use serde::Deserialize;

/// File that describes a study.
pub const STUDY_FILE: &str = "study.json";
/// File with the predictions for the unseen runs.
pub const SCORED_FILE: &str = "predictions.csv";

/// Name of the file of a surrogate.
pub(super) fn member_file(name: &str) -> String {
    format!("{name}.json")
}

/// The files in a folder with networks of the given surrogates, finished or not, also those that a killed process left
/// half-written.
pub(super) fn network_files(folder: &Path, surrogates: &[String]) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(|entry| entry.ok());
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let mut found: Vec<String> = names.filter(|name| surrogates.iter().any(|own| is_of(name, own))).collect();
    found.sort();
    found
}

/// True if a file is that of a network of a surrogate: `NAME-1.json`, `NAME-1.unfinished`.
fn is_of(file: &str, surrogate: &str) -> bool {
    let rest = file.strip_prefix(surrogate).and_then(|rest| rest.strip_prefix('-'));
    let Some((number, ending)) = rest.and_then(|rest| rest.split_once('.')) else { return false };
    let endings = ["json", "json.part", "unfinished", "unfinished.part"];
    number.parse::<usize>().is_ok() && endings.contains(&ending)
}

/// The first keys of every file of a study.
#[derive(Deserialize)]
pub(super) struct Head {
    pub format: String,
    pub version: u64,
}

/// The version of a file of an earlier format, which was of the paper's networks only.
pub(super) fn old_paper_format(text: &str, format: &str) -> Option<u64> {
    let head: Option<Head> = serde_json::from_str(text).ok();
    head.filter(|head| head.format == format).map(|head| head.version)
}
