//! The parameters that sensors declare, from which case files are read.

use crate::parameter::SensorParameter;
use crate::sensor::SensorDescription;

/// Keys of `[recording]` that are not parameters of sensors.
pub const OWN_KEYS: [&str; 7] =
    ["states", "first_strain", "strains", "snapshots", "sensors", "observations_per_state", "looks"];

/// A parameter with the sensors that have it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DeclaredParameter {
    /// The parameter.
    pub parameter: SensorParameter,
    /// The names of the sensors that have it.
    pub sensors: Vec<&'static str>,
    /// True if one of them is recorded in every test.
    pub always: bool,
    /// True if one of them comes with granum.
    pub of_granum: bool,
}

/// The parameters of these sensors, each with true if it is recorded in every test, and with true if it comes with granum.
pub(crate) fn declared_parameters<'a>(
    sensors: impl Iterator<Item = (&'a SensorDescription, bool, bool)>,
) -> Vec<DeclaredParameter> {
    let mut found: Vec<DeclaredParameter> = Vec::new();
    for (description, always, of_granum) in sensors {
        for parameter in &description.parameters {
            match found.iter_mut().find(|known| known.parameter.key == parameter.key) {
                Some(known) => {
                    known.always |= always;
                    known.sensors.push(description.name);
                    known.sensors.dedup();
                }
                None => {
                    let (parameter, sensors) = (*parameter, vec![description.name]);
                    found.push(DeclaredParameter { parameter, sensors, always, of_granum });
                }
            }
        }
    }
    found
}
