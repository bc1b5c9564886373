//! One number on a processor that fuses multiplication and addition in an instruction, and kernels over single numbers.

#[cfg(target_arch = "x86_64")]
use crate::isa::Isa;
use crate::lanes::Real;

/// A computation over single numbers. `run`, and everything that it calls in its hot loops, must be `#[inline(always)]`, since the
/// calls would otherwise be compiled for the baseline instruction set.
pub trait ScalarKernel {
    /// What it returns.
    type Output;
    /// The computation; numbers of the type `R` are made by [`Real::splat`] and read by [`Real::reduce_add`].
    fn run<R: Real>(self) -> Self::Output;
}

/// Runs a kernel over single numbers, with fused multiplications that are instructions wherever the processor has them.
///
/// ```
/// use granum_simd::{Real, ScalarKernel, fused};
///
/// struct Line(f64);
/// impl ScalarKernel for Line {
///     type Output = f64;
///     #[inline(always)]
///     fn run<R: Real>(self) -> f64 {
///         R::splat(2.0).mul_add(R::splat(self.0), R::splat(1.0)).reduce_add()
///     }
/// }
/// assert_eq!(fused(Line(3.0)), 7.0);
/// ```
#[inline]
pub fn fused<K: ScalarKernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if Isa::Avx2.available() {
        // SAFETY: the processor has just been found to have every feature that the function enables.
        return unsafe { run_fused(kernel) };
    }
    kernel.run::<f64>()
}

/// Computes in plain numbers, compiled for wider instructions where the processor has them. Whatever `compute` calls must be
/// `#[inline(always)]`.
///
/// ```
/// assert_eq!(granum_simd::wide(|| 2.0 * 3.0), 6.0);
/// ```
#[inline]
pub fn wide<T>(compute: impl FnOnce() -> T) -> T {
    #[cfg(target_arch = "x86_64")]
    if Isa::Avx2.available() {
        // SAFETY: as above.
        return unsafe { run_wide(compute) };
    }
    compute()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_fused<K: ScalarKernel>(kernel: K) -> K::Output {
    kernel.run::<Fused>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_wide<T>(compute: impl FnOnce() -> T) -> T {
    compute()
}

#[cfg(target_arch = "x86_64")]
pub(crate) use with_instruction::Fused;

#[cfg(target_arch = "x86_64")]
mod with_instruction {
    use std::ops::{Add, Div, Mul, Neg, Sub};

    use crate::fused::hardware;
    use crate::lanes::Real;

    /// One number whose fused multiplication is an instruction. A plain `f64` asks the processor at each.
    ///
    /// SAFETY of the block here: a value is created only inside [`fused`](super::fused) and [`crate::dispatch()`], after FMA was
    /// detected on the processor.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Fused(f64);

    macro_rules! operator {
        ($trait:ident, $method:ident, $op:tt) => {
            impl $trait for Fused {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Fused(self.0 $op other.0)
                }
            }
        };
    }
    operator!(Add, add, +);
    operator!(Sub, sub, -);
    operator!(Mul, mul, *);
    operator!(Div, div, /);

    impl Neg for Fused {
        type Output = Self;
        #[inline(always)]
        fn neg(self) -> Self {
            Fused(-self.0)
        }
    }

    impl Real for Fused {
        type Mask = bool;
        #[inline(always)]
        fn splat(value: f64) -> Self {
            Fused(value)
        }
        #[inline(always)]
        fn mul_add(self, factor: Self, term: Self) -> Self {
            unsafe { Fused(hardware(self.0, factor.0, term.0)) }
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Fused(self.0.sqrt())
        }
        #[inline(always)]
        fn abs(self) -> Self {
            Fused(self.0.abs())
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Fused(Real::min(self.0, other.0))
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            Fused(Real::max(self.0, other.0))
        }
        #[inline(always)]
        fn lt(self, other: Self) -> bool {
            self.0 < other.0
        }
        #[inline(always)]
        fn le(self, other: Self) -> bool {
            self.0 <= other.0
        }
        #[inline(always)]
        fn eq(self, other: Self) -> bool {
            self.0 == other.0
        }
        #[inline(always)]
        fn select(mask: bool, yes: Self, no: Self) -> Self {
            if mask { yes } else { no }
        }
        #[inline(always)]
        fn exp2_integer(self) -> Self {
            Fused(self.0.exp2_integer())
        }
        #[inline(always)]
        fn reciprocal_cbrt_guess(self) -> Self {
            Fused(self.0.reciprocal_cbrt_guess())
        }
        #[inline(always)]
        fn reduce_max(self) -> f64 {
            self.0
        }
        #[inline(always)]
        fn reduce_add(self) -> f64 {
            self.0
        }
    }
}
