//! The frame in which a contact stores tangential vectors, and its rotation.
//!
//! Each unit normal n has its own frame (e_1, e_2, n): the shortest rotation from the nearer pole (0, 0, s), `s = sign n_z`,
//! to n carries the axes (x, s y) to (e_1, e_2) (Duff et al. 2017, J. Computer Graphics Techniques 6, 1). A tangential
//! vector then has two components, lies in the contact plane by construction, and a friction law is two-dimensional.
//!
//! When the normal moves from m to n, a stored vector follows the shortest rotation from m to n. Relative to the frames it
//! rotates by the area of the spherical triangle (pole, m, n), half of which has the tangent
//! `s (m_x n_y - m_y n_x) / (1 + m.n + s (m_z + n_z))` (van Oosterom and Strackee 1983), and by the spin about the normal.
//! Where n has left the hemisphere of m, the two frames at n differ by a further half angle with the direction
//! `n_y + i s n_x`. All three half angles are multiplied as complex numbers and squared: the rotation is exact and preserves
//! the norm for a step of any size.

use granum_simd::{Mask, Real};

use granum_simd::vectors::dot;

/// Two unit vectors that complete the normal to a right-handed frame.
#[derive(Clone, Copy)]
pub struct ContactFrame<R> {
    /// First axis of the contact plane.
    pub first: [R; 3],
    /// Second axis of the contact plane.
    pub second: [R; 3],
}

/// 1 on the hemisphere `n_z >= 0`, else -1.
#[inline(always)]
fn side<R: Real>(normal: [R; 3]) -> R {
    R::select(normal[2].lt(R::zero()), R::splat(-1.0), R::splat(1.0))
}

impl<R: Real> ContactFrame<R> {
    /// The frame of a unit normal.
    #[inline(always)]
    pub fn new(normal: [R; 3]) -> Self {
        let [x, y, z] = normal;
        let s = side(normal);
        let a = R::splat(-1.0) / (s + z);
        let (ax, sx) = (a * x, s * x);
        let cross = ax * y;
        ContactFrame {
            first: [sx.mul_add(ax, R::splat(1.0)), s * cross, -sx],
            second: [cross, (a * y).mul_add(y, s), -y],
        }
    }

    /// Components of a vector in the contact plane.
    #[inline(always)]
    pub fn components(&self, vector: [R; 3]) -> [R; 2] {
        [dot(self.first, vector), dot(self.second, vector)]
    }

    /// The vector of given components.
    #[inline(always)]
    pub fn vector(&self, components: [R; 2]) -> [R; 3] {
        let ([a, b], [f, s]) = (components, [self.first, self.second]);
        [a.mul_add(f[0], b * s[0]), a.mul_add(f[1], b * s[1]), a.mul_add(f[2], b * s[2])]
    }
}

/// Components, in the frame of `-normal`, of minus a vector that is given by its components in the frame of `normal`: the
/// form that a stored force takes when the grains of a pair change roles.
///
/// The frame of `-n` is `(e_1, -e_2)`, so that nothing is rounded, except for a normal on the equator, where both directions
/// belong to the same hemisphere.
pub fn swap_sides(normal: [f64; 3], vector: [f64; 2]) -> [f64; 2] {
    if normal[2] != 0.0 {
        return [-vector[0], vector[1]];
    }
    let opposite = ContactFrame::new(normal.map(|x| -x));
    opposite.components(ContactFrame::new(normal).vector(vector)).map(|x| -x)
}

/// A rotation in the contact plane: the rotation of a stored vector in one step, relative to the frames.
#[derive(Clone, Copy)]
pub struct Turn<R> {
    pub(in crate::contact) cosine: R,
    pub(in crate::contact) sine: R,
}

impl<R: Real> Turn<R> {
    /// Rotation from the unit normal `old` to `new`, with `cosine` their dot product, and a spin (angle, rad) about it.
    ///
    /// The tangent of half the spin is evaluated by its series to the fifth order: the angle is exact to 1e-10 up to 0.1 rad
    /// per step.
    #[inline(always)]
    pub fn new(old: [R; 3], new: [R; 3], cosine: R, spin: R) -> Self {
        let one = R::splat(1.0);
        let s = side(old);
        let real = s.mul_add(old[2] + new[2], one + cosine);
        let imaginary = s * old[0].mul_add(new[1], -(old[1] * new[0]));
        let half = spin * R::splat(0.5);
        let square = half * half;
        let series = square.mul_add(R::splat(2.0 / 15.0), R::splat(1.0 / 3.0));
        let tangent = (half * square).mul_add(series, half);
        let (mut w, mut z) = (imaginary.mul_add(-tangent, real), real.mul_add(tangent, imaginary));
        let crossed = !s.eq(side(new));
        if crossed.any() {
            let (a, b) = (new[1], s * new[0]);
            let (cw, cz) = (w.mul_add(a, -(z * b)), w.mul_add(b, z * a));
            w = R::select(crossed, cw, w);
            z = R::select(crossed, cz, z);
        }
        let (ww, zz) = (w * w, z * z);
        let inverse = one / (ww + zz);
        Turn { cosine: (ww - zz) * inverse, sine: (w + w) * (z * inverse) }
    }

    /// Converts the components of a vector in the old frame into those of the rotated vector in the new frame.
    #[inline(always)]
    pub fn apply(&self, v: [R; 2]) -> [R; 2] {
        [self.cosine.mul_add(v[0], -(self.sine * v[1])), self.sine.mul_add(v[0], self.cosine * v[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_simd::vectors::{add_scaled, cross};
    use proptest::prelude::*;

    fn unit(z: f64, azimuth: f64) -> [f64; 3] {
        let r = (1.0 - z * z).sqrt();
        [r * azimuth.cos(), r * azimuth.sin(), z]
    }

    /// Rotation of a vector in space by tilt and spin.
    fn reference(old: [f64; 3], new: [f64; 3], spin: f64, q: [f64; 3]) -> [f64; 3] {
        let sum: [f64; 3] = std::array::from_fn(|a| old[a] + new[a]);
        let tilted = add_scaled(q, -dot(new, q) / (1.0 + dot(old, new)), sum);
        add_scaled(tilted.map(|v| v * spin.cos()), spin.sin(), cross(new, tilted))
    }

    proptest! {
        #[test]
        fn frames_are_right_handed(z in -1.0f64..=1.0, azimuth in -4.0f64..4.0) {
            let n = unit(z, azimuth);
            let frame = ContactFrame::new(n);
            let third = cross(frame.first, frame.second);
            for a in 0..3 {
                prop_assert!((third[a] - n[a]).abs() < 1e-15);
            }
            prop_assert!(dot(frame.first, n).abs() < 1e-15 && dot(frame.second, n).abs() < 1e-15);
            prop_assert!((dot(frame.first, frame.first) - 1.0).abs() < 1e-15);
        }

        #[test]
        fn turns_as_in_space(
            z in -1.0f64..=1.0, azimuth in -4.0f64..4.0,
            tilt in prop::array::uniform3(-1.0f64..1.0), size in -6.0f64..0.0, spin in -0.02f64..0.02,
            v in prop::array::uniform2(-1.0f64..1.0),
        ) {
            let old = unit(z, azimuth);
            let moved: [f64; 3] = std::array::from_fn(|a| old[a] + 0.5 * 10f64.powf(size) * tilt[a]);
            let new = moved.map(|x| x / dot(moved, moved).sqrt());
            let expected = reference(old, new, spin, ContactFrame::new(old).vector(v));
            let found = ContactFrame::new(new).vector(Turn::new(old, new, dot(old, new), spin).apply(v));
            for a in 0..3 {
                prop_assert!((expected[a] - found[a]).abs() < 1e-14, "{expected:?} {found:?}");
            }
        }
    }

    #[test]
    fn sides_can_be_swapped() {
        for z in [-0.9, -0.3, 0.0, 0.4, 1.0] {
            for azimuth in [-3.0, -1.0, 0.0, 0.5, 2.0] {
                let (n, v) = (unit(z, azimuth), [0.3, -0.7]);
                let before = ContactFrame::new(n).vector(v);
                let after = ContactFrame::new(n.map(|x| -x)).vector(swap_sides(n, v));
                for a in 0..3 {
                    assert!((before[a] + after[a]).abs() < 1e-15, "{z} {azimuth}: {before:?} {after:?}");
                }
            }
        }
    }

    #[test]
    fn crosses_the_equator() {
        for k in 0..24 {
            let azimuth = k as f64 * 0.27 - 3.0;
            for (from, to) in [(1e-9, -1e-9), (-1e-4, 2e-4), (0.0, -1e-3), (-0.2, 0.2)] {
                let (old, new) = (unit(from, azimuth), unit(to, azimuth + 0.01));
                let v = [0.6, -0.8];
                let expected = reference(old, new, 0.01, ContactFrame::new(old).vector(v));
                let found = ContactFrame::new(new).vector(Turn::new(old, new, dot(old, new), 0.01).apply(v));
                for a in 0..3 {
                    assert!(
                        (expected[a] - found[a]).abs() < 1e-14,
                        "{azimuth} {from}: {expected:?} {found:?}"
                    );
                }
            }
        }
    }
}
