//! Granular temperature `T = <(v' - <v'>)^2> / 3`, the mean square of one component of the fluctuating velocity (Ogawa 1978;
//! Campbell 1990), and that of the rotation, `<(R omega)^2> / 3`.
//!
//! Its square root, divided by the relative velocity `rate d` of neighbours (with the strain rate of [`crate::inertial_number`]
//! and the mean diameter d), is the ratio of the fluctuating motion to the mean shear; in slow flow it tends to a constant.

use granum_core::Part;
use granum_core::assembly::{Assembly, Grain, Vector};

use crate::ratio::{mean, ratio};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Values};

/// The sensor.
pub struct GranularTemperature;

impl Sensor for GranularTemperature {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("granular_temperature", "mean square of the fluctuating velocities and spins")
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
        let Assembly { grains, velocity_gradient, .. } = observation.assembly;
        let drift: Vector = std::array::from_fn(|a| average(grains, |grain| grain.velocity[a]));
        let fluctuation = |grain: &Grain| square(&std::array::from_fn(|a| grain.velocity[a] - drift[a]));
        let temperature = average(grains, fluctuation) / 3.0;
        let rotational = average(grains, |grain| grain.radius * grain.radius * square(&grain.spin)) / 3.0;
        let rate = velocity_gradient.iter().flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
        let diameter = 2.0 * average(grains, |grain| grain.radius);
        values.extend([temperature, rotational, ratio(temperature.sqrt(), rate * diameter)]);
    }
}

fn average(grains: &[Grain], value: impl Fn(&Grain) -> f64) -> f64 {
    mean(grains.iter().map(value).sum::<f64>() + 0.0, grains.len())
}

fn square(v: &Vector) -> f64 {
    v.iter().map(|x| x * x).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;

    /// Half of the grains move by (3, 0, 4) and half by (1, 0, 4): T = 1/3 about the drift of (2, 0, 4).
    #[test]
    fn a_drift_is_no_temperature() {
        let mut assembly = lattice::simple_cubic(4, 2.0, 0.0, 0.0);
        for (k, grain) in assembly.grains.iter_mut().enumerate() {
            grain.velocity = [if k % 2 == 0 { 3.0 } else { 1.0 }, 0.0, 4.0];
            grain.spin = [0.0, 3.0, 0.0];
        }
        assembly.velocity_gradient[0][0] = -0.5;
        let row = measured(&GranularTemperature, &assembly);
        for (value, exact) in row.iter().zip([1.0 / 3.0, 3.0, (1.0f64 / 3.0).sqrt()]) {
            assert!((value - exact).abs() < 1e-14, "{row:?}");
        }
    }
}
