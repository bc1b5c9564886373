//! Fused multiply-adds of two doubles side by side, and of one.

use std::arch::wasm32::*;

#[cfg(not(granum_relaxed))]
use super::emulated;

/// `a b + c` of two doubles, rounded once.
#[inline(always)]
pub(super) fn two_fused(a: v128, b: v128, c: v128) -> v128 {
    #[cfg(granum_relaxed)]
    return granum_relaxed::relaxed_mul_add(a, b, c);
    #[cfg(not(granum_relaxed))]
    emulated::mul_add(a, b, c)
}

/// `factor * other + term` of single numbers, rounded once.
#[inline(always)]
pub(crate) fn one_fused(factor: f64, other: f64, term: f64) -> f64 {
    f64x2_extract_lane::<0>(two_fused(f64x2_splat(factor), f64x2_splat(other), f64x2_splat(term)))
}
