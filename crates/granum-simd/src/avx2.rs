//! Eight lanes in two 256-bit registers.
//!
//! SAFETY of every block here: a value of [`Avx2`] is created only inside [`crate::dispatch()`], after AVX2 and FMA were
//! detected on the processor.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::lanes::{Lanes, Mask, Real, no_such_row};
use crate::portable::{EXPONENT_MAGIC, RECIPROCAL_CBRT_MAGIC, THIRD};
use crate::rows::{Row4, Row8};
use crate::scalar::Fused;

/// Eight lanes in two 256-bit registers.
#[derive(Clone, Copy)]
pub struct Avx2(__m256d, __m256d);

/// All ones or all zeros in each lane.
#[derive(Clone, Copy)]
pub struct Avx2Mask(__m256d, __m256d);

impl Avx2 {
    #[inline(always)]
    fn to_array(self) -> [f64; 8] {
        let mut a = [0.0; 8];
        unsafe {
            _mm256_storeu_pd(a.as_mut_ptr(), self.0);
            _mm256_storeu_pd(a.as_mut_ptr().add(4), self.1);
        }
        a
    }
}

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                unsafe { $type($intrinsic(self.0, other.0), $intrinsic(self.1, other.1)) }
            }
        }
    };
}
operator!(Avx2Mask, BitAnd, bitand, _mm256_and_pd);
operator!(Avx2Mask, BitOr, bitor, _mm256_or_pd);
operator!(Avx2, Add, add, _mm256_add_pd);
operator!(Avx2, Sub, sub, _mm256_sub_pd);
operator!(Avx2, Mul, mul, _mm256_mul_pd);
operator!(Avx2, Div, div, _mm256_div_pd);

impl Not for Avx2Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        unsafe {
            let ones = _mm256_castsi256_pd(_mm256_set1_epi64x(-1));
            Avx2Mask(_mm256_xor_pd(self.0, ones), _mm256_xor_pd(self.1, ones))
        }
    }
}
impl Mask for Avx2Mask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        let m = unsafe { _mm256_castsi256_pd(_mm256_set1_epi64x(if value { -1 } else { 0 })) };
        Avx2Mask(m, m)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == 0xff
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        unsafe { (_mm256_movemask_pd(self.0) | (_mm256_movemask_pd(self.1) << 4)) as u16 }
    }
}

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Avx2(_mm256_xor_pd(self.0, sign), _mm256_xor_pd(self.1, sign))
        }
    }
}

impl Real for Avx2 {
    type Mask = Avx2Mask;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        let v = unsafe { _mm256_set1_pd(value) };
        Avx2(v, v)
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        unsafe { Avx2(_mm256_fmadd_pd(self.0, factor.0, term.0), _mm256_fmadd_pd(self.1, factor.1, term.1)) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        unsafe { Avx2(_mm256_sqrt_pd(self.0), _mm256_sqrt_pd(self.1)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Avx2(_mm256_andnot_pd(sign, self.0), _mm256_andnot_pd(sign, self.1))
        }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        unsafe { Avx2(_mm256_min_pd(self.0, other.0), _mm256_min_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        unsafe { Avx2(_mm256_max_pd(self.0, other.0), _mm256_max_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx2Mask {
        unsafe {
            Avx2Mask(
                _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0),
                _mm256_cmp_pd::<_CMP_LT_OQ>(self.1, other.1),
            )
        }
    }
    #[inline(always)]
    fn le(self, other: Self) -> Avx2Mask {
        unsafe {
            Avx2Mask(
                _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0),
                _mm256_cmp_pd::<_CMP_LE_OQ>(self.1, other.1),
            )
        }
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx2Mask {
        unsafe {
            Avx2Mask(
                _mm256_cmp_pd::<_CMP_EQ_OQ>(self.0, other.0),
                _mm256_cmp_pd::<_CMP_EQ_OQ>(self.1, other.1),
            )
        }
    }
    #[inline(always)]
    fn select(mask: Avx2Mask, yes: Self, no: Self) -> Self {
        unsafe { Avx2(_mm256_blendv_pd(no.0, yes.0, mask.0), _mm256_blendv_pd(no.1, yes.1, mask.1)) }
    }
    #[inline(always)]
    fn exp2_integer(self) -> Self {
        let one = |v: __m256d| unsafe {
            let shifted = _mm256_castpd_si256(_mm256_add_pd(v, _mm256_set1_pd(EXPONENT_MAGIC)));
            _mm256_castsi256_pd(_mm256_slli_epi64::<52>(shifted))
        };
        Avx2(one(self.0), one(self.1))
    }
    #[inline(always)]
    fn reciprocal_cbrt_guess(self) -> Self {
        let one = |v: __m256d| unsafe {
            let upper = _mm256_srli_epi64::<32>(_mm256_castpd_si256(v));
            let third = _mm256_srli_epi64::<33>(_mm256_mul_epu32(upper, _mm256_set1_epi64x(THIRD as i64)));
            let guess = _mm256_sub_epi64(_mm256_set1_epi64x(RECIPROCAL_CBRT_MAGIC as i64), third);
            _mm256_castsi256_pd(_mm256_slli_epi64::<32>(guess))
        };
        Avx2(one(self.0), one(self.1))
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

/// Transposes a 4 x 4 block held in four registers.
#[inline(always)]
fn transpose4(r: [__m256d; 4]) -> [__m256d; 4] {
    unsafe {
        let t0 = _mm256_unpacklo_pd(r[0], r[1]);
        let t1 = _mm256_unpackhi_pd(r[0], r[1]);
        let t2 = _mm256_unpacklo_pd(r[2], r[3]);
        let t3 = _mm256_unpackhi_pd(r[2], r[3]);
        [
            _mm256_permute2f128_pd::<0x20>(t0, t2),
            _mm256_permute2f128_pd::<0x20>(t1, t3),
            _mm256_permute2f128_pd::<0x31>(t0, t2),
            _mm256_permute2f128_pd::<0x31>(t1, t3),
        ]
    }
}

impl Lanes for Avx2 {
    type Scalar = Fused;
    const REGISTERS: usize = 8;
    const PAIRED: bool = false;
    #[inline(always)]
    fn load(source: &[f64; 8]) -> Self {
        unsafe { Avx2(_mm256_loadu_pd(source.as_ptr()), _mm256_loadu_pd(source.as_ptr().add(4))) }
    }
    #[inline(always)]
    fn store(self, target: &mut [f64; 8]) {
        unsafe {
            _mm256_storeu_pd(target.as_mut_ptr(), self.0);
            _mm256_storeu_pd(target.as_mut_ptr().add(4), self.1);
        }
    }
    #[inline(always)]
    fn check(index: &[u32; 8], bound: usize) {
        let bound32 = bound.min(u32::MAX as usize) as u32;
        // SAFETY: eight indices are 32 bytes.
        let beyond = unsafe {
            let index = _mm256_loadu_si256(index.as_ptr().cast());
            // An index that is not below the bound is the larger of the two.
            let larger = _mm256_max_epu32(index, _mm256_set1_epi32(bound32 as i32));
            _mm256_movemask_epi8(_mm256_cmpeq_epi32(larger, index))
        };
        if beyond != 0 {
            no_such_row(index, bound);
        }
    }
    #[inline(always)]
    fn gather8(rows: &[Row8], index: &[u32; 8]) -> [Self; 8] {
        Self::check(index, rows.len());
        let block = |first: usize, offset: usize| {
            // SAFETY: the indices have just been checked.
            transpose4(std::array::from_fn(|l| unsafe {
                _mm256_load_pd(rows.get_unchecked(index[first + l] as usize).0.as_ptr().add(offset))
            }))
        };
        let (a, b, c, d) = (block(0, 0), block(4, 0), block(0, 4), block(4, 4));
        std::array::from_fn(|i| if i < 4 { Avx2(a[i], b[i]) } else { Avx2(c[i - 4], d[i - 4]) })
    }
    #[inline(always)]
    fn gather4(rows: &[Row4], index: &[u32; 8]) -> [Self; 4] {
        Self::check(index, rows.len());
        let block = |first: usize| {
            // SAFETY: the indices have just been checked.
            transpose4(std::array::from_fn(|l| unsafe {
                _mm256_load_pd(rows.get_unchecked(index[first + l] as usize).0.as_ptr())
            }))
        };
        let (a, b) = (block(0), block(4));
        std::array::from_fn(|i| Avx2(a[i], b[i]))
    }
    #[inline(always)]
    fn differences8(rows: &[Row8], from: &[u32; 8], to: &[u32; 8]) -> [Self; 8] {
        Self::check(from, rows.len());
        Self::check(to, rows.len());
        let block = |first: usize, offset: usize| {
            // SAFETY: the indices have just been checked.
            transpose4(std::array::from_fn(|l| unsafe {
                let a = rows.get_unchecked(from[first + l] as usize).0.as_ptr().add(offset);
                let b = rows.get_unchecked(to[first + l] as usize).0.as_ptr().add(offset);
                _mm256_sub_pd(_mm256_load_pd(b), _mm256_load_pd(a))
            }))
        };
        let (a, b, c, d) = (block(0, 0), block(4, 0), block(0, 4), block(4, 4));
        std::array::from_fn(|i| if i < 4 { Avx2(a[i], b[i]) } else { Avx2(c[i - 4], d[i - 4]) })
    }
    #[inline(always)]
    fn sums4(rows: &[Row4], a: &[u32; 8], b: &[u32; 8]) -> [Self; 4] {
        Self::check(a, rows.len());
        Self::check(b, rows.len());
        let block = |first: usize| {
            // SAFETY: the indices have just been checked.
            transpose4(std::array::from_fn(|l| unsafe {
                let a = rows.get_unchecked(a[first + l] as usize).0.as_ptr();
                let b = rows.get_unchecked(b[first + l] as usize).0.as_ptr();
                _mm256_add_pd(_mm256_load_pd(a), _mm256_load_pd(b))
            }))
        };
        let (low, high) = (block(0), block(4));
        std::array::from_fn(|i| Avx2(low[i], high[i]))
    }
    #[inline(always)]
    fn transpose(c: [Self; 8]) -> [Self; 8] {
        let upper = |half: fn(&Avx2) -> __m256d| transpose4(std::array::from_fn(|k| half(&c[k])));
        let lower = |half: fn(&Avx2) -> __m256d| transpose4(std::array::from_fn(|k| half(&c[4 + k])));
        let (a, b) = (upper(|x| x.0), upper(|x| x.1));
        let (p, q) = (lower(|x| x.0), lower(|x| x.1));
        std::array::from_fn(|l| if l < 4 { Avx2(a[l], p[l]) } else { Avx2(b[l - 4], q[l - 4]) })
    }
    #[inline(always)]
    fn reduce_add8(columns: [Self; 8]) -> Self {
        let c = columns;
        // (0+1)+(2+3) of the lower and of the upper half of four values.
        let half = |a: __m256d, b: __m256d, c: __m256d, d: __m256d| unsafe {
            let ab = _mm256_hadd_pd(a, b); // a0+a1 b0+b1 a2+a3 b2+b3
            let cd = _mm256_hadd_pd(c, d);
            let lower = _mm256_permute2f128_pd::<0x20>(ab, cd);
            let upper = _mm256_permute2f128_pd::<0x31>(ab, cd);
            _mm256_add_pd(lower, upper)
        };
        unsafe {
            Avx2(
                _mm256_add_pd(half(c[0].0, c[1].0, c[2].0, c[3].0), half(c[0].1, c[1].1, c[2].1, c[3].1)),
                _mm256_add_pd(half(c[4].0, c[5].0, c[6].0, c[7].0), half(c[4].1, c[5].1, c[6].1, c[7].1)),
            )
        }
    }
}
