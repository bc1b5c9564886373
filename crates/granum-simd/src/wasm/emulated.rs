//! `a b + c` of two doubles side by side, rounded once, in instructions that every WebAssembly with SIMD has.

#![allow(
    improper_ctypes_definitions,
    reason = "Rust calls these functions; the convention of C hands vectors over in registers"
)]

use std::arch::wasm32::*;

use crate::fused::exact::exact;

/// `2^27 + 1`, which splits a double into two parts of at most 26 bits (Veltkamp).
const SPLIT: f64 = 134_217_729.0;
/// `2^-850`: smaller results may lack bits.
const SMALL: f64 = f64::from_bits((1023 - 850) << 52);

/// `a b + c`, rounded once. The exact sum is found in three parts (Dekker, Knuth); the lowest is made slightly larger and slightly smaller, and
/// if both round alike, the result is certain. Near ties, for small results, overflow and NaN each number goes the long way
/// (`fused::exact`).
///
/// Not inlined: the loops of the engine would have megabytes. The convention of C hands vectors over in registers.
#[inline(never)]
pub(crate) extern "C" fn mul_add(a: v128, b: v128, c: v128) -> v128 {
    let product = f64x2_mul(a, b);
    // The upper part of `a` has 26 bits: that of `b` has 26 bits and a sign, so that all four products are exact.
    let a_high = v128_and(a, u64x2_splat(!0x7ff_ffff));
    let a_low = f64x2_sub(a, a_high);
    let scaled = f64x2_mul(f64x2_splat(SPLIT), b);
    let b_high = f64x2_sub(scaled, f64x2_sub(scaled, b));
    let b_low = f64x2_sub(b, b_high);
    let rest = f64x2_sub(f64x2_sub(product, f64x2_mul(a_high, b_high)), f64x2_mul(a_low, b_high));
    let error = f64x2_sub(f64x2_mul(a_low, b_low), f64x2_sub(rest, f64x2_mul(a_high, b_low)));
    let (high, low) = two_sum(c, error);
    let (sum, middle) = two_sum(product, high);
    let lowest = f64x2_add(middle, low);
    let larger = f64x2_add(sum, f64x2_mul(lowest, f64x2_splat(1.0 + 4.0 * f64::EPSILON)));
    let smaller = f64x2_add(sum, f64x2_mul(lowest, f64x2_splat(1.0 - 4.0 * f64::EPSILON)));
    // Zero is negative where product and term are; a sum of two negative numbers is negative anyway.
    let sign = v128_and(v128_and(product, c), u64x2_splat(1 << 63));
    let (larger, smaller) = (v128_or(larger, sign), v128_or(smaller, sign));
    let zero = f64x2_splat(0.0);
    let small =
        v128_and(f64x2_lt(f64x2_abs(larger), f64x2_splat(SMALL)), f64x2_ne(v128_or(larger, product), zero));
    // A comparison with NaN is true for "not equal".
    let unsure = v128_or(f64x2_ne(larger, smaller), small);
    if v128_any_true(unsure) { one_by_one(a, b, c) } else { larger }
}

/// The sum of two numbers and the error of its rounding (Knuth).
#[inline(always)]
fn two_sum(a: v128, b: v128) -> (v128, v128) {
    let sum = f64x2_add(a, b);
    let b_part = f64x2_sub(sum, a);
    (sum, f64x2_add(f64x2_sub(a, f64x2_sub(sum, b_part)), f64x2_sub(b, b_part)))
}

#[cold]
#[inline(never)]
extern "C" fn one_by_one(a: v128, b: v128, c: v128) -> v128 {
    f64x2(
        exact(f64x2_extract_lane::<0>(a), f64x2_extract_lane::<0>(b), f64x2_extract_lane::<0>(c)),
        exact(f64x2_extract_lane::<1>(a), f64x2_extract_lane::<1>(b), f64x2_extract_lane::<1>(c)),
    )
}
