//! Granum's own fused multiply-add of single numbers.
//!
//! `f64::mul_add` calls the C library where the processor of the target need not have the instruction, and not every library
//! rounds once: that of mingw-w64 computes in extended precision and rounds again. Here the processor computes where it can,
//! which x86-64 tells at run time, and an exact routine elsewhere.

pub(crate) mod exact;

#[cfg(any(
    test,
    not(any(target_arch = "aarch64", all(target_arch = "wasm32", target_feature = "simd128")))
))]
use exact::exact;

/// `factor * other + term`, rounded once.
///
/// ```
/// let x = 1.0 + f64::EPSILON;
/// assert_eq!(granum_simd::mul_add(x, x, -(1.0 + 2.0 * f64::EPSILON)), f64::EPSILON * f64::EPSILON);
/// ```
#[inline]
pub fn mul_add(factor: f64, other: f64, term: f64) -> f64 {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("fma") {
        // SAFETY: the processor has just been found to have the instruction.
        return unsafe { hardware(factor, other, term) };
    }
    #[cfg(target_arch = "aarch64")]
    return hardware(factor, other, term);
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    return crate::wasm::fused::one_fused(factor, other, term);
    #[cfg(not(any(target_arch = "aarch64", all(target_arch = "wasm32", target_feature = "simd128"))))]
    exact(factor, other, term)
}

/// By the instruction of the processor.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "fma")]
#[inline]
pub(crate) fn hardware(factor: f64, other: f64, term: f64) -> f64 {
    use std::arch::x86_64::{_mm_cvtsd_f64, _mm_fmadd_sd, _mm_set_sd};
    _mm_cvtsd_f64(_mm_fmadd_sd(_mm_set_sd(factor), _mm_set_sd(other), _mm_set_sd(term)))
}

/// By the instruction of the processor.
#[cfg(target_arch = "aarch64")]
#[inline(always)]
#[expect(clippy::disallowed_methods, reason = "every processor of this architecture has the instruction")]
pub(crate) fn hardware(factor: f64, other: f64, term: f64) -> f64 {
    factor.mul_add(other, term)
}

#[cfg(test)]
mod tests;
