//! The file of sums of a data set, and whether the files in a folder are still those of which it was written.

use std::collections::BTreeMap;
use std::path::Path;

use granum_core::digest::Digest;
use granum_io::run::file_digest;
use granum_io::shell::ShowPath;
use granum_io::{Result, read_table_with_words};

use super::layout::{CARD, CASE_FILE, LEFT_OUT_FILE, METADATA, RUNS_FILE, SECONDS_FILE, STATES_FILE, SUMS};

/// First line of the file of sums.
const FIRST_LINE: &str = "# granum data set 1";
/// Beginning of the line with the digest of what the data set was made of.
const MADE_OF: &str = "# made of ";
/// Beginning of the line with the digest of the content.
const CONTENT: &str = "# content ";
/// The files with sums; the one of runs that were left out need not be there.
const WITH_SUMS: [&str; 6] = [CARD, CASE_FILE, LEFT_OUT_FILE, METADATA, RUNS_FILE, STATES_FILE];

/// The data set that a folder has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Known {
    /// That which is wanted, with the SHA-256 over its content.
    Whole(String),
    /// That which is wanted, of which a file is not the one that was written; in words.
    Damaged(String),
    /// None, or one that was made of other runs.
    Other,
}

/// Looks at all files of a data set, and compares them with its sums.
///
/// # Errors
/// If a file cannot be read.
pub(super) fn known(folder: &Path, made_of: &str) -> Result<Known> {
    let Ok(text) = granum_core::input::read_text(&folder.join(SUMS), 1 << 20) else {
        return Ok(Known::Other);
    };
    if text.lines().find_map(|line| line.strip_prefix(MADE_OF)) != Some(made_of) {
        return Ok(Known::Other);
    }
    let damaged =
        |name: &str, what: &str| Ok(Known::Damaged(format!("{} {what}", folder.join(name).shown())));
    let sums: BTreeMap<&str, &str> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split_once("  "))
        .map(|(sum, name)| (name, sum))
        .collect();
    for name in WITH_SUMS {
        let is_there = folder.join(name).is_file();
        match sums.get(name) {
            Some(_) if !is_there => return damaged(name, "is missing"),
            Some(sum) if file_digest(&folder.join(name))? != **sum => {
                return damaged(name, "was changed or damaged");
            }
            None if is_there => return damaged(name, "is not among the sums of the data set"),
            None if name != LEFT_OUT_FILE => return damaged(SUMS, "was changed or damaged"),
            _ => {}
        }
    }
    let tables = sums_of_tables(folder)?;
    if sums_text(folder, made_of, &tables)? != text {
        return damaged(SUMS, "was changed or damaged");
    }
    // Times differ from machine to machine, so that they have no sum.
    if !folder.join(SECONDS_FILE).is_file() {
        return damaged(SECONDS_FILE, "is missing");
    }
    if read_table_with_words(folder.join(SECONDS_FILE), None).is_err() {
        return damaged(SECONDS_FILE, "was changed or damaged");
    }
    Ok(Known::Whole(content_digest(&tables)))
}

/// SHA-256 of the files of runs and states.
pub(super) fn sums_of_tables(folder: &Path) -> Result<BTreeMap<&'static str, String>> {
    [RUNS_FILE, STATES_FILE].into_iter().map(|name| Ok((name, file_digest(&folder.join(name))?))).collect()
}

/// SHA-256 over the content.
pub(super) fn content_digest(sums: &BTreeMap<&'static str, String>) -> String {
    let mut digest = Digest::new();
    digest.text(FIRST_LINE);
    sums.values().for_each(|sum| digest.text(sum));
    digest.finish()
}

/// The file of sums for the files that the folder has.
pub(super) fn sums_text(
    folder: &Path,
    made_of: &str,
    sums: &BTreeMap<&'static str, String>,
) -> Result<String> {
    let mut lines = vec![
        FIRST_LINE.to_string(),
        format!("{MADE_OF}{made_of}"),
        format!("{CONTENT}{}", content_digest(sums)),
    ];
    for name in WITH_SUMS.into_iter().filter(|name| folder.join(name).is_file()) {
        let sum = match sums.get(name) {
            Some(sum) => sum.clone(),
            None => file_digest(&folder.join(name))?,
        };
        lines.push(format!("{sum}  {name}"));
    }
    Ok(lines.join("\n") + "\n")
}
