//! `granum digest`: one hash of the results of a run.

use std::path::{Path, PathBuf};

use clap::Args;
use granum_io::RunStatus;
use granum_io::run::OWN_ENGINE;
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
/// any number of threads and any instruction set. The digest of a run of another engine, such as LAMMPS, identifies its files only: the
/// same case gives another one on another computer.
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
        let found: Vec<Digested> =
            self.folders.iter().map(|folder| digest(context, folder)).collect::<Result<_, _>>()?;
        let rows: Vec<Value> = self
            .folders
            .iter()
            .zip(&found)
            .map(|(folder, found)| {
                json!({
                    "folder": output::path(folder),
                    "sha256": found.digest,
                    "status": found.status,
                    "engine": found.engine,
                    "same_everywhere": found.is_own(),
                })
            })
            .collect();
        let line = |(folder, found): (&PathBuf, &Digested)| {
            let part =
                if found.status == RunStatus::Finished { "" } else { "  (of the part finished so far)" };
            let engine = match found.is_own() {
                true => String::new(),
                false => format!("  (of what {} gave here: not the same on every computer)", found.engine),
            };
            format!("{}  {}{part}{engine}", found.digest, folder.shown())
        };
        output::say(context, &json!({ "digests": rows }), || {
            self.folders.iter().zip(&found).map(line).collect::<Vec<_>>().join("\n")
        })
    }
}

/// The digest of a run, with its status and the engine that carried it out.
struct Digested {
    digest: String,
    status: RunStatus,
    engine: String,
}

impl Digested {
    /// True if the engine is granum's own, which gives the same bits everywhere.
    fn is_own(&self) -> bool {
        self.engine == OWN_ENGINE
    }
}

fn digest(context: &Context, folder: &Path) -> Result<Digested, Failure> {
    let run = whole::open_run(context, folder)?;
    let record = run.record()?;
    records::check_begun(&run, &record)?;
    whole::check(folder, &whole::faults_of_run(&run)?)?;
    Ok(Digested { digest: of_run(&run)?, status: record.status, engine: record.engine })
}
