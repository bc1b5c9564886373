//! The folders of runs that a command is given, directly or within folders.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use granum_campaign::data_set::DataSet;
use granum_campaign::plan::Keep;
use granum_campaign::rows::RowFiles;
use granum_campaign::{Campaign, CampaignRun};
use granum_core::parallel;
use granum_io::{Error, RunKind};
use granum_run::runs_table::{RunEntry, find_runs};

use crate::context::Context;
use crate::failure::Failure;

/// The runs of a table.
pub fn run_entries(context: &Context, folders: &[PathBuf], digest: bool) -> Result<Vec<RunEntry>, Failure> {
    let mut entries = Vec::new();
    for folder in folders {
        match (Campaign::read(folder, context.vocabulary())?, DataSet::is_in(folder)) {
            (Some(campaign), _) if campaign.keep() == Keep::Dataset => {
                let begun = |run: &&CampaignRun| campaign.folder_of(&run.name).join("run.json").is_file();
                let rows = campaign.rows_kept()?;
                let runs = campaign.runs().iter().filter(|run| campaign.has_rows(&rows, run) || begun(run));
                let runs: Vec<&CampaignRun> = runs.collect();
                entries.extend(parallel::map(runs.len(), 0, |k| {
                    of_campaign(context, &campaign, &rows, runs[k], digest)
                })?);
            }
            (_, true) => {
                for run in DataSet::read(folder, context.reading())?.each_run()? {
                    let entry = RunEntry::new(&run.name, folder, run.case, run.record);
                    entries.push(RunEntry { digest: Some(run.digest), ..entry });
                }
            }
            _ => {
                let runs = run_folders(context, std::slice::from_ref(folder))?;
                let known: BTreeSet<PathBuf> =
                    entries.iter().map(|entry: &RunEntry| entry.folder.clone()).collect();
                let new: Vec<PathBuf> = runs.into_iter().filter(|run| !known.contains(run)).collect();
                entries.extend(parallel::map(new.len(), 0, |k| of_folder(context, &new[k], digest))?);
            }
        }
    }
    Ok(entries)
}

/// A run of a campaign whose folders may have gone.
fn of_campaign(
    context: &Context,
    campaign: &Campaign,
    rows: &RowFiles,
    run: &CampaignRun,
    digest: bool,
) -> Result<RunEntry, Failure> {
    let folder = campaign.folder_of(&run.name);
    if folder.join("run.json").is_file() {
        return of_folder(context, &folder, digest);
    }
    let stored = rows.run(&run.name)?;
    let entry = RunEntry::new(&run.name, folder, campaign.case_of(run)?, stored.record);
    Ok(RunEntry { digest: digest.then_some(stored.digest), ..entry })
}

/// Reads a run, with its digest if it is asked for and the run has results.
fn of_folder(context: &Context, folder: &Path, digest: bool) -> Result<RunEntry, Failure> {
    context.check_stopped(|| "nothing was written".into())?;
    let opened = context.run_at(folder)?;
    let run = RunEntry::from_run(&opened)?.with_strength()?;
    // A series that is missing but was written must not pass for a test that has not begun.
    let has_results = run.record.kind == RunKind::Sample || opened.has_series();
    Ok(if digest && has_results { run.with_digest()? } else { run })
}

/// The runs in the given folders, as [`find_runs`] finds them. Those of a campaign come in the order of its plan, as far as they have been
/// begun; runs that are no longer in the plan are left out.
pub fn run_folders(context: &Context, folders: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut found: Vec<PathBuf> = Vec::new();
    for folder in folders {
        let inside = match Campaign::read(folder, context.vocabulary())? {
            Some(campaign) => {
                let all = campaign.runs().iter().map(|run| campaign.folder_of(&run.name));
                let begun: Vec<PathBuf> = all.filter(|path| path.join("run.json").is_file()).collect();
                if begun.is_empty() {
                    return Err(Error::content(folder, "none of its runs has been begun").into());
                }
                begun
            }
            None => find_runs(std::slice::from_ref(folder))?,
        };
        let known: BTreeSet<PathBuf> = found.iter().cloned().collect();
        found.extend(inside.into_iter().filter(|run| !known.contains(run)));
    }
    Ok(found)
}
