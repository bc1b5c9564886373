//! Whether a run can be trusted: its own limits, and what to change where one is broken.

use granum_io::run::QualityFlag;
use granum_sensors::Record;

use super::data::column;
use super::energy;

/// Strain after which the servo must hold its target; before, the sample answers the start of loading.
pub const SETTLED_STRAIN: f64 = 0.005;
/// Largest root mean square error of the mean stress.
pub const SERVO_RMS: f64 = 0.01;
/// Largest single error of the mean stress.
pub const SERVO_WORST: f64 = 0.03;
/// Largest inertial number of quasi-static shear (GDR MiDi 2004).
pub const INERTIAL_NUMBER: f64 = 1e-3;
/// Largest mean unbalanced force over the mean contact force.
pub const UNBALANCED_FORCE: f64 = 0.02;
/// Largest overlap for which elastic spheres with separate contacts are a fair model.
pub const OVERLAP: f64 = 0.01;
/// Largest error of the energy ledger over the boundary work.
pub const CLOSURE: f64 = 1e-3;

/// Errors of the servo after [`SETTLED_STRAIN`]: root mean square and worst.
pub fn servo_errors(record: &Record) -> Option<[f64; 2]> {
    let settled = |name: &str| -> Vec<f64> {
        (column(record, "deviator_strain").iter().zip(column(record, name)))
            .filter(|(strain, error)| **strain > SETTLED_STRAIN && error.is_finite())
            .map(|(_, error)| *error)
            .collect()
    };
    let (rms, worst) = (settled("servo_error_rms"), settled("servo_error_largest"));
    if rms.is_empty() || worst.is_empty() {
        return None;
    }
    let square = rms.iter().map(|error| error * error).sum::<f64>() / rms.len() as f64;
    Some([square.sqrt(), worst.into_iter().fold(0.0, |worst, error| worst.max(error.abs()))])
}

fn largest(values: &[f64]) -> Option<f64> {
    values.iter().copied().filter(|value| value.is_finite()).map(f64::abs).reduce(f64::max)
}

/// Judges a run by what its record holds; what it does not hold is not judged.
pub fn flags(record: &Record) -> Vec<QualityFlag> {
    let servo = servo_errors(record);
    let unbalanced = column(record, "unbalanced_force");
    // The mean over the test: single rearrangements push grains for a moment.
    let mean = unbalanced.iter().filter(|u| u.is_finite()).sum::<f64>() / unbalanced.len().max(1) as f64;
    let servo_advice = "shear more slowly or use more grains: the servo cannot follow the sample";
    let checks: [(&str, Option<f64>, f64, &str); 6] = [
        ("servo_error_rms", servo.map(|errors| errors[0]), SERVO_RMS, servo_advice),
        ("servo_error_largest", servo.map(|errors| errors[1]), SERVO_WORST, servo_advice),
        (
            "inertial_number",
            largest(column(record, "inertial_number")),
            INERTIAL_NUMBER,
            "shear more slowly: lower the inertial number of the case",
        ),
        (
            "unbalanced_force_mean",
            (!unbalanced.is_empty()).then_some(mean),
            UNBALANCED_FORCE,
            "shear more slowly or raise the damping of the contacts",
        ),
        (
            "largest_overlap",
            largest(column(record, "largest_overlap")),
            OVERLAP,
            "use stiffer grains or a lower stress: contacts of one grain are no longer independent",
        ),
        (
            "energy_closure",
            energy::closure(record),
            CLOSURE,
            "shorten the time step: energy is made or lost by the integration",
        ),
    ];
    (checks.into_iter())
        .filter_map(|(name, found, limit, advice)| Some(QualityFlag::at_most(name, found?, limit, advice)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_sensors::{NamedColumn, Series};

    fn record(columns: &[(&str, &[f64])]) -> Record {
        let columns = columns
            .iter()
            .map(|(name, values)| NamedColumn {
                name: (*name).to_owned(),
                unit: "1".to_owned(),
                values: values.to_vec(),
            })
            .collect();
        Record { series: Series { columns }, forces: Vec::new() }
    }

    #[test]
    fn the_start_of_loading_does_not_count_for_the_servo() {
        let record = record(&[
            ("deviator_strain", &[0.001, 0.01, 0.02]),
            ("servo_error_rms", &[0.5, 0.003, 0.004]),
            ("servo_error_largest", &[0.5, 0.01, 0.04]),
        ]);
        let [rms, worst] = servo_errors(&record).unwrap();
        assert!((rms - 12.5e-6f64.sqrt()).abs() < 1e-12);
        assert_eq!(worst, 0.04);
        let flags = flags(&record);
        assert_eq!(flags.iter().map(|flag| flag.passed).collect::<Vec<_>>(), [true, false]);
    }

    #[test]
    fn what_is_not_recorded_is_not_judged_and_nan_does_not_hold_by_chance() {
        assert!(flags(&Record::default()).is_empty());
        let record = record(&[("inertial_number", &[1e-4, f64::NAN, 2e-3])]);
        assert!(!flags(&record)[0].passed);
    }
}
