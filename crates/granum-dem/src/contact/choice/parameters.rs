//! Values of the parameters of the laws.

use std::collections::BTreeMap;

use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};

use super::registry::Laws;
use crate::contact::law::description::LawParameter;
use crate::contact::law::limits::MOST_PARAMETERS;

/// Values given to parameters of contact laws, in SI units, by key; the others have their defaults.
///
/// A table of fixed size without heap allocation, so that the structures that contain it can be copied.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParameterValues {
    /// Sorted by key; empty entries last.
    values: [Option<(&'static str, f64)>; MOST_PARAMETERS],
}

/// More values than the table can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the laws of a contact can have at most {MOST_PARAMETERS} parameters with given values; {key} is one too many"
)]
pub struct TooManyParameters {
    /// The key for which there was no room.
    pub key: &'static str,
}

impl ParameterValues {
    /// No given values.
    pub const NONE: ParameterValues = ParameterValues { values: [None; MOST_PARAMETERS] };

    /// The value given to a key.
    pub fn given(&self, key: &str) -> Option<f64> {
        self.iter().find(|(known, _)| *known == key).map(|(_, value)| value)
    }

    /// The value of a parameter: the given one, or else its default.
    pub fn value(&self, parameter: &LawParameter) -> f64 {
        self.given(parameter.key).unwrap_or(parameter.default)
    }

    /// These values and one more.
    ///
    /// # Errors
    /// If there is no room.
    pub fn with(mut self, key: &'static str, value: f64) -> Result<ParameterValues, TooManyParameters> {
        self.set(key, value)?;
        Ok(self)
    }

    /// Gives a value to a key.
    ///
    /// # Errors
    /// If there is no room.
    pub fn set(&mut self, key: &'static str, value: f64) -> Result<(), TooManyParameters> {
        let place = self.values.iter().position(|v| v.is_none_or(|(known, _)| known == key));
        let place = place.ok_or(TooManyParameters { key })?;
        self.values[place] = Some((key, value));
        // By key, so that the order of setting does not matter to comparisons.
        self.values.sort_by_key(|v| v.map_or((true, ""), |(key, _)| (false, key)));
        Ok(())
    }

    /// Removes a given value, so that the default applies again.
    pub fn unset(&mut self, key: &str) {
        for value in &mut self.values {
            value.take_if(|(known, _)| *known == key);
        }
        self.values.sort_by_key(|v| v.map_or((true, ""), |(key, _)| (false, key)));
    }

    /// Keys and values that were given, sorted by key.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.values.iter().flatten().copied()
    }

    /// True if no value was given.
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// The values of some parameters, in their order.
    pub(crate) fn resolved(&self, parameters: &[LawParameter]) -> [f64; MOST_PARAMETERS] {
        let mut out = [0.0; MOST_PARAMETERS];
        for (to, parameter) in out.iter_mut().zip(parameters) {
            *to = self.value(parameter);
        }
        out
    }
}

impl Serialize for ParameterValues {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.iter().collect::<BTreeMap<_, _>>().serialize(to)
    }
}

impl ParameterValues {
    /// Values by key, as a file has them; a law must have each of the keys.
    pub(crate) fn named(values: &BTreeMap<String, f64>, laws: &Laws) -> Result<ParameterValues, String> {
        let known = laws.parameters();
        let mut named = ParameterValues::NONE;
        for (key, value) in values {
            let Some(parameter) = known.iter().find(|p| p.key == key) else {
                return Err(format!("no contact law has a parameter {key:?}"));
            };
            named.set(parameter.key, *value).map_err(|error| error.to_string())?;
        }
        Ok(named)
    }
}

/// By their keys: those of granum's own laws.
impl<'d> Deserialize<'d> for ParameterValues {
    fn deserialize<D: Deserializer<'d>>(from: D) -> Result<ParameterValues, D::Error> {
        let values = BTreeMap::deserialize(from)?;
        ParameterValues::named(&values, &Laws::standard()).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_kept_by_key() {
        let a = ParameterValues::NONE.with("rolling_friction", 0.2).unwrap().with("a", 1.0).unwrap();
        let mut b = ParameterValues::NONE.with("a", 2.0).unwrap().with("rolling_friction", 0.2).unwrap();
        assert_ne!(a, b);
        b.set("a", 1.0).unwrap();
        assert_eq!(a, b);
        assert_eq!((a.given("a"), a.given("b")), (Some(1.0), None));
        b.unset("a");
        assert_eq!(b.iter().collect::<Vec<_>>(), [("rolling_friction", 0.2)]);
        let bytes = postcard::to_allocvec(&b).unwrap();
        assert_eq!(postcard::from_bytes::<ParameterValues>(&bytes).unwrap(), b);
        let unknown = postcard::to_allocvec(&a).unwrap();
        assert!(postcard::from_bytes::<ParameterValues>(&unknown).is_err());
    }

    #[test]
    fn too_many_are_refused() {
        let mut values = ParameterValues::NONE;
        for key in ["a", "b", "c", "d", "e", "f", "g", "h", "j", "k", "l", "m", "n", "o", "p", "q"] {
            values.set(key, 1.0).unwrap();
            values.set(key.to_uppercase().leak(), 1.0).unwrap();
        }
        assert_eq!(values.set("i", 1.0), Err(TooManyParameters { key: "i" }));
        values.set("a", 2.0).unwrap();
    }
}
