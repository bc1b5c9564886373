//! The traits that a formula is written against.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::rows::{Row4, Row8};

/// A truth value per lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// The same truth value in every lane.
    fn splat(value: bool) -> Self;
    /// True if any lane is true.
    fn any(self) -> bool;
    /// True if every lane is true.
    fn all(self) -> bool;
    /// One bit for each lane, lane 0 in bit 0; the second half of [`crate::Twice`] starts at bit 8.
    fn bits(self) -> u16;
}

/// A real number, or eight of them side by side.
///
/// Comparisons follow IEEE 754 (false when an operand is NaN). [`Real::min`] and [`Real::max`]
/// return the second operand when either is NaN, as the x86 instructions do.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The truth values that result from comparisons.
    type Mask: Mask;
    /// The same number in every lane.
    fn splat(value: f64) -> Self;
    /// `self * factor + term`, rounded once. A plain `f64` computes [`mul_add`](crate::mul_add()).
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller: `if self < other { self } else { other }`.
    fn min(self, other: Self) -> Self;
    /// The larger: `if self > other { self } else { other }`.
    fn max(self, other: Self) -> Self;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// `self == other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// `yes` where the mask is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Two to the power of an integral number between -1022 and 1023.
    fn exp2_integer(self) -> Self;
    /// An estimate of the reciprocal cube root of a positive number, accurate to 4 %: the exponent is divided by minus three
    /// in integer arithmetic on the upper 32 bits, identically on every instruction set.
    fn reciprocal_cbrt_guess(self) -> Self;
    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    /// `if mask { self } else { 0 }`.
    #[inline(always)]
    fn keep(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, Self::zero())
    }
    /// The largest lane (or the number itself).
    fn reduce_max(self) -> f64;
    /// The sum of the lanes in a fixed order: ((0+1)+(2+3)) + ((4+5)+(6+7)).
    fn reduce_add(self) -> f64;
}

/// Eight [`Real`] lanes, with the memory operations of a batch.
pub trait Lanes: Real {
    /// One number beside the lanes, whose fused multiplications are those of the instruction set; a plain `f64` in a kernel would ask
    /// the processor at each.
    type Scalar: Real;
    /// Number of values of this type that fit into the vector registers of the processor: the limit for a register-blocked
    /// loop.
    const REGISTERS: usize;
    /// True if a long formula is faster for two batches side by side ([`crate::Twice`]) than for one after the other. With the 16
    /// registers of AVX2 it is not: measured, 5000 grains gain 4 % alone with compiled laws.
    const PAIRED: bool;
    /// Loads eight numbers.
    fn load(source: &[f64; 8]) -> Self;
    /// Stores eight numbers.
    fn store(self, target: &mut [f64; 8]);
    /// Panics unless every index is below `bound`.
    fn check(index: &[u32; 8], bound: usize);
    /// Lane `l` of entry `c` of the result is `rows[index[l]].0[c]`. Panics if an index is out of range.
    fn gather8(rows: &[Row8], index: &[u32; 8]) -> [Self; 8];
    /// The same as [`Lanes::gather8`] for rows of four.
    fn gather4(rows: &[Row4], index: &[u32; 8]) -> [Self; 4];
    /// `gather8(rows, to) - gather8(rows, from)`, subtracted row by row, which halves the number of shuffles.
    fn differences8(rows: &[Row8], from: &[u32; 8], to: &[u32; 8]) -> [Self; 8];
    /// `gather4(rows, a) + gather4(rows, b)`.
    fn sums4(rows: &[Row4], a: &[u32; 8], b: &[u32; 8]) -> [Self; 4];
    /// Lane `c` of entry `l` of the result is lane `l` of `columns[c]`.
    fn transpose(columns: [Self; 8]) -> [Self; 8];
    /// Entry `c` of row `l` becomes lane `l` of `columns[c]`.
    #[inline(always)]
    fn scatter8(columns: [Self; 8], rows: &mut [Row8; 8]) {
        let turned = Self::transpose(columns);
        for l in 0..8 {
            turned[l].store(&mut rows[l].0);
        }
    }
    /// Lane `l` of the result is `columns[l].reduce_add()`, with the same bits.
    fn reduce_add8(columns: [Self; 8]) -> Self;
}

/// Panics with the row that is out of bounds; a separate function, so that the checking loops stay small.
#[cold]
#[inline(never)]
pub(crate) fn no_such_row(index: &[u32; 8], bound: usize) -> ! {
    let largest = index.iter().max().copied().unwrap_or(0);
    panic!("row {largest} of {bound}");
}
