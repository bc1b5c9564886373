//! How far a bond is stretched, sheared, bent and twisted, from the places and orientations of its two ends.
//!
//! When a bond is made, a frame `Q_0` whose first axis joins the pieces is stored with both ends, `Q_i = q_i* Q_0` and `Q_j = q_j* Q_0`. Later
//! ```text
//! A = q_i Q_i,  B = q_j Q_j (or -B, whichever is nearer to A),  Q_m = (A + B)/|A + B|,
//! P = A* B,  phi = 2 vec(P)/P_0,  u = R(Q_m)^T d,
//! ```
//! where d is the distance of the two points of attachment. Everything follows from the present places: nothing drifts, a rigid motion gives
//! exactly zero, and the order of the ends does not matter. The force `R(Q_m) f` acts on both ends at the middle of the two points, so that
//! angular momentum is conserved exactly.

use granum_simd::Real;
use granum_simd::vectors::{add_scaled, dot, scale};

/// A rotation in each lane, `[w, x, y, z]`.
pub(super) type Turn<R> = [R; 4];
/// A vector in each lane.
pub(super) type Vectors<R> = [R; 3];

/// The product of two quaternions: first the rotation `b`, then `a`.
#[inline(always)]
pub(super) fn product<R: Real>(a: &Turn<R>, b: &Turn<R>) -> Turn<R> {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The same with the rotation `a` reversed.
#[inline(always)]
fn reversed_product<R: Real>(a: &Turn<R>, b: &Turn<R>) -> Turn<R> {
    product(&[a[0], -a[1], -a[2], -a[3]], b)
}

/// A quaternion with the length one.
#[inline(always)]
fn normalized<R: Real>(q: Turn<R>) -> Turn<R> {
    scale(R::splat(1.0) / dot(q, q).sqrt(), q)
}

/// The orientation of a sphere after a step with a constant spin, rad/s: `(1, omega dt/2)`, made one long, times the orientation. The mean
/// spin of rigid bodies of several pieces is defined by the same relation.
#[inline(always)]
pub(super) fn turned<R: Real>(q: &Turn<R>, spin: &Vectors<R>, dt: R) -> Turn<R> {
    let half = R::splat(0.5) * dt;
    normalized(product(&[R::splat(1.0), half * spin[0], half * spin[1], half * spin[2]], q))
}

/// The axes of a frame as vectors in space.
#[inline(always)]
fn axes<R: Real>(q: &Turn<R>) -> [Vectors<R>; 3] {
    let [w, x, y, z] = *q;
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    [
        [one - two * (y * y + z * z), two * (x * y + w * z), two * (x * z - w * y)],
        [two * (x * y - w * z), one - two * (x * x + z * z), two * (y * z + w * x)],
        [two * (x * z + w * y), two * (y * z - w * x), one - two * (x * x + y * y)],
    ]
}

/// The first axis of a frame.
#[inline(always)]
fn first_axis<R: Real>(q: &Turn<R>) -> Vectors<R> {
    let [w, x, y, z] = *q;
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    [one - two * (y * y + z * z), two * (x * y + w * z), two * (x * z - w * y)]
}

/// The two ends of a bond.
pub(super) struct Ends<R> {
    /// Orientations `q_i` and `q_j` of the pieces.
    pub(super) orientations: [Turn<R>; 2],
    /// The frame of the bond in the axes of each.
    pub(super) frames: [Turn<R>; 2],
    /// Distances of the point of attachment from the centres, m.
    pub(super) arms: [R; 2],
    /// From the centre of piece i to that of j, m.
    pub(super) branch: Vectors<R>,
}

/// What a bond has become.
pub(super) struct Strained<R> {
    /// Axes of the middle frame.
    pub(super) axes: [Vectors<R>; 3],
    /// Stretch and the two shear displacements, m.
    pub(super) displacement: Vectors<R>,
    /// Twist and the two bending angles, `2 tan(angle/2)`.
    pub(super) rotation: Vectors<R>,
    /// From the centres of the pieces to the point at which the force acts, m.
    pub(super) levers: [Vectors<R>; 2],
}

/// What a bond has become, from where its ends are.
#[inline(always)]
pub(super) fn strained<R: Real>(ends: &Ends<R>) -> Strained<R> {
    let a = product(&ends.orientations[0], &ends.frames[0]);
    let b = product(&ends.orientations[1], &ends.frames[1]);
    let opposite = dot(a, b).lt(R::zero());
    let mut near = b;
    for k in 0..4 {
        near[k] = R::select(opposite, -b[k], b[k]);
    }
    let middle = normalized([a[0] + near[0], a[1] + near[1], a[2] + near[2], a[3] + near[3]]);
    let between = reversed_product(&a, &near);
    let factor = R::splat(2.0) / between[0];
    let rotation = [factor * between[1], factor * between[2], factor * between[3]];
    let (of_first, of_second) = (scale(ends.arms[0], first_axis(&a)), scale(ends.arms[1], first_axis(&near)));
    let mut apart = ends.branch;
    for k in 0..3 {
        apart[k] = ends.branch[k] - of_second[k] - of_first[k];
    }
    let axes = axes(&middle);
    let displacement = [dot(axes[0], apart), dot(axes[1], apart), dot(axes[2], apart)];
    let half = R::splat(0.5);
    let levers =
        [add_scaled(of_first, half, apart), add_scaled(scale(R::splat(-1.0), of_second), -half, apart)];
    Strained { axes, displacement, rotation, levers }
}

/// Components along the axes, as a vector in space.
#[inline(always)]
pub(super) fn in_space<R: Real>(axes: &[Vectors<R>; 3], components: &Vectors<R>) -> Vectors<R> {
    let sum = scale(components[0], axes[0]);
    add_scaled(add_scaled(sum, components[1], axes[1]), components[2], axes[2])
}

/// A vector in space, as components along the axes.
#[inline(always)]
pub(super) fn in_axes<R: Real>(axes: &[Vectors<R>; 3], vector: &Vectors<R>) -> Vectors<R> {
    [dot(axes[0], *vector), dot(axes[1], *vector), dot(axes[2], *vector)]
}

/// A frame whose first axis has a direction: the shortest rotation that brings the axis x there.
pub(super) fn frame_along(direction: &Vectors<f64>) -> Turn<f64> {
    let length = dot(*direction, *direction).sqrt();
    let [x, y, z] = scale(1.0 / length, *direction);
    if x < -0.999_999 {
        // Half a turn about any axis across; z is one.
        return normalized([-y, 0.0, -z * 0.0, 1.0 - x]);
    }
    normalized([1.0 + x, 0.0, -z, y])
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::rotation::{IDENTITY, about, conjugate, matrix, to_space};
    use granum_simd::vectors::cross;

    /// `k_n A, k_s A, k_n I, k_s J`.
    const STIFFNESS: [f64; 4] = [1000.0, 400.0, 20.0, 16.0];

    /// Force on i, couple about the centre of i, couple about the centre of j, and energy of a bond that was made between two places, whose
    /// ends are now elsewhere.
    fn loads(
        places: [[f64; 3]; 2],
        turns: [Turn<f64>; 2],
        made: &Turn<f64>,
    ) -> ([f64; 3], [f64; 3], [f64; 3], f64) {
        let ends = Ends {
            orientations: turns,
            frames: [*made; 2],
            arms: [0.5; 2],
            branch: std::array::from_fn(|k| places[1][k] - places[0][k]),
        };
        let s = strained(&ends);
        let [kn, ks, kb, kt] = STIFFNESS;
        let (u, phi) = (s.displacement, s.rotation);
        let force = in_space(&s.axes, &[kn * u[0], ks * u[1], ks * u[2]]);
        let couple = in_space(&s.axes, &[kt * phi[0], kb * phi[1], kb * phi[2]]);
        let moment = |lever: [f64; 3], sign: f64| {
            let turning = cross(lever, force);
            std::array::from_fn(|k| sign * (couple[k] + turning[k]))
        };
        let energy = 0.5 * (kn * u[0] * u[0] + ks * (u[1] * u[1] + u[2] * u[2]))
            + 0.5 * (kt * phi[0] * phi[0] + kb * (phi[1] * phi[1] + phi[2] * phi[2]));
        (force, moment(s.levers[0], 1.0), moment(s.levers[1], -1.0), energy)
    }

    fn near(found: [f64; 3], right: [f64; 3], tolerance: f64) {
        for k in 0..3 {
            assert!((found[k] - right[k]).abs() < tolerance, "{found:?} {right:?}");
        }
    }

    /// A fault of other programs: the force depended on which end was named first.
    #[test]
    fn the_force_does_not_depend_on_the_order_of_the_ends() {
        let places = [[0.0; 3], [1.01, 0.02, 0.0]];
        let turn = about(&[0.0, 0.0, 1.0], 0.4);
        let made = frame_along(&[1.0, 0.0, 0.0]);
        let (force, of_first, of_second, energy) = loads(places, [IDENTITY, turn], &made);
        near(force, [27.887_494_235_3, -68.241_779_398_8, 0.0], 1e-9);
        near(of_first, [0.0, 0.0, -25.264_331_232_7], 1e-9);
        near(of_second, [0.0, 0.0, -44.217_615_844_9], 1e-9);
        assert!((energy - 8.294_676_938_1).abs() < 1e-9);
        // The ends swapped: the bond was made from (1, 0, 0) to the origin.
        let swapped = loads([places[1], places[0]], [turn, IDENTITY], &frame_along(&[-1.0, 0.0, 0.0]));
        near(swapped.0, force.map(|x| -x), 1e-12);
        near(swapped.1, of_second, 1e-12);
        near(swapped.2, of_first, 1e-12);
        // The other sign of a quaternion, and another azimuth of the frame.
        for (turn, made) in [(turn.map(|x| -x), made), (turn, product(&made, &about(&[1.0, 0.0, 0.0], 0.7)))]
        {
            let other = loads(places, [IDENTITY, turn], &made);
            near(other.0, force, 1e-12);
            near(other.1, of_first, 1e-12);
            near(other.2, of_second, 1e-12);
            assert!((other.3 - energy).abs() < 1e-12);
        }
    }

    #[test]
    fn rigid_motion_loads_nothing() {
        let direction = [0.36, -0.48, 0.8];
        let made = frame_along(&direction);
        near(first_axis(&made), direction, 1e-15);
        for turn in [about(&[1.0, 2.0, -0.5], 2.9), about(&[0.3, 0.0, 1.0], -1.3)] {
            let branch = to_space(&matrix(&turn), &direction);
            let (force, of_first, of_second, energy) = loads([[0.0; 3], branch], [turn; 2], &made);
            near(force, [0.0; 3], 1e-12);
            near(of_first, [0.0; 3], 1e-12);
            near(of_second, [0.0; 3], 1e-12);
            assert!(energy < 1e-24);
        }
    }

    #[test]
    fn frames_lie_along_any_direction() {
        for direction in
            [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [-1.0, 1e-9, -1e-9], [0.0, 0.0, 2.0], [-3.0, 0.1, 0.2]]
        {
            let length = dot(direction, direction).sqrt();
            let frame = frame_along(&direction);
            near(first_axis(&frame), direction.map(|x| x / length), 1e-8);
            assert!((dot(frame, frame) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn spheres_turn_by_their_spin() {
        let (dt, steps) = (1e-3, 1000);
        let spin = [0.4, -0.2, 0.7];
        let mut q = IDENTITY;
        for _ in 0..steps {
            q = turned(&q, &spin, dt);
        }
        let exact = about(&spin, dot(spin, spin).sqrt());
        let error = product(&conjugate(&exact), &q);
        assert!(error[1..].iter().all(|x| x.abs() < 1e-7), "{error:?}");
    }

    /// `bond bpm/rotational` of LAMMPS (version of July 2025, neither smoothed nor damped) for the same four stiffnesses: the formulas meet to
    /// the second order in displacement and angle (`benches/peers/lammps/bonds.py`).
    #[test]
    fn small_displacements_load_as_in_lammps() {
        let turn = about(&[0.003, 0.002, -0.001], 14e-6f64.sqrt());
        let made = frame_along(&[1.0, 0.0, 0.0]);
        let (force, of_first, of_second, _) =
            loads([[0.0; 3], [1.001, 0.002, 0.0015]], [IDENTITY, turn], &made);
        near(force, [0.999_623_494_8, 0.999_500_103_9, 1.004_005_497_4], 5e-3);
        near(of_first, [0.048_244_635_3, -0.461_809_249_3, 0.479_172_342_3], 5e-3);
        near(of_second, [-0.047_735_874_5, -0.541_700_818_3, 0.519_328_014_8], 5e-3);
        // Half of the displacement and of the angles: a quarter of the difference.
        let turn = about(&[0.0015, 0.001, -0.0005], 3.5e-6f64.sqrt());
        let (half, ..) = loads([[0.0; 3], [1.0005, 0.001, 0.000_75]], [IDENTITY, turn], &made);
        near(half, [0.499_906_062_2, 0.499_875_013_9, 0.501_000_687_7], 1.3e-3);
    }
}
