//! Unbalanced force: mean resultant contact force on a grain over the mean contact force,
//! `(1/N) sum |F_g| / ((1/N_k) sum |f_c|)`.
//!
//! F_g is the sum of the contact forces on a grain, dashpots included, for all grains (it is zero for those without
//! contacts); f_c is the elastic force of a contact. It is close to 0 in equilibrium. Definitions differ between codes: some
//! use maxima, some divide by the largest contact force, which gives a smaller value.

use crate::ratio::{mean, ratio};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};
use granum_core::Part;
use granum_core::geometry::length;

/// The sensor.
pub struct UnbalancedForce;

impl Sensor for UnbalancedForce {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "unbalanced_force",
            "mean resultant force on a grain over the mean contact force",
        )
        .speaking_of(Subject::Bodies)
        .columns([SensorColumn::new(
            "unbalanced_force",
            "1",
            "mean |resultant force| over grains / mean |contact force| over contacts",
        )])
        .needing(&[
            Part::ResultantForces,
            Part::Contacts,
            Part::NormalForces,
            Part::TangentialForces,
        ])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        values.push(unbalanced_force(observation));
    }
}

/// The unbalanced force; 0 without contact forces.
pub fn unbalanced_force(observation: &Observation) -> f64 {
    let grains = &observation.assembly.bodies;
    let contacts = &observation.assembly.contacts;
    let resultant: f64 = grains.iter().map(|grain| length(&grain.force)).sum();
    let contact: f64 = contacts.iter().map(|contact| length(&contact.force())).sum();
    ratio(mean(resultant, grains.len()), mean(contact, contacts.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    #[test]
    fn one_free_push_among_equal_contacts() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 2e-4);
        assert_eq!(unbalanced_force(&Observation::new(&assembly)), 0.0);
        assembly.bodies[4].force = [0.0, -3e-4, 4e-4];
        let value = unbalanced_force(&Observation::new(&assembly));
        assert!((value - 5e-4 / 27.0 / 2e-4).abs() < 1e-12, "{value}");
    }
}
