//! `granum digest`: one hash of the results of a run.

use std::path::{Path, PathBuf};

use clap::Args;
use granum_core::digest::Digest as Hash;
use granum_io::snapshot::{contacts_table, grains_table};
use granum_io::{Run, RunStatus, Table};
use serde_json::{Value, json};

use super::records;
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
        let found = self.folders.iter().map(|folder| digest(folder)).collect::<Result<Vec<_>, _>>()?;
        let rows: Vec<Value> = self
            .folders
            .iter()
            .zip(&found)
            .map(|(folder, (digest, status))| json!({ "folder": folder, "sha256": digest, "status": status }))
            .collect();
        let line = |(folder, (digest, status)): (&PathBuf, &(String, RunStatus))| {
            let part = if *status == RunStatus::Finished { "" } else { "  (of the part finished so far)" };
            format!("{digest}  {}{part}", folder.display())
        };
        output::say(context, &json!({ "digests": rows }), || {
            self.folders.iter().zip(&found).map(line).collect::<Vec<_>>().join("\n")
        })
    }
}

/// The digest and the status of a run folder.
fn digest(folder: &Path) -> Result<(String, RunStatus), Failure> {
    let run = Run::at(folder)?;
    let record = run.record()?;
    records::check_begun(&run, &record)?;
    let mut hash = Hash::new();
    hash.text("granum digest 1");
    hash.text(&run.case()?.digest_with(record.packing_digest()));
    // A sample has no tables of a test, whereas a test that has begun has both.
    if record.kind != "prepare" {
        table(&mut hash, "series", &run.series()?);
        table(&mut hash, "forces", &run.forces()?);
        for name in run.histograms()? {
            table(&mut hash, &format!("histogram {name}"), &run.histogram(&name)?);
        }
    }
    for name in run.snapshots()? {
        let assembly = run.snapshot(&name)?;
        hash.text(&name);
        table(&mut hash, "grains", &grains_table(&assembly)?);
        table(&mut hash, "contacts", &contacts_table(&assembly)?);
        hash.numbers(&[assembly.cell, assembly.velocity_gradient, assembly.strain].concat().concat());
        hash.numbers(&[assembly.time, assembly.time_step, assembly.step as f64]);
        hash.text(&serde_json::to_string(&assembly.energy)?);
    }
    Ok((hash.finish(), record.status))
}

/// The first name that a column had: digests keep it, so that they can be compared with those of earlier versions.
fn first_name(column: &str) -> &str {
    if column == "observations" { "looks" } else { column }
}

fn table(hash: &mut Hash, name: &str, table: &Table) {
    hash.text(name);
    for column in table.columns() {
        hash.text(first_name(&column.name));
        hash.text(&column.unit);
        hash.numbers(&column.values);
    }
}
