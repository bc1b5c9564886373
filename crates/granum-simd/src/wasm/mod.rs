//! Eight lanes in four 128-bit registers of WebAssembly.
//!
//! Its fused multiply-add is an instruction of relaxed SIMD in a module that is compiled with `--cfg granum_relaxed`; a page takes that module
//! only where the browser has been found to fuse. Elsewhere it is computed exactly (`emulated.rs`).
//!
//! SAFETY of every block here: the module is compiled for these instructions, and a browser without them refuses it as a whole.

#[cfg(not(granum_relaxed))]
mod emulated;
pub(crate) mod fused;

use std::arch::wasm32::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::lanes::{Lanes, Mask, Real, no_such_row};
use crate::portable::{EXPONENT_MAGIC, RECIPROCAL_CBRT_MAGIC};
use crate::rows::{Row4, Row8};
use fused::two_fused;

/// The bits of `2^52`: combined with those of a whole number below `2^52` they are the sum of both.
const TWO_52: u64 = 0x4330_0000_0000_0000;
/// `2^52 + 1`.
const NEXT_TO_TWO_52: f64 = 4_503_599_627_370_497.0;
/// `2^52 + 2^40`: adding it to a number rounds that to a whole one, also to one below zero, whose lowest bits are then those of the sum.
const TO_WHOLE: f64 = 4_504_699_138_998_272.0;

/// Eight lanes in four 128-bit registers.
#[derive(Clone, Copy)]
pub struct Wasm([v128; 4]);

/// All ones or all zeros in each lane.
#[derive(Clone, Copy)]
pub struct WasmMask([v128; 4]);

/// `yes` or `no` in both lanes of a mask.
#[inline(always)]
fn two_selected(mask: v128, yes: v128, no: v128) -> v128 {
    #[cfg(granum_relaxed)]
    return granum_relaxed::relaxed_select(yes, no, mask);
    #[cfg(not(granum_relaxed))]
    v128_bitselect(yes, no, mask)
}

impl Wasm {
    #[inline(always)]
    fn map(self, f: impl Fn(v128) -> v128) -> Self {
        let [a, b, c, d] = self.0;
        Wasm([f(a), f(b), f(c), f(d)])
    }
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(v128, v128) -> v128) -> Self {
        let ([a, b, c, d], [p, q, r, s]) = (self.0, other.0);
        Wasm([f(a, p), f(b, q), f(c, r), f(d, s)])
    }
    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(v128, v128) -> v128) -> WasmMask {
        WasmMask(self.zip(other, f).0)
    }
    #[inline(always)]
    fn to_array(self) -> [f64; 8] {
        let mut array = [0.0; 8];
        self.store(&mut array);
        array
    }
}

impl WasmMask {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(v128, v128) -> v128) -> Self {
        let ([a, b, c, d], [p, q, r, s]) = (self.0, other.0);
        WasmMask([f(a, p), f(b, q), f(c, r), f(d, s)])
    }
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(
                    other,
                    #[inline(always)]
                    |a, b| $intrinsic(a, b),
                )
            }
        }
    };
}
operator!(WasmMask, BitAnd, bitand, v128_and);
operator!(WasmMask, BitOr, bitor, v128_or);
operator!(Wasm, Add, add, f64x2_add);
operator!(Wasm, Sub, sub, f64x2_sub);
operator!(Wasm, Mul, mul, f64x2_mul);
operator!(Wasm, Div, div, f64x2_div);

impl Not for WasmMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        let [a, b, c, d] = self.0;
        WasmMask([v128_not(a), v128_not(b), v128_not(c), v128_not(d)])
    }
}

impl Mask for WasmMask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        WasmMask([u64x2_splat(if value { u64::MAX } else { 0 }); 4])
    }
    #[inline(always)]
    fn any(self) -> bool {
        let [a, b, c, d] = self.0;
        v128_any_true(v128_or(v128_or(a, b), v128_or(c, d)))
    }
    #[inline(always)]
    fn all(self) -> bool {
        let [a, b, c, d] = self.0;
        i64x2_all_true(v128_and(v128_and(a, b), v128_and(c, d)))
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        let [a, b, c, d] = self.0;
        // Sixteen bits of a lane each, then one byte each.
        let low = i32x4_shuffle::<0, 2, 4, 6>(a, b);
        let high = i32x4_shuffle::<0, 2, 4, 6>(c, d);
        u8x16_bitmask(i8x16_narrow_i16x8(i16x8_narrow_i32x4(low, high), u64x2_splat(0)))
    }
}

impl Neg for Wasm {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(
            #[inline(always)]
            |a| f64x2_neg(a),
        )
    }
}

impl Real for Wasm {
    type Mask = WasmMask;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Wasm([f64x2_splat(value); 4])
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        let ([a, b, c, d], [p, q, r, s], [t, u, v, w]) = (self.0, factor.0, term.0);
        Wasm([two_fused(a, p, t), two_fused(b, q, u), two_fused(c, r, v), two_fused(d, s, w)])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(
            #[inline(always)]
            |a| f64x2_sqrt(a),
        )
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(
            #[inline(always)]
            |a| f64x2_abs(a),
        )
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| f64x2_pmin(b, a),
        )
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| f64x2_pmax(b, a),
        )
    }
    #[inline(always)]
    fn lt(self, other: Self) -> WasmMask {
        self.compare(
            other,
            #[inline(always)]
            |a, b| f64x2_lt(a, b),
        )
    }
    #[inline(always)]
    fn le(self, other: Self) -> WasmMask {
        self.compare(
            other,
            #[inline(always)]
            |a, b| f64x2_le(a, b),
        )
    }
    #[inline(always)]
    fn eq(self, other: Self) -> WasmMask {
        self.compare(
            other,
            #[inline(always)]
            |a, b| f64x2_eq(a, b),
        )
    }
    #[inline(always)]
    fn select(mask: WasmMask, yes: Self, no: Self) -> Self {
        let ([m, n, o, p], [a, b, c, d], [q, r, s, t]) = (mask.0, yes.0, no.0);
        Wasm([two_selected(m, a, q), two_selected(n, b, r), two_selected(o, c, s), two_selected(p, d, t)])
    }
    /// A mask has all bits of a lane or none.
    #[inline(always)]
    fn keep(self, mask: WasmMask) -> Self {
        let ([a, b, c, d], [m, n, o, p]) = (self.0, mask.0);
        Wasm([v128_and(a, m), v128_and(b, n), v128_and(c, o), v128_and(d, p)])
    }
    #[inline(always)]
    fn exp2_integer(self) -> Self {
        self.map(
            #[inline(always)]
            |a| i64x2_shl(f64x2_add(a, f64x2_splat(EXPONENT_MAGIC)), 52),
        )
    }
    #[inline(always)]
    fn reciprocal_cbrt_guess(self) -> Self {
        self.map(
            #[inline(always)]
            |a| {
                // A product of 64 bits takes a dozen instructions of most processors. The upper half of the bits, less one, is a number whose third is never half-way
                // between two whole ones: rounded to the nearest it is the third of the upper half, rounded down.
                let less_one =
                    f64x2_sub(v128_or(u64x2_shr(a, 32), u64x2_splat(TWO_52)), f64x2_splat(NEXT_TO_TWO_52));
                let third = f64x2_add(f64x2_mul(less_one, f64x2_splat(1.0 / 3.0)), f64x2_splat(TO_WHOLE));
                i64x2_shl(i64x2_sub(u64x2_splat(RECIPROCAL_CBRT_MAGIC as u64), third), 32)
            },
        )
    }
    #[inline(always)]
    fn reduce_max(self) -> f64 {
        self.to_array().iter().fold(f64::NEG_INFINITY, |m, &a| Real::max(a, m))
    }
    #[inline(always)]
    fn reduce_add(self) -> f64 {
        let a = self.to_array();
        ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]))
    }
}

/// Two numbers of a row from an entry on.
///
/// # Safety
/// `row` must be in range, and `at + 1` one of its entries.
#[inline(always)]
unsafe fn two_of<const N: usize>(rows: *const [f64; N], row: u32, at: usize) -> v128 {
    unsafe { v128_load(rows.add(row as usize).cast::<f64>().add(at).cast()) }
}

/// Columns of eight lanes from what `two` gives for a lane and an entry: the entry and the one after it.
#[inline(always)]
fn columns<const C: usize>(two: impl Fn(usize, usize) -> v128) -> [Wasm; C] {
    let mut columns = [Wasm::splat(0.0); C];
    for at in (0..C).step_by(2) {
        for half in 0..4 {
            let (a, b) = (two(2 * half, at), two(2 * half + 1, at));
            columns[at].0[half] = i64x2_shuffle::<0, 2>(a, b);
            columns[at + 1].0[half] = i64x2_shuffle::<1, 3>(a, b);
        }
    }
    columns
}

impl Lanes for Wasm {
    type Scalar = f64;
    const REGISTERS: usize = 4;
    const PAIRED: bool = false;
    #[inline(always)]
    fn load(source: &[f64; 8]) -> Self {
        let at: *const v128 = source.as_ptr().cast();
        unsafe { Wasm([v128_load(at), v128_load(at.add(1)), v128_load(at.add(2)), v128_load(at.add(3))]) }
    }
    #[inline(always)]
    fn store(self, target: &mut [f64; 8]) {
        let at: *mut v128 = target.as_mut_ptr().cast();
        unsafe {
            v128_store(at, self.0[0]);
            v128_store(at.add(1), self.0[1]);
            v128_store(at.add(2), self.0[2]);
            v128_store(at.add(3), self.0[3]);
        }
    }
    #[inline(always)]
    fn check(index: &[u32; 8], bound: usize) {
        let at: *const v128 = index.as_ptr().cast();
        let (low, high) = unsafe { (v128_load(at), v128_load(at.add(1))) };
        let bounds = u32x4_splat(bound as u32);
        let within = v128_and(u32x4_lt(low, bounds), u32x4_lt(high, bounds));
        if !u32x4_all_true(within) {
            no_such_row(index, bound);
        }
    }
    #[inline(always)]
    fn gather8(rows: &[Row8], index: &[u32; 8]) -> [Self; 8] {
        Self::check(index, rows.len());
        let rows = rows.as_ptr().cast::<[f64; 8]>();
        columns(
            #[inline(always)]
            // SAFETY: just checked.
            |l, at| unsafe { two_of(rows, index[l], at) },
        )
    }
    #[inline(always)]
    fn gather4(rows: &[Row4], index: &[u32; 8]) -> [Self; 4] {
        Self::check(index, rows.len());
        let rows = rows.as_ptr().cast::<[f64; 4]>();
        columns(
            #[inline(always)]
            // SAFETY: just checked.
            |l, at| unsafe { two_of(rows, index[l], at) },
        )
    }
    #[inline(always)]
    fn differences8(rows: &[Row8], from: &[u32; 8], to: &[u32; 8]) -> [Self; 8] {
        Self::check(from, rows.len());
        Self::check(to, rows.len());
        let rows = rows.as_ptr().cast::<[f64; 8]>();
        columns(
            #[inline(always)]
            // SAFETY: just checked.
            |l, at| unsafe { f64x2_sub(two_of(rows, to[l], at), two_of(rows, from[l], at)) },
        )
    }
    #[inline(always)]
    fn sums4(rows: &[Row4], a: &[u32; 8], b: &[u32; 8]) -> [Self; 4] {
        Self::check(a, rows.len());
        Self::check(b, rows.len());
        let rows = rows.as_ptr().cast::<[f64; 4]>();
        columns(
            #[inline(always)]
            // SAFETY: just checked.
            |l, at| unsafe { f64x2_add(two_of(rows, a[l], at), two_of(rows, b[l], at)) },
        )
    }
    #[inline(always)]
    fn transpose(turned: [Self; 8]) -> [Self; 8] {
        columns(
            #[inline(always)]
            |l, at| turned[l].0[at / 2],
        )
    }
    #[inline(always)]
    fn reduce_add8(columns: [Self; 8]) -> Self {
        // The sums of neighbouring lanes of both vectors.
        #[inline(always)]
        fn pairs(a: v128, b: v128) -> v128 {
            f64x2_add(i64x2_shuffle::<0, 2>(a, b), i64x2_shuffle::<1, 3>(a, b))
        }
        let mut sums = Wasm::splat(0.0);
        for half in 0..4 {
            let (a, b) = (columns[2 * half].0, columns[2 * half + 1].0);
            let low = f64x2_add(pairs(a[0], b[0]), pairs(a[1], b[1]));
            let high = f64x2_add(pairs(a[2], b[2]), pairs(a[3], b[3]));
            sums.0[half] = f64x2_add(low, high);
        }
        sums
    }
}
