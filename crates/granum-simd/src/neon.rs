//! Eight lanes in four 128-bit registers of aarch64, which has fused multiply-adds in its baseline.
//!
//! SAFETY of every block here: every aarch64 processor has these instructions.

use std::arch::aarch64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::lanes::{Lanes, Mask, Real, no_such_row};
use crate::portable::{EXPONENT_MAGIC, RECIPROCAL_CBRT_MAGIC, THIRD};
use crate::rows::{Row4, Row8};

/// Eight lanes in four 128-bit registers.
#[derive(Clone, Copy)]
pub struct Neon([float64x2_t; 4]);

/// All ones or all zeros in each lane.
#[derive(Clone, Copy)]
pub struct NeonMask([uint64x2_t; 4]);

impl Neon {
    #[inline(always)]
    fn map(self, f: impl Fn(float64x2_t) -> float64x2_t) -> Self {
        let [a, b, c, d] = self.0;
        Neon([f(a), f(b), f(c), f(d)])
    }
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(float64x2_t, float64x2_t) -> float64x2_t) -> Self {
        let ([a, b, c, d], [p, q, r, s]) = (self.0, other.0);
        Neon([f(a, p), f(b, q), f(c, r), f(d, s)])
    }
    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(float64x2_t, float64x2_t) -> uint64x2_t) -> NeonMask {
        let ([a, b, c, d], [p, q, r, s]) = (self.0, other.0);
        NeonMask([f(a, p), f(b, q), f(c, r), f(d, s)])
    }
    #[inline(always)]
    fn to_array(self) -> [f64; 8] {
        let mut array = [0.0; 8];
        self.store(&mut array);
        array
    }
}

impl NeonMask {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(uint64x2_t, uint64x2_t) -> uint64x2_t) -> Self {
        let ([a, b, c, d], [p, q, r, s]) = (self.0, other.0);
        NeonMask([f(a, p), f(b, q), f(c, r), f(d, s)])
    }
    /// Sixteen bits of ones or zeros a lane.
    #[inline(always)]
    fn narrow(self) -> uint16x8_t {
        let [a, b, c, d] = self.0;
        unsafe {
            let low = vcombine_u32(vmovn_u64(a), vmovn_u64(b));
            let high = vcombine_u32(vmovn_u64(c), vmovn_u64(d));
            vcombine_u16(vmovn_u32(low), vmovn_u32(high))
        }
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
                    |a, b| unsafe { $intrinsic(a, b) },
                )
            }
        }
    };
}
operator!(NeonMask, BitAnd, bitand, vandq_u64);
operator!(NeonMask, BitOr, bitor, vorrq_u64);
operator!(Neon, Add, add, vaddq_f64);
operator!(Neon, Sub, sub, vsubq_f64);
operator!(Neon, Mul, mul, vmulq_f64);
operator!(Neon, Div, div, vdivq_f64);

impl Not for NeonMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        let ones = NeonMask::splat(true);
        self.zip(
            ones,
            #[inline(always)]
            |a, b| unsafe { veorq_u64(a, b) },
        )
    }
}

impl Mask for NeonMask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        NeonMask([unsafe { vdupq_n_u64(if value { u64::MAX } else { 0 }) }; 4])
    }
    #[inline(always)]
    fn any(self) -> bool {
        unsafe { vmaxvq_u16(self.narrow()) != 0 }
    }
    #[inline(always)]
    fn all(self) -> bool {
        unsafe { vminvq_u16(self.narrow()) != 0 }
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        const WEIGHTS: [u16; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
        unsafe { vaddvq_u16(vandq_u16(self.narrow(), vld1q_u16(WEIGHTS.as_ptr()))) }
    }
}

impl Neg for Neon {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(
            #[inline(always)]
            |a| unsafe { vnegq_f64(a) },
        )
    }
}

impl Real for Neon {
    type Mask = NeonMask;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Neon([unsafe { vdupq_n_f64(value) }; 4])
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        let ([a, b, c, d], [p, q, r, s], [t, u, v, w]) = (self.0, factor.0, term.0);
        unsafe { Neon([vfmaq_f64(t, a, p), vfmaq_f64(u, b, q), vfmaq_f64(v, c, r), vfmaq_f64(w, d, s)]) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(
            #[inline(always)]
            |a| unsafe { vsqrtq_f64(a) },
        )
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(
            #[inline(always)]
            |a| unsafe { vabsq_f64(a) },
        )
    }
    // The processor's own minimum and maximum treat NaN in another way.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> NeonMask {
        self.compare(
            other,
            #[inline(always)]
            |a, b| unsafe { vcltq_f64(a, b) },
        )
    }
    #[inline(always)]
    fn le(self, other: Self) -> NeonMask {
        self.compare(
            other,
            #[inline(always)]
            |a, b| unsafe { vcleq_f64(a, b) },
        )
    }
    #[inline(always)]
    fn eq(self, other: Self) -> NeonMask {
        self.compare(
            other,
            #[inline(always)]
            |a, b| unsafe { vceqq_f64(a, b) },
        )
    }
    #[inline(always)]
    fn select(mask: NeonMask, yes: Self, no: Self) -> Self {
        let ([m, n, o, p], [a, b, c, d], [q, r, s, t]) = (mask.0, yes.0, no.0);
        unsafe { Neon([vbslq_f64(m, a, q), vbslq_f64(n, b, r), vbslq_f64(o, c, s), vbslq_f64(p, d, t)]) }
    }
    #[inline(always)]
    fn exp2_integer(self) -> Self {
        self.map(
            #[inline(always)]
            |a| unsafe {
                let shifted = vreinterpretq_u64_f64(vaddq_f64(a, vdupq_n_f64(EXPONENT_MAGIC)));
                vreinterpretq_f64_u64(vshlq_n_u64::<52>(shifted))
            },
        )
    }
    #[inline(always)]
    fn reciprocal_cbrt_guess(self) -> Self {
        self.map(
            #[inline(always)]
            |a| unsafe {
                let upper = vshrn_n_u64::<32>(vreinterpretq_u64_f64(a));
                let third = vshrq_n_u64::<33>(vmull_u32(upper, vdup_n_u32(THIRD)));
                let guess = vsubq_u64(vdupq_n_u64(RECIPROCAL_CBRT_MAGIC as u64), third);
                vreinterpretq_f64_u64(vshlq_n_u64::<32>(guess))
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
unsafe fn two_of<const N: usize>(rows: *const [f64; N], row: u32, at: usize) -> float64x2_t {
    unsafe { vld1q_f64(rows.add(row as usize).cast::<f64>().add(at)) }
}

/// Columns of eight lanes from what `two` gives for a lane and an entry: the entry and the one after it.
#[inline(always)]
fn columns<const C: usize>(two: impl Fn(usize, usize) -> float64x2_t) -> [Neon; C] {
    let mut columns = [Neon::splat(0.0); C];
    for at in (0..C).step_by(2) {
        for half in 0..4 {
            let (a, b) = (two(2 * half, at), two(2 * half + 1, at));
            unsafe {
                columns[at].0[half] = vtrn1q_f64(a, b);
                columns[at + 1].0[half] = vtrn2q_f64(a, b);
            }
        }
    }
    columns
}

impl Lanes for Neon {
    type Scalar = f64;
    const REGISTERS: usize = 8;
    // Four independent registers a value already fill the gaps, and two values take all there are.
    const PAIRED: bool = false;
    #[inline(always)]
    fn load(source: &[f64; 8]) -> Self {
        let at = source.as_ptr();
        unsafe { Neon([vld1q_f64(at), vld1q_f64(at.add(2)), vld1q_f64(at.add(4)), vld1q_f64(at.add(6))]) }
    }
    #[inline(always)]
    fn store(self, target: &mut [f64; 8]) {
        let at = target.as_mut_ptr();
        unsafe {
            vst1q_f64(at, self.0[0]);
            vst1q_f64(at.add(2), self.0[1]);
            vst1q_f64(at.add(4), self.0[2]);
            vst1q_f64(at.add(6), self.0[3]);
        }
    }
    #[inline(always)]
    fn check(index: &[u32; 8], bound: usize) {
        // Eight indices are two registers.
        let largest = unsafe {
            let (low, high) = (vld1q_u32(index.as_ptr()), vld1q_u32(index.as_ptr().add(4)));
            vmaxvq_u32(vmaxq_u32(low, high))
        };
        if largest as usize >= bound {
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
            |l, at| unsafe { vsubq_f64(two_of(rows, to[l], at), two_of(rows, from[l], at)) },
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
            |l, at| unsafe { vaddq_f64(two_of(rows, a[l], at), two_of(rows, b[l], at)) },
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
        let mut sums = Neon::splat(0.0);
        for half in 0..4 {
            let (a, b) = (columns[2 * half].0, columns[2 * half + 1].0);
            // The sums of neighbouring lanes of both columns, then of those.
            unsafe {
                let low = vaddq_f64(vpaddq_f64(a[0], b[0]), vpaddq_f64(a[1], b[1]));
                let high = vaddq_f64(vpaddq_f64(a[2], b[2]), vpaddq_f64(a[3], b[3]));
                sums.0[half] = vaddq_f64(low, high);
            }
        }
        sums
    }
}
