//! Fabric: the orientation of the contacts.
//!
//! Satake (1982): `phi_ij = <n_i n_j>`, the mean over the contacts, with n the unit normal; its trace is 1. Deviator
//! `phi_d = phi_1 - phi_3`, where axis 1 is the axis of compression and axes 2 and 3 are averaged; also over strong
//! (`N > <N>`) and weak contacts separately, each divided by its own number of contacts (Radjai et al. 1998). The difference
//! of the largest and smallest eigenvalue is reported as well: it is independent of the axes, but biased upwards by noise
//! (it is positive even for a finite isotropic sample).
//!
//! Every contact of two grains of several pieces counts, with its own normal; [`crate::pair_fabric`] has one branch for each pair of grains.

use granum_core::Part;
use granum_core::assembly::{Contact, Matrix};

use crate::tensor::{add_dyad, deviator, eigenvalues, scaled};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Fabric;

impl Sensor for Fabric {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "fabric",
            "Satake's fabric tensor and its deviator, also for strong and weak contacts separately",
        )
        .speaking_of(Subject::Contacts)
        .columns([
            SensorColumn::new("fabric_11", "1", "phi_11 = <n_1 n_1>"),
            SensorColumn::new("fabric_22", "1", "phi_22"),
            SensorColumn::new("fabric_33", "1", "phi_33"),
            SensorColumn::new("fabric_12", "1", "phi_12"),
            SensorColumn::new("fabric_13", "1", "phi_13"),
            SensorColumn::new("fabric_23", "1", "phi_23"),
            SensorColumn::new("deviator_fabric", "1", "phi_d = phi_1 - phi_3, axes 2 and 3 averaged"),
            SensorColumn::new("strong_deviator_fabric", "1", "phi_d of the strong contacts, N > <N>")
                .needing(&[Part::NormalForces]),
            SensorColumn::new("weak_deviator_fabric", "1", "phi_d of the weak contacts, N <= <N>")
                .needing(&[Part::NormalForces]),
            SensorColumn::new("principal_deviator_fabric", "1", "largest minus smallest eigenvalue of phi"),
            SensorColumn::new("strong_fraction", "1", "strong contacts over all contacts")
                .needing(&[Part::NormalForces]),
        ])
        .needing(&[Part::Contacts])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let [(weak, weak_count), (strong, strong_count)] = fabrics(observation, |c| observation.is_strong(c));
        let count = (strong_count + weak_count).max(1) as f64;
        let (a, b) = (strong_count as f64 / count, weak_count as f64 / count);
        let all: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| a * strong[i][j] + b * weak[i][j]));
        let principal = eigenvalues(&all);
        values.extend([all[0][0], all[1][1], all[2][2], all[0][1], all[0][2], all[1][2]]);
        values.extend([deviator(&all), deviator(&strong), deviator(&weak), principal[0] - principal[2], a]);
    }
}

/// Fabric tensor of the selected contacts, and their number; zero without any.
pub fn fabric(observation: &Observation, chosen: impl Fn(&Contact) -> bool) -> (Matrix, usize) {
    let [_, of_chosen] = fabrics(observation, chosen);
    of_chosen
}

/// Fabric tensors of the contacts that are not selected and of those that are, and their numbers.
fn fabrics(observation: &Observation, chosen: impl Fn(&Contact) -> bool) -> [(Matrix, usize); 2] {
    let mut sums = [([[0.0; 3]; 3], 0); 2];
    for contact in &observation.assembly.contacts {
        // An index instead of a branch, which no processor could predict.
        let (sum, count) = &mut sums[usize::from(chosen(contact))];
        add_dyad(sum, 1.0, &contact.normal, &contact.normal);
        *count += 1;
    }
    sums.map(|(sum, count)| if count == 0 { (sum, 0) } else { (scaled(&sum, 1.0 / count as f64), count) })
}

/// Deviator fabric `phi_d` of all contacts.
pub fn deviator_fabric(observation: &Observation) -> f64 {
    deviator(&fabric(observation, |_| true).0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;
    use crate::tensor::trace;
    use proptest::prelude::*;

    #[test]
    fn cubic_lattices_are_isotropic() {
        for assembly in
            [lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4), lattice::face_centred_cubic(3, 1e-4, 1e-4, 1e-4)]
        {
            let (tensor, count) = fabric(&Observation::new(&assembly), |_| true);
            assert_eq!(count, assembly.contacts.len());
            for i in 0..3 {
                for j in 0..3 {
                    let exact = if i == j { 1.0 / 3.0 } else { 0.0 };
                    assert!((tensor[i][j] - exact).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn contacts_along_the_axis_give_one_and_across_it_minus_a_half() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        assembly.contacts.retain(|contact| contact.normal[0].abs() > 0.5);
        assert!((deviator_fabric(&Observation::new(&assembly)) - 1.0).abs() < 1e-12);
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        assembly.contacts.retain(|contact| contact.normal[0].abs() < 0.5);
        assert!((deviator_fabric(&Observation::new(&assembly)) + 0.5).abs() < 1e-12);
    }

    #[test]
    fn strong_and_weak_networks_are_told_apart() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        for contact in &mut assembly.contacts {
            contact.normal_force = if contact.normal[0].abs() > 0.5 { 3.0 } else { 1.0 };
        }
        let row = measured(&Fabric, &assembly);
        assert!(row[6].abs() < 1e-12, "all: {}", row[6]);
        assert!((row[7] - 1.0).abs() < 1e-12, "strong: {}", row[7]);
        assert!((row[8] + 0.5).abs() < 1e-12, "weak: {}", row[8]);
        assert!((row[10] - 1.0 / 3.0).abs() < 1e-12);
    }

    /// Independent check: the fabric along the axis from the histogram of orientations, with the cosine uniform within each
    /// bin.
    #[test]
    fn the_rose_gives_the_same_fabric() {
        let assembly = lattice::random_contacts(400, 7);
        let observation = Observation::new(&assembly);
        let rose = crate::rose::Rose::from_observation(&observation);
        let by_rose: f64 = (0..crate::rose::BINS)
            .map(|b| {
                let (high, low) = (crate::rose::EDGE_COSINES[b], crate::rose::EDGE_COSINES[b + 1]);
                rose.counts[b] as f64 * (high * high + high * low + low * low) / 3.0
            })
            .sum::<f64>()
            / assembly.contacts.len() as f64;
        let tensor = fabric(&observation, |_| true).0;
        assert!((tensor[0][0] - by_rose).abs() < 0.01, "{} {by_rose}", tensor[0][0]);
    }

    proptest! {
        #[test]
        fn fabric_has_unit_trace_and_turns_with_the_assembly(
            seed in 0u64..1000,
            axis in prop::array::uniform3(-1.0..1.0f64),
        ) {
            prop_assume!(axis.iter().map(|x| x * x).sum::<f64>() > 0.01);
            let assembly = lattice::random_contacts(60, seed);
            let q = lattice::rotation(axis, 0.7);
            let turned = lattice::rotated(&assembly, &q);
            let before = fabric(&Observation::new(&assembly), |_| true).0;
            let after = fabric(&Observation::new(&turned), |_| true).0;
            let expected = lattice::conjugate(&q, &before);
            prop_assert!((trace(&before) - 1.0).abs() < 1e-12);
            for i in 0..3 {
                for j in 0..3 {
                    prop_assert!((after[i][j] - expected[i][j]).abs() < 1e-12);
                }
            }
            let (a, b) = (eigenvalues(&before), eigenvalues(&after));
            prop_assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-12));
        }
    }
}
