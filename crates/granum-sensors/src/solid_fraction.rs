//! Solid fraction: `sum (4/3) pi R^3 / V`, with overlaps counted twice as is usual (they are some 1e-4 of the volume).
//! R is the radius of the sphere of the volume of a grain: of several pieces the volume is that of their union, in which what pieces of one
//! grain have in common counts once.

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
    use crate::{clumps, lattice};

    #[test]
    fn lattices_have_their_known_solid_fractions() {
        let pi = std::f64::consts::PI;
        let simple = lattice::simple_cubic(3, 1e-4, 1e-9, 0.0);
        assert!((solid_fraction(&Observation::new(&simple)) - pi / 6.0).abs() < 1e-8);
        let dense = lattice::face_centred_cubic(3, 1e-4, 1e-9, 0.0);
        assert!((solid_fraction(&Observation::new(&dense)) - pi / 18f64.sqrt()).abs() < 1e-8);
    }

    /// The union of the pieces of a grain counts, not their sum: two spheres of diameter 1 at the distance 0.5 have 0.8436 of the
    /// volume of both, 1.0472.
    #[test]
    fn pieces_that_overlap_count_once() {
        let assembly = clumps::packing(3).assembly();
        let observation = Observation::new(&assembly);
        let union = 27.0 * 0.8835729338221;
        assert!((grain_volume(&observation) / union - 1.0).abs() < 1e-12);
        assert!((solid_fraction(&observation) * observation.volume / union - 1.0).abs() < 1e-12);
    }
}
