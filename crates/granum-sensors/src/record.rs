//! What the sensors saw over a test: a series of rows and the histogram of forces of each.

use granum_core::{Column, Table, TableError};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::force_distribution::ForceHistogram;
use crate::{all, invariants};

/// What is wrong with a table that should be a record.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordError {
    /// A column is not there, or the columns do not fit together.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A value cannot be.
    #[error("column `{name}`, row {row}: {value} is not {wanted}")]
    BadValue {
        /// Name of the column.
        name: String,
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
        /// What would be right.
        wanted: &'static str,
    },
    /// The bins of a state do not follow one another.
    #[error("forces, row {row}: the bins of state {state} do not follow one another at steps of {bin_width}")]
    BrokenBins {
        /// Row, from 0.
        row: usize,
        /// State of the row.
        state: f64,
        /// Width of a bin.
        bin_width: f64,
    },
}

/// The record of a test.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// One row a state: `state`, `looks`, every column of every sensor, then `forces_below` and `forces_above`, the
    /// contacts outside the bins of the histogram. A test that is given as stages has a column `stage` before `state`, which
    /// counts from 0 in each, and the columns of the general invariants after those of the sensors.
    pub series: Table,
    /// The histogram of forces of each row.
    pub forces: Vec<ForceHistogram>,
}

impl Record {
    /// From state number, looks and values of each state, and its histogram; `stages` is the number of the stage of each
    /// row, where the test is given as stages.
    pub(crate) fn from_states(
        rows: &[(usize, u64, Vec<f64>)],
        forces: Vec<ForceHistogram>,
        stages: Option<&[usize]>,
    ) -> Self {
        let number = |name: &str, values: Vec<f64>| column(name, "", values);
        let mut table = Vec::new();
        if let Some(stages) = stages {
            table.push(number("stage", stages.iter().map(|stage| *stage as f64).collect()));
        }
        table.push(number("state", rows.iter().map(|row| row.0 as f64).collect()));
        table.push(number("looks", rows.iter().map(|row| row.1 as f64).collect()));
        let mut first = 0;
        let further = stages.is_some().then_some(&invariants::SENSOR);
        for sensor in all().iter().chain(further) {
            let places = first..first + sensor.columns.len();
            first = places.end;
            let is_unused = |row: &(usize, u64, Vec<f64>)| {
                let values = sensor.columns.iter().zip(&row.2[places.clone()]);
                values.filter(|(column, _)| column.optional).all(|(_, value)| *value == 0.0)
            };
            let unused = rows.iter().all(is_unused);
            for (k, sensor_column) in places.zip(sensor.columns) {
                if !(sensor_column.optional && unused) {
                    let values = rows.iter().map(|row| row.2[k]).collect();
                    table.push(column(sensor_column.name, sensor_column.unit, values));
                }
            }
        }
        table.push(number("forces_below", forces.iter().map(|h| h.below as f64).collect()));
        table.push(number("forces_above", forces.iter().map(|h| h.above as f64).collect()));
        Record { series: table_of(table), forces }
    }

    /// The histograms as a table, one row a bin: `state`, `deviator_strain`, `force` (centre of the bin),
    /// `bin_width`, `count`, `probability_density`, before them `stage` where the series has it. With [`Record::series`] it is
    /// the whole record.
    pub fn force_table(&self) -> Table {
        let states = self.series.values("state").unwrap_or(&[]);
        let strains = self.series.values("deviator_strain").unwrap_or(&[]);
        let mut table = ["state", "deviator_strain", "force", "bin_width", "count", "probability_density"]
            .map(|name| column(name, "", Vec::new()));
        let mut stages = Vec::new();
        let stage = self.series.values("stage");
        for (k, ((histogram, &state), &strain)) in self.forces.iter().zip(states).zip(strains).enumerate() {
            if let Some(stage) = stage.and_then(|stage| stage.get(k)) {
                stages.extend(std::iter::repeat_n(*stage, histogram.bins()));
            }
            for bin in 0..histogram.bins() {
                let row = [
                    state,
                    strain,
                    histogram.centre(bin),
                    histogram.bin_width,
                    histogram.counts[bin] as f64,
                    histogram.density(bin),
                ];
                for (column, value) in table.iter_mut().zip(row) {
                    column.values.push(value);
                }
            }
        }
        let stage = stage.map(|_| column("stage", "", stages));
        table_of(stage.into_iter().chain(table))
    }

    /// Puts a record together again from its two tables.
    ///
    /// # Errors
    /// A missing or ragged column, a count that is not a whole number, bins that do not follow one another.
    pub fn from_tables(series: Table, force_table: &Table) -> Result<Self, RecordError> {
        let states = series.column("state")?;
        let below = series.column("forces_below")?;
        let above = series.column("forces_above")?;
        let of = force_table.column("state")?;
        let stage_of = force_table.values("stage").unwrap_or(&[]);
        let stages = series.values("stage").unwrap_or(&[]);
        let mut forces = Vec::with_capacity(states.len());
        let mut row = 0;
        for (k, &state) in states.iter().enumerate() {
            let start = row;
            let stage = stages.get(k);
            while row < of.len() && of[row] == state && stage_of.get(row) == stage {
                row += 1;
            }
            let mut histogram = read_histogram(force_table, start, row, state)?;
            histogram.below = whole("forces_below", k, below[k])?;
            histogram.above = whole("forces_above", k, above[k])?;
            forces.push(histogram);
        }
        if row < of.len() {
            return Err(RecordError::BadValue {
                name: "state".to_owned(),
                row,
                value: of[row],
                wanted: "the state of a row of the series, in the same order",
            });
        }
        Ok(Record { series, forces })
    }
}

fn column(name: &str, unit: &str, values: Vec<f64>) -> Column {
    Column::new(name, if unit == "1" { "" } else { unit }, values)
}

/// A table of columns of one length.
fn table_of(columns: impl IntoIterator<Item = Column>) -> Table {
    let mut table = Table::default();
    for column in columns {
        // Nothing is refused: every column has one value a row of the record.
        let _ = table.set(column);
    }
    table
}

fn whole(name: &str, row: usize, value: f64) -> Result<u64, RecordError> {
    // Counts beyond 2^53 would not be exact in a column of floating-point numbers.
    if (0.0..=9_007_199_254_740_992.0).contains(&value) && value.fract() == 0.0 {
        Ok(value as u64)
    } else {
        Err(RecordError::BadValue { name: name.to_owned(), row, value, wanted: "a whole number of contacts" })
    }
}

fn read_histogram(
    table: &Table,
    start: usize,
    end: usize,
    state: f64,
) -> Result<ForceHistogram, RecordError> {
    let centres = &table.column("force")?[start..end];
    let widths = &table.column("bin_width")?[start..end];
    let counts = &table.column("count")?[start..end];
    let (Some(&first_centre), Some(&bin_width)) = (centres.first(), widths.first()) else {
        return Err(RecordError::BrokenBins { row: start, state, bin_width: 0.0 });
    };
    let first = (first_centre / bin_width - 0.5).round();
    if !(bin_width > 0.0 && bin_width.is_finite() && first.abs() < 1e9) {
        let name = "bin_width".to_owned();
        return Err(RecordError::BadValue {
            name,
            row: start,
            value: bin_width,
            wanted: "the positive width of a bin",
        });
    }
    let mut histogram = ForceHistogram {
        bin_width,
        first_bin: first as i64,
        counts: Vec::with_capacity(end - start),
        below: 0,
        above: 0,
    };
    for (k, &count) in counts.iter().enumerate() {
        let expected = (first + k as f64 + 0.5) * bin_width;
        let off = (centres[k] - expected).abs();
        if off.is_nan() || off > 1e-6 * bin_width || widths[k] != bin_width {
            return Err(RecordError::BrokenBins { row: start + k, state, bin_width });
        }
        histogram.counts.push(whole("count", start + k, count)?);
    }
    Ok(histogram)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Recorder, lattice};
    use granum_dem::config::Recording;

    fn record() -> Record {
        let recording = Recording { states: 3, looks: 2, bin_width: 0.1, ..Default::default() };
        let mut recorder = Recorder::new(&recording, 0.3);
        for k in 0..=60 {
            let mut assembly = lattice::random_contacts(50, k);
            assembly.strain[0][0] = 0.005 * k as f64;
            recorder.look(&assembly);
        }
        recorder.record()
    }

    #[test]
    fn two_tables_hold_the_whole_record() {
        let record = record();
        let forces = record.force_table();
        assert_eq!(forces.rows(), 4 * record.forces[0].bins());
        assert_eq!(Record::from_tables(record.series.clone(), &forces), Ok(record));
    }

    /// The table with one of its columns changed.
    fn with(table: &Table, name: &str, change: impl Fn(&mut Vec<f64>)) -> Table {
        let mut columns = table.columns().to_vec();
        let column = columns.iter_mut().find(|column| column.name == name).unwrap();
        change(&mut column.values);
        Table::new(columns).unwrap()
    }

    /// The table with all of its columns changed.
    fn with_all(table: &Table, change: impl Fn(&mut Vec<f64>)) -> Table {
        let mut columns = table.columns().to_vec();
        columns.iter_mut().for_each(|column| change(&mut column.values));
        Table::new(columns).unwrap()
    }

    #[test]
    fn broken_tables_are_refused_with_the_place() {
        let record = record();
        let good = record.force_table();
        let message = |series: &Table, forces: &Table| {
            Record::from_tables(series.clone(), forces).unwrap_err().to_string()
        };

        let columns = record.series.columns().iter().filter(|column| column.name != "forces_above");
        let series = Table::new(columns.cloned().collect()).unwrap();
        assert!(message(&series, &good).starts_with("there is no column forces_above"));

        let forces = with(&good, "count", |values| values[7] = 2.5);
        let text = message(&record.series, &forces);
        assert_eq!(text, "column `count`, row 7: 2.5 is not a whole number of contacts");

        let forces = with(&good, "force", |values| values.swap(3, 4));
        assert!(message(&record.series, &forces).contains("row 3: the bins of state 0"));

        let forces = with_all(&good, |values| values.truncate(2 * record.forces[0].bins()));
        assert!(Record::from_tables(record.series.clone(), &forces).is_err(), "two states have no bins");

        let forces = with_all(&good, |values| values.push(*values.last().unwrap()));
        assert!(Record::from_tables(record.series, &forces).is_err(), "a bin too many");
    }
}
