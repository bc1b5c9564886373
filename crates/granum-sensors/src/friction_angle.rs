//! Mobilised friction angle: `sin(phi) = (sigma_1 - sigma_3) / (sigma_1 + sigma_3)` of the largest and smallest principal
//! stress (Mohr and Coulomb without cohesion).
//!
//! It is 90 degrees where the smallest principal stress is tensile, and 0 where the sum of the two is not positive.

use granum_core::Part;
use granum_core::assembly::Matrix;
use granum_dem::invariants::mobilised_friction;

use crate::numerics::asin_degrees;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct FrictionAngle;

impl Sensor for FrictionAngle {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("friction_angle", "mobilised friction angle of the principal stresses")
            .speaking_of(Subject::Sample)
            .columns([SensorColumn::new(
                "mobilised_friction_angle",
                "deg",
                "phi of sin(phi) = (sigma_1 - sigma_3) / (sigma_1 + sigma_3)",
            )])
            .needing(&[Part::Cell, Part::Contacts, Part::NormalForces, Part::TangentialForces])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        values.push(friction_angle(&observation.stress.tensor()));
    }
}

/// Mobilised friction angle of a stress, compression positive, in degrees.
pub fn friction_angle(stress: &Matrix) -> f64 {
    asin_degrees(mobilised_friction(stress))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values computed independently; the last has a principal stress in tension.
    #[test]
    fn friction_angles_of_known_stresses() {
        let general = [[200.0, 30.0, 0.0], [30.0, 150.0, -20.0], [0.0, -20.0, 100.0]];
        assert!((friction_angle(&general) - 23.59558289).abs() < 1e-7);
        let diagonal = |a: f64, b: f64, c: f64| [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]];
        assert!((friction_angle(&diagonal(300.0, 150.0, 100.0)) - 30.0).abs() < 1e-12);
        assert_eq!(friction_angle(&diagonal(50.0, 50.0, 50.0)), 0.0);
        assert_eq!(friction_angle(&diagonal(50.0, 20.0, -10.0)), 90.0);
    }
}
