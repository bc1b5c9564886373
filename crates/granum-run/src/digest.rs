//! One hash of the results of a run.

use std::collections::BTreeMap;

use granum_core::digest::Digest;
use granum_core::{Column, Table};
use granum_io::snapshot::{contacts_table, grains_table};
use granum_io::{Error, Result, Run, RunKind};

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
    if record.kind == RunKind::Test {
        let series = run.series()?;
        table(&mut hash, "series", &series);
        table(&mut hash, "forces", &as_first_written(run.forces()?, &series)?);
        for name in run.histograms()? {
            table(
                &mut hash,
                &format!("histogram {name}"),
                &as_first_written(run.histogram(&name)?, &series)?,
            );
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

/// The table of a histogram as the first versions wrote it, so that digests can be compared with theirs: with the deviator strain of the
/// state after its number, and with the stage only where the series has it.
fn as_first_written(table: Table, series: &Table) -> Result<Table> {
    let strains = series.values("deviator_strain").filter(|_| !table.has("deviator_strain"));
    let keys = |table: &Table| -> Vec<[u64; 2]> {
        let states = table.values("state").unwrap_or(&[]);
        let stage =
            |row: usize| table.values("stage").and_then(|stages| stages.get(row)).copied().unwrap_or(1.0);
        states.iter().enumerate().map(|(row, state)| [stage(row).to_bits(), state.to_bits()]).collect()
    };
    let by_state: BTreeMap<[u64; 2], f64> = strains.map_or_else(BTreeMap::new, |strains| {
        keys(series).into_iter().zip(strains.iter().copied()).collect()
    });
    let mut columns = Vec::new();
    for column in table.columns() {
        if column.name != "stage" || series.has("stage") {
            columns.push(column.clone());
        }
        if column.name == "state" && strains.is_some() {
            let strain = |key: [u64; 2]| by_state.get(&key).copied().unwrap_or(f64::NAN);
            columns.push(Column::new("deviator_strain", "", keys(&table).into_iter().map(strain).collect()));
        }
    }
    Ok(Table::new(columns)?)
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
