//! What a sensor is.

use crate::Look;

/// How the looks around a recorded state become its one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Averaging {
    /// The mean over the looks.
    Mean,
    /// The root of the mean square over the looks: for errors that change sign.
    RootMeanSquare,
    /// The largest over the looks: for limits that must not be exceeded even once.
    Largest,
}

/// One column of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorColumn {
    /// Its name, unique among all sensors.
    pub name: &'static str,
    /// Its unit; `1` for a number.
    pub unit: &'static str,
    /// What it is, in one line.
    pub description: &'static str,
    /// How looks are averaged.
    pub averaging: Averaging,
    /// True for a column that a series leaves out, with the other such columns of its sensor, where all of them are zero
    /// throughout.
    pub optional: bool,
}

impl SensorColumn {
    /// A column whose looks are averaged by their mean.
    pub const fn new(name: &'static str, unit: &'static str, description: &'static str) -> Self {
        SensorColumn { name, unit, description, averaging: Averaging::Mean, optional: false }
    }

    /// The same column, left out of a series where it is zero throughout.
    pub const fn optional(self) -> Self {
        SensorColumn { optional: true, ..self }
    }

    /// The same column with another way to average its looks.
    pub const fn averaged(self, averaging: Averaging) -> Self {
        SensorColumn { averaging, ..self }
    }
}

/// A soft sensor: named columns and the function that measures them.
#[derive(Clone, Copy)]
pub struct Sensor {
    /// Its name.
    pub name: &'static str,
    /// What it measures, in one line.
    pub description: &'static str,
    /// Its columns.
    pub columns: &'static [SensorColumn],
    /// Appends one value a column.
    pub measure: fn(&Look, &mut Vec<f64>),
}
