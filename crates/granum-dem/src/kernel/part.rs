//! The parts of values of two batches that are evaluated side by side.

use granum_simd::{Lanes, Real, Twice};

/// Selects one of the batches that are evaluated together.
pub(super) trait Part<L: Lanes, R: Real> {
    fn part(all: R) -> L;
    fn mask(all: R::Mask) -> L::Mask;
}
pub(super) struct Whole;
pub(super) struct First;
pub(super) struct Second;
impl<L: Lanes> Part<L, L> for Whole {
    #[inline(always)]
    fn part(all: L) -> L {
        all
    }
    #[inline(always)]
    fn mask(all: L::Mask) -> L::Mask {
        all
    }
}
impl<L: Lanes> Part<L, Twice<L>> for First {
    #[inline(always)]
    fn part(all: Twice<L>) -> L {
        all.0
    }
    #[inline(always)]
    fn mask(all: Twice<L::Mask>) -> L::Mask {
        all.0
    }
}
impl<L: Lanes> Part<L, Twice<L>> for Second {
    #[inline(always)]
    fn part(all: Twice<L>) -> L {
        all.1
    }
    #[inline(always)]
    fn mask(all: Twice<L::Mask>) -> L::Mask {
        all.1
    }
}
