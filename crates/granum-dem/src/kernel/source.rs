//! Source of the constants of a batch of pairs.

use super::views::Views;

/// Source of the constants of a batch.
pub(crate) trait ConstantSource: Copy {
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
    #[inline(always)]
    fn by_batch(_v: &Views) -> bool {
        false
    }
}
impl ConstantSource for ByBatch {
    #[inline(always)]
    fn by_batch(_v: &Views) -> bool {
        true
    }
}
impl ConstantSource for AlikeOrByBatch {
    #[inline(always)]
    fn by_batch(v: &Views) -> bool {
        !v.equal
    }
}
