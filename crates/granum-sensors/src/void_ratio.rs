//! Void ratio `e = (V - V_s) / V_s`: the volume of the voids over that of the grains. With the solid fraction phi it is
//! `(1 - phi) / phi`; overlaps are counted twice, as in the [solid fraction](crate::solid_fraction), where the volume
//! of a grain of several pieces is that of their union.

use granum_core::Part;

use crate::ratio::ratio;
use crate::solid_fraction::grain_volume;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct VoidRatio;

impl Sensor for VoidRatio {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("void_ratio", "volume of the voids over the volume of the grains")
            .speaking_of(Subject::Bodies)
            .columns([SensorColumn::new(
                "void_ratio",
                "1",
                "e = (V - V_s) / V_s, V_s the volume of the grains",
            )])
            .needing(&[Part::Cell, Part::Radii])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        values.push(void_ratio(observation));
    }
}

/// Void ratio; 0 without grains.
pub fn void_ratio(observation: &Observation) -> f64 {
    let solid = grain_volume(observation);
    ratio(observation.volume - solid, solid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    #[test]
    fn lattices_have_their_known_void_ratios() {
        let pi = std::f64::consts::PI;
        let simple = lattice::simple_cubic(3, 1e-4, 1e-9, 0.0);
        assert!((void_ratio(&Observation::new(&simple)) - (6.0 / pi - 1.0)).abs() < 1e-7);
        let dense = lattice::face_centred_cubic(3, 1e-4, 1e-9, 0.0);
        assert!((void_ratio(&Observation::new(&dense)) - (18f64.sqrt() / pi - 1.0)).abs() < 1e-7);
    }
}
