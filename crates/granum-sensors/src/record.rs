//! What the sensors saw over a test: a series of rows and the histogram of forces of each.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::all;
use crate::force_distribution::ForceHistogram;

/// A named column of numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedColumn {
    /// Its name.
    pub name: String,
    /// Its unit; `1` for a number.
    pub unit: String,
    /// One value a row.
    pub values: Vec<f64>,
}

/// A table of named columns, all of one length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// The columns.
    pub columns: Vec<NamedColumn>,
}

impl Series {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The values of a column, if there is one of that name.
    pub fn values(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|column| column.name == name).map(|column| column.values.as_slice())
    }

    /// The values of a column that must be there.
    ///
    /// # Errors
    /// [`RecordError::MissingColumn`].
    pub fn required(&self, name: &str) -> Result<&[f64], RecordError> {
        self.values(name).ok_or_else(|| RecordError::MissingColumn { name: name.to_owned() })
    }
}

/// What is wrong with a table that should be a record.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordError {
    /// A column is not there.
    #[error("the table has no column `{name}`")]
    MissingColumn {
        /// Name of the column.
        name: String,
    },
    /// Columns of one table have different lengths.
    #[error("column `{name}` has {found} rows, the first column has {expected}")]
    Ragged {
        /// Name of the column.
        name: String,
        /// Its rows.
        found: usize,
        /// Rows of the first column.
        expected: usize,
    },
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
    /// contacts outside the bins of the histogram.
    pub series: Series,
    /// The histogram of forces of each row.
    pub forces: Vec<ForceHistogram>,
}

impl Record {
    /// From state number, looks and values of each state, and its histogram.
    pub(crate) fn from_states(rows: &[(usize, u64, Vec<f64>)], forces: Vec<ForceHistogram>) -> Self {
        let number = |name: &str, values: Vec<f64>| column(name, "1", values);
        let mut table = vec![
            number("state", rows.iter().map(|row| row.0 as f64).collect()),
            number("looks", rows.iter().map(|row| row.1 as f64).collect()),
        ];
        let mut first = 0;
        for sensor in all() {
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
        Record { series: Series { columns: table }, forces }
    }

    /// The histograms as a table, one row a bin: `state`, `deviator_strain`, `force` (centre of the bin),
    /// `bin_width`, `count`, `probability_density`. With [`Record::series`] it is the whole record.
    pub fn force_table(&self) -> Series {
        let states = self.series.values("state").unwrap_or(&[]);
        let strains = self.series.values("deviator_strain").unwrap_or(&[]);
        let mut table = ["state", "deviator_strain", "force", "bin_width", "count", "probability_density"]
            .map(|name| column(name, "1", Vec::new()));
        for ((histogram, &state), &strain) in self.forces.iter().zip(states).zip(strains) {
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
        Series { columns: table.into() }
    }

    /// Puts a record together again from its two tables.
    ///
    /// # Errors
    /// A missing or ragged column, a count that is not a whole number, bins that do not follow one another.
    pub fn from_tables(series: Series, force_table: &Series) -> Result<Self, RecordError> {
        for table in [&series, force_table] {
            check_lengths(table)?;
        }
        let states = series.required("state")?;
        let below = series.required("forces_below")?;
        let above = series.required("forces_above")?;
        let of = force_table.required("state")?;
        let mut forces = Vec::with_capacity(states.len());
        let mut row = 0;
        for (k, &state) in states.iter().enumerate() {
            let start = row;
            while row < of.len() && of[row] == state {
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

fn column(name: &str, unit: &str, values: Vec<f64>) -> NamedColumn {
    NamedColumn { name: name.to_owned(), unit: unit.to_owned(), values }
}

fn check_lengths(table: &Series) -> Result<(), RecordError> {
    let expected = table.rows();
    for column in &table.columns {
        let found = column.values.len();
        if found != expected {
            return Err(RecordError::Ragged { name: column.name.clone(), found, expected });
        }
    }
    Ok(())
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
    table: &Series,
    start: usize,
    end: usize,
    state: f64,
) -> Result<ForceHistogram, RecordError> {
    let centres = &table.required("force")?[start..end];
    let widths = &table.required("bin_width")?[start..end];
    let counts = &table.required("count")?[start..end];
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

    #[test]
    fn broken_tables_are_refused_with_the_place() {
        let record = record();
        let good = record.force_table();
        let message =
            |series: Series, forces: &Series| Record::from_tables(series, forces).unwrap_err().to_string();

        let mut series = record.series.clone();
        series.columns.retain(|column| column.name != "forces_above");
        assert_eq!(message(series, &good), "the table has no column `forces_above`");

        let mut series = record.series.clone();
        series.columns[4].values.pop();
        assert_eq!(message(series, &good), "column `lateral_strain_2` has 3 rows, the first column has 4");

        let mut forces = good.clone();
        forces.columns[4].values[7] = 2.5;
        let text = message(record.series.clone(), &forces);
        assert_eq!(text, "column `count`, row 7: 2.5 is not a whole number of contacts");

        let mut forces = good.clone();
        forces.columns[2].values.swap(3, 4);
        assert!(message(record.series.clone(), &forces).contains("row 3: the bins of state 0"));

        let mut forces = good.clone();
        for column in &mut forces.columns {
            column.values.truncate(2 * record.forces[0].bins());
        }
        assert!(Record::from_tables(record.series.clone(), &forces).is_err(), "two states have no bins");

        let mut forces = good;
        for column in &mut forces.columns {
            let last = *column.values.last().unwrap();
            column.values.push(last);
        }
        assert!(Record::from_tables(record.series, &forces).is_err(), "a bin too many");
    }
}
