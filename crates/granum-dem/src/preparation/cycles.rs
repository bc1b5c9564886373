//! Strain cycles after compaction, which make a sample denser than compression alone.
//!
//! The axial strain is brought to the amplitude, to its negative, and so on, at constant mean stress and with the friction of the
//! compaction. A reversal takes place at the first check of the preparation after the amplitude is reached; checks are made every few
//! hundred steps.

use super::{Preparation, Simulation};
use crate::servo::CellControl;

/// Largest strain rate that the servo adds, as a multiple of the axial strain rate.
const SERVO_LIMIT: f64 = 30.0;

/// Begins to strain a sample at the mean stress, Pa, of its compaction.
pub(super) fn begin(s: &mut Simulation, p: &Preparation, mean_stress: f64) {
    let rate = s.strain_rate(p.inertial_number, mean_stress);
    s.set_control(CellControl::constant_mean_stress(0, rate, mean_stress, SERVO_LIMIT * rate));
    s.reset_phase(0.0);
}

/// Reverses the strain rate when the amplitude is reached; `turns` is the number of reversals so far. True once all cycles are done.
pub(super) fn turned(s: &mut Simulation, p: &Preparation, cycles: u64, turns: &mut u64) -> bool {
    let strain = s.state().strain()[0][0];
    let sign = if turns.is_multiple_of(2) { 1.0 } else { -1.0 };
    if sign * strain < p.cycle_strain {
        return false;
    }
    *turns += 1;
    if *turns >= 2 * cycles {
        return true;
    }
    s.reverse();
    false
}
