//! Whether a run can be trusted: its own limits, and what to change where one is broken.

use super::data::RunReport;
use super::energy;
use super::numbers::{percent, significant};

/// One thing that a run must keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Flag {
    /// What is looked at.
    pub name: &'static str,
    /// What was found, marked up.
    pub found: String,
    /// What is asked, marked up.
    pub limit: String,
    /// Whether it is kept.
    pub held: bool,
    /// What to change if it is not.
    pub advice: &'static str,
}

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
pub fn servo_errors(run: &RunReport) -> Option<[f64; 2]> {
    let settled = |column: &str| -> Vec<f64> {
        (run.column("deviator_strain").iter().zip(run.column(column)))
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
pub fn flags(run: &RunReport) -> Vec<Flag> {
    let mut flags = Vec::new();
    let mut judge = |name, found: Option<f64>, limit: f64, share: bool, advice| {
        let Some(found) = found else { return };
        let text = |value: f64| if share { percent(value) } else { significant(value, 2) };
        let held = found <= limit;
        flags.push(Flag {
            name,
            found: text(found),
            limit: format!("at most {}", text(limit)),
            held,
            advice,
        });
    };
    let servo = servo_errors(run);
    let servo_advice = "Shear more slowly or use more grains: the servo cannot follow the sample.";
    judge("Error of the mean stress, rms", servo.map(|e| e[0]), SERVO_RMS, true, servo_advice);
    judge("Error of the mean stress, worst", servo.map(|e| e[1]), SERVO_WORST, true, servo_advice);
    let inertial = "Shear more slowly: lower the inertial number of the case.";
    judge("Inertial number", largest(run.column("inertial_number")), INERTIAL_NUMBER, false, inertial);
    // The mean over the test: single rearrangements push grains for a moment.
    let unbalanced = run.column("unbalanced_force");
    let mean = unbalanced.iter().filter(|u| u.is_finite()).sum::<f64>() / unbalanced.len().max(1) as f64;
    judge(
        "Unbalanced force, mean over the test",
        (!unbalanced.is_empty()).then_some(mean),
        UNBALANCED_FORCE,
        false,
        "Shear more slowly or raise the damping of the contacts.",
    );
    judge(
        "Largest overlap over the sum of the radii",
        largest(run.column("largest_overlap")),
        OVERLAP,
        true,
        "Use stiffer grains or a lower stress: contacts of one grain are no longer independent.",
    );
    judge(
        "Energy ledger, error over boundary work",
        energy::closure(run),
        CLOSURE,
        true,
        "Shorten the time step: energy is made or lost by the integration.",
    );
    flags
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_sensors::{NamedColumn, Record, Series};

    fn run(columns: &[(&str, &[f64])]) -> RunReport {
        let columns = columns
            .iter()
            .map(|(name, values)| NamedColumn {
                name: (*name).to_owned(),
                unit: "1".to_owned(),
                values: values.to_vec(),
            })
            .collect();
        RunReport { record: Record { series: Series { columns }, forces: Vec::new() }, ..Default::default() }
    }

    #[test]
    fn the_start_of_loading_does_not_count_for_the_servo() {
        let run = run(&[
            ("deviator_strain", &[0.001, 0.01, 0.02]),
            ("servo_error_rms", &[0.5, 0.003, 0.004]),
            ("servo_error_largest", &[0.5, 0.01, 0.04]),
        ]);
        let [rms, worst] = servo_errors(&run).unwrap();
        assert!((rms - 12.5e-6f64.sqrt()).abs() < 1e-12);
        assert_eq!(worst, 0.04);
        let flags = flags(&run);
        assert_eq!(flags.iter().map(|flag| flag.held).collect::<Vec<_>>(), [true, false]);
    }

    #[test]
    fn what_is_not_recorded_is_not_judged_and_nan_does_not_hold_by_chance() {
        assert!(flags(&RunReport::default()).is_empty());
        let run = run(&[("inertial_number", &[1e-4, f64::NAN, 2e-3])]);
        assert!(!flags(&run)[0].held);
    }
}
