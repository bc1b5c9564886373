//! A spring with a slider, in the plane of rolling or about the normal: the common part of the elastic-plastic laws.

use granum_simd::Real;
use granum_simd::vectors::dot;

/// Result of a step.
pub(super) struct Slid<R: Real, const D: usize> {
    /// The couple at its end, N m.
    pub(super) couple: [R; D],
    /// Where it is at its limit.
    pub(super) at_limit: R::Mask,
    /// Work absorbed by the couple, J.
    pub(super) work: R,
    /// The part of the work that is not stored, J.
    pub(super) loss: R,
}

/// Rotates a spring by an angle, rad, given the couple before, N m, the stiffness before and now, N m, and the limit of the couple,
/// N m.
///
/// Where the stiffness has decreased the couple is reduced in proportion, so that unloading does not create energy.
#[inline(always)]
pub(super) fn slide<R: Real, const D: usize>(
    held: [R; D],
    before: R,
    stiffness: R,
    limit: R,
    turned: [R; D],
) -> Slid<R, D> {
    let (one, half, tiny) = (R::splat(1.0), R::splat(0.5), R::splat(1e-200));
    let kept = (stiffness / before.max(tiny)).min(one);
    let mut trial = held;
    for k in 0..D {
        trial[k] = stiffness.mul_add(turned[k], kept * held[k]);
    }
    let at_limit = dot(trial, trial).ge(limit * limit);
    let factor = R::select(at_limit, limit / dot(trial, trial).sqrt().max(tiny), one);
    let (mut couple, mut sum) = (trial, held);
    for k in 0..D {
        couple[k] = factor * trial[k];
        sum[k] = held[k] + couple[k];
    }
    let work = half * dot(sum, turned);
    let gained = energy(couple, stiffness) - energy(held, before);
    Slid { couple, at_limit, work, loss: work - gained }
}

/// `M^2 / 2 k`. Without a couple there is no energy, even where the stiffness is zero.
///
/// This is a function and not a closure: a closure that is not inlined would be compiled without vector instructions.
#[inline(always)]
fn energy<R: Real, const D: usize>(couple: [R; D], stiffness: R) -> R {
    R::splat(0.5) * dot(couple, couple) / stiffness.max(R::splat(1e-200))
}

/// Energy of a spring with a couple, J: `M^2 / 2 k`.
pub(super) fn stored<const D: usize>(couple: [f64; D], stiffness: f64) -> f64 {
    if stiffness > 0.0 { 0.5 * dot(couple, couple) / stiffness } else { 0.0 }
}
