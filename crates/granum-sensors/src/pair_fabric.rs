//! Fabric of the branches between grains: where the neighbours of a grain are.
//!
//! `chi_ij = <m_i m_j>` with `m = l / |l|`, the mean over the pairs of grains that touch, l the branch vector between their centres of
//! mass; its trace is 1. Of spheres l is along the contact normal, and chi is [Satake's tensor](crate::fabric). Elongated grains that lie on
//! each other side to side have short branches, and normals that are not along them, so that the fabric of such grains is described by
//! branches and normals separately (Azema, Radjai and Saussine 2009; Azema and Radjai 2010). Deviator `chi_d = chi_1 - chi_3` along axis 1, axes 2
//! and 3 averaged, as of the contacts; the difference of the largest and smallest eigenvalue is independent of the axes.

use granum_core::Part;
use granum_core::assembly::Matrix;
use granum_core::geometry::length;

use crate::ratio::{mean, ratio};
use crate::tensor::{add_dyad, deviator, eigenvalues, scaled};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct PairFabric;

impl Sensor for PairFabric {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "pair_fabric",
            "directions and lengths of the branches between grains that touch",
        )
        .speaking_of(Subject::Bodies)
        .columns([
            SensorColumn::new(
                "pair_fabric_11",
                "1",
                "chi_11 = <m_1 m_1> of the branches, one a pair of grains",
            ),
            SensorColumn::new("pair_fabric_22", "1", "chi_22"),
            SensorColumn::new("pair_fabric_33", "1", "chi_33"),
            SensorColumn::new("pair_fabric_12", "1", "chi_12"),
            SensorColumn::new("pair_fabric_13", "1", "chi_13"),
            SensorColumn::new("pair_fabric_23", "1", "chi_23"),
            SensorColumn::new("deviator_pair_fabric", "1", "chi_d = chi_1 - chi_3, axes 2 and 3 averaged"),
            SensorColumn::new(
                "principal_deviator_pair_fabric",
                "1",
                "largest minus smallest eigenvalue of chi",
            ),
            SensorColumn::new(
                "mean_branch_length",
                "m",
                "mean distance of the centres of two grains that touch",
            ),
        ])
        .needing(&[Part::Contacts])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let (fabric, distance) = pair_fabric(observation);
        let principal = eigenvalues(&fabric);
        let [[a, d, e], [_, b, f], [_, _, c]] = fabric;
        values.extend([a, b, c, d, e, f]);
        values.extend([deviator(&fabric), principal[0] - principal[2], distance]);
    }
}

/// The fabric of the branches and their mean length, m; zero without pairs.
pub fn pair_fabric(observation: &Observation) -> (Matrix, f64) {
    let (mut sum, mut lengths, mut count) = ([[0.0; 3]; 3], 0.0, 0);
    for pair in observation.pairs() {
        let branch = pair.branch();
        let long = length(&branch);
        let direction = branch.map(|x| ratio(x, long));
        add_dyad(&mut sum, 1.0, &direction, &direction);
        lengths += long;
        count += 1;
    }
    (scaled(&sum, ratio(1.0, f64::from(count))), mean(lengths, count as usize))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fabric::fabric;
    use crate::sensor::measured;
    use crate::{clumps, lattice};

    /// Branches (0, 1, 0), (1.5, 0.5, 0) and (1, 0.5, 0): the pair that touches twice counts once.
    #[test]
    fn branches_join_the_centres_of_mass() {
        let row = measured(&PairFabric, &clumps::few());
        let third = 1.0 / 3.0;
        let exact = [1.7 * third, 1.3 * third, 0.0, 0.7 * third, 0.0, 0.0, 0.35];
        assert!(row.iter().zip(exact).all(|(value, exact)| (value - exact).abs() < 1e-14), "{row:?}");
        // In the plane the eigenvalues are 1/2 +- sqrt((0.2/3)^2 + (0.7/3)^2), and the smallest is that of z.
        let largest = 0.5 + third * (0.2f64 * 0.2 + 0.7 * 0.7).sqrt();
        assert!((row[7] - largest).abs() < 1e-14);
        assert!((row[8] - third * (1.0 + 2.5f64.sqrt() + 1.25f64.sqrt())).abs() < 1e-14);
    }

    #[test]
    fn branches_of_spheres_are_along_the_normals() {
        let mut assembly = lattice::random_contacts(100, 3);
        assembly.contacts.truncate(100);
        let observation = Observation::new(&assembly);
        let (of_pairs, of_contacts) = (pair_fabric(&observation).0, fabric(&observation, |_| true).0);
        for (own, other) in of_pairs.iter().flatten().zip(of_contacts.iter().flatten()) {
            assert!((own - other).abs() < 1e-14);
        }
    }
}
