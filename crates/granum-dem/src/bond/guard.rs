//! Below which energy a bond cannot rupture: a bond that has stored less is not judged, so that most bonds in most steps need neither their
//! limits nor the criterion. What is judged, and so every result, is as if all bonds were.

use granum_simd::{LANES, Row8};

use super::bonds::Bonds;
use super::bonds::column::{LIMIT, STIFFNESS};
use super::law::bond_law::{BondStiffness, LIMITS};

/// In place of an energy, where there is no bond any more.
pub(super) const RUPTURED: f64 = -1.0;
/// Share of the energy that is left for what is rounded.
const CERTAIN: f64 = 1.0 - 1e-6;

/// For each bond of a batch the energy, J, below which it cannot rupture, that of compression not counted.
pub(super) fn guards_of(bonds: &Bonds, batch: usize) -> Row8 {
    let (columns, law) = (bonds.columns_of(batch), bonds.laws[bonds.law[batch] as usize].law());
    let of = |lane: usize| {
        if !bonds.is_alive(batch, lane) {
            return RUPTURED;
        }
        let [normal, shear, bending, twisting] = std::array::from_fn(|k| columns[STIFFNESS + k].0[lane]);
        let limits: [f64; LIMITS] = std::array::from_fn(|k| columns[LIMIT + k].0[lane]);
        let stiffness = BondStiffness { normal, shear, bending, twisting };
        let energy = CERTAIN * law.least_energy_at_rupture(&stiffness, &limits);
        // Numbers of a forged checkpoint.
        if energy >= 0.0 && limits.iter().all(|limit| *limit >= 0.0) { energy } else { 0.0 }
    };
    let mut guards = Row8([RUPTURED; LANES]);
    for (lane, guard) in guards.0.iter_mut().enumerate() {
        *guard = of(lane);
    }
    guards
}
