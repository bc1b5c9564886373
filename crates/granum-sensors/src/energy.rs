//! Energy by mechanism, J: the energy stored at present, and the work and losses since the start of the phase.
//!
//! The energy balance closes: `boundary_work = change of (kinetic + elastic normal) + tangential_work + damping + adhesion made +
//! adhesion broken`, where the normal energy includes that of the joined surfaces. The tangential work is stored or dissipated by
//! sliding and micro-slip: `tangential_work = change of elastic tangential + friction + micro-slip`; each term is computed
//! independently, so that the gap of this equation is the inconsistency of the tangential law (none without micro-slip). If contacts
//! resist rolling, the right-hand side also includes `rolling_work` of [`crate::rolling`], and if an adhesion law acts, the change of
//! energy and the loss of [`crate::attraction`].

use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};
use granum_core::Part;
use granum_core::energy::MechanismGroup;

/// The sensor.
pub struct Energy;

impl Sensor for Energy {
    fn description(&self) -> SensorDescription {
        let stored = [
            SensorColumn::new("kinetic_energy", "J", "of the fluctuating velocities and the spins")
                .needing(&[Part::Radii, Part::Masses, Part::Velocities, Part::Spins]),
            SensorColumn::new(
                "elastic_normal_energy",
                "J",
                "of the normal approach of all contacts, that of their joined surfaces included",
            )
            .needing(&[Part::Contacts, Part::ContactEnergies]),
            SensorColumn::new(
                "elastic_tangential_energy",
                "J",
                "stored by the tangential displacement of all contacts",
            )
            .needing(&[Part::Contacts, Part::ContactEnergies]),
            SensorColumn::new(
                "boundary_work",
                "J",
                "work that the deformation of the cell did on the grains",
            )
            .needing(&[Part::EnergyBalance]),
        ];
        SensorDescription::new(
            "energy",
            "stored energies and the energy balance of work and losses since the start of the phase",
        )
        .speaking_of(Subject::Sample)
        .columns(stored.into_iter().chain(mechanism_columns(MechanismGroup::Forces)))
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let (mut normal, mut tangential) = (0.0, 0.0);
        for contact in &observation.assembly.contacts {
            normal += contact.normal_energy;
            tangential += contact.tangential_energy;
        }
        let balance = &observation.assembly.energy;
        values.extend([kinetic_energy(observation), normal, tangential, balance.boundary_work]);
        values.extend(MechanismGroup::Forces.values(balance));
    }
}

/// The columns of the mechanisms of a group.
pub(crate) fn mechanism_columns(group: MechanismGroup) -> impl Iterator<Item = SensorColumn> {
    group.mechanisms().map(|mechanism| {
        SensorColumn::new(mechanism.column, "J", mechanism.meaning).needing(&[Part::EnergyBalance])
    })
}

/// Kinetic energy of the fluctuating motion and the spins, J ([`Assembly::kinetic_energy`](granum_core::Assembly::kinetic_energy)).
pub fn kinetic_energy(observation: &Observation) -> f64 {
    observation.assembly.kinetic_energy()
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::assembly::{Assembly, Sphere};

    #[test]
    fn a_rolling_sphere_has_seven_tenths_m_v_squared() {
        let grain = Sphere {
            mass: 2.0,
            radius: 0.5,
            velocity: [3.0, 0.0, 0.0],
            spin: [0.0, 6.0, 0.0],
            ..Default::default()
        };
        let assembly = Assembly { ..Default::default() }.with_spheres(vec![grain]);
        assert!((kinetic_energy(&Observation::new(&assembly)) - 0.7 * 2.0 * 9.0).abs() < 1e-12);
    }
}
