//! Largest overlap `alpha / (R_i + R_j)`: elastic spheres are a reasonable model while it is small (below about 1e-2).

use crate::ratio::ratio;
use crate::{Averaging, Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};
use granum_core::Part;

/// The sensor.
pub struct Overlap;

impl Sensor for Overlap {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("overlap", "overlap of the grains in contact")
            .speaking_of(Subject::Contacts)
            .columns([SensorColumn::new(
                "largest_overlap",
                "1",
                "largest alpha / (R_i + R_j) over the contacts and the observations",
            )
            .averaged(Averaging::Largest)])
            .needing(&[Part::Radii, Part::Contacts, Part::Overlaps])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        values.push(largest_overlap(observation));
    }
}

/// Largest `alpha / (R_i + R_j)`; 0 without contacts, and for contacts in tension whose grains no longer overlap.
pub fn largest_overlap(observation: &Observation) -> f64 {
    let pieces = &observation.assembly.pieces;
    observation
        .assembly
        .contacts
        .iter()
        .filter_map(|contact| {
            let radii = pieces.get(contact.i)?.radius + pieces.get(contact.j)?.radius;
            Some(ratio(contact.approach, radii))
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    #[test]
    fn a_lattice_overlaps_by_its_strain() {
        let assembly = lattice::simple_cubic(3, 1e-4, 1e-3, 2e-4);
        assert!((largest_overlap(&Observation::new(&assembly)) - 1e-3).abs() < 1e-12);
    }
}
