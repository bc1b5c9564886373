//! Spin of the grains, along and across their long axes, and the energy of their rotation.
//!
//! Root mean squares of the spin omega over all grains, and of its parts `omega . u` and `|omega - (omega . u) u|` over the grains with a
//! single long axis u, that of the least moment of inertia I_u ([`crate::orientation`]). If the energy of rotation were shared evenly by
//! the axes of a grain with the equal moments I_t across u, the square across would be `2 I_u / I_t` of that along u. Over the observations of
//! a state the squares are averaged.
//!
//! The energy of rotation is `1/2 sum I_k omega_k^2` in the principal axes, of spheres `1/5 m R^2 omega^2`; it is a part of the
//! [kinetic energy](crate::energy).

use granum_core::Part;

use crate::principal_axes::along_and_across;
use crate::ratio::mean;
use crate::{Averaging, Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Spin;

impl Sensor for Spin {
    fn description(&self) -> SensorDescription {
        let root_mean_square =
            |name, meaning| SensorColumn::new(name, "rad/s", meaning).averaged(Averaging::RootMeanSquare);
        SensorDescription::new("spin", "spins along and across the long axes of the grains, and their energy")
            .speaking_of(Subject::Bodies)
            .columns([
                root_mean_square("spin", "root mean square spin over all grains"),
                root_mean_square(
                    "spin_along_long_axis",
                    "root mean square of the component along the long axis",
                ),
                root_mean_square(
                    "spin_across_long_axis",
                    "root mean square of the part across the long axis",
                ),
                SensorColumn::new("rotational_energy", "J", "part of the kinetic energy that the spins have")
                    .needing(&[Part::Radii, Part::Masses]),
            ])
            .needing(&[Part::Spins])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let assembly = observation.assembly;
        let (mut square, mut doubled) = (0.0, 0.0);
        let (mut parts, mut count) = ([0.0; 2], 0);
        for body in &assembly.bodies {
            square += body.spin.iter().map(|w| w * w).sum::<f64>();
            doubled += assembly.rotation_doubled(body);
            if let Some([along, across]) = along_and_across(assembly, body, &body.spin) {
                parts = [parts[0] + along, parts[1] + across];
                count += 1;
            }
        }
        values.push(mean(square, assembly.bodies.len()).sqrt());
        values.extend(parts.map(|part| mean(part, count).sqrt()));
        values.push(0.5 * doubled);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clumps;
    use crate::sensor::measured;

    /// Dimers along x, x and y with moments of 0.1 and 0.35, and two spheres of mass 1 and radius 0.5.
    #[test]
    fn spins_are_split_by_the_long_axis() {
        let mut assembly = clumps::few();
        let spins = [[1.0, 2.0, 2.0], [0.0, 3.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 1.0]];
        assembly.bodies.iter_mut().zip(spins).for_each(|(body, spin)| body.spin = spin);
        let row = measured(&Spin, &assembly);
        let energy = 0.5 * (0.1 + 0.35 * 8.0) + 0.5 * 0.35 * 9.0 + 0.5 * 0.1 * 16.0 + 0.2 * 0.25;
        let exact = [7f64.sqrt(), (17.0 / 3.0f64).sqrt(), (17.0 / 3.0f64).sqrt(), energy];
        assert!(row.iter().zip(exact).all(|(value, exact)| (value - exact).abs() < 1e-12), "{row:?}");
        assert!((assembly.kinetic_energy() - energy).abs() < 1e-12, "nothing else moves");
        assembly.bodies[2].spin = [0.0, 1.0, 0.0];
        let row = measured(&Spin, &assembly);
        assert!((row[1] - (2.0 / 3.0f64).sqrt()).abs() < 1e-12, "{row:?}");
    }
}
