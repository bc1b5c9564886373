//! Directions of the bonds that hold and of those that ruptured: the mean of `n n` over bonds and over cracks, with the unit vector n along the
//! bond. Tension along an axis opens cracks whose normals lie along it.

use granum_core::Part;
use granum_core::assembly::{Matrix, Vector};

use crate::tensor::{add_dyad, deviator, scaled};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct BondFabric;

impl Sensor for BondFabric {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("bond_fabric", "directions of the bonds that hold, and of the cracks")
            .speaking_of(Subject::Bonds)
            .columns([
                SensorColumn::new("bond_fabric_11", "1", "<n_1 n_1> of the bonds that hold"),
                SensorColumn::new("bond_fabric_22", "1", "<n_2 n_2> of the bonds that hold"),
                SensorColumn::new("bond_fabric_33", "1", "<n_3 n_3> of the bonds that hold"),
                SensorColumn::new(
                    "bond_deviator_fabric",
                    "1",
                    "phi_1 - phi_3 of the bonds, axes 2 and 3 averaged",
                ),
                SensorColumn::new("crack_fabric_11", "1", "<n_1 n_1> of the bonds that ruptured"),
                SensorColumn::new("crack_fabric_22", "1", "<n_2 n_2> of the bonds that ruptured"),
                SensorColumn::new("crack_fabric_33", "1", "<n_3 n_3> of the bonds that ruptured"),
                SensorColumn::new(
                    "crack_deviator_fabric",
                    "1",
                    "phi_1 - phi_3 of the cracks, axes 2 and 3 averaged",
                ),
            ])
            .needing(&[Part::Bonds])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let assembly = observation.assembly;
        for fabric in [
            mean_dyad(assembly.bonds.iter().map(|bond| bond.normal)),
            mean_dyad(assembly.broken_bonds.iter().map(|bond| bond.normal)),
        ] {
            values.extend([fabric[0][0], fabric[1][1], fabric[2][2], deviator(&fabric)]);
        }
    }
}

/// The mean of `n n`; zero without directions.
fn mean_dyad(directions: impl Iterator<Item = Vector>) -> Matrix {
    let (mut sum, mut count) = ([[0.0; 3]; 3], 0usize);
    for n in directions {
        add_dyad(&mut sum, 1.0, &n, &n);
        count += 1;
    }
    scaled(&sum, 1.0 / count.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::measured;
    use granum_core::assembly::{Assembly, Bond};

    #[test]
    fn bonds_along_two_axes() {
        let along = |normal| Bond { normal, ..Bond::default() };
        let bonds = vec![along([1.0, 0.0, 0.0]), along([1.0, 0.0, 0.0]), along([0.0, 0.0, 1.0])];
        let assembly = Assembly { bonds, ..Assembly::default() };
        let row = measured(&BondFabric, &assembly);
        for (found, right) in row.iter().zip([2.0 / 3.0, 0.0, 1.0 / 3.0, 0.5, 0.0, 0.0, 0.0, 0.0]) {
            assert!((found - right).abs() < 1e-15, "{row:?}");
        }
    }
}
