//! Solid fraction: `sum (4/3) pi R^3 / V`, with overlaps counted twice as is usual (they are some 1e-4 of the volume).

use crate::ratio::ratio;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};
use granum_core::Part;

/// The sensor.
pub struct SolidFraction;

impl Sensor for SolidFraction {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("solid_fraction", "volume of the grains over the volume of the cell")
            .speaking_of(Subject::Bodies)
            .columns([SensorColumn::new(
                "solid_fraction",
                "1",
                "sum of (4/3) pi R^3 over the volume of the cell",
            )])
            .needing(&[Part::Cell, Part::Radii])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        values.push(solid_fraction(observation));
    }
}

/// Volume of all grains, m3.
pub fn grain_volume(observation: &Observation) -> f64 {
    let cubes: f64 =
        observation.assembly.bodies.iter().map(|body| body.equivalent_radius).map(|r| r * r * r).sum();
    4.0 / 3.0 * std::f64::consts::PI * cubes
}

/// Solid fraction; 0 for a cell without a volume.
pub fn solid_fraction(observation: &Observation) -> f64 {
    ratio(grain_volume(observation), observation.volume)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    #[test]
    fn lattices_have_their_known_solid_fractions() {
        let pi = std::f64::consts::PI;
        let simple = lattice::simple_cubic(3, 1e-4, 1e-9, 0.0);
        assert!((solid_fraction(&Observation::new(&simple)) - pi / 6.0).abs() < 1e-8);
        let dense = lattice::face_centred_cubic(3, 1e-4, 1e-9, 0.0);
        assert!((solid_fraction(&Observation::new(&dense)) - pi / 18f64.sqrt()).abs() < 1e-8);
    }
}
