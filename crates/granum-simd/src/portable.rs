//! A single `f64`, and eight of them in an array: the reference that the vector types must match bit for bit.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::fused::mul_add;
use crate::lanes::{Lanes, Mask, Real, no_such_row};
use crate::rows::{Row4, Row8};
use crate::scalar::{ScalarKernel, fused};

impl Mask for bool {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        self as u16
    }
}

/// 2^52 + 1023: adding it to an integral number stores number + 1023 in the low bits.
pub(crate) const EXPONENT_MAGIC: f64 = 4_503_599_627_370_496.0 + 1023.0;
/// Upper half of the constant for the initial estimate of the reciprocal cube root.
pub(crate) const RECIPROCAL_CBRT_MAGIC: u32 = 0x553e_f0ff;
/// Multiplication by this number and a shift by 33 bits divides a 32-bit number by three.
pub(crate) const THIRD: u32 = 0xAAAA_AAAB;

impl Real for f64 {
    type Mask = bool;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        mul_add(self, factor, term)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn exp2_integer(self) -> Self {
        f64::from_bits((self + EXPONENT_MAGIC).to_bits() << 52)
    }
    #[inline(always)]
    fn reciprocal_cbrt_guess(self) -> Self {
        let upper = (self.to_bits() >> 32) as u32;
        let third = ((upper as u64 * THIRD as u64) >> 33) as u32;
        f64::from_bits((RECIPROCAL_CBRT_MAGIC.wrapping_sub(third) as u64) << 32)
    }
    #[inline(always)]
    fn reduce_max(self) -> f64 {
        self
    }
    #[inline(always)]
    fn reduce_add(self) -> f64 {
        self
    }
}

/// Eight lanes in an array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Portable(pub [f64; 8]);

/// Eight truth values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PortableMask([bool; 8]);

impl PortableMask {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(bool, bool) -> bool) -> Self {
        PortableMask(std::array::from_fn(|l| f(self.0[l], other.0[l])))
    }
}
impl BitAnd for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        self.zip(other, |a, b| a & b)
    }
}
impl BitOr for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        self.zip(other, |a, b| a | b)
    }
}
impl Not for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        PortableMask(self.0.map(|a| !a))
    }
}
impl Mask for PortableMask {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        PortableMask([value; 8])
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.iter().any(|&a| a)
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.iter().all(|&a| a)
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        self.0.iter().enumerate().fold(0, |bits, (l, &a)| bits | ((a as u16) << l))
    }
}

impl Portable {
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Portable(self.0.map(f))
    }
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Portable(std::array::from_fn(|l| f(self.0[l], other.0[l])))
    }
    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> PortableMask {
        PortableMask(std::array::from_fn(|l| f(self.0[l], other.0[l])))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Portable {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $op b)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Portable {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

/// `factor` times `other` plus `term` in every lane. The baseline of x86-64 has no fused multiplication and asks the processor
/// for it: one question for eight lanes takes less time and an eighth of the code.
#[cfg_attr(target_arch = "x86_64", inline(never))]
#[cfg_attr(not(target_arch = "x86_64"), inline(always))]
fn fused_lanes(factor: Portable, other: Portable, term: Portable) -> Portable {
    fused(EachLane([factor, other, term]))
}

struct EachLane([Portable; 3]);

impl ScalarKernel for EachLane {
    type Output = Portable;
    #[inline(always)]
    fn run<R: Real>(self) -> Portable {
        let [factor, other, term] = self.0.map(|lanes| lanes.0);
        Portable(std::array::from_fn(
            #[inline(always)]
            |l| R::splat(factor[l]).mul_add(R::splat(other[l]), R::splat(term[l])).reduce_add(),
        ))
    }
}

impl Real for Portable {
    type Mask = PortableMask;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Portable([value; 8])
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        fused_lanes(self, factor, term)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, Real::min)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, Real::max)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a < b)
    }
    #[inline(always)]
    fn le(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn eq(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a == b)
    }
    #[inline(always)]
    fn select(mask: PortableMask, yes: Self, no: Self) -> Self {
        Portable(std::array::from_fn(|l| if mask.0[l] { yes.0[l] } else { no.0[l] }))
    }
    #[inline(always)]
    fn exp2_integer(self) -> Self {
        self.map(Real::exp2_integer)
    }
    #[inline(always)]
    fn reciprocal_cbrt_guess(self) -> Self {
        self.map(Real::reciprocal_cbrt_guess)
    }
    #[inline(always)]
    fn reduce_max(self) -> f64 {
        self.0.iter().fold(f64::NEG_INFINITY, |m, &a| Real::max(a, m))
    }
    #[inline(always)]
    fn reduce_add(self) -> f64 {
        let a = self.0;
        ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]))
    }
}

impl Lanes for Portable {
    type Scalar = f64;
    const REGISTERS: usize = 4;
    const PAIRED: bool = false;
    #[inline(always)]
    fn load(source: &[f64; 8]) -> Self {
        Portable(*source)
    }
    #[inline(always)]
    fn store(self, target: &mut [f64; 8]) {
        *target = self.0;
    }
    #[inline(always)]
    fn check(index: &[u32; 8], bound: usize) {
        let largest = index.iter().fold(0, |most, &i| if i > most { i } else { most });
        if largest as usize >= bound {
            no_such_row(index, bound);
        }
    }
    #[inline(always)]
    fn gather8(rows: &[Row8], index: &[u32; 8]) -> [Self; 8] {
        let row: [&Row8; 8] = index.map(|i| &rows[i as usize]);
        std::array::from_fn(|c| Portable(std::array::from_fn(|l| row[l].0[c])))
    }
    #[inline(always)]
    fn gather4(rows: &[Row4], index: &[u32; 8]) -> [Self; 4] {
        let row: [&Row4; 8] = index.map(|i| &rows[i as usize]);
        std::array::from_fn(|c| Portable(std::array::from_fn(|l| row[l].0[c])))
    }
    #[inline(always)]
    fn differences8(rows: &[Row8], from: &[u32; 8], to: &[u32; 8]) -> [Self; 8] {
        let (a, b) = (Self::gather8(rows, from), Self::gather8(rows, to));
        std::array::from_fn(|c| b[c] - a[c])
    }
    #[inline(always)]
    fn sums4(rows: &[Row4], a: &[u32; 8], b: &[u32; 8]) -> [Self; 4] {
        let (a, b) = (Self::gather4(rows, a), Self::gather4(rows, b));
        std::array::from_fn(|c| a[c] + b[c])
    }
    #[inline(always)]
    fn transpose(columns: [Self; 8]) -> [Self; 8] {
        std::array::from_fn(|l| Portable(std::array::from_fn(|c| columns[c].0[l])))
    }
    #[inline(always)]
    fn reduce_add8(columns: [Self; 8]) -> Self {
        Portable(columns.map(Real::reduce_add))
    }
}
