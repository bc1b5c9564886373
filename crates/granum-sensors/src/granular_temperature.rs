//! Granular temperature `T = <(v' - <v'>)^2> / 3`, the mean square of one component of the fluctuating velocity (Ogawa 1978;
//! Campbell 1990), and that of the rotation, `<(R omega)^2> / 3`; a grain of several pieces
//! counts in the latter as the sphere of its mass with its energy of rotation, `(R omega)^2 = 5/2 sum I_k omega_k^2 / m`.
//!
//! Its square root, divided by the relative velocity `rate d` of neighbours (with the strain rate of [`crate::inertial_number`]
//! and the mean diameter d), is the ratio of the fluctuating motion to the mean shear; in slow flow it tends to a constant.

use granum_core::Part;
use granum_core::assembly::{Assembly, Body, Vector};

use crate::ratio::{mean, ratio};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct GranularTemperature;

impl Sensor for GranularTemperature {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("granular_temperature", "mean square of the fluctuating velocities and spins")
            .speaking_of(Subject::Bodies)
            .columns([
                SensorColumn::new("granular_temperature", "m2/s2", "T = <(v' - <v'>)^2> / 3"),
                SensorColumn::new("rotational_temperature", "m2/s2", "<(R omega)^2> / 3")
                    .needing(&[Part::Spins]),
                SensorColumn::new(
                    "relative_velocity_fluctuation",
                    "1",
                    "sqrt(T) over strain rate times mean diameter; 0 without a strain rate",
                )
                .needing(&[Part::StrainRate]),
            ])
            .needing(&[Part::Velocities, Part::Radii])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let Assembly { bodies, velocity_gradient, .. } = observation.assembly;
        let drift: Vector = std::array::from_fn(|a| average(bodies, |body| body.velocity[a]));
        let fluctuation = |body: &Body| square(&std::array::from_fn(|a| body.velocity[a] - drift[a]));
        let temperature = average(bodies, fluctuation) / 3.0;
        let assembly = observation.assembly;
        let of_spin = |body: &Body| match body.rigid {
            None => body.equivalent_radius * body.equivalent_radius * square(&body.spin),
            // R^2 omega^2 of the sphere of this mass with this energy of rotation.
            Some(_) => ratio(2.5 * assembly.rotation_doubled(body), body.mass),
        };
        let rotational = average(bodies, of_spin) / 3.0;
        let rate = velocity_gradient.iter().flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
        let diameter = 2.0 * average(bodies, |body| body.equivalent_radius);
        values.extend([temperature, rotational, ratio(temperature.sqrt(), rate * diameter)]);
    }
}

fn average(bodies: &[Body], value: impl Fn(&Body) -> f64) -> f64 {
    mean(bodies.iter().map(value).sum::<f64>() + 0.0, bodies.len())
}

fn square(v: &Vector) -> f64 {
    v.iter().map(|x| x * x).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::measured;
    use crate::{clumps, lattice};

    /// Half of the grains move by (3, 0, 4) and half by (1, 0, 4): T = 1/3 about the drift of (2, 0, 4).
    #[test]
    fn a_drift_is_no_temperature() {
        let mut assembly = lattice::simple_cubic(4, 2.0, 0.0, 0.0);
        for (k, grain) in assembly.bodies.iter_mut().enumerate() {
            grain.velocity = [if k % 2 == 0 { 3.0 } else { 1.0 }, 0.0, 4.0];
            grain.spin = [0.0, 3.0, 0.0];
        }
        assembly.velocity_gradient[0][0] = -0.5;
        let row = measured(&GranularTemperature, &assembly);
        for (value, exact) in row.iter().zip([1.0 / 3.0, 3.0, (1.0f64 / 3.0).sqrt()]) {
            assert!((value - exact).abs() < 1e-14, "{row:?}");
        }
    }

    /// A clump counts with the energy of its rotation: 2.5 (0.1 1^2 + 0.35 2^2) / m instead of (R omega)^2 = 0.36 x 5, and a sphere with
    /// (0.5 x 2)^2, over five grains and three components.
    #[test]
    fn clumps_have_the_temperature_of_their_energy() {
        let mut assembly = clumps::few();
        assembly.bodies[0].spin = [1.0, 2.0, 0.0];
        assembly.bodies[3].spin = [0.0, 2.0, 0.0];
        let found = measured(&GranularTemperature, &assembly)[1];
        assert!((found - (2.5 * 1.5 + 1.0) / 15.0).abs() < 1e-14, "{found}");
    }
}
