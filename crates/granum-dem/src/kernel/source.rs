//! Source of the constants of a batch of pairs.

use super::views::Views;

/// Source of the constants of a batch.
pub(crate) trait ConstantSource: Copy {
    /// True if pieces of clumps may be among the grains. Equal grains are spheres.
    const MAY_HAVE_CLUMPS: bool;
    /// True if each batch has its own constants.
    fn by_batch(v: &Views) -> bool;
}

/// All pairs have the same constants.
#[derive(Clone, Copy)]
pub(crate) struct Alike;
/// Every batch has its own constants.
#[derive(Clone, Copy)]
pub(crate) struct ByBatch;
/// Either of the two, decided again for every batch.
#[derive(Clone, Copy)]
pub(crate) struct AlikeOrByBatch;
impl ConstantSource for Alike {
    const MAY_HAVE_CLUMPS: bool = false;
    #[inline(always)]
    fn by_batch(_v: &Views) -> bool {
        false
    }
}
impl ConstantSource for ByBatch {
    const MAY_HAVE_CLUMPS: bool = true;
    #[inline(always)]
    fn by_batch(_v: &Views) -> bool {
        true
    }
}
impl ConstantSource for AlikeOrByBatch {
    const MAY_HAVE_CLUMPS: bool = true;
    #[inline(always)]
    fn by_batch(v: &Views) -> bool {
        !v.equal
    }
}
