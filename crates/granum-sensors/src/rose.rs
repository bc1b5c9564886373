//! Rose diagram of contact normals: the number of contacts, and their forces, by the angle to the axis of compression.
//!
//! Nine bins of 10 degrees of the angle between the normal (as a line) and axis 1. The density is relative to an isotropic
//! assembly, `(n_b / N_k) / (cos low - cos high)`, so that it is 1 everywhere without anisotropy; the mean force is
//! `<N>_b / <N>` (Rothenburg and Bathurst 1989).

use crate::ratio::{mean, ratio};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};
use granum_core::Part;

/// Number of bins.
pub const BINS: usize = 9;

/// Cosines of the edges of the bins: 0, 10, ... 90 degrees.
pub const EDGE_COSINES: [f64; BINS + 1] = [
    1.0,
    0.984_807_753_012_208,
    0.939_692_620_785_908_4,
    0.866_025_403_784_438_6,
    0.766_044_443_118_978,
    0.642_787_609_686_539_3,
    0.5,
    0.342_020_143_325_668_7,
    0.173_648_177_666_930_3,
    0.0,
];

/// The sensor.
pub struct RoseOfContacts;

impl Sensor for RoseOfContacts {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("rose", "contact normals and forces by their angle to the axis of compression")
            .speaking_of(Subject::Contacts)
            .columns([
                SensorColumn::new("rose_05", "1", "density of normals at 0-10 degrees, 1 if isotropic"),
                SensorColumn::new("rose_15", "1", "density of normals at 10-20 degrees, 1 if isotropic"),
                SensorColumn::new("rose_25", "1", "density of normals at 20-30 degrees, 1 if isotropic"),
                SensorColumn::new("rose_35", "1", "density of normals at 30-40 degrees, 1 if isotropic"),
                SensorColumn::new("rose_45", "1", "density of normals at 40-50 degrees, 1 if isotropic"),
                SensorColumn::new("rose_55", "1", "density of normals at 50-60 degrees, 1 if isotropic"),
                SensorColumn::new("rose_65", "1", "density of normals at 60-70 degrees, 1 if isotropic"),
                SensorColumn::new("rose_75", "1", "density of normals at 70-80 degrees, 1 if isotropic"),
                SensorColumn::new("rose_85", "1", "density of normals at 80-90 degrees, 1 if isotropic"),
                SensorColumn::new("rose_force_05", "1", "mean normal force at 0-10 degrees over <N>")
                    .needing(&[Part::NormalForces]),
                SensorColumn::new("rose_force_15", "1", "mean normal force at 10-20 degrees over <N>")
                    .needing(&[Part::NormalForces]),
                SensorColumn::new("rose_force_25", "1", "mean normal force at 20-30 degrees over <N>")
                    .needing(&[Part::NormalForces]),
                SensorColumn::new("rose_force_35", "1", "mean normal force at 30-40 degrees over <N>")
                    .needing(&[Part::NormalForces]),
                SensorColumn::new("rose_force_45", "1", "mean normal force at 40-50 degrees over <N>")
                    .needing(&[Part::NormalForces]),
                SensorColumn::new("rose_force_55", "1", "mean normal force at 50-60 degrees over <N>")
                    .needing(&[Part::NormalForces]),
                SensorColumn::new("rose_force_65", "1", "mean normal force at 60-70 degrees over <N>")
                    .needing(&[Part::NormalForces]),
                SensorColumn::new("rose_force_75", "1", "mean normal force at 70-80 degrees over <N>")
                    .needing(&[Part::NormalForces]),
                SensorColumn::new("rose_force_85", "1", "mean normal force at 80-90 degrees over <N>")
                    .needing(&[Part::NormalForces]),
            ])
            .needing(&[Part::Contacts])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let rose = Rose::from_observation(observation);
        values.extend((0..BINS).map(|b| rose.density(b)));
        values.extend(
            (0..BINS).map(|b| ratio(mean(rose.force_sums[b], rose.counts[b]), observation.mean_normal_force)),
        );
    }
}

/// Contacts by the angle of their normal to axis 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rose {
    /// Number of contacts in each bin.
    pub counts: [usize; BINS],
    /// Sum of their normal forces, N.
    pub force_sums: [f64; BINS],
}

impl Rose {
    /// Counts the contacts.
    pub fn from_observation(observation: &Observation) -> Self {
        let mut rose = Rose::default();
        for contact in &observation.assembly.contacts {
            let cosine = contact.normal[0].abs();
            // Counted instead of searched: no processor can predict where a search would end.
            let bin = EDGE_COSINES[1..BINS].iter().filter(|&&edge| cosine <= edge).count();
            rose.counts[bin] += 1;
            rose.force_sums[bin] += contact.normal_force;
        }
        rose
    }

    /// Density of bin b relative to an isotropic assembly; 0 without contacts.
    pub fn density(&self, bin: usize) -> f64 {
        let all: usize = self.counts.iter().sum();
        mean(self.counts[bin] as f64, all) / (EDGE_COSINES[bin] - EDGE_COSINES[bin + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;

    #[test]
    fn edges_are_the_cosines_of_tens_of_degrees() {
        for (k, cosine) in EDGE_COSINES.iter().enumerate() {
            assert!((cosine - (10.0 * k as f64).to_radians().cos()).abs() < 1e-15);
        }
    }

    #[test]
    fn a_simple_cubic_lattice_has_two_petals() {
        let assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 2e-4);
        let row = measured(&RoseOfContacts, &assembly);
        assert!((row[0] - 1.0 / 3.0 / (1.0 - EDGE_COSINES[1])).abs() < 1e-12);
        assert!((row[8] - 2.0 / 3.0 / EDGE_COSINES[8]).abs() < 1e-12);
        assert!(row[1..8].iter().all(|&density| density == 0.0));
        assert!((row[9] - 1.0).abs() < 1e-12 && (row[17] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_random_assembly_is_round_and_normalised() {
        let assembly = lattice::random_contacts(4000, 11);
        let observation = Observation::new(&assembly);
        let rose = Rose::from_observation(&observation);
        let total: f64 = (0..BINS).map(|b| rose.density(b) * (EDGE_COSINES[b] - EDGE_COSINES[b + 1])).sum();
        assert!((total - 1.0).abs() < 1e-12);
        for b in 2..BINS {
            assert!((rose.density(b) - 1.0).abs() < 0.2, "bin {b}: {}", rose.density(b));
        }
    }
}
