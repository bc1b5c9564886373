//! Anisotropies of contacts, normal forces and tangential forces, and the stress ratio that follows from them (the
//! stress-force-fabric relation: Rothenburg and Bathurst 1989; in three dimensions Chantawarangul 1993, Guo and Zhao 2013).
//!
//! With the fabric `phi = <n n>` the density of contact normals is `(1 + a^c_ij n_i n_j) / 4 pi`, `a^c = 15/2 phi'` (a prime denotes
//! the deviator). Normal and tangential forces as functions of the direction follow from means in which each contact counts
//! with `w = 1 / (1 + a^c_ij n_i n_j)`, so that every direction has the same weight:
//! `F^n = <w N n n>`, `f_0 = tr F^n`, `a^n = 15/2 F^n' / f_0`; `F^t = -<w T n>`, `a^t = 5 F^t' / f_0`.
//!
//! The scalars are `sqrt(3/2 a:a)`, negative where `a:sigma' < 0`. To first order
//! `q/p = 2/5 (a_c + a_n + 3/2 a_t)` with the von Mises stress q, if the anisotropies are coaxial with the stress and all branches
//! have the same length. The column `stress_force_fabric_ratio` is the right-hand side, to be compared with the measured ratio.
//!
//! Grains of several pieces have branches between their centres of mass that are not along the normals, so that of them the right-hand side
//! differs from the measured ratio also where the anisotropies are small (compare [`crate::pair_fabric`]).
//!
//! The expansion is of second order, so that in a strongly anisotropic assembly the density can become negative for some
//! directions; w is therefore limited to 10.

use granum_core::Part;
use granum_core::assembly::Matrix;
use granum_dem::invariants::deviator;

use crate::fabric::fabric;
use crate::ratio::mean;
use crate::tensor::{add_dyad, scaled, signed_size, trace};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Anisotropies;

impl Sensor for Anisotropies {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "anisotropies",
            "anisotropies of contacts and forces, and the stress ratio that follows from them",
        )
        .speaking_of(Subject::Contacts)
        .columns([
            SensorColumn::new("contact_anisotropy", "1", "a_c of the contact normals"),
            SensorColumn::new("normal_force_anisotropy", "1", "a_n of the normal forces by direction"),
            SensorColumn::new(
                "tangential_force_anisotropy",
                "1",
                "a_t of the tangential forces by direction",
            ),
            SensorColumn::new(
                "stress_force_fabric_ratio",
                "1",
                "2/5 (a_c + a_n + 3/2 a_t), which approximates von Mises stress over p",
            ),
        ])
        .needing(&[Part::Cell, Part::Contacts, Part::NormalForces, Part::TangentialForces])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let Anisotropy { contacts, normal, tangential } = Anisotropy::from_observation(observation);
        values.extend([contacts, normal, tangential, 0.4 * (contacts + normal + 1.5 * tangential)]);
    }
}

/// The three anisotropies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// a_c.
    pub contacts: f64,
    /// a_n.
    pub normal: f64,
    /// a_t.
    pub tangential: f64,
}

impl Anisotropy {
    /// Computes the anisotropies; all 0 without contacts, those of the forces also where the mean normal force is not positive.
    pub fn from_observation(observation: &Observation) -> Anisotropy {
        let stress = deviator(&observation.stress.tensor());
        let contacts = &observation.assembly.contacts;
        let density = scaled(&deviator(&fabric(observation, |_| true).0), 7.5);
        let (mut normal, mut tangential) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for contact in contacts {
            let n = &contact.normal;
            let share: f64 = (0..3).map(|i| (0..3).map(|j| density[i][j] * n[i] * n[j]).sum::<f64>()).sum();
            let weight = 1.0 / (1.0 + share).max(0.1);
            add_dyad(&mut normal, weight * contact.normal_force, n, n);
            add_dyad(&mut tangential, -weight, &contact.tangential_force, n);
        }
        let mean_force = trace(&normal);
        // The factor 1 / N of the means cancels in the quotient.
        let by_force = |t: &Matrix, factor: f64| match mean(mean_force, contacts.len()) > 0.0 {
            true => signed_size(&scaled(&deviator(t), factor / mean_force), &stress),
            false => 0.0,
        };
        let normal = by_force(&normal, 7.5);
        let tangential = by_force(&tangential, 5.0);
        Anisotropy { contacts: signed_size(&density, &stress), normal, tangential }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;
    use granum_core::assembly::{Assembly, Contact, Vector};
    use granum_dem::invariants::signed_von_mises;

    /// Contacts whose normals and forces follow the expansions exactly, axisymmetric about an axis: directions at equal
    /// steps of the cumulated density and of the azimuth.
    fn expansion([contact, normal, tangential]: [f64; 3], axis: usize) -> Assembly {
        // A deviator of scalar size a is a (2/3, -1/3, -1/3); a_ij n_i n_j = a (c^2 - 1/3).
        let second = |a: f64, c: f64| a * (c * c - 1.0 / 3.0);
        let cumulated = |c: f64| c + contact * (c * c * c - c) / 3.0;
        let (rings, around) = (400, 24);
        let mut assembly = lattice::simple_cubic(3, 1.0, 0.0, 0.0);
        assembly.contacts.clear();
        for ring in 0..rings {
            let target = 2.0 * (ring as f64 + 0.5) / rings as f64 - 1.0;
            let (mut low, mut high) = (-1.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if cumulated(middle) < target { low = middle } else { high = middle }
            }
            let c: f64 = 0.5 * (low + high);
            let s = (1.0 - c * c).sqrt();
            for k in 0..around {
                let azimuth = std::f64::consts::TAU * k as f64 / around as f64;
                let place = |along: f64, across: f64| -> Vector {
                    let mut v = [0.0; 3];
                    v[axis] = along;
                    v[(axis + 1) % 3] = across * azimuth.cos();
                    v[(axis + 2) % 3] = across * azimuth.sin();
                    v
                };
                let n = place(c, s);
                // -T is a_ij n_j less its part along n: a c (axis - c n).
                let along_axis = place(1.0, 0.0);
                let force = std::array::from_fn(|i| -tangential * c * (along_axis[i] - c * n[i]));
                assembly.contacts.push(Contact {
                    i: 0,
                    j: 1,
                    normal: n,
                    branch: n,
                    normal_force: 1.0 + second(normal, c),
                    tangential_force: force,
                    ..Default::default()
                });
            }
        }
        assembly
    }

    /// The integrals of the expansions give the stress ratio exactly: 0.4488721805 and 0.8918625678 for these two, where the
    /// relation of first order gives 0.44 and 0.88.
    #[test]
    fn expansions_are_recovered_and_the_relation_is_right_to_first_order() {
        for (given, exact, relation) in
            [([0.3, 0.5, 0.2], 0.4488721805, 0.44), ([0.6, 1.0, 0.4], 0.8918625678, 0.88)]
        {
            for axis in [0, 2] {
                let assembly = expansion(given, axis);
                let observation = Observation::new(&assembly);
                let found = Anisotropy::from_observation(&observation);
                for (value, wanted) in [found.contacts, found.normal, found.tangential].iter().zip(given) {
                    assert!((value - wanted).abs() < 2e-4, "{found:?}");
                }
                let stress = observation.stress.tensor();
                let measured_ratio = signed_von_mises(&stress) / observation.stress.mean();
                assert!((measured_ratio / exact - 1.0).abs() < 2e-4, "{measured_ratio}");
                let row = measured(&Anisotropies, &assembly);
                assert!((row[3] - relation).abs() < 3e-4, "{row:?}");
            }
        }
    }

    #[test]
    fn lattices_and_assemblies_without_load_are_isotropic() {
        for assembly in
            [lattice::face_centred_cubic(2, 1e-4, 1e-4, 1e-4), lattice::simple_cubic(3, 1e-4, 1e-4, 0.0)]
        {
            assert!(measured(&Anisotropies, &assembly).iter().all(|value| value.abs() < 1e-12));
        }
    }
}
