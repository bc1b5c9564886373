//! One hash of the results of a run.

use std::collections::BTreeMap;
use std::path::Path;

use granum_core::digest::Digest;
use granum_core::{Assembly, Column, Table};
use granum_io::snapshot::{contacts_table, grains_table};
use granum_io::{Error, Result, Run, RunKind};
use granum_sensors::Record;
use granum_sensors::force_distribution::FORCES;

/// SHA-256 (hexadecimal) of the physical content of a run: case, series, force histograms and snapshots, bit by bit. Times and the
/// description of the computer are left out, so that the same case has the same digest on every machine.
///
/// # Errors
/// If a file of the run is missing or damaged; the message names it.
pub fn of_run(run: &Run) -> Result<String> {
    let record = run.record()?;
    let mut hash = begun(&run.case()?.digest_with(record.packing_digest()));
    // A sample has no tables of a test, whereas a test that has begun has both.
    if record.kind == RunKind::Test {
        let mut histograms = Vec::new();
        for name in run.histograms()? {
            let table = run.histogram(&name)?;
            histograms.push((name, table));
        }
        measurements(&mut hash, &run.series()?, run.forces()?, histograms)?;
    }
    for name in run.snapshots()? {
        snapshot(&mut hash, &name, &run.snapshot(&name)?)?;
    }
    Ok(hash.finish())
}

/// The same of a run that is in memory: the digest of its case, its measurements if it is a test, and its snapshots by name. It is the one of
/// [`of_run`] for the folder of that run.
///
/// # Errors
/// If the measurements have no histogram of forces, or a table cannot be made of a snapshot.
pub fn of_results(
    case_digest: &str,
    record: Option<&Record>,
    snapshots: &BTreeMap<String, Assembly>,
) -> Result<String> {
    let mut hash = begun(case_digest);
    if let Some(record) = record {
        let mut tables: BTreeMap<String, Table> =
            record.histogram_tables().map(|(name, table)| (name.to_string(), table)).collect();
        let forces = tables.remove(FORCES).ok_or_else(|| fault("there is no histogram of forces"))?;
        measurements(&mut hash, &record.series, forces, tables)?;
    }
    for (name, assembly) in snapshots {
        snapshot(&mut hash, name, assembly)?;
    }
    Ok(hash.finish())
}

/// What is wrong with a run that has no folder.
fn fault(what: impl Into<String>) -> Error {
    Error::content(Path::new("the run in memory"), what.into())
}

fn begun(case_digest: &str) -> Digest {
    let mut hash = Digest::new();
    hash.text("granum digest 1");
    hash.text(case_digest);
    hash
}

/// Takes in the series and the histograms of a test; those beside the forces sorted by name.
fn measurements(
    hash: &mut Digest,
    series: &Table,
    forces: Table,
    histograms: impl IntoIterator<Item = (String, Table)>,
) -> Result<()> {
    table(hash, "series", series);
    table(hash, "forces", &as_first_written(forces, series)?);
    for (name, content) in histograms {
        table(hash, &format!("histogram {name}"), &as_first_written(content, series)?);
    }
    Ok(())
}

fn snapshot(hash: &mut Digest, name: &str, assembly: &Assembly) -> Result<()> {
    hash.text(name);
    table(hash, "grains", &grains_table(assembly)?);
    table(hash, "contacts", &contacts_table(assembly)?);
    hash.numbers(&[assembly.cell, assembly.velocity_gradient, assembly.strain].concat().concat());
    hash.numbers(&[assembly.time, assembly.time_step, assembly.step as f64]);
    hash.text(&serde_json::to_string(&assembly.energy).map_err(|error| fault(error.to_string()))?);
    Ok(())
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
