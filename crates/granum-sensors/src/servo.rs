//! Accuracy of the mean stress held by the servo.
//!
//! Relative error `p/p_target - 1`; 0 where the servo has no target for the mean stress.

use crate::{Averaging, Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};
use granum_core::Part;

/// The sensor.
pub struct Servo;

impl Sensor for Servo {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("servo", "relative error of the mean stress against the target of the servo")
            .speaking_of(Subject::Sample)
            .columns([
                SensorColumn::new(
                    "servo_error_rms",
                    "1",
                    "root mean square of p/p_target - 1 over the observations",
                )
                .averaged(Averaging::RootMeanSquare),
                SensorColumn::new(
                    "servo_error_largest",
                    "1",
                    "largest |p/p_target - 1| over the observations",
                )
                .averaged(Averaging::Largest),
            ])
            .needing(&[
                Part::Cell,
                Part::Contacts,
                Part::NormalForces,
                Part::TangentialForces,
                Part::TargetMeanStress,
            ])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let error = servo_error(observation);
        values.extend([error, error.abs()]);
    }
}

/// `p/p_target - 1`; 0 without a target or with a target of zero.
pub fn servo_error(observation: &Observation) -> f64 {
    match observation.assembly.target_mean_stress {
        Some(target) if target != 0.0 => observation.stress.mean() / target - 1.0,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;

    #[test]
    fn the_error_is_relative_to_the_target() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 2e-4);
        let p = Observation::new(&assembly).stress.mean();
        assert_eq!(servo_error(&Observation::new(&assembly)), 0.0);
        assembly.target_mean_stress = Some(p / 1.02);
        let row = measured(&Servo, &assembly);
        assert!((row[0] - 0.02).abs() < 1e-12 && (row[1] - 0.02).abs() < 1e-12);
        assembly.target_mean_stress = Some(p / 0.97);
        let row = measured(&Servo, &assembly);
        assert!((row[0] + 0.03).abs() < 1e-12 && (row[1] - 0.03).abs() < 1e-12);
    }
}
