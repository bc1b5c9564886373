//! The record of a test in the folder of its run: the series, and one table for each histogram.

use granum_io::{Error, Result, Run, RunFolder, RunStatus};
use granum_sensors::Record;
use granum_sensors::force_distribution::FORCES;

/// Writes a record into the folder of a run.
///
/// # Errors
/// If a file cannot be written.
pub fn write_record(folder: &RunFolder, record: &Record) -> Result<()> {
    folder.write_series(&record.series)?;
    for (name, table) in record.histogram_tables() {
        match name {
            FORCES => folder.write_forces(&table)?,
            _ => folder.write_histogram(name, &table)?,
        }
    }
    Ok(())
}

/// Reads the record of a run.
///
/// # Errors
/// If a file is missing or damaged, or if the two files are not the record of a test; the message names the file or folder.
pub fn read_record(run: &Run) -> Result<Record> {
    match read_once(run) {
        // The tables of a test under way may be replaced while one after the other is read.
        Err(error) if run.record()?.status == RunStatus::Running => read_once(&run.now()).map_err(|_| error),
        other => other,
    }
}

fn read_once(run: &Run) -> Result<Record> {
    let mut tables = vec![(FORCES.to_string(), run.forces()?)];
    for name in run.histograms()? {
        let table = run.histogram(&name)?;
        tables.push((name, table));
    }
    let tables = tables.iter().map(|(name, table)| (name.as_str(), table));
    Record::from_tables(run.series()?, tables).map_err(|error| {
        let message =
            format!("its series.parquet and histograms are not those of a test: {error}; run it again");
        Error::content(run.path(), message)
    })
}
