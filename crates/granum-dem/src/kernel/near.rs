//! Loads the grains of a batch and decides whether any of its pairs interacts.

use granum_simd::{Lanes, Mask};

use super::fetch::{AHEAD, fetch_ahead};
use super::laws::StageLaws;
use super::order::Order;
use super::source::ConstantSource;
use super::views::Views;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::interaction::PairMotion;
use crate::pairs::NORMAL_COLUMNS;
use granum_simd::vectors::{dot, scale};

/// Values that are the same for all batches of a stage.
pub(super) struct Common<L: Lanes> {
    pub(super) gradient: [[L; 3]; 3],
    pub(super) dt: L,
    pub(super) alike: PairConstants<L>,
}

impl<L: Lanes> Common<L> {
    /// Velocity of j relative to i caused by the deformation of the cell.
    #[inline(always)]
    pub(super) fn affine(&self, branch: [L; 3]) -> [L; 3] {
        let [x, y, z] = self.gradient;
        [dot(x, branch), dot(y, branch), dot(z, branch)]
    }
}

/// A batch in which at least one pair interacts or did so in the step before, with the relative motion of its grains.
#[derive(Clone, Copy)]
pub(super) struct PairBatch<L> {
    pub(super) batch: usize,
    pub(super) kinematics: PairMotion<L>,
    /// Smaller mass of the two grains, kg; zero where all are equal.
    pub(super) mass: L,
}

/// Number of rows of constants that are stored for each batch.
#[inline(always)]
pub(super) fn constants_kept<S: StageLaws>(laws: &S) -> usize {
    PairConstants::kept(laws.has_moments(), laws.has_adhesion())
}

#[inline(always)]
pub(super) fn constants_of<L: Lanes, S: StageLaws, C: ConstantSource>(
    v: &Views,
    laws: &S,
    b: usize,
    common: &Common<L>,
) -> PairConstants<L> {
    if C::by_batch(v) {
        let kept = constants_kept(laws);
        // SAFETY: constants are only read.
        let rows = unsafe { &v.constants.read()[b * kept..(b + 1) * kept] };
        PairConstants::from_columns(kept, |c| L::load(&rows[c].0))
    } else {
        common.alike
    }
}

impl<L: Lanes> PairBatch<L> {
    /// A place for a batch that is yet to be loaded.
    #[inline(always)]
    pub(super) fn none() -> Self {
        let three = [L::zero(); 3];
        let kinematics = PairMotion {
            branch: three,
            velocity: three,
            rolling: three,
            mean_spin: three,
            relative_spin: three,
        };
        PairBatch { batch: 0, kinematics, mass: L::zero() }
    }
}

/// Loads the grains of a batch. Returns false, and leaves `slot` as it is, if the batch is to be tested and no pair touches
/// now or did in the step before.
#[inline(always)]
pub(super) fn near_batch<L: Lanes, S: StageLaws, C: ConstantSource, const IMAGE: bool, const TESTED: bool>(
    v: &Views,
    laws: &S,
    order: &Order,
    turn: usize,
    common: &Common<L>,
    slot: &mut PairBatch<L>,
) -> bool {
    let b = order.batch(turn);
    // SAFETY: grains and lists are only read in this stage; marks of a batch belong to the thread that works on its block.
    let (particles, spin, i, j, marks) = unsafe {
        (
            &v.particles.read()[..v.grains + 2],
            &v.spin.read()[..v.grains + 2],
            &v.first.read()[b],
            &v.second.read()[b],
            v.marks.write(b..b + 1)[0],
        )
    };
    if v.far {
        let [later, lists] = [turn + AHEAD, turn + 2 * AHEAD].map(
            #[inline(always)]
            |turn| order.batch(turn),
        );
        fetch_ahead::<C>(v, later, lists, columns_of(laws), constants_kept(laws));
    }
    let apart = L::differences8(particles, i, j);
    let mut branch = [apart[0], apart[1], apart[2]];
    if IMAGE {
        // SAFETY: only read in this stage.
        let image = L::gather4(&v.images, unsafe { &v.image.read()[b] });
        branch = [branch[0] + image[0], branch[1] + image[1], branch[2] + image[2]];
    }
    let constants = constants_of::<L, S, C>(v, laws, b, common);
    if TESTED && marks.touched == 0 && (!S::MAY_HAVE_ADHESION || marks.attracting == 0) {
        // In sets without an adhesion law separated grains do not interact, and no range need be added.
        let reach = if S::MAY_HAVE_ADHESION {
            constants.radius_sum + L::splat(v.onset)
        } else {
            constants.radius_sum
        };
        let near = dot(branch, branch).lt(reach * reach);
        if !near.any() {
            return false;
        }
    }
    let affine = common.affine(branch);
    let half = L::splat(0.5);
    let velocity = [apart[4] + affine[0], apart[5] + affine[1], apart[6] + affine[2]];
    let (rolling, mean_spin, mass);
    if C::by_batch(v) {
        let (a, c) = (L::gather8(particles, i), L::gather8(particles, j));
        let (wa, wc) = (L::gather4(spin, i), L::gather4(spin, j));
        let lever = constants.inverse_radius_sum;
        rolling = std::array::from_fn(
            #[inline(always)]
            |k| a[3].mul_add(wa[k], c[3] * wc[k]) * lever,
        );
        mean_spin = scale(half, [wa[0] + wc[0], wa[1] + wc[1], wa[2] + wc[2]]);
        mass = a[7].min(c[7]);
        if S::MAY_HAVE_MOMENTS {
            slot.kinematics.relative_spin = [wa[0] - wc[0], wa[1] - wc[1], wa[2] - wc[2]];
        }
    } else {
        if S::MAY_HAVE_MOMENTS && laws.has_moments() {
            let (wa, wc) = (L::gather4(spin, i), L::gather4(spin, j));
            mean_spin = scale(half, [wa[0] + wc[0], wa[1] + wc[1], wa[2] + wc[2]]);
            slot.kinematics.relative_spin = [wa[0] - wc[0], wa[1] - wc[1], wa[2] - wc[2]];
        } else {
            let both = L::sums4(spin, i, j);
            mean_spin = scale(half, [both[0], both[1], both[2]]);
        }
        (rolling, mass) = (mean_spin, L::zero());
    }
    // The relative spin is copied unchanged: sets without moments never write it.
    let relative_spin = slot.kinematics.relative_spin;
    slot.kinematics = PairMotion { branch, velocity, rolling, mean_spin, relative_spin };
    (slot.batch, slot.mass) = (b, mass);
    true
}

/// Number of columns of the contact history of a batch.
#[inline(always)]
pub(super) fn columns_of<S: StageLaws>(laws: &S) -> usize {
    NORMAL_COLUMNS + laws.history().iter().sum::<usize>()
}

/// Loads the grains of two batches within the cell whose pairs are all known to touch.
#[inline(always)]
pub(super) fn touching_pair<L: Lanes, S: StageLaws, C: ConstantSource>(
    v: &Views,
    laws: &S,
    order: &Order,
    turn: usize,
    common: &Common<L>,
    slots: &mut [PairBatch<L>; 2],
) {
    for (k, slot) in slots.iter_mut().enumerate() {
        near_batch::<L, S, C, false, false>(v, laws, order, turn + k, common, slot);
    }
}
