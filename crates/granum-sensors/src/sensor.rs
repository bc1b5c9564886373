//! Definition of a sensor.

use granum_core::{Assembly, Part};
use granum_dem::config::Recording;

use crate::Observation;
use crate::histogram::{Bins, Histogram};
use crate::parameter::SensorParameter;

/// How the observations around a recorded state are reduced to one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Averaging {
    /// The mean over the observations.
    Mean,
    /// The root mean square over the observations: for errors that change sign.
    RootMeanSquare,
    /// The largest value of the observations: for limits that must not be exceeded even once.
    Largest,
}

/// One column of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SensorColumn {
    /// Its name, unique among all sensors.
    pub name: &'static str,
    /// Its unit; `1` for a dimensionless number.
    pub unit: &'static str,
    /// Its meaning, in one line.
    pub description: &'static str,
    /// How observations are averaged.
    pub averaging: Averaging,
    /// True for a column that is omitted from a series, with the other optional columns of its sensor, if all of them are
    /// zero throughout.
    pub optional: bool,
    /// Parts of an assembly that it needs in addition to those of its sensor.
    pub needs: &'static [Part],
}

impl SensorColumn {
    /// A column whose value is the mean over the observations.
    pub const fn new(name: &'static str, unit: &'static str, description: &'static str) -> Self {
        SensorColumn { name, unit, description, averaging: Averaging::Mean, optional: false, needs: &[] }
    }

    /// The same column, omitted from a series where it is zero throughout.
    pub const fn optional(self) -> Self {
        SensorColumn { optional: true, ..self }
    }

    /// The same column with another kind of averaging.
    pub const fn averaged(self, averaging: Averaging) -> Self {
        SensorColumn { averaging, ..self }
    }

    /// The same column, which needs more parts of an assembly than the other columns of its sensor.
    pub const fn needing(self, needs: &'static [Part]) -> Self {
        SensorColumn { needs, ..self }
    }
}

/// What the values of a sensor speak of. A grain of one piece is both: its contacts are those of its piece.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Subject {
    /// The sample as a whole: cell, servo, invariants of stress and strain, energies.
    #[default]
    Sample,
    /// Bodies, that is grains: a grain of several pieces counts once, with its centre of mass and the size of the sphere of its volume.
    Bodies,
    /// Contacts between pieces: two grains of several pieces can have several.
    Contacts,
    /// Bonds between pieces, those that hold and those that ruptured.
    Bonds,
}

impl Subject {
    /// Its name in lists.
    pub fn name(self) -> &'static str {
        match self {
            Subject::Sample => "the sample",
            Subject::Bodies => "grains",
            Subject::Contacts => "contacts",
            Subject::Bonds => "bonds",
        }
    }
}

/// The description of a sensor.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SensorDescription {
    /// Its name, with which a case requests it.
    pub name: &'static str,
    /// What it measures, in one line.
    pub help: &'static str,
    /// What its values speak of.
    pub subject: Subject,
    /// Its columns.
    pub columns: Vec<SensorColumn>,
    /// Its parameters, which a case gives as keys of `[recording]`.
    pub parameters: Vec<SensorParameter>,
    /// The parts of an assembly that it needs.
    pub needs: Vec<Part>,
    /// True if it compares an observation with the previous one, so that it cannot be evaluated on a single assembly.
    pub remembers: bool,
}

impl SensorDescription {
    /// A sensor of the sample as a whole, without columns, which needs nothing.
    pub fn new(name: &'static str, help: &'static str) -> SensorDescription {
        SensorDescription {
            name,
            help,
            subject: Subject::default(),
            columns: Vec::new(),
            parameters: Vec::new(),
            needs: Vec::new(),
            remembers: false,
        }
    }

    /// The same sensor, whose values speak of this.
    pub fn speaking_of(self, subject: Subject) -> SensorDescription {
        SensorDescription { subject, ..self }
    }

    /// The same sensor with these columns.
    pub fn columns(self, columns: impl IntoIterator<Item = SensorColumn>) -> SensorDescription {
        SensorDescription { columns: columns.into_iter().collect(), ..self }
    }

    /// The same sensor with these parameters.
    pub fn parameters(self, parameters: impl IntoIterator<Item = SensorParameter>) -> SensorDescription {
        SensorDescription { parameters: parameters.into_iter().collect(), ..self }
    }

    /// The same sensor, which needs these parts of an assembly.
    pub fn needing(self, parts: &[Part]) -> SensorDescription {
        SensorDescription { needs: parts.to_vec(), ..self }
    }

    /// The same sensor, which compares an observation with the previous one.
    pub fn remembering(self) -> SensorDescription {
        SensorDescription { remembers: true, ..self }
    }
}

/// The data that a sensor stores from one observation of a test to the next: finite numbers, none at the first observation. They are
/// part of the checkpoint, so that a resumed run gives the same bits.
pub type Memory = Vec<f64>;

/// Measures an assembly.
///
/// A sensor reads only the assembly, so that it cannot disturb a run and can also be evaluated on the data of another program.
/// Scalars go into columns, distributions into histograms, and data for the next observation into a [`Memory`].
/// For any finite assembly every value must be a finite number: a mean over nothing is 0.
///
/// ```
/// use granum_core::quantity::Dimension;
/// use granum_core::{Assembly, Part};
/// use granum_dem::config::Recording;
/// use granum_sensors::*;
///
/// /// Where the histogram ends; a case gives it as `recording.largest_radius`.
/// const LARGEST: SensorParameter =
///     SensorParameter::new("largest_radius", Dimension::LENGTH, 1e-3, [1e-9, 1.0], "Largest radius with a bin of its own");
///
/// /// The radii of the grains: a scalar, a histogram, a parameter, and a number that is remembered.
/// struct Sizes;
///
/// impl Sensor for Sizes {
///     fn description(&self) -> SensorDescription {
///         SensorDescription::new("sizes", "how large the grains are")
///             .speaking_of(Subject::Bodies)
///             .columns([
///                 SensorColumn::new("largest_radius", "m", "the largest radius"),
///                 SensorColumn::new("grain_gain", "1", "grains that came since the last observation"),
///             ])
///             .parameters([LARGEST])
///             .needing(&[Part::Radii])
///     }
///     fn histograms(&self, recording: &Recording) -> Vec<Bins> {
///         let largest = LARGEST.value(recording).unwrap_or(1e-3);
///         vec![Bins::new("radii", "radius", "m").width(1e-5).range(0.0, largest)]
///     }
///     fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values) {
///         let radii = || observation.assembly.bodies.iter().map(|grain| grain.equivalent_radius);
///         let count = observation.assembly.bodies.len() as f64;
///         values.push(radii().fold(0.0, f64::max));
///         values.push(memory.first().map_or(0.0, |before| count - before));
///         values.count(0, radii());
///         *memory = vec![count];
///     }
/// }
///
/// let sensors = Sensors::standard().with(Sizes)?;
/// assert_eq!(sensors.named("sizes")?.columns.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Sensor: Send + Sync {
    /// Its name, its columns, and what it needs.
    fn description(&self) -> SensorDescription;

    /// The bins of its histograms, for a recording.
    fn histograms(&self, recording: &Recording) -> Vec<Bins> {
        let _ = recording;
        Vec::new()
    }

    /// The reason why the sensor cannot be used with the parameters of a recording, with the key to set; `None` if it can. A recording
    /// that names the sensor is then refused. Parameters that are [needed](SensorParameter::needed) are checked beside that.
    fn lacks(&self, recording: &Recording) -> Option<String> {
        let _ = recording;
        None
    }

    /// The distance, m, up to which the sensor searches the neighbours of every grain of an assembly; zero if it searches none. A sensor
    /// for which this would take more than 20,000 steps a grain, and more than 2e8 in all, is left out of a measurement, and in a record
    /// its values are not a number.
    fn reach(&self, assembly: &Assembly) -> f64 {
        let _ = assembly;
        0.0
    }

    /// Measures: one value for each column, in their order, and counts into the histograms.
    fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values);
}

/// Receives the values that a sensor measures.
pub struct Values<'a> {
    row: &'a mut Vec<f64>,
    histograms: &'a mut [Histogram],
    why_not: Option<&'static str>,
}

impl<'a> Values<'a> {
    pub(crate) fn new(row: &'a mut Vec<f64>, histograms: &'a mut [Histogram]) -> Values<'a> {
        Values { row, histograms, why_not: None }
    }

    /// Says that the sensor cannot measure this assembly, and why, e.g. because it would take too long. Its columns are left out, or not a
    /// number in a record.
    pub fn give_up(&mut self, why: &'static str) {
        self.why_not = Some(why);
    }

    /// Why the sensor gave up, if it did.
    pub(crate) fn why_not(&self) -> Option<&'static str> {
        self.why_not
    }

    /// The value of the next column.
    pub fn push(&mut self, value: f64) {
        self.row.push(value);
    }

    /// The values of the next columns.
    pub fn extend(&mut self, values: impl IntoIterator<Item = f64>) {
        self.row.extend(values);
    }

    /// Counts values into a histogram, by its number in [`Sensor::histograms`]; nothing is counted if there is no such histogram.
    pub fn count(&mut self, histogram: usize, values: impl IntoIterator<Item = f64>) {
        if let Some(histogram) = self.histogram(histogram) {
            values.into_iter().for_each(|value| histogram.add(value));
        }
    }

    /// A histogram, by its number in [`Sensor::histograms`].
    pub fn histogram(&mut self, number: usize) -> Option<&mut Histogram> {
        self.histograms.get_mut(number)
    }
}

/// The values that a sensor measures on one assembly, for tests.
#[cfg(test)]
pub(crate) fn measured(sensor: &dyn Sensor, assembly: &granum_core::Assembly) -> Vec<f64> {
    let mut row = Vec::new();
    sensor.measure(&Observation::new(assembly), &mut Memory::new(), &mut Values::new(&mut row, &mut []));
    row
}
