//! Rate of rupture: the share of all bonds that ruptures per unit of strain.
//!
//! With the broken share f (see [`bonds`](crate::bonds)) and the strain eps, from one observation to the next
//!
//! ```text
//! d_f / d_s,  d_s = sqrt(2/3 d_eps : d_eps)
//! ```
//!
//! The length s of the strain path is the deviatoric strain where the volume is constant, and it also grows in isotropic and oedometric
//! compression. Observations are spread evenly over the interval of a row, so that the mean of a row is the rate in it.

use granum_core::Part;

use crate::ratio::ratio;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct RuptureRate;

impl Sensor for RuptureRate {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("rupture_rate", "share of the bonds that ruptures per unit of strain")
            .speaking_of(Subject::Bonds)
            .columns([SensorColumn::new(
                "bond_rupture_rate",
                "1",
                "share of all bonds that ruptured since the last observation over the length of the strain path; 0 at the first",
            )])
            .needing(&[Part::Bonds, Part::Strain])
            .remembering()
    }

    fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values) {
        let assembly = observation.assembly;
        let broken = assembly.broken_bonds.len() as f64;
        let share = ratio(broken, broken + assembly.bonds.len() as f64);
        let mut now = vec![share];
        now.extend(assembly.strain.iter().flatten());
        values.push(match memory.len() == now.len() {
            true => {
                let squares: f64 = now.iter().zip(&*memory).skip(1).map(|(a, b)| (a - b) * (a - b)).sum();
                ratio(share - memory[0], (2.0 / 3.0 * squares).sqrt())
            }
            false => 0.0,
        });
        *memory = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::assembly::{Assembly, Bond, BrokenBond, Rupture};

    #[test]
    fn the_share_that_ruptures_is_counted_per_strain() {
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
        let mut memory = Memory::new();
        let mut observe = |broken: usize, axial: f64| {
            let lateral = -0.5 * axial;
            let assembly = Assembly {
                strain: [[axial, 0.0, 0.0], [0.0, lateral, 0.0], [0.0, 0.0, lateral]],
                bonds: vec![Bond::default(); 10 - broken],
                broken_bonds: vec![crack; broken],
                ..Assembly::default()
            };
            let mut row = Vec::new();
            let observation = Observation::new(&assembly);
            RuptureRate.measure(&observation, &mut memory, &mut Values::new(&mut row, &mut []));
            row[0]
        };
        assert_eq!(observe(1, 0.01), 0.0);
        // At constant volume the length of the path is the axial strain.
        assert!((observe(4, 0.03) - 0.3 / 0.02).abs() < 1e-9);
        assert_eq!(observe(4, 0.05), 0.0);
        // Without strain nothing can be said.
        assert_eq!(observe(6, 0.05), 0.0);
    }
}
