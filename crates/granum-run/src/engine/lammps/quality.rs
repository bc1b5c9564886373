//! What can be judged of a test that LAMMPS carried out, and what cannot.

use granum_dem::config::MOST_CONTACTS;
use granum_io::run::{QualityFlag, RunRecord};
use granum_sensors::Record;

use super::reading::Reading;
use crate::engine::flags;
use crate::engine::native::{note, quality};

/// Largest root mean square difference of the mean stress of the recorded contacts from that of LAMMPS, relative to it.
const STRESSES_DIFFER: f64 = 0.02;

/// Adds the quality flags of a finished test, and a note on what is not judged.
pub(super) fn add(reading: &Reading, seen: &Record, record: &mut RunRecord) {
    let progress = &reading.progress;
    let speed_key = reading.case.test_definition().speed_key;
    let errors: Vec<_> = progress.ends.iter().map(|end| end.servo_error).collect();
    let lost = quality::stages_without_stress(seen, &progress.ends);
    let judged: Vec<_> = errors.iter().enumerate().filter(|(k, _)| lost.get(*k) != Some(&true)).collect();
    let (servo_error, servo_limit) = quality::worst_servo_error(&reading.stages, judged.iter().copied());
    let unmet = quality::unmet_stages(&reading.stages, &progress.ends);
    let mean = quality::mean_of_carrying(seen);
    let largest = |name: &str| seen.series.values(name).unwrap_or(&[]).iter().copied().fold(0.0, f64::max);
    let limit = reading.grains.properties().contact.stable_fraction(MOST_CONTACTS);
    let mut flags = vec![flags::stages_cut_short(unmet)];
    let inertial_number = quality::mean_inertial_number(seen, &reading.stages);
    flags.extend(flags::quasi_static(inertial_number, mean("unbalanced_force"), speed_key));
    flags.extend([
        flags::overlap("largest_overlap", largest("largest_overlap")),
        flags::time_step("time_step_fraction", progress.time_step_fraction, limit),
        QualityFlag::at_most(
            "stress_differs_from_lammps",
            (progress.differences / progress.compared.max(1) as f64).sqrt(),
            STRESSES_DIFFER,
            "the mean stress of the recorded contacts is not that of LAMMPS, whose dashpots it leaves out; lower the speed",
        ),
    ]);
    let controlled = reading.stages.iter().any(|stage| controls_stress(&stage.control));
    if controlled && !judged.is_empty() {
        flags.push(flags::servo_error(servo_error, servo_limit, speed_key));
    }
    record.quality.extend(flags);
    note(
        record,
        "not judged: energy_gap and servo_error_largest, since LAMMPS tells neither the energy that is lost nor the error of the servo in \
         each step; momentum_drift, since LAMMPS integrates velocities in the laboratory and not relative to the cell; mean_stress_lost"
            .into(),
    );
}

/// True if some stress is held or moved.
fn controls_stress(control: &granum_dem::loading::Control) -> bool {
    let drives =
        control.components.iter().any(|drive| matches!(drive, granum_dem::loading::Drive::Stress(_)));
    drives || control.constraints.iter().flatten().any(|constraint| constraint.stress != [0.0; 6])
}
