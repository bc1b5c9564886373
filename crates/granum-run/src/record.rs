//! The record of a test in the folder of its run: two tables, the series and the histograms of forces.

use granum_io::{Error, Result, Run, RunFolder};
use granum_sensors::Record;

/// Writes a record into the folder of a run.
///
/// # Errors
/// If a file cannot be written.
pub fn write_record(folder: &RunFolder, record: &Record) -> Result<()> {
    folder.write_series(&record.series)?;
    folder.write_forces(&record.force_table())?;
    Ok(())
}

/// Reads the record of a run.
///
/// # Errors
/// If a file is missing or damaged, or the two are no record; the message names the file or folder.
pub fn read_record(run: &Run) -> Result<Record> {
    Record::from_tables(run.series()?, &run.forces()?).map_err(|error| {
        let message =
            format!("its series.parquet and forces.parquet are not those of a test: {error}; run it again");
        Error::content(run.path(), message)
    })
}
