//! The parameters that sensors have declared, from which case files are read.

use std::sync::{PoisonError, RwLock};

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

/// The sensors with parameters that programs have added to those of granum.
static ADDED: RwLock<Vec<SensorDescription>> = RwLock::new(Vec::new());

/// Number of sensors with parameters that have been added to those of granum.
pub fn added_sensors_with_parameters() -> usize {
    ADDED.read().unwrap_or_else(PoisonError::into_inner).len()
}

/// The parameters of these sensors, each with true if it is recorded in every test, and of those that were added.
pub(crate) fn with_those_added<'a>(
    sensors: impl Iterator<Item = (&'a SensorDescription, bool)>,
) -> Vec<DeclaredParameter> {
    let added = ADDED.read().unwrap_or_else(PoisonError::into_inner).clone();
    let mut found: Vec<DeclaredParameter> = Vec::new();
    let own = sensors.map(|(description, always)| (description.clone(), always, true));
    let others = added.into_iter().map(|description| (description, false, false));
    for (description, always, of_granum) in own.chain(others) {
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

/// Notes the parameters of a sensor that a program has added.
pub(crate) fn add(description: SensorDescription) {
    let mut added = ADDED.write().unwrap_or_else(PoisonError::into_inner);
    let is_same = |known: &SensorDescription| {
        (known.name, &known.parameters) == (description.name, &description.parameters)
    };
    if !description.parameters.is_empty() && !added.iter().any(is_same) {
        added.push(description);
    }
}
