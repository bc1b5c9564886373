//! Inertial number `I = strain_rate * d * sqrt(rho / p)` (GDR MiDi 2004).
//!
//! The strain rate is the component of the velocity gradient with the largest absolute value: the axial rate in axisymmetric
//! compression, the shear rate in simple shear. d is the mean diameter, rho the density of the solid (including any density
//! scaling, since it is computed from the masses), p the measured mean stress. 0 where p is not positive.

use crate::solid_fraction::grain_volume;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};
use granum_core::Part;

/// The sensor.
pub struct InertialNumber;

impl Sensor for InertialNumber {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "inertial_number",
            "ratio of inertial forces to confinement; quasi-static below about 1e-3",
        )
        .speaking_of(Subject::Sample)
        .columns([SensorColumn::new("inertial_number", "1", "I = strain_rate d sqrt(rho / p)")])
        .needing(&[
            Part::Cell,
            Part::Radii,
            Part::Masses,
            Part::StrainRate,
            Part::Contacts,
            Part::NormalForces,
            Part::TangentialForces,
        ])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        values.push(inertial_number(observation));
    }
}

/// The inertial number.
pub fn inertial_number(observation: &Observation) -> f64 {
    let grains = &observation.assembly.bodies;
    let p = observation.stress.mean();
    let volume = grain_volume(observation);
    if grains.is_empty() || volume == 0.0 || p.is_nan() || p <= 0.0 {
        return 0.0;
    }
    let rate = observation.assembly.velocity_gradient.iter().flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
    let diameter =
        2.0 * grains.iter().map(|grain| grain.equivalent_radius).sum::<f64>() / grains.len() as f64;
    let density = grains.iter().map(|grain| grain.mass).sum::<f64>() / volume;
    rate * diameter * (density / p).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    /// The case of the paper: with 20 kPa, d = 0.1 mm, 2650 kg/m3 scaled by 1e12, and 1e-5 /s, I = 3.640e-4.
    #[test]
    fn the_papers_rate_with_its_density_scaling() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 2e-4);
        let p = Observation::new(&assembly).stress.mean();
        for contact in &mut assembly.contacts {
            contact.normal_force *= 20e3 / p;
        }
        let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.5e-4f64.powi(3);
        for (scaling, rate) in [(1e12, 1e-5), (1.0, 10.0)] {
            for grain in &mut assembly.bodies {
                grain.mass = 2650.0 * scaling * volume;
            }
            assembly.velocity_gradient = [[-rate, 0.0, 0.0], [0.0, 0.5 * rate, 0.0], [0.0, 0.0, 0.5 * rate]];
            let value = inertial_number(&Observation::new(&assembly));
            assert!((value / 3.640e-4 - 1.0).abs() < 1e-4, "{value}");
        }
    }
}
