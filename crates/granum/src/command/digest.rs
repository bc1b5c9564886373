//! `granum digest`: one hash of the results of a run.

use std::path::{Path, PathBuf};

use clap::Args;
use granum_io::RunStatus;
use granum_io::shell::ShowPath;
use granum_run::digest::of_run;
use serde_json::{Value, json};

use super::{records, whole};
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Print one SHA-256 hash of the physical content of a run: case, series, force histograms and snapshots, bit by bit.
///
/// Times and the description of the computer are left out, so that two users with the same case obtain the same digest, with
/// any number of threads and any instruction set.
#[derive(Args)]
#[command(after_help = "Example:\n  granum digest run-1 run-2")]
pub struct Digest {
    /// Run folders.
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
}

impl Digest {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("reading the runs"));
        let found =
            self.folders.iter().map(|folder| digest(context, folder)).collect::<Result<Vec<_>, _>>()?;
        let rows: Vec<Value> = self
            .folders
            .iter()
            .zip(&found)
            .map(|(folder, (digest, status))| json!({ "folder": output::path(folder), "sha256": digest, "status": status }))
            .collect();
        let line = |(folder, (digest, status)): (&PathBuf, &(String, RunStatus))| {
            let part = if *status == RunStatus::Finished { "" } else { "  (of the part finished so far)" };
            format!("{digest}  {}{part}", folder.shown())
        };
        output::say(context, &json!({ "digests": rows }), || {
            self.folders.iter().zip(&found).map(line).collect::<Vec<_>>().join("\n")
        })
    }
}

/// The digest and the status of a run folder.
fn digest(context: &Context, folder: &Path) -> Result<(String, RunStatus), Failure> {
    let run = whole::open_run(context, folder)?;
    let record = run.record()?;
    records::check_begun(&run, &record)?;
    whole::check(folder, &whole::faults_of_run(&run)?)?;
    Ok((of_run(&run)?, record.status))
}
