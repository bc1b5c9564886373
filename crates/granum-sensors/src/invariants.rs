//! Invariants of stress and strain that do not refer to an axis of compression, and the shear strains: the columns
//! that were added for tests along any path. The formulas are in [`granum_dem::invariants`].

use granum_core::Part;
use granum_dem::invariants::{
    deviatoric_strain, intermediate_ratio, lode_cosine, mean, mobilised_friction, signed_von_mises,
};

use crate::ratio::ratio;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor. It is recorded in every test with all columns; the section `[shear]` keeps those of its first version.
pub struct Invariants;

impl Sensor for Invariants {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "invariants",
            "arc length of the strain path, shear strains, and invariants of stress and strain",
        )
        .speaking_of(Subject::Sample)
        .columns([
            SensorColumn::new(
                "arc_length",
                "1",
                "arc length of the strain path, sum of sqrt(2/3 d_eps:d_eps)",
            ),
            SensorColumn::new("shear_strain_yz", "1", "gamma_yz, an angle"),
            SensorColumn::new("shear_strain_zx", "1", "gamma_zx, an angle"),
            SensorColumn::new("shear_strain_xy", "1", "gamma_xy, an angle"),
            SensorColumn::new(
                "deviatoric_strain",
                "1",
                "eps_q = sqrt(2/3 e:e) of the deviator e of the strain",
            ),
            SensorColumn::new("von_mises_stress", "Pa", "q_vM = sqrt(3/2 s:s) with the sign of J_3"),
            SensorColumn::new("von_mises_ratio", "1", "ratio of this q_vM to p"),
            SensorColumn::new(
                "intermediate_stress_ratio",
                "1",
                "b = (sigma_2 - sigma_3) / (sigma_1 - sigma_3) of the principal stresses",
            ),
            SensorColumn::new(
                "lode_cosine",
                "1",
                "cos(3 theta) of the Lode angle: 1 in compression, -1 in extension",
            ),
            SensorColumn::new(
                "mobilised_friction",
                "1",
                "sin(phi) = (sigma_1 - sigma_3) / (sigma_1 + sigma_3)",
            ),
        ])
        .needing(&[
            Part::Cell,
            Part::Contacts,
            Part::NormalForces,
            Part::TangentialForces,
            Part::Strain,
        ])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let (stress, strain) = (observation.stress.tensor(), &observation.assembly.strain);
        let q = signed_von_mises(&stress);
        values.extend([
            observation.assembly.arc_length,
            strain[1][2] + strain[2][1],
            strain[2][0] + strain[0][2],
            strain[0][1] + strain[1][0],
            deviatoric_strain(strain),
            q,
            ratio(q, mean(&stress)),
            intermediate_ratio(&stress),
            lode_cosine(&stress),
            mobilised_friction(&stress),
        ]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;
    use granum_core::assembly::Assembly;
    use proptest::prelude::*;

    proptest! {
        /// No axis is treated differently from the others: a rotated assembly has the same invariants of the stress.
        #[test]
        fn invariants_stay_where_the_assembly_is_turned(seed in 0u64..1000, axis in prop::array::uniform3(-1.0..1.0f64)) {
            prop_assume!(axis.iter().map(|x| x * x).sum::<f64>() > 0.01);
            let assembly = lattice::random_contacts(60, seed);
            let turned = lattice::rotated(&assembly, &lattice::rotation(axis, 1.3));
            let row = |assembly: &Assembly| measured(&Invariants, assembly);
            let (before, after) = (row(&assembly), row(&turned));
            prop_assert_eq!(before.len(), Invariants.description().columns.len());
            for (a, b) in before.iter().zip(&after).skip(5) {
                prop_assert!((a - b).abs() <= 1e-7 * a.abs().max(1.0), "{:?} {:?}", before, after);
            }
        }
    }
}
