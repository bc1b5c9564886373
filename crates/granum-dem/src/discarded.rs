//! Energy lost with those parts of the contact history that tangential laws discard.
//!
//! The energy stored in a discarded turning point of the load is given by a long formula, which about one contact in a
//! hundred needs in a step. The contact stage therefore only collects such contacts, as they were before the step, and the
//! formula is evaluated for eight of them side by side, outside the loop over contacts, which has no registers to spare.

use granum_simd::{LANES, Lanes, Row8};

use crate::contact::law::limits::{LAW_CONSTANTS, MAX_HISTORY};
use crate::kernel::laws::StageLaws;

/// Numbers that are collected for a contact: the constants of the law, the stiffness and the history.
const COLUMNS: usize = LAW_CONSTANTS + 1 + MAX_HISTORY;
/// The energy is evaluated in one of this many steps and counts for all of them, because the evaluation makes the contact
/// stage a tenth slower. It is a prime number, so that the sampling does not follow the period of an oscillation.
const EVERY: u64 = 13;

/// The number of steps for which the energy discarded in a step counts; zero in steps that are not sampled.
pub(crate) fn sampling_weight(step: u64) -> f64 {
    if step.is_multiple_of(EVERY) { EVERY as f64 } else { 0.0 }
}

/// Number of groups of eight: two whole batches may be added to an incomplete group of seven.
const GROUPS: usize = 3;

/// Contacts waiting for evaluation, in groups of eight in the order of their arrival, so that the sum does not depend on
/// when a group is taken.
pub(crate) struct Discarded {
    /// Index of the oldest group.
    first: usize,
    count: usize,
    rows: [[Row8; COLUMNS]; GROUPS],
}

impl Discarded {
    pub(crate) fn new() -> Self {
        Discarded { first: 0, count: 0, rows: [[Row8::default(); COLUMNS]; GROUPS] }
    }

    /// Collects the contacts of a batch whose bit is set; `history` holds the columns of the law before the step.
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
            let (group, lane) = ((self.first + self.count / LANES) % GROUPS, self.count % LANES);
            for (target, row) in self.rows[group].iter_mut().zip(known.iter().chain(history)) {
                target.0[lane] = row.0[from];
            }
            self.count += 1;
        }
    }

    /// True if a group is complete: the formula must then be evaluated before two more batches are added.
    #[inline(always)]
    pub(crate) fn is_full(&self) -> bool {
        self.count >= LANES
    }

    /// Removes the oldest group and returns its lost energy, J, one value for each lane.
    #[inline(always)]
    pub(crate) fn take<L: Lanes, S: StageLaws>(&mut self, laws: &S) -> L {
        let rows = &self.rows[self.first];
        let count = self.count.min(LANES);
        let place = L::load(&std::array::from_fn(|l| l as f64));
        let mut history = [L::zero(); MAX_HISTORY];
        for (c, column) in history.iter_mut().enumerate().take(laws.history()[0]) {
            *column = L::load(&rows[LAW_CONSTANTS + 1 + c].0);
        }
        let constants = std::array::from_fn(|c| L::load(&rows[c].0));
        let lost = laws.discarded(&constants, L::load(&rows[LAW_CONSTANTS].0), &history);
        self.count -= count;
        self.first = (self.first + 1) % GROUPS;
        lost.keep(place.lt(L::splat(count as f64)))
    }
}

#[cfg(test)]
mod tests {
    use granum_simd::{Portable, Real};

    use super::*;
    use crate::config::Material;
    use crate::contact::PairProperties;
    use crate::contact::evaluation::set::Compiled;
    use crate::contact::law::constants::{columns, named};
    use crate::contact::normal::Hertz;
    use crate::contact::tangential::MindlinDeresiewicz as Law;
    use crate::contact::{NormalTraits, TangentialLaw};
    use crate::kernel::laws::InLoop;

    /// Histories on all three kinds of curve, at one load.
    fn history(k: usize) -> [f64; MAX_HISTORY] {
        let x = (k as f64 * 0.7).sin();
        let mut history = [0.0; MAX_HISTORY];
        let force = [3e-5 * x, -1e-5 * x * x, -2e-5 * x, 4e-5, 1e-5 * x, -3e-5 * x];
        history[..6].copy_from_slice(&force);
        history[6] = (k % 3) as f64;
        history[7] = 3e-4;
        history
    }

    const BATCHES: usize = 50;
    const STIFFNESS: f64 = 2e4;

    fn constants() -> [f64; LAW_CONSTANTS] {
        let material = Material::default();
        let normal = NormalTraits { name: "hertz", contact_area: true, adhesive: false };
        let pair = PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.1);
        columns(Law::prepare(&pair, &normal, &[]))
    }

    fn bits(batch: usize) -> u16 {
        ((batch * 2_654_435_761) >> 7) as u16 & if batch % 5 < 2 { 0xff } else { 0x21 }
    }

    /// Sum of all losses, by lane, evaluated after every `together` batches.
    fn summed(together: usize) -> [f64; LANES] {
        let (mut discarded, mut sum) = (Discarded::new(), Portable::zero());
        let laws: InLoop<false, Hertz, Law> = InLoop(Compiled::new());
        for batch in 0..BATCHES {
            let rows: Vec<Row8> =
                (0..Law::HISTORY).map(|c| Row8(std::array::from_fn(|l| history(8 * batch + l)[c]))).collect();
            let constants = constants().map(Portable::splat);
            discarded.put::<Portable>(bits(batch), &constants, Portable::splat(STIFFNESS), &rows);
            while batch % together == together - 1 && discarded.is_full() {
                sum = sum + discarded.take::<Portable, _>(&laws);
            }
        }
        sum = sum + discarded.take::<Portable, _>(&laws);
        assert_eq!(discarded.take::<Portable, _>(&laws).reduce_add(), 0.0);
        let mut lanes = [0.0; LANES];
        sum.store(&mut lanes);
        lanes
    }

    #[test]
    fn eight_by_eight_is_what_each_would_have_lost() {
        let each = |k: usize| Law::discarded(&named(&constants()), STIFFNESS, &history(k));
        // A loading curve stores no energy beyond itself.
        assert!(each(3).abs() < 1e-12 * each(4).abs());
        let put = (0..BATCHES * LANES).filter(|k| bits(k / LANES) >> (k % LANES) & 1 == 1);
        let exact: f64 = put.map(each).sum();
        let sum: f64 = summed(1).iter().sum();
        assert!(exact != 0.0 && (sum / exact - 1.0).abs() < 1e-12, "{sum:e} {exact:e}");
    }

    /// Instruction sets differ in the number of batches that they evaluate at once.
    #[test]
    fn the_sum_does_not_depend_on_when_it_is_taken() {
        assert_eq!(summed(1), summed(2));
    }

    #[test]
    fn steps_looked_at_count_for_all() {
        let counted: f64 = (0..130 * EVERY).map(sampling_weight).sum();
        assert_eq!(counted, (130 * EVERY) as f64);
    }
}
