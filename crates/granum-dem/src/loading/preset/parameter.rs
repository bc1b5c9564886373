//! The parameters of a named path, with their kinds, defaults and bounds, and the values given to them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::loading::History;

/// A parameter of a preset.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PathParameter {
    /// Its key in a case file.
    pub key: &'static str,
    /// The kind of its values.
    pub kind: PathParameterKind,
    /// The SI unit of a number; `1` for a pure number.
    pub unit: &'static str,
    /// Its meaning, in one or two sentences.
    pub help: &'static str,
    /// Its default; where it may be omitted without having one, a description of what applies then.
    pub default: PathParameterDefault,
    /// Smallest and largest value of a number.
    pub bounds: [f64; 2],
}

/// The kind of the values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathParameterKind {
    /// A number.
    Number,
    /// One of these words, each with its meaning.
    Word(&'static [[&'static str; 2]]),
    /// Increasing numbers.
    List,
    /// A history of strains and stresses, from a file or a table.
    History,
}

/// The rule for a parameter that is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathParameterDefault {
    /// This number.
    Value(f64),
    /// This word.
    Word(&'static str),
    /// These numbers.
    List(&'static [f64]),
    /// No value; the sentence describes what applies instead.
    Absent(&'static str),
    /// Nothing: it must be given.
    Needed,
}

/// A value given to a parameter.
///
/// ```
/// use granum_dem::loading::preset::{self, Given};
///
/// let given = Given::from([("axial_strain".to_string(), 0.1.into())]);
/// let stages = preset::named("drained-triaxial").map(|path| path.expand(&given)).unwrap_or_default();
/// assert_eq!(stages.len(), 1);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PathValue {
    /// A number in SI units.
    Number(f64),
    /// A word.
    Word(String),
    /// Increasing numbers.
    List(Vec<f64>),
    /// A history of strains and stresses.
    History(History),
}

impl From<f64> for PathValue {
    fn from(number: f64) -> PathValue {
        PathValue::Number(number)
    }
}

impl From<&str> for PathValue {
    fn from(word: &str) -> PathValue {
        PathValue::Word(word.to_string())
    }
}

/// What is wrong with parameters of a path together: the key, and a sentence that begins with it.
pub type PathFault = (&'static str, String);

/// Values by the keys of their parameters; those not given have their defaults.
pub type Given = BTreeMap<String, PathValue>;

/// The speed of a path, for [`PathValues::speed`](super::PathValues::speed).
pub const INERTIAL_NUMBER: PathParameter = PathParameter {
    key: "inertial_number",
    help: "Speed: inertial number I of the driving strain rate at the mean stress at the start of the stage.",
    default: PathParameterDefault::Value(1e-3),
    bounds: [1e-8, 0.1],
    ..STATES
};

/// The speed as a strain rate, for every preset.
pub(super) const STRAIN_RATE: PathParameter = PathParameter {
    key: "strain_rate",
    unit: "1/s",
    help: "Driving strain rate, which can be given instead of inertial_number.",
    default: PathParameterDefault::Absent("given by inertial_number"),
    bounds: [1e-12, 1e9],
    ..STATES
};

/// Factor on the density, together with a strain rate, for every preset.
pub(super) const DENSITY_SCALING: PathParameter = PathParameter {
    key: "density_scaling",
    help: "Factor on the density of every grain in the stages driven at strain_rate; only together with strain_rate.",
    default: PathParameterDefault::Absent("1"),
    bounds: [1e-6, 1e24],
    ..STATES
};

/// The parameters of every preset that does not declare them itself.
pub(super) const COMMON: &[PathParameter] = &[INERTIAL_NUMBER, STRAIN_RATE, DENSITY_SCALING];

/// The number of states that a path records, for [`PathValues::states`](super::PathValues::states).
pub const STATES: PathParameter = PathParameter {
    key: "states",
    kind: PathParameterKind::Number,
    unit: "1",
    help: "Number of equal intervals; a state is recorded at the end of each.",
    default: PathParameterDefault::Value(100.0),
    bounds: [1.0, 1e6],
};

/// States at equal distances of arc length.
pub const INTERVAL: PathParameter = PathParameter {
    key: "interval",
    help: "Arc length of strain between recorded states.",
    default: PathParameterDefault::Value(1e-4),
    bounds: [1e-7, 1.0],
    ..STATES
};

/// A stress that may be left out; it is then that of the sample.
pub const fn stress(key: &'static str, help: &'static str) -> PathParameter {
    let default = PathParameterDefault::Absent("that of the sample");
    PathParameter { key, unit: "Pa", help, default, bounds: [1e-3, 1e11], ..STATES }
}

/// A stress that may be left out, and may also be zero or a tension; it is then that of the sample.
pub const fn any_stress(key: &'static str, help: &'static str) -> PathParameter {
    PathParameter { bounds: [-1e11, 1e11], ..stress(key, help) }
}

/// A deviator stress with a default of zero.
pub const fn deviator(key: &'static str, help: &'static str) -> PathParameter {
    PathParameter {
        key,
        unit: "Pa",
        help,
        default: PathParameterDefault::Value(0.0),
        bounds: [-1e11, 1e11],
        ..STATES
    }
}

/// A pure number with a default and bounds.
pub const fn number(key: &'static str, help: &'static str, default: f64, bounds: [f64; 2]) -> PathParameter {
    PathParameter { key, help, default: PathParameterDefault::Value(default), bounds, ..STATES }
}

/// A number that may be left out, with a description of what applies then.
pub const fn optional(
    key: &'static str,
    help: &'static str,
    absent: &'static str,
    bounds: [f64; 2],
) -> PathParameter {
    PathParameter { key, help, default: PathParameterDefault::Absent(absent), bounds, ..STATES }
}

/// A choice between words, of which the first is the default.
pub const fn word(
    key: &'static str,
    help: &'static str,
    words: &'static [[&'static str; 2]],
) -> PathParameter {
    PathParameter {
        key,
        kind: PathParameterKind::Word(words),
        help,
        default: PathParameterDefault::Word(words[0][0]),
        ..STATES
    }
}
