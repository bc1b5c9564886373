//! Strong and weak networks: the contacts with a normal force above the mean, and the others (Radjai et al. 1998). Every test
//! records the strong fraction, the deviator fabrics and the parts of q/p along axis 1; these are the measures that do not refer
//! to an axis.
//!
//! The share of the mean stress is `p_strong / p`. The share of the deviator is `(s_strong : s) / (s : s)`, s the deviator of
//! the stress; that of the weak contacts is the remainder. The anisotropy of a network is `a_c = sqrt(3/2 a:a)` with
//! `a = 15/2 phi'` of its own contacts, as in [`crate::anisotropies`], negative if it is opposed to the stress.

use granum_core::Part;
use granum_core::assembly::Contact;
use granum_dem::invariants::deviator;

use crate::fabric::fabric;
use crate::ratio::{mean, ratio};
use crate::tensor::{contract, scaled, signed_size, trace};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Networks;

impl Sensor for Networks {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "networks",
            "stress and fabric of the strong and the weak contacts, without reference to an axis",
        )
        .speaking_of(Subject::Contacts)
        .columns([
            SensorColumn::new(
                "strong_mean_stress_share",
                "1",
                "part of p carried by strong contacts, N > <N>",
            ),
            SensorColumn::new(
                "strong_deviator_share",
                "1",
                "part of the deviator of the stress carried by them",
            ),
            SensorColumn::new(
                "strong_coordination_number",
                "1",
                "2 N_s / N of the strong contacts, over all grains",
            ),
            SensorColumn::new("strong_contact_anisotropy", "1", "a_c of the strong contacts"),
            SensorColumn::new(
                "weak_contact_anisotropy",
                "1",
                "a_c of the weak contacts, negative against the stress",
            ),
        ])
        .needing(&[Part::Cell, Part::Contacts, Part::NormalForces, Part::TangentialForces])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let stress = &observation.stress;
        let whole = deviator(&stress.tensor());
        let (normal, tangential) = (&stress.strong_normal, &stress.strong_tangential);
        let strong = std::array::from_fn(|i| std::array::from_fn(|j| normal[i][j] + tangential[i][j]));
        let anisotropy = |chosen: &dyn Fn(&Contact) -> bool| {
            let tensor = deviator(&fabric(observation, chosen).0);
            signed_size(&scaled(&tensor, 7.5), &whole)
        };
        let count =
            observation.assembly.contacts.iter().filter(|contact| observation.is_strong(contact)).count();
        values.extend([
            ratio(trace(&strong), trace(&stress.tensor())),
            ratio(contract(&deviator(&strong), &whole), contract(&whole, &whole)),
            mean(2.0 * count as f64, observation.assembly.bodies.len()),
            anisotropy(&|contact| observation.is_strong(contact)),
            anisotropy(&|contact| !observation.is_strong(contact)),
        ]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;

    /// A simple cubic lattice with forces of 3 along one axis and 1 along the others: the strong contacts are those of the
    /// axis, so p_strong / p = 3/5, they carry the deviator (3, 0, 0)' of (2, 0, 0)': 3/2; a_c = 15/2 and -15/4.
    #[test]
    fn a_lattice_loaded_along_any_axis() {
        for axis in 0..3 {
            let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
            for contact in &mut assembly.contacts {
                contact.normal_force = if contact.normal[axis].abs() > 0.5 { 3.0 } else { 1.0 };
            }
            let row = measured(&Networks, &assembly);
            for (value, exact) in row.iter().zip([0.6, 1.5, 2.0, 7.5, -3.75]) {
                assert!((value - exact).abs() < 1e-12, "axis {axis}: {row:?}");
            }
        }
    }
}
