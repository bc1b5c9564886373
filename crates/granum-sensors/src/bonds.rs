//! Bonds: how many hold and how many ruptured, how, and what they store and carry.
//!
//! With N bonds that hold and N_t, N_s that ruptured by tension and by shear since the first was made, the broken share is
//! `(N_t + N_s) / (N + N_t + N_s)`. Their part in the mean stress is `- sum F . l / (3 V)` with the force F on the first piece and the branch l
//! between the centres of the bodies, compression positive.

use granum_core::Part;
use granum_core::assembly::Rupture;
use granum_core::geometry::dot;

use crate::ratio::{mean, ratio};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Bonds;

impl Sensor for Bonds {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("bonds", "bonds that hold and that ruptured, what they store and carry")
            .speaking_of(Subject::Bonds)
            .columns([
                SensorColumn::new("bonds", "1", "number of bonds that hold"),
                SensorColumn::new("bonds_broken_by_tension", "1", "number of bonds that ruptured by tension"),
                SensorColumn::new("bonds_broken_by_shear", "1", "number of bonds that ruptured by shear"),
                SensorColumn::new("broken_bond_fraction", "1", "bonds that ruptured over all that were made"),
                SensorColumn::new("bonds_per_grain", "1", "2 N / N_grains: mean number of bonds of a grain"),
                SensorColumn::new("bond_energy", "J", "elastic energy of the bonds"),
                SensorColumn::new("bond_mean_stress", "Pa", "part of the bonds in the mean stress"),
                SensorColumn::new("mean_bond_radius", "m", "mean radius of the bonds that hold"),
                SensorColumn::new(
                    "mean_bond_utilisation",
                    "1",
                    "mean ratio of load to strength of the bonds",
                ),
            ])
            .needing(&[Part::Bonds])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let assembly = observation.assembly;
        let (bonds, broken) = (&assembly.bonds, &assembly.broken_bonds);
        let by = |rupture: Rupture| broken.iter().filter(|bond| bond.rupture == rupture).count() as f64;
        let (tension, shear) = (by(Rupture::Tension), by(Rupture::Shear));
        let count = bonds.len() as f64;
        let virial: f64 = bonds.iter().map(|bond| -dot(&bond.force(), &assembly.branch_of_bond(bond))).sum();
        values.extend([count, tension, shear, ratio(tension + shear, count + tension + shear)]);
        values.push(ratio(2.0 * count, assembly.bodies.len() as f64));
        values.push(bonds.iter().map(|bond| bond.energy).sum::<f64>() + 0.0);
        values.push(ratio(virial, 3.0 * observation.volume) + 0.0);
        values.push(mean(bonds.iter().map(|bond| bond.radius).sum::<f64>() + 0.0, bonds.len()));
        values.push(mean(bonds.iter().map(|bond| bond.utilisation.max(0.0)).sum::<f64>() + 0.0, bonds.len()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;
    use granum_core::assembly::{Bond, BrokenBond};

    #[test]
    fn two_bonds_and_three_cracks() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        let bond =
            Bond { j: 1, branch: [2e-4, 0.0, 0.0], normal: [1.0, 0.0, 0.0], radius: 1e-5, ..Bond::default() };
        assembly.bonds = vec![
            Bond { normal_force: -3.0, energy: 1.0, utilisation: 0.5, ..bond },
            Bond { normal_force: 1.0, energy: 2.0, utilisation: -0.2, ..bond },
        ];
        let crack = BrokenBond {
            id: 0,
            bodies: [1, 2],
            rupture: Rupture::Tension,
            energy: 1.0,
            time: 0.0,
            phase: 0,
            place: [0.0; 3],
            normal: [1.0, 0.0, 0.0],
            radius: 1e-5,
        };
        assembly.broken_bonds = vec![crack, crack, BrokenBond { rupture: Rupture::Shear, ..crack }];
        let row = measured(&Bonds, &assembly);
        let stress = -2.0 * 2e-4 / (3.0 * assembly.volume());
        assert_eq!(row[..4], [2.0, 2.0, 1.0, 0.6]);
        assert_eq!(row[4..6], [4.0 / 27.0, 3.0]);
        assert_eq!(row[7], 1e-5);
        assert!((row[6] / stress - 1.0).abs() < 1e-12 && row[8] == 0.25, "{row:?}");
    }
}
