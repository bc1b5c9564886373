//! How well the servo holds the mean stress.
//!
//! Relative error `p/p_target - 1`; 0 where the servo aims at no mean stress.

use crate::{Averaging, Look, Sensor, SensorColumn};

/// The sensor.
pub const SENSOR: Sensor = Sensor {
    name: "servo",
    description: "relative error of the mean stress against the target of the servo",
    columns: &[
        SensorColumn::new("servo_error_rms", "1", "root mean square of p/p_target - 1 over the observations")
            .averaged(Averaging::RootMeanSquare),
        SensorColumn::new("servo_error_largest", "1", "largest |p/p_target - 1| over the observations")
            .averaged(Averaging::Largest),
    ],
    measure,
};

/// `p/p_target - 1`; 0 without a target or with a target of zero.
pub fn servo_error(look: &Look) -> f64 {
    match look.assembly.target_mean_stress {
        Some(target) if target != 0.0 => look.stress.mean() / target - 1.0,
        _ => 0.0,
    }
}

fn measure(look: &Look, row: &mut Vec<f64>) {
    let error = servo_error(look);
    row.extend([error, error.abs()]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    #[test]
    fn the_error_is_relative_to_the_target() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 2e-4);
        let p = Look::new(&assembly).stress.mean();
        assert_eq!(servo_error(&Look::new(&assembly)), 0.0);
        assembly.target_mean_stress = Some(p / 1.02);
        let mut row = Vec::new();
        measure(&Look::new(&assembly), &mut row);
        assert!((row[0] - 0.02).abs() < 1e-12 && (row[1] - 0.02).abs() < 1e-12);
        assembly.target_mean_stress = Some(p / 0.97);
        row.clear();
        measure(&Look::new(&assembly), &mut row);
        assert!((row[0] + 0.03).abs() < 1e-12 && (row[1] - 0.03).abs() < 1e-12);
    }
}
