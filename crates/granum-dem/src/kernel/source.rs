//! Where the constants of a batch of pairs come from.

use super::Views;

/// Where the constants of a batch come from.
pub(crate) trait ConstantSource: Copy {
    /// True if each batch has its own.
    fn by_batch(v: &Views) -> bool;
}

/// All pairs are alike.
#[derive(Clone, Copy)]
pub(crate) struct Alike;
/// Pairs differ.
#[derive(Clone, Copy)]
pub(crate) struct ByBatch;
/// Whichever of the two, asked anew for every batch.
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
