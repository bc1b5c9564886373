//! The measurements of the sensors in a test: a series of rows, each with its histograms.

use std::ops::Range;

use granum_core::{Column, Table, TableError};
use granum_dem::config::RecordedColumns;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::force_distribution::FORCES;
use crate::state_sums::StateSums;
use crate::{Bins, Histogram, SensorColumn};

/// Errors of a table that should be a record.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RecordError {
    /// A column is missing, or the columns do not fit together.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A value is not possible.
    #[error("column `{name}`, row {row}: {value} is not {wanted}")]
    BadValue {
        /// Name of the column.
        name: String,
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
        /// The permitted values.
        wanted: &'static str,
    },
    /// The bins of a state are not consecutive.
    #[error("row {row}: the bins of state {state} are not adjacent bins of width {bin_width}")]
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
///
/// ```
/// use granum_core::{Column, Table};
/// use granum_sensors::{Histogram, Record};
///
/// let series = Table::new(vec![Column::new("state", "", vec![0.0])])?;
/// let record = Record::with_forces(series, vec![Histogram::new(0.25, -2.0, 6.0)]);
/// assert_eq!((record.series.rows(), record.forces()[0].bins()), (1, 32));
/// # Ok::<(), granum_core::TableError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// One row per state: `state`, `observations`, every column of every sensor, then for each histogram how many values lie
    /// outside its bins, as `forces_below` and `forces_above`. A test that is defined as a list of stages has a column `stage`
    /// before `state`, which is counted from 0 in each stage.
    pub series: Table,
    /// The histograms of the sensors, those of the contact forces first.
    pub histograms: Vec<Histograms>,
}

/// A histogram of every state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Histograms {
    /// Its name, e.g. `forces`.
    pub name: String,
    /// What is counted, e.g. `force`.
    pub quantity: String,
    /// Unit of that; empty for a number.
    pub unit: String,
    /// One for each row of the series.
    pub states: Vec<Histogram>,
}

impl Record {
    /// From the sums over the states, each with the number of its stage, of sensors with these columns and bins.
    pub(crate) fn from_states<'a>(
        sensors: &[&[SensorColumn]],
        bins: &[Bins],
        states: impl Iterator<Item = (usize, &'a StateSums)>,
        columns: RecordedColumns,
    ) -> Self {
        let states: Vec<(usize, &StateSums)> = states.collect();
        let numbers_stages = columns == RecordedColumns::All;
        let columns = || sensors.iter().flat_map(|columns| columns.iter());
        let rows: Vec<Vec<f64>> = states.iter().map(|(_, sums)| sums.averages(columns())).collect();
        let number = |name: &str, value: &dyn Fn(&(usize, &StateSums)) -> f64| {
            column(name, "", states.iter().map(value).collect())
        };
        let mut table = Vec::new();
        if numbers_stages {
            table.push(number("stage", &|(stage, _)| *stage as f64));
        }
        table.push(number("state", &|(_, sums)| sums.state as f64));
        table.push(number("observations", &|(_, sums)| sums.observations as f64));
        let mut first = 0;
        for sensor in sensors {
            let places = first..first + sensor.len();
            first = places.end;
            let is_unused = |row: &Vec<f64>| {
                let mut values =
                    sensor.iter().zip(&row[places.clone()]).filter(|(column, _)| column.optional);
                values.all(|(_, value)| *value == 0.0)
            };
            let unused = rows.iter().all(is_unused);
            for (k, sensor_column) in places.clone().zip(*sensor) {
                if !(sensor_column.optional && unused) {
                    let values = rows.iter().map(|row| row[k]).collect();
                    table.push(column(sensor_column.name, sensor_column.unit, values));
                }
            }
        }
        let mut histograms = Vec::new();
        for (k, bins) in bins.iter().enumerate() {
            let found = states.iter().filter_map(|(_, sums)| sums.histograms.get(k).cloned());
            let series = Histograms {
                name: bins.name.into(),
                quantity: bins.quantity.into(),
                unit: if bins.unit == "1" { String::new() } else { bins.unit.into() },
                states: found.collect(),
            };
            let outside =
                |value: fn(&Histogram) -> u64| series.states.iter().map(|h| value(h) as f64).collect();
            table.push(column(&below(bins.name), "", outside(|h| h.below)));
            table.push(column(&above(bins.name), "", outside(|h| h.above)));
            histograms.push(series);
        }
        Record { series: table_of(table), histograms }
    }

    /// A record of a series and the histograms of the contact forces of its rows.
    pub fn with_forces(series: Table, forces: Vec<Histogram>) -> Record {
        let (name, quantity) = (FORCES.to_string(), "force".to_string());
        Record {
            series,
            histograms: vec![Histograms { name, quantity, unit: String::new(), states: forces }],
        }
    }

    /// The histograms of that name, one for each row of the series; empty where they were not recorded.
    pub fn histograms(&self, name: &str) -> &[Histogram] {
        self.histograms.iter().find(|known| known.name == name).map_or(&[], |known| &known.states)
    }

    /// The histograms of the contact forces.
    pub fn forces(&self) -> &[Histogram] {
        self.histograms(FORCES)
    }

    /// The histograms as tables with their names, one row per bin: the key of the state, which is `stage` and `state`, the centre of the
    /// bin (named as what is counted, e.g. `force`), `bin_width`, `count`, `probability_density`. The table of the forces has the
    /// `deviator_strain` after the key, where the series has it. With [`Record::series`] they are the whole record.
    pub fn histogram_tables(&self) -> impl Iterator<Item = (&str, Table)> {
        self.histograms.iter().map(|histograms| (histograms.name.as_str(), self.table_of(histograms)))
    }

    fn table_of(&self, histograms: &Histograms) -> Table {
        let each = |value: &dyn Fn(&Histogram, usize) -> f64| -> Vec<f64> {
            let states = histograms.states.iter();
            states.flat_map(|histogram| (0..histogram.bins()).map(|bin| value(histogram, bin))).collect()
        };
        let of_state = |values: &[f64]| -> Vec<f64> {
            let states = histograms.states.iter().zip(values);
            states.flat_map(|(histogram, value)| std::iter::repeat_n(*value, histogram.bins())).collect()
        };
        let key = StateKeys::from_table(&self.series);
        let mut columns =
            vec![column("stage", "", of_state(&key.stages)), column("state", "", of_state(&key.states))];
        if let Some(strains) = self.series.values("deviator_strain").filter(|_| histograms.name == FORCES) {
            columns.push(column("deviator_strain", "", of_state(strains)));
        }
        let unit = histograms.unit.as_str();
        columns.extend([
            column(&histograms.quantity, unit, each(&|histogram, bin| histogram.centre(bin))),
            column("bin_width", unit, each(&|histogram, _| histogram.bin_width)),
            column("count", "", each(&|histogram, bin| histogram.counts[bin] as f64)),
            column("probability_density", "", each(&|histogram, bin| histogram.density(bin))),
        ]);
        table_of(columns)
    }

    /// Reconstructs a record from its tables: the series, and those of the histograms with their names.
    ///
    /// # Errors
    /// A missing column, columns of unequal length, a count that is not a whole number, or bins that are not consecutive.
    pub fn from_tables<'a>(
        series: Table,
        tables: impl IntoIterator<Item = (&'a str, &'a Table)>,
    ) -> Result<Self, RecordError> {
        let read = |(name, table)| read_histograms(&series, name, table);
        let histograms = tables.into_iter().map(read).collect::<Result<_, _>>()?;
        Ok(Record { series, histograms })
    }
}

/// Name of the column of values below the bins.
fn below(name: &str) -> String {
    format!("{name}_below")
}

/// Name of the column of values above the bins.
fn above(name: &str) -> String {
    format!("{name}_above")
}

/// The keys of the rows of a table: the number of the stage and of the state in it.
struct StateKeys {
    stages: Vec<f64>,
    states: Vec<f64>,
}

impl StateKeys {
    /// Without a column `stage` all rows are of stage 1, and without a column `state` these are numbered from 0.
    fn from_table(table: &Table) -> StateKeys {
        let rows = table.rows();
        let numbered = || (0..rows).map(|row| row as f64).collect();
        StateKeys {
            stages: table.values("stage").map_or_else(|| vec![1.0; rows], <[f64]>::to_vec),
            states: table.values("state").map_or_else(numbered, <[f64]>::to_vec),
        }
    }

    fn at(&self, row: usize) -> Option<[f64; 2]> {
        Some([*self.stages.get(row)?, *self.states.get(row)?])
    }
}

/// The histograms of one name, one for each row of the series.
fn read_histograms(series: &Table, name: &str, table: &Table) -> Result<Histograms, RecordError> {
    let states = series.column("state")?;
    let below = (below(name), series.column(&below(name))?);
    let above = (above(name), series.column(&above(name))?);
    let of = table.column("state")?;
    let (wanted, keys) = (StateKeys::from_table(series), StateKeys::from_table(table));
    // The column of the counted quantity precedes that of the bin width.
    let names: Vec<&str> = table.names().collect();
    let width = names.iter().position(|name| *name == "bin_width").unwrap_or(0);
    let quantity = names.get(width.saturating_sub(1)).copied().unwrap_or("force");
    let mut found = Histograms { name: name.into(), quantity: quantity.into(), ..Histograms::default() };
    found.unit = table.get(quantity).map_or_else(String::new, |column| column.unit.clone());
    let mut row = 0;
    for (k, &state) in states.iter().enumerate() {
        let start = row;
        while row < of.len() && keys.at(row) == wanted.at(k) {
            row += 1;
        }
        let mut histogram = read_histogram(table, quantity, start..row, state)?;
        histogram.below = whole(&below.0, k, below.1[k])?;
        histogram.above = whole(&above.0, k, above.1[k])?;
        found.states.push(histogram);
    }
    if row < of.len() {
        return Err(RecordError::BadValue {
            name: "state".to_owned(),
            row,
            value: of[row],
            wanted: "the state of a row of the series, in the same order",
        });
    }
    Ok(found)
}

fn column(name: &str, unit: &str, values: Vec<f64>) -> Column {
    Column::new(name, if unit == "1" { "" } else { unit }, values)
}

/// A table of columns of equal length.
fn table_of(columns: impl IntoIterator<Item = Column>) -> Table {
    let mut table = Table::default();
    for column in columns {
        // This cannot fail: every column has one value for each row of the record.
        let _ = table.set(column);
    }
    table
}

fn whole(name: &str, row: usize, value: f64) -> Result<u64, RecordError> {
    // Counts beyond 2^53 would not be exact in a column of floating-point numbers.
    if (0.0..=9_007_199_254_740_992.0).contains(&value) && value.fract() == 0.0 {
        Ok(value as u64)
    } else {
        Err(RecordError::BadValue { name: name.to_owned(), row, value, wanted: "a whole number" })
    }
}

fn read_histogram(
    table: &Table,
    quantity: &str,
    rows: Range<usize>,
    state: f64,
) -> Result<Histogram, RecordError> {
    let start = rows.start;
    let counts = &table.column("count")?[rows.clone()];
    let widths = &table.column("bin_width")?[rows.clone()];
    let centres = &table.column(quantity)?[rows.clone()];
    let (Some(&first_centre), Some(&bin_width)) = (centres.first(), widths.first()) else {
        return Err(RecordError::BrokenBins { row: start, state, bin_width: 0.0 });
    };
    let first = libm::round(first_centre / bin_width - 0.5);
    if !(bin_width > 0.0 && bin_width.is_finite() && first.abs() < 1e9) {
        let name = "bin_width".to_owned();
        return Err(RecordError::BadValue {
            name,
            row: start,
            value: bin_width,
            wanted: "the positive width of a bin",
        });
    }
    let mut histogram = Histogram {
        bin_width,
        first_bin: first as i64,
        counts: Vec::with_capacity(rows.len()),
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
    use crate::{Recorder, Sensors, lattice};
    use granum_dem::config::Recording;

    fn record() -> Record {
        let sensors = vec!["overlap_distribution".to_string()];
        let recording = Recording::default().with(|recording| {
            recording.states = 3;
            recording.observations_per_state = 2;
            recording.parameters = [("bin_width".to_string(), 0.1)].into();
            recording.sensors = sensors;
        });
        let mut recorder = Recorder::new(&Sensors::standard(), &recording, 0.3).unwrap();
        for k in 0..=60 {
            let mut assembly = lattice::random_contacts(50, k);
            assembly.strain[0][0] = 0.005 * k as f64;
            assembly.contacts.iter_mut().for_each(|contact| contact.approach = contact.normal_force.abs());
            recorder.observe(&assembly);
        }
        recorder.record()
    }

    #[test]
    fn tables_hold_the_whole_record() {
        let record = record();
        let tables: Vec<(&str, Table)> = record.histogram_tables().collect();
        assert_eq!(tables.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["forces", "overlaps"]);
        assert_eq!(tables[0].1.rows(), 4 * record.forces()[0].bins());
        let names = |of: usize| tables[of].1.names().collect::<Vec<_>>();
        let after = ["bin_width", "count", "probability_density"];
        assert_eq!(names(0), [&["stage", "state", "deviator_strain", "force"][..], &after].concat());
        assert_eq!(names(1), [&["stage", "state", "overlap"][..], &after].concat());
        assert!(record.histograms("overlaps").iter().all(|histogram| histogram.total() > 0));
        let tables = tables.iter().map(|(name, table)| (*name, table));
        assert_eq!(Record::from_tables(record.series.clone(), tables), Ok(record.clone()));
    }

    /// The histograms are keyed by stage and state: no other column of the series is needed for them.
    #[test]
    fn histograms_need_no_strain() {
        let record = record();
        let mut without = record.clone();
        without.series.remove("deviator_strain");
        for (name, table) in without.histogram_tables() {
            assert_eq!(table.rows(), 4 * record.histograms(name)[0].bins(), "{name}");
        }
    }

    /// A run of an earlier version, whose histograms have no stage and the deviator strain in its place.
    #[test]
    fn tables_of_earlier_versions_are_read() {
        let record = record();
        let earlier = |mut table: Table| {
            table.remove("stage");
            let strain = table.values("state").unwrap().iter().map(|state| 0.1 * state).collect();
            table.set(Column::new("deviator_strain", "", strain)).unwrap();
            table
        };
        let tables: Vec<(&str, Table)> =
            record.histogram_tables().map(|(name, table)| (name, earlier(table))).collect();
        let tables = tables.iter().map(|(name, table)| (*name, table));
        // What is counted stands before the width of a bin, wherever else the strain stands.
        assert_eq!(Record::from_tables(record.series.clone(), tables), Ok(record.clone()));
    }

    /// The table with one of its columns modified.
    fn with(table: &Table, name: &str, change: impl Fn(&mut Vec<f64>)) -> Table {
        let mut columns = table.columns().to_vec();
        let column = columns.iter_mut().find(|column| column.name == name).unwrap();
        change(&mut column.values);
        Table::new(columns).unwrap()
    }

    /// The table with all of its columns modified.
    fn with_all(table: &Table, change: impl Fn(&mut Vec<f64>)) -> Table {
        let mut columns = table.columns().to_vec();
        columns.iter_mut().for_each(|column| change(&mut column.values));
        Table::new(columns).unwrap()
    }

    #[test]
    fn broken_tables_are_refused_with_the_place() {
        let record = record();
        let good = record.histogram_tables().next().unwrap().1;
        let message = |series: &Table, forces: &Table| {
            Record::from_tables(series.clone(), [("forces", forces)]).unwrap_err().to_string()
        };

        let columns = record.series.columns().iter().filter(|column| column.name != "forces_above");
        let series = Table::new(columns.cloned().collect()).unwrap();
        assert!(message(&series, &good).starts_with("there is no column forces_above"));

        let forces = with(&good, "count", |values| values[7] = 2.5);
        let text = message(&record.series, &forces);
        assert_eq!(text, "column `count`, row 7: 2.5 is not a whole number");

        let forces = with(&good, "force", |values| values.swap(3, 4));
        assert!(message(&record.series, &forces).contains("row 3: the bins of state 0"));

        let forces = with_all(&good, |values| values.truncate(2 * record.forces()[0].bins()));
        assert!(
            Record::from_tables(record.series.clone(), [("forces", &forces)]).is_err(),
            "two states have no bins"
        );

        let forces = with_all(&good, |values| values.push(*values.last().unwrap()));
        assert!(Record::from_tables(record.series, [("forces", &forces)]).is_err(), "a bin too many");
    }
}
