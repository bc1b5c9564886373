//! Energy of the histories that tangential laws forget.
//!
//! What a forgotten turning point stored is a long formula, needed for one contact in a hundred a step. The contact stage only
//! puts such contacts down, as they were before the step, and the formula runs on eight of them side by side, away from
//! the loop that has no registers to spare.

use granum_simd::{LANES, Lanes, Row8};

use crate::contact::{LAW_CONSTANTS, MAX_HISTORY, TangentialLaw};

/// Numbers put down of a contact: the law's constants, the stiffness, the history.
const COLUMNS: usize = LAW_CONSTANTS + 1 + MAX_HISTORY;
/// Of so many steps one is looked at and counts for all: looking makes the contact stage a tenth slower. A prime, lest it
/// keep time with anything that swings.
const EVERY: u64 = 13;

/// How often what is forgotten in a step counts.
pub(crate) fn account(step: u64) -> f64 {
    if step.is_multiple_of(EVERY) { EVERY as f64 } else { 0.0 }
}

/// Contacts put down.
pub(crate) struct Forgotten {
    count: usize,
    /// Three groups of eight: two whole batches may come to the seven of an incomplete one.
    rows: [[Row8; COLUMNS]; 3],
}

impl Forgotten {
    pub(crate) fn new() -> Self {
        Forgotten { count: 0, rows: [[Row8::default(); COLUMNS]; 3] }
    }

    /// Puts down the contacts of a batch whose bit is set; `history` holds the law's columns as they were.
    #[inline(always)]
    pub(crate) fn put<L: Lanes>(
        &mut self,
        mut bits: u16,
        constants: &[L; LAW_CONSTANTS],
        stiffness: L,
        history: &[Row8],
    ) {
        if bits == 0 {
            return;
        }
        let mut known = [Row8::default(); LAW_CONSTANTS + 1];
        for (row, lanes) in known.iter_mut().zip(constants) {
            lanes.store(&mut row.0);
        }
        stiffness.store(&mut known[LAW_CONSTANTS].0);
        while bits != 0 {
            let from = bits.trailing_zeros() as usize % LANES;
            bits &= bits - 1;
            let (group, lane) = (self.count / LANES, self.count % LANES);
            for (target, row) in self.rows[group].iter_mut().zip(known.iter().chain(history)) {
                target.0[lane] = row.0[from];
            }
            self.count += 1;
        }
    }

    /// True with a complete group: the formula must run before two more batches.
    #[inline(always)]
    pub(crate) fn is_full(&self) -> bool {
        self.count >= LANES
    }

    /// Energy lost with what was put down, J, by lanes; nothing is left.
    #[inline(always)]
    pub(crate) fn take<L: Lanes, T: TangentialLaw>(&mut self) -> L {
        let place = L::load(&std::array::from_fn(|l| l as f64));
        let mut sum = L::zero();
        for (k, rows) in self.rows[..self.count.div_ceil(LANES)].iter().enumerate() {
            let mut history = [L::zero(); MAX_HISTORY];
            for (c, column) in history.iter_mut().enumerate().take(T::HISTORY) {
                *column = L::load(&rows[LAW_CONSTANTS + 1 + c].0);
            }
            let constants = std::array::from_fn(|c| L::load(&rows[c].0));
            let lost = T::forgotten(&constants, L::load(&rows[LAW_CONSTANTS].0), &history);
            sum = sum + lost.keep(place.lt(L::splat((self.count - k * LANES) as f64)));
        }
        self.count = 0;
        sum
    }
}

#[cfg(test)]
mod tests {
    use granum_simd::{Portable, Real};

    use super::*;
    use crate::config::Material;
    use crate::contact::PairProperties;
    use crate::contact::mindlin_deresiewicz::MindlinDeresiewicz as Law;

    /// Histories on all three kinds of curve, of one load.
    fn history(k: usize) -> [f64; MAX_HISTORY] {
        let x = (k as f64 * 0.7).sin();
        let mut history = [0.0; MAX_HISTORY];
        let force = [3e-5 * x, -1e-5 * x * x, -2e-5 * x, 4e-5, 1e-5 * x, -3e-5 * x];
        history[..6].copy_from_slice(&force);
        history[6] = (k % 3) as f64;
        history[7] = 3e-4;
        history
    }

    #[test]
    fn eight_by_eight_is_what_each_would_have_lost() {
        let material = Material::default();
        let pair = PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.1);
        let constants = Law::prepare(&pair);
        let stiffness = 2e4;
        let each = |k: usize| Law::forgotten(&constants, stiffness, &history(k));
        // A loading curve stores nothing beyond itself.
        assert!(each(3).abs() < 1e-12 * each(4).abs());
        let (mut forgotten, mut sum, mut exact) = (Forgotten::new(), 0.0, 0.0);
        for batch in 0..50usize {
            let bits = ((batch * 2_654_435_761) >> 7) as u16 & if batch % 5 == 0 { 0xff } else { 0x21 };
            let rows: Vec<Row8> =
                (0..Law::HISTORY).map(|c| Row8(std::array::from_fn(|l| history(8 * batch + l)[c]))).collect();
            forgotten.put::<Portable>(
                bits,
                &constants.map(Portable::splat),
                Portable::splat(stiffness),
                &rows,
            );
            exact += (0..8).filter(|l| bits >> l & 1 == 1).map(|l| each(8 * batch + l)).sum::<f64>();
            if forgotten.is_full() || batch == 49 {
                sum += forgotten.take::<Portable, Law>().reduce_add();
            }
        }
        assert!(exact != 0.0 && (sum / exact - 1.0).abs() < 1e-12, "{sum:e} {exact:e}");
        assert_eq!(forgotten.take::<Portable, Law>().reduce_add(), 0.0);
    }

    #[test]
    fn steps_looked_at_count_for_all() {
        let counted: f64 = (0..130 * EVERY).map(account).sum();
        assert_eq!(counted, (130 * EVERY) as f64);
    }
}
