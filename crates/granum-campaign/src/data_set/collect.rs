//! From the folders of runs to the data set.

use std::path::PathBuf;

use granum_core::parallel;
use granum_io::Result;
use granum_run::Flow;

use super::contents::Contents;
use super::known::{Known, known};
use super::layout::DATA_SET;
use super::write::{remove, write};
use crate::campaign::Campaign;
use crate::plan::Keep;
use crate::rows::{RowFiles, RowWriter, forget_leftovers, read_run, remove_folder};

/// Number of runs that are taken in at once.
const RUNS_AT_ONCE: usize = 64;

/// What was collected.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Collected {
    /// Number of runs that have been finished by other processes since the journal was written.
    pub added: usize,
    /// The data set; `None` if no run is part of it.
    pub data_set: Option<DataSetSummary>,
    /// Number of runs that were left out of the data set because they did not pass a check.
    pub flagged: usize,
    /// Number of runs that failed.
    pub failed: usize,
    /// Number of runs that are not finished.
    pub unfinished: usize,
    /// Why folders of runs could not be thrown away, if that was asked for, and what was damaged and has been made again.
    pub remarks: Vec<String>,
}

/// What a data set has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DataSetSummary {
    /// Its folder.
    pub folder: PathBuf,
    /// Number of its runs.
    pub runs: usize,
    /// SHA-256 over its content.
    pub digest: String,
    /// False if it was there already.
    pub is_new: bool,
}

/// Takes up what processes have done in the folder of a campaign, whoever they were: adds it to the journal, takes the rows of finished
/// runs in, throws folders away if the plan says so, and writes the data set of all finished runs. What is there already is not done
/// again. For the process alone that has the folder; it can be ended at any time, and the same call goes on.
///
/// # Errors
/// If a run cannot be read or a file cannot be written, or `flow` stops it.
pub fn collect(campaign: &Campaign, flow: &(dyn Fn() -> Flow + Sync)) -> Result<Collected> {
    let go_on = || match flow() {
        Flow::Stop => Err(granum_io::Error::Rule("the data set was not written: stopped".into())),
        Flow::Continue => Ok(()),
    };
    forget_leftovers(campaign.folder())?;
    let added = campaign.collect()?;
    let contents = Contents::new(campaign)?;
    let mut remarks = Vec::new();
    let folder = campaign.folder().join(DATA_SET);
    let made_of = contents.digest(campaign);
    let is_there = known(&folder, &made_of)?;
    let is_made = !contents.taken.is_empty() && !matches!(is_there, Known::Whole(_));
    let rows = take_in_missing(campaign, &contents, is_made, &go_on)?;
    if campaign.keep() == Keep::Dataset {
        throw_away(campaign, &contents, &rows, &mut remarks)?;
    }
    let data_set = if contents.taken.is_empty() {
        remove(campaign)?;
        None
    } else {
        let make = || write(campaign, &rows, &contents, &made_of, &go_on).map(|(digest, _)| (digest, true));
        let (digest, is_new) = match is_there {
            Known::Whole(digest) => (digest, false),
            Known::Other => make()?,
            Known::Damaged(what) => {
                let made = make()?;
                remarks.push(format!("{what}; the data set was made again from the rows of its runs"));
                made
            }
        };
        Some(DataSetSummary { folder, runs: contents.taken.len(), digest, is_new })
    };
    let [flagged, failed, unfinished] =
        ["flagged", "failed", "unfinished"].map(|state| contents.count(state));
    Ok(Collected { added, data_set, flagged, failed, unfinished, remarks })
}

/// Takes in the runs of the data set that have not been, in the order of the plan. The rows of the others are looked at if a data set
/// `is_made` of them.
fn take_in_missing(
    campaign: &Campaign,
    contents: &Contents,
    is_made: bool,
    go_on: &(dyn Fn() -> Result<()> + Sync),
) -> Result<RowFiles> {
    let known = RowFiles::read(campaign.folder())?;
    let is_missing = |k: &usize| {
        let run = &campaign.runs()[*k];
        // Rows that were damaged are taken in again, as long as the folder of their run is there.
        let is_damaged = || {
            is_made
                && campaign.folder_of(&run.name).join("run.json").is_file()
                && known.run(&run.name).is_err()
        };
        !campaign.has_rows(&known, run) || is_damaged()
    };
    let missing: Vec<usize> = contents.taken.iter().copied().filter(is_missing).collect();
    if missing.is_empty() {
        return Ok(known);
    }
    let mut writer = RowWriter::new(campaign.folder());
    for numbers in missing.chunks(RUNS_AT_ONCE) {
        go_on()?;
        let runs = parallel::map(numbers.len(), 0, |k| {
            let name = &campaign.runs()[numbers[k]].name;
            Ok::<_, granum_io::Error>((
                name.clone(),
                read_run(&campaign.folder_of(name), campaign.vocabulary())?,
            ))
        })?;
        writer.append(&runs)?;
    }
    RowFiles::read(campaign.folder())
}

/// Throws away the folders of runs whose rows are in, and those of samples of which no other run is left.
fn throw_away(
    campaign: &Campaign,
    contents: &Contents,
    rows: &RowFiles,
    remarks: &mut Vec<String>,
) -> Result<()> {
    let is_in = |k: usize| campaign.has_rows(rows, &campaign.runs()[k]);
    let mut remove = |folder: PathBuf| {
        if folder.is_dir()
            && let Err(error) = remove_folder(campaign.folder(), &folder)
        {
            remarks.push(error.to_string());
        }
    };
    for run in contents.taken.iter().filter(|k| is_in(**k)).map(|k| &campaign.runs()[*k]) {
        remove(campaign.folder_of(&run.name));
    }
    let mut needed: Vec<bool> = vec![true; campaign.runs().len()];
    contents.taken.iter().filter(|k| is_in(**k)).for_each(|k| needed[*k] = false);
    campaign.samples_not_needed(&needed).into_iter().for_each(&mut remove);
    Ok(())
}
