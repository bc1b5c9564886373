//! Sliding fraction: the fraction of the contacts, and of the strong ones, that were at the friction limit in the last step.
//! Two grains of several pieces can have several contacts, each of which counts; [`crate::pair_sliding`] counts pairs of grains.

use crate::ratio::mean;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};
use granum_core::Part;

/// The sensor.
pub struct Sliding;

impl Sensor for Sliding {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("sliding", "contacts whose tangential force is at the friction limit")
            .speaking_of(Subject::Contacts)
            .columns([
                SensorColumn::new("sliding_fraction", "1", "sliding contacts over all contacts"),
                SensorColumn::new(
                    "strong_sliding_fraction",
                    "1",
                    "sliding strong contacts over strong contacts",
                )
                .needing(&[Part::NormalForces]),
            ])
            .needing(&[Part::Contacts, Part::Sliding])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let (mut sliding, mut strong, mut both) = (0, 0, 0);
        for contact in &observation.assembly.contacts {
            let is_strong = observation.is_strong(contact);
            sliding += usize::from(contact.sliding);
            strong += usize::from(is_strong);
            both += usize::from(is_strong && contact.sliding);
        }
        values.extend([mean(sliding as f64, observation.assembly.contacts.len()), mean(both as f64, strong)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;

    #[test]
    fn sliding_is_counted_among_all_and_among_strong() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        for (k, contact) in assembly.contacts.iter_mut().enumerate() {
            contact.normal_force = if k % 3 == 0 { 4.0 } else { 1.0 };
            contact.sliding = k % 6 == 0 || k % 3 == 1;
        }
        let row = measured(&Sliding, &assembly);
        let n = assembly.contacts.len();
        assert_eq!(n, 81);
        assert!((row[0] - (14.0 + 27.0) / 81.0).abs() < 1e-15);
        assert!((row[1] - 14.0 / 27.0).abs() < 1e-15);
    }
}
