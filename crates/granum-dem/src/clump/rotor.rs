//! Rotation of a rigid body in a step: its angular momentum is given, and it turns as the free rotor by three exact rotations.
//!
//! With the intermediate moment `I_m`, the largest `I_a` and the smallest `I_b` the energy of rotation is
//! `|L|^2 / (2 I_m) + L_a^2/2 (1/I_a - 1/I_m) + L_b^2/2 (1/I_b - 1/I_m)`. The flow of the first term is a rotation about L and commutes with
//! the others; those are rotations about axes of the body, applied as `a/2, b, a/2`. Each is exact but for its angle, which comes from
//! `tan(x/2) = x/2 (1 + x^2/12)`: a function of conserved numbers, so that the whole is symplectic and reversible, leaves the angular
//! momentum as it is, and is exact for a body with two equal moments. It needs no function of the platform.

use granum_core::rotation::{Quaternion, matrix, to_body, to_space};
use granum_simd::Real;

use crate::assembly::Vector;

/// `tan(x/2)` to the third order.
#[inline(always)]
fn half_tangent<R: Real>(x: R) -> R {
    let square = x * x;
    R::splat(0.5) * x * square.mul_add(R::splat(1.0 / 12.0), R::splat(1.0))
}

/// The product of two quaternions: first the rotation `b`, then `a`.
#[inline(always)]
fn product<R: Real>(a: &[R; 4], b: &[R; 4]) -> [R; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The matrix of a rotation: its columns are the axes of the body in space.
#[inline(always)]
pub(crate) fn axes<R: Real>(q: &[R; 4]) -> [[R; 3]; 3] {
    let [w, x, y, z] = *q;
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    [
        [one - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)],
        [two * (x * y + w * z), one - two * (x * x + z * z), two * (y * z - w * x)],
        [two * (x * z - w * y), two * (y * z + w * x), one - two * (x * x + y * y)],
    ]
}

/// One of the three rotations: about an axis of the body, whose moment has the reciprocal that differs by `difference` from that of the
/// intermediate moment. Turns the angular momentum in the axes of the body, and the orientation.
#[inline(always)]
fn turn<R: Real>(axis: usize, dt: R, difference: R, of_body: &mut [R; 3], q: &mut [R; 4]) {
    let tangent = half_tangent(of_body[axis] * dt * difference);
    let square = tangent * tangent;
    let reciprocal = R::splat(1.0) / (R::splat(1.0) + square);
    let cosine = (R::splat(1.0) - square) * reciprocal;
    let sine = (tangent + tangent) * reciprocal;
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (a, b) = (of_body[i], of_body[j]);
    (of_body[i], of_body[j]) = (cosine * a + sine * b, cosine * b - sine * a);
    let mut about = [R::zero(); 4];
    (about[0], about[axis + 1]) = (R::splat(1.0), tangent);
    *q = product(q, &about);
}

/// The orientation of a body after a time `dt`, s, with a constant angular momentum, kg m2/s, in the axes of space. Its moments of inertia,
/// kg m2, rise.
#[inline(always)]
pub(crate) fn turned<R: Real>(orientation: &[R; 4], momentum: &[R; 3], inertia: &[R; 3], dt: R) -> [R; 4] {
    let [x, y, z] = *momentum;
    let rotation = axes(orientation);
    let mut of_body = [R::zero(); 3];
    for c in 0..3 {
        of_body[c] = rotation[0][c] * x + rotation[1][c] * y + rotation[2][c] * z;
    }
    let size = (x * x + y * y + z * z).sqrt();
    let one = R::splat(1.0);
    let middle = one / inertia[1];
    let factor = half_tangent(size * dt * middle) / size;
    // Without angular momentum there is no axis.
    let factor = R::select(size.gt(R::zero()), factor, R::zero());
    let mut q = product(&[one, factor * x, factor * y, factor * z], orientation);
    let (half, least, largest) = (R::splat(0.5) * dt, one / inertia[0] - middle, one / inertia[2] - middle);
    turn(2, half, largest, &mut of_body, &mut q);
    turn(0, dt, least, &mut of_body, &mut q);
    turn(2, half, largest, &mut of_body, &mut q);
    let length = one / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    [q[0] * length, q[1] * length, q[2] * length, q[3] * length]
}

/// The mean spin, rad/s, of a step of length `dt` between two orientations: `2/dt vec(dq)/dq_0` with `dq = q_new q_old*`. With it the arm c of a
/// point of the body changes by exactly `dt omega x (c_old + c_new) / 2`.
#[inline(always)]
pub(crate) fn mean_spin<R: Real>(before: &[R; 4], after: &[R; 4], dt: R) -> [R; 3] {
    let change = product(after, &[before[0], -before[1], -before[2], -before[3]]);
    let factor = R::splat(2.0) / (dt * change[0]);
    [factor * change[1], factor * change[2], factor * change[3]]
}

/// The spin of a body with an angular momentum, rad/s: `R I^-1 R^T L`.
pub(crate) fn spin(orientation: &Quaternion, momentum: &Vector, inertia: &Vector) -> Vector {
    let rotation = matrix(orientation);
    let of_body = to_body(&rotation, momentum);
    to_space(&rotation, &[of_body[0] / inertia[0], of_body[1] / inertia[1], of_body[2] / inertia[2]])
}

/// The angular momentum of a body with a spin, rad/s: `R I R^T omega`.
pub(crate) fn momentum(orientation: &Quaternion, spin: &Vector, inertia: &Vector) -> Vector {
    let rotation = matrix(orientation);
    let of_body = to_body(&rotation, spin);
    to_space(&rotation, &[of_body[0] * inertia[0], of_body[1] * inertia[1], of_body[2] * inertia[2]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::geometry::cross;
    use granum_core::rotation::IDENTITY;

    /// Energy of rotation, J.
    fn energy(q: &Quaternion, momentum: &Vector, inertia: &Vector) -> f64 {
        let l = to_body(&matrix(q), momentum);
        0.5 * (0..3).map(|k| l[k] * l[k] / inertia[k]).sum::<f64>()
    }

    /// The spin in the axes of the body.
    fn spin_of_body(q: &Quaternion, l: &Vector, inertia: &Vector) -> Vector {
        let l = to_body(&matrix(q), l);
        [l[0] / inertia[0], l[1] / inertia[1], l[2] / inertia[2]]
    }

    /// The time between two passages of the third component of the spin through zero in the same direction, from linear interpolation
    /// between steps.
    fn period(inertia: &Vector, spin: &Vector, dt: f64, component: usize) -> f64 {
        let l = momentum(&IDENTITY, spin, inertia);
        let (mut q, mut last, mut passages) = (IDENTITY, spin[component], Vec::new());
        for step in 1..200_000 {
            q = turned(&q, &l, inertia, dt);
            let now = spin_of_body(&q, &l, inertia)[component];
            if last < 0.0 && now >= 0.0 {
                passages.push((step as f64 - now / (now - last)) * dt);
                if passages.len() == 2 {
                    return passages[1] - passages[0];
                }
            }
            last = now;
        }
        panic!("no period");
    }

    #[test]
    fn the_period_of_a_free_body_is_that_of_the_elliptic_integral() {
        let found = period(&[1.0, 1.5, 2.2], &[0.3, 1.0, 0.2], 0.01, 0);
        assert!((found / 29.1599627024 - 1.0).abs() < 2e-6, "{found}");
    }

    /// A body that turns about the axis of its intermediate moment turns over, the later the smaller the disturbance.
    #[test]
    fn tumbling_takes_the_time_that_theory_gives() {
        for (disturbance, golden) in [(1e-2, 55.7384094207), (1e-4, 101.926827195)] {
            let found = period(&[1.0, 1.5, 2.2], &[disturbance, 1.0, disturbance], 0.01, 1);
            assert!((found / golden - 1.0).abs() < 5e-6, "{found} {golden}");
        }
    }

    /// A symmetric top precesses about its angular momentum: the error of a step is that of the tangent alone.
    #[test]
    fn a_symmetric_top_precesses() {
        let inertia = [1.0, 1.0, 2.0];
        let l = momentum(&IDENTITY, &[0.6, 0.0, 1.0], &inertia);
        for (time, golden) in [
            (1, [0.8381512182, 0.2179865241, 0.1190865809, 0.4855953017]),
            (10, [0.6309509307, -0.0692636509, 0.2341468112, -0.7363957771]),
        ] {
            let mut q = IDENTITY;
            let dt = 1.0 / 256.0;
            for _ in 0..256 * time {
                q = turned(&q, &l, &inertia, dt);
            }
            let sign = if q[0] * golden[0] < 0.0 { -1.0 } else { 1.0 };
            for k in 0..4 {
                assert!((sign * q[k] - golden[k]).abs() < 2e-9, "{q:?} {golden:?}");
            }
        }
    }

    #[test]
    fn the_energy_of_a_free_body_has_no_drift_and_a_reversed_step_returns() {
        let inertia = [1.0, 1.5, 2.2];
        let l = momentum(&IDENTITY, &[0.3, 1.0, 0.2], &inertia);
        let first = energy(&IDENTITY, &l, &inertia);
        let (mut q, mut largest, mut means) = (IDENTITY, 0.0f64, [0.0; 10]);
        for step in 0..100_000 {
            q = turned(&q, &l, &inertia, 0.1);
            let error = energy(&q, &l, &inertia) / first - 1.0;
            largest = largest.max(error.abs());
            means[step / 10_000] += error / 1e4;
        }
        assert!(largest < 6e-5, "{largest:e}");
        assert!((means[9] - means[0]).abs() < 1e-6, "{means:?}");
        let back = turned(&turned(&q, &l, &inertia, 0.1), &l, &inertia, -0.1);
        assert!((0..4).all(|k| (back[k] - q[k]).abs() < 1e-14), "{back:?} {q:?}");
    }

    #[test]
    fn the_mean_spin_moves_every_point_to_its_new_place() {
        let inertia = [1.0, 1.5, 2.2];
        let l = momentum(&IDENTITY, &[0.3, 1.0, -0.7], &inertia);
        let q = turned(&IDENTITY, &l, &inertia, 0.3);
        let mean = mean_spin(&IDENTITY, &q, 0.3);
        let arm = [0.4, -0.2, 0.9];
        let after = to_space(&matrix(&q), &arm);
        let middle = std::array::from_fn(|k| 0.5 * (arm[k] + after[k]));
        let moved = cross(&mean, &middle);
        for k in 0..3 {
            assert!((after[k] - arm[k] - 0.3 * moved[k]).abs() < 1e-15);
        }
        let given = spin(&q, &l, &inertia);
        let again = momentum(&q, &given, &inertia);
        assert!((0..3).all(|k| (again[k] - l[k]).abs() < 1e-15));
    }
}
