//! Eight lanes in one 512-bit register.
//!
//! SAFETY of every block here: a value of [`Avx512`] is created only inside [`crate::dispatch()`], after AVX-512 F, DQ, BW
//! and VL were detected on the processor.

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::lanes::{Lanes, Mask, Real, no_such_row};
use crate::portable::{EXPONENT_MAGIC, RECIPROCAL_CBRT_MAGIC, THIRD};
use crate::rows::{Row4, Row8};
use crate::scalar::Fused;

/// Eight lanes in one 512-bit register.
#[derive(Clone, Copy)]
pub struct Avx512(__m512d);

/// One bit for each lane.
#[derive(Clone, Copy)]
pub struct Avx512Mask(__mmask8);

impl BitAnd for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Avx512Mask(self.0 & other.0)
    }
}
impl BitOr for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Avx512Mask(self.0 | other.0)
    }
}
impl Not for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Avx512Mask(!self.0)
    }
}
impl Mask for Avx512Mask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Avx512Mask(if value { 0xff } else { 0 })
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0 == 0xff
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        self.0 as u16
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for Avx512 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Avx512(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}
operator!(Add, add, _mm512_add_pd);
operator!(Sub, sub, _mm512_sub_pd);
operator!(Mul, mul, _mm512_mul_pd);
operator!(Div, div, _mm512_div_pd);

impl Neg for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Avx512(unsafe { _mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)) })
    }
}

impl Real for Avx512 {
    type Mask = Avx512Mask;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Avx512(unsafe { _mm512_set1_pd(value) })
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Avx512(unsafe { _mm512_fmadd_pd(self.0, factor.0, term.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Avx512(unsafe { _mm512_sqrt_pd(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Avx512(unsafe { _mm512_abs_pd(self.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Avx512(unsafe { _mm512_min_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Avx512(unsafe { _mm512_max_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx512Mask {
        Avx512Mask(unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Avx512Mask {
        Avx512Mask(unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Avx512Mask {
        Avx512Mask(unsafe { _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Avx512Mask, yes: Self, no: Self) -> Self {
        Avx512(unsafe { _mm512_mask_blend_pd(mask.0, no.0, yes.0) })
    }
    #[inline(always)]
    fn exp2_integer(self) -> Self {
        unsafe {
            let shifted = _mm512_castpd_si512(_mm512_add_pd(self.0, _mm512_set1_pd(EXPONENT_MAGIC)));
            Avx512(_mm512_castsi512_pd(_mm512_slli_epi64::<52>(shifted)))
        }
    }
    #[inline(always)]
    fn reciprocal_cbrt_guess(self) -> Self {
        unsafe {
            let upper = _mm512_srli_epi64::<32>(_mm512_castpd_si512(self.0));
            let third = _mm512_srli_epi64::<33>(_mm512_mul_epu32(upper, _mm512_set1_epi64(THIRD as i64)));
            let guess = _mm512_sub_epi64(_mm512_set1_epi64(RECIPROCAL_CBRT_MAGIC as i64), third);
            Avx512(_mm512_castsi512_pd(_mm512_slli_epi64::<32>(guess)))
        }
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

impl Avx512 {
    #[inline(always)]
    fn to_array(self) -> [f64; 8] {
        let mut a = [0.0; 8];
        unsafe { _mm512_storeu_pd(a.as_mut_ptr(), self.0) };
        a
    }
}

/// One index, loaded separately: otherwise the compiler would extract it from the vector that was loaded by the check, at
/// the cost of two instructions on the ports that the arithmetic needs.
#[inline(always)]
fn scalar(index: &[u32; 8], l: usize) -> usize {
    // SAFETY: a reference may be read.
    unsafe { std::ptr::from_ref(&index[l]).read_volatile() as usize }
}

/// Transposes an 8 x 8 block held in eight registers.
#[inline(always)]
fn transpose8(r: [__m512d; 8]) -> [__m512d; 8] {
    unsafe {
        let t0 = _mm512_unpacklo_pd(r[0], r[1]);
        let t1 = _mm512_unpackhi_pd(r[0], r[1]);
        let t2 = _mm512_unpacklo_pd(r[2], r[3]);
        let t3 = _mm512_unpackhi_pd(r[2], r[3]);
        let t4 = _mm512_unpacklo_pd(r[4], r[5]);
        let t5 = _mm512_unpackhi_pd(r[4], r[5]);
        let t6 = _mm512_unpacklo_pd(r[6], r[7]);
        let t7 = _mm512_unpackhi_pd(r[6], r[7]);
        // 128-bit blocks: t0 = (00 10)(02 12)(04 14)(06 16), ...
        let a0 = _mm512_shuffle_f64x2::<0x88>(t0, t2); // blocks 0,2 of t0 and t2
        let a1 = _mm512_shuffle_f64x2::<0x88>(t1, t3);
        let a2 = _mm512_shuffle_f64x2::<0xdd>(t0, t2); // blocks 1,3
        let a3 = _mm512_shuffle_f64x2::<0xdd>(t1, t3);
        let b0 = _mm512_shuffle_f64x2::<0x88>(t4, t6);
        let b1 = _mm512_shuffle_f64x2::<0x88>(t5, t7);
        let b2 = _mm512_shuffle_f64x2::<0xdd>(t4, t6);
        let b3 = _mm512_shuffle_f64x2::<0xdd>(t5, t7);
        [
            _mm512_shuffle_f64x2::<0x88>(a0, b0),
            _mm512_shuffle_f64x2::<0x88>(a1, b1),
            _mm512_shuffle_f64x2::<0x88>(a2, b2),
            _mm512_shuffle_f64x2::<0x88>(a3, b3),
            _mm512_shuffle_f64x2::<0xdd>(a0, b0),
            _mm512_shuffle_f64x2::<0xdd>(a1, b1),
            _mm512_shuffle_f64x2::<0xdd>(a2, b2),
            _mm512_shuffle_f64x2::<0xdd>(a3, b3),
        ]
    }
}

/// Rows of the entries l and l + 4 of the index, side by side.
///
/// # Safety
/// The index must have been checked.
#[inline(always)]
unsafe fn two_rows(rows: &[Row4], index: &[u32; 8], l: usize) -> __m512d {
    unsafe {
        let low = _mm256_load_pd(rows.get_unchecked(scalar(index, l)).0.as_ptr());
        let high = _mm256_load_pd(rows.get_unchecked(scalar(index, l + 4)).0.as_ptr());
        _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high)
    }
}

/// Transposes rows of four, where each register holds the rows l and l + 4.
#[inline(always)]
fn transpose4(r: [__m512d; 4]) -> [__m512d; 4] {
    unsafe {
        let t0 = _mm512_unpacklo_pd(r[0], r[1]); // (00 10)(02 12)(40 50)(42 52)
        let t1 = _mm512_unpackhi_pd(r[0], r[1]);
        let t2 = _mm512_unpacklo_pd(r[2], r[3]);
        let t3 = _mm512_unpackhi_pd(r[2], r[3]);
        let even = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let odd = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        [
            _mm512_permutex2var_pd(t0, even, t2),
            _mm512_permutex2var_pd(t1, even, t3),
            _mm512_permutex2var_pd(t0, odd, t2),
            _mm512_permutex2var_pd(t1, odd, t3),
        ]
    }
}

impl Lanes for Avx512 {
    type Scalar = Fused;
    const REGISTERS: usize = 32;
    const PAIRED: bool = true;
    #[inline(always)]
    fn load(source: &[f64; 8]) -> Self {
        Avx512(unsafe { _mm512_loadu_pd(source.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, target: &mut [f64; 8]) {
        unsafe { _mm512_storeu_pd(target.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn check(index: &[u32; 8], bound: usize) {
        let bound32 = bound.min(u32::MAX as usize) as u32;
        // SAFETY: eight indices are 32 bytes.
        let beyond = unsafe {
            let index = _mm256_loadu_si256(index.as_ptr().cast());
            _mm256_cmpge_epu32_mask(index, _mm256_set1_epi32(bound32 as i32))
        };
        if beyond != 0 {
            no_such_row(index, bound);
        }
    }
    #[inline(always)]
    fn gather8(rows: &[Row8], index: &[u32; 8]) -> [Self; 8] {
        Self::check(index, rows.len());
        // SAFETY: the indices have just been checked.
        let r: [__m512d; 8] = std::array::from_fn(|l| unsafe {
            _mm512_load_pd(rows.get_unchecked(scalar(index, l)).0.as_ptr())
        });
        transpose8(r).map(Avx512)
    }
    #[inline(always)]
    fn gather4(rows: &[Row4], index: &[u32; 8]) -> [Self; 4] {
        Self::check(index, rows.len());
        // SAFETY: the indices have just been checked.
        let row = |l: usize| unsafe { two_rows(rows, index, l) };
        transpose4([row(0), row(1), row(2), row(3)]).map(Avx512)
    }
    #[inline(always)]
    fn differences8(rows: &[Row8], from: &[u32; 8], to: &[u32; 8]) -> [Self; 8] {
        Self::check(from, rows.len());
        Self::check(to, rows.len());
        // SAFETY: the indices have just been checked.
        transpose8(std::array::from_fn(
            #[inline(always)]
            |l| unsafe {
                let (from, to) = (scalar(from, l), scalar(to, l));
                let a = _mm512_load_pd(rows.get_unchecked(from).0.as_ptr());
                let b = _mm512_load_pd(rows.get_unchecked(to).0.as_ptr());
                _mm512_sub_pd(b, a)
            },
        ))
        .map(Avx512)
    }
    #[inline(always)]
    fn sums4(rows: &[Row4], a: &[u32; 8], b: &[u32; 8]) -> [Self; 4] {
        Self::check(a, rows.len());
        Self::check(b, rows.len());
        // SAFETY: the indices have just been checked.
        let sum = |l: usize| unsafe { _mm512_add_pd(two_rows(rows, a, l), two_rows(rows, b, l)) };
        transpose4([sum(0), sum(1), sum(2), sum(3)]).map(Avx512)
    }
    #[inline(always)]
    fn transpose(columns: [Self; 8]) -> [Self; 8] {
        transpose8(columns.map(|c| c.0)).map(Avx512)
    }
    #[inline(always)]
    fn reduce_add8(columns: [Self; 8]) -> Self {
        unsafe {
            // Pairs within each 128-bit block: (x0+x1 y0+y1) (x2+x3 y2+y3) (x4+x5 y4+y5) (x6+x7 y6+y7).
            let pairs =
                |x: Self, y: Self| _mm512_add_pd(_mm512_unpacklo_pd(x.0, y.0), _mm512_unpackhi_pd(x.0, y.0));
            // (0+1)+(2+3) and (4+5)+(6+7) of four values, two 128-bit blocks of each.
            let fours = |p: __m512d, q: __m512d| {
                _mm512_add_pd(_mm512_shuffle_f64x2::<0x88>(p, q), _mm512_shuffle_f64x2::<0xdd>(p, q))
            };
            let c = columns;
            let low = fours(pairs(c[0], c[1]), pairs(c[2], c[3]));
            let high = fours(pairs(c[4], c[5]), pairs(c[6], c[7]));
            Avx512(fours(low, high))
        }
    }
}
