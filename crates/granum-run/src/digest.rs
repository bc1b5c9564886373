//! One hash of the results of a run.

use granum_core::Table;
use granum_core::digest::Digest;
use granum_io::snapshot::{contacts_table, grains_table};
use granum_io::{Error, Result, Run};

/// SHA-256 (hexadecimal) of the physical content of a run: case, series, force histograms and snapshots, bit by bit. Times and the
/// description of the computer are left out, so that the same case has the same digest on every machine.
///
/// # Errors
/// If a file of the run is missing or damaged; the message names it.
pub fn of_run(run: &Run) -> Result<String> {
    let record = run.record()?;
    let mut hash = Digest::new();
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
        let energy = serde_json::to_string(&assembly.energy);
        hash.text(&energy.map_err(|error| Error::content(run.path(), error.to_string()))?);
    }
    Ok(hash.finish())
}

/// The first name that a column had: digests keep it, so that they can be compared with those of earlier versions.
fn first_name(column: &str) -> &str {
    if column == "observations" { "looks" } else { column }
}

fn table(hash: &mut Digest, name: &str, table: &Table) {
    hash.text(name);
    for column in table.columns() {
        hash.text(first_name(&column.name));
        hash.text(&column.unit);
        hash.numbers(&column.values);
    }
}
