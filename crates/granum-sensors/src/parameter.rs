//! Parameters of sensors: numbers of the case that a sensor declares and reads.

use granum_core::quantity::Dimension;
use granum_dem::config::Recording;

/// What holds where a case does not give a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParameterDefault {
    /// This value, in SI units.
    Value(f64),
    /// No value; the text says what that means.
    Absent(&'static str),
    /// Nothing: a case that names the sensor must give the parameter. The text says what is not known without it.
    Needed(&'static str),
}

/// A parameter of a sensor: a number that a case gives as `recording.<key>`. The sensor lists it in its
/// [description](crate::SensorDescription::parameters), and the case file, its template, schema and checks follow from that.
/// Sensors that share a parameter list the same one.
///
/// ```
/// use granum_core::quantity::Dimension;
/// use granum_dem::config::Recording;
/// use granum_sensors::SensorParameter;
///
/// const RANGE: SensorParameter =
///     SensorParameter::new("range", Dimension::LENGTH, 1e-4, [0.0, 1.0], "Distance up to which neighbours are counted");
/// let recording = Recording::default().with(|recording| drop(recording.parameters.insert("range".into(), 2e-4)));
/// assert_eq!([RANGE.value(&Recording::default()), RANGE.value(&recording)], [Some(1e-4), Some(2e-4)]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SensorParameter {
    /// Its key in the section `[recording]` of a case.
    pub key: &'static str,
    /// Its physical dimension, which determines its units.
    pub dimension: Dimension,
    /// What holds where it is not given.
    pub default: ParameterDefault,
    /// Smallest and largest value, in SI units.
    pub bounds: [f64; 2],
    /// Its meaning, in one sentence.
    pub meaning: &'static str,
}

impl SensorParameter {
    /// A parameter with a default value.
    pub const fn new(
        key: &'static str,
        dimension: Dimension,
        default: f64,
        bounds: [f64; 2],
        meaning: &'static str,
    ) -> SensorParameter {
        SensorParameter { key, dimension, default: ParameterDefault::Value(default), bounds, meaning }
    }

    /// The same parameter without a default value; the text says what that means.
    pub const fn optional(self, meaning: &'static str) -> SensorParameter {
        SensorParameter { default: ParameterDefault::Absent(meaning), ..self }
    }

    /// The same parameter, which a case that names the sensor must give; the text says what is not known without it.
    pub const fn needed(self, lacking: &'static str) -> SensorParameter {
        SensorParameter { default: ParameterDefault::Needed(lacking), ..self }
    }

    /// The default value, if it has one.
    pub fn default_value(&self) -> Option<f64> {
        match self.default {
            ParameterDefault::Value(value) => Some(value),
            ParameterDefault::Absent(_) | ParameterDefault::Needed(_) => None,
        }
    }

    /// Its value in a recording: the given one, or else the default; `None` without either.
    pub fn value(&self, recording: &Recording) -> Option<f64> {
        recording.parameters.get(self.key).copied().or(self.default_value())
    }

    /// The reason why a recording without it cannot be made, with the key to set.
    pub(crate) fn lack(&self, recording: &Recording) -> Option<String> {
        match self.default {
            ParameterDefault::Needed(lacking) if self.value(recording).is_none() => {
                Some(format!("{lacking}; set recording.{}", self.key))
            }
            _ => None,
        }
    }
}
