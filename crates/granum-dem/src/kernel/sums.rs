//! The sums over the contacts of a block, by name: where each stands among the numbers that are added in lanes.

use std::ops::Range;

use granum_core::energy::MechanismEnergies;

use crate::contact::law::energy_channel::SetEnergies;
use crate::contact_sums::ContactSums;

/// Number of sums.
pub(super) const SUMS: usize = 21;
/// The nine components of the virial, row by row.
const VIRIAL: Range<usize> = 0..9;
pub(super) const TANGENTIAL_WORK: usize = 9;
pub(super) const FRICTION: usize = 10;
pub(super) const DAMPING: usize = 11;
pub(super) const BOUNDARY_POWER: usize = 12;
pub(super) const STIFFNESS: usize = 13;
pub(super) const NORMAL_FORCE: usize = 14;
pub(super) const MICRO_SLIP: usize = 15;
pub(super) const ADHESION_MADE: usize = 16;
pub(super) const ADHESION_BROKEN: usize = 17;
pub(super) const ROLLING_WORK: usize = 18;
pub(super) const ROLLING: usize = 19;
pub(super) const ATTRACTION_LOSS: usize = 20;

/// The place of a component of the virial.
#[inline(always)]
pub(super) const fn virial(row: usize, column: usize) -> usize {
    VIRIAL.start + 3 * row + column
}

/// The sums of a block, once the lanes are added.
#[inline(always)]
pub(super) fn contact_sums(s: &[f64], channels: SetEnergies<f64>, fastest: f64) -> ContactSums {
    ContactSums {
        virial: std::array::from_fn(|a| s[VIRIAL.start + a]),
        mechanisms: MechanismEnergies {
            tangential_work: s[TANGENTIAL_WORK],
            friction: s[FRICTION],
            damping: s[DAMPING],
            micro_slip: s[MICRO_SLIP],
            adhesion_made: s[ADHESION_MADE],
            adhesion_broken: s[ADHESION_BROKEN],
            rolling_work: s[ROLLING_WORK],
            rolling: s[ROLLING],
            attraction_loss: s[ATTRACTION_LOSS],
        },
        boundary_power: s[BOUNDARY_POWER],
        stiffness: s[STIFFNESS],
        normal_force: s[NORMAL_FORCE],
        channels,
        fastest,
    }
}
