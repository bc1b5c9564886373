//! A saved state of the simulation within a checkpoint, to which later stages return.

use granum_dem::contact::choice::registry::Laws;
use granum_dem::simulation::Simulation;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::task::laboratory_error::LaboratoryError;

/// The bytes of a simulation; in text they are hexadecimal digits.
#[derive(Clone)]
pub(super) struct SavedState(Vec<u8>);

impl SavedState {
    /// Saves a simulation.
    pub(super) fn from_simulation(simulation: &Simulation) -> Result<SavedState, LaboratoryError> {
        let bytes = simulation.checkpoint("").map_err(|error| LaboratoryError::Kept(error.to_string()))?;
        Ok(SavedState(bytes))
    }

    /// Restores the simulation.
    pub(super) fn restore(&self, laws: &Laws) -> Result<Simulation, LaboratoryError> {
        let (simulation, _) = Simulation::restore_among(&self.0, laws)
            .map_err(|error| LaboratoryError::Kept(error.to_string()))?;
        Ok(simulation)
    }
}

impl Serialize for SavedState {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut text = String::with_capacity(2 * self.0.len());
        for byte in &self.0 {
            text.extend(
                [byte >> 4, byte & 15].map(|digit| char::from(b"0123456789abcdef"[usize::from(digit)])),
            );
        }
        to.serialize_str(&text)
    }
}

impl<'d> Deserialize<'d> for SavedState {
    fn deserialize<D: Deserializer<'d>>(from: D) -> Result<SavedState, D::Error> {
        let text = String::deserialize(from)?;
        let wrong = || serde::de::Error::custom("the state that stages go back to is not a list of bytes");
        let digit = |byte: u8| char::from(byte).to_digit(16).ok_or_else(wrong);
        let pairs = text.as_bytes().chunks(2);
        let bytes = pairs.map(|pair| match pair {
            [high, low] => Ok((16 * digit(*high)? + digit(*low)?) as u8),
            _ => Err(wrong()),
        });
        Ok(SavedState(bytes.collect::<Result<_, _>>()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_written_and_read_as_digits() {
        let text = serde_json::to_string(&SavedState(vec![0, 171, 255])).unwrap();
        assert_eq!(text, "\"00abff\"");
        assert_eq!(serde_json::from_str::<SavedState>(&text).unwrap().0, [0, 171, 255]);
        for bad in ["\"0\"", "\"0g\"", "\"é\""] {
            assert!(serde_json::from_str::<SavedState>(bad).is_err(), "{bad}");
        }
    }
}
