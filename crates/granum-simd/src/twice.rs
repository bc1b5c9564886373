//! Two numbers, or two vectors of lanes, evaluated side by side.
//!
//! In a long formula most operations wait for the result of an earlier one. When two independent evaluations are interleaved
//! operation by operation, each uses the idle times of the other; every lane has the same bits as in a separate evaluation.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::lanes::{Mask, Real};

/// Two reals side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twice<R>(pub R, pub R);

macro_rules! operator {
    ($bound:ident, $trait:ident, $method:ident) => {
        impl<R: $bound> $trait for Twice<R> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Twice($trait::$method(self.0, other.0), $trait::$method(self.1, other.1))
            }
        }
    };
}
operator!(Mask, BitAnd, bitand);
operator!(Mask, BitOr, bitor);
operator!(Real, Add, add);
operator!(Real, Sub, sub);
operator!(Real, Mul, mul);
operator!(Real, Div, div);

impl<R: Mask> Not for Twice<R> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Twice(!self.0, !self.1)
    }
}

impl<R: Real> Neg for Twice<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Twice(-self.0, -self.1)
    }
}

impl<M: Mask> Mask for Twice<M> {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Twice(M::splat(value), M::splat(value))
    }
    #[inline(always)]
    fn any(self) -> bool {
        (self.0 | self.1).any()
    }
    #[inline(always)]
    fn all(self) -> bool {
        (self.0 & self.1).all()
    }
    #[inline(always)]
    fn bits(self) -> u16 {
        self.0.bits() | (self.1.bits() << 8)
    }
}

impl<R: Real> Real for Twice<R> {
    type Mask = Twice<R::Mask>;
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Twice(R::splat(value), R::splat(value))
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Twice(self.0.mul_add(factor.0, term.0), self.1.mul_add(factor.1, term.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Twice(self.0.sqrt(), self.1.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Twice(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Twice(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Twice(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        Twice(self.0.lt(other.0), self.1.lt(other.1))
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        Twice(self.0.le(other.0), self.1.le(other.1))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> Self::Mask {
        Twice(self.0.eq(other.0), self.1.eq(other.1))
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Twice(R::select(mask.0, yes.0, no.0), R::select(mask.1, yes.1, no.1))
    }
    #[inline(always)]
    fn exp2_integer(self) -> Self {
        Twice(self.0.exp2_integer(), self.1.exp2_integer())
    }
    #[inline(always)]
    fn reciprocal_cbrt_guess(self) -> Self {
        Twice(self.0.reciprocal_cbrt_guess(), self.1.reciprocal_cbrt_guess())
    }
    #[inline(always)]
    fn reduce_max(self) -> f64 {
        let (a, b) = (self.0.reduce_max(), self.1.reduce_max());
        Real::max(a, b)
    }
    #[inline(always)]
    fn reduce_add(self) -> f64 {
        self.0.reduce_add() + self.1.reduce_add()
    }
}
