//! The folders of runs that a command is given, directly or within folders.

use std::path::PathBuf;

use granum_campaign::Campaign;
use granum_io::Error;
use granum_run::runs_table::find_runs;

use crate::failure::Failure;

/// The runs in the given folders, as [`find_runs`] finds them. Those of a campaign come in the order of its plan, as far as they have been
/// begun; runs that are no longer in the plan are left out.
pub fn run_folders(folders: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut found: Vec<PathBuf> = Vec::new();
    for folder in folders {
        let inside = match Campaign::read(folder)? {
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
        let new: Vec<PathBuf> = inside.into_iter().filter(|run| !found.contains(run)).collect();
        found.extend(new);
    }
    Ok(found)
}
