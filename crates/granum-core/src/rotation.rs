//! Rotations as unit quaternions `[w, x, y, z]`, from the axes of a body to the axes of space.

use crate::geometry::{Matrix, Vector};

/// A quaternion `w + x i + y j + z k`; a rotation if its length is one.
pub type Quaternion = [f64; 4];

/// No rotation.
pub const IDENTITY: Quaternion = [1.0, 0.0, 0.0, 0.0];

/// The product `a b`: first the rotation `b`, then `a`.
pub fn product(a: &Quaternion, b: &Quaternion) -> Quaternion {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The reverse rotation.
pub fn conjugate(q: &Quaternion) -> Quaternion {
    [q[0], -q[1], -q[2], -q[3]]
}

/// The quaternion with its length made one; no rotation if it has no length.
pub fn normalized(q: &Quaternion) -> Quaternion {
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    if length > 0.0 { q.map(|component| component / length) } else { IDENTITY }
}

/// The rotation by an angle, rad, about an axis, which need not have length one.
pub fn about(axis: &Vector, angle: f64) -> Quaternion {
    let length = crate::geometry::length(axis);
    if length == 0.0 {
        return IDENTITY;
    }
    let (sine, cosine) = libm::sincos(0.5 * angle);
    [cosine, sine * axis[0] / length, sine * axis[1] / length, sine * axis[2] / length]
}

/// The matrix of a rotation: its columns are the axes of the body in space.
pub fn matrix(q: &Quaternion) -> Matrix {
    let [w, x, y, z] = *q;
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// A vector of the body in the axes of space: matrix times vector, summed in the order of the components.
pub fn to_space(rotation: &Matrix, v: &Vector) -> Vector {
    let row = |r: usize| rotation[r][0] * v[0] + rotation[r][1] * v[1] + rotation[r][2] * v[2];
    [row(0), row(1), row(2)]
}

/// A vector of space in the axes of the body: transposed matrix times vector.
pub fn to_body(rotation: &Matrix, v: &Vector) -> Vector {
    let column = |c: usize| rotation[0][c] * v[0] + rotation[1][c] * v[1] + rotation[2][c] * v[2];
    [column(0), column(1), column(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y() {
        let turn = matrix(&about(&[0.0, 0.0, 2.0], 0.5 * std::f64::consts::PI));
        let turned = to_space(&turn, &[1.0, 0.0, 0.0]);
        assert!((turned[1] - 1.0).abs() < 1e-15 && turned[0].abs() < 1e-15 && turned[2] == 0.0, "{turned:?}");
        let back = to_body(&turn, &turned);
        assert!((back[0] - 1.0).abs() < 1e-15 && back[1].abs() < 1e-15, "{back:?}");
    }

    #[test]
    fn a_product_is_one_rotation_after_the_other() {
        let (a, b) = (about(&[1.0, 2.0, -0.5], 0.7), about(&[0.3, -1.0, 2.0], -1.9));
        let v = [0.2, -1.4, 0.6];
        let one_by_one = to_space(&matrix(&a), &to_space(&matrix(&b), &v));
        let at_once = to_space(&matrix(&product(&a, &b)), &v);
        for k in 0..3 {
            assert!((one_by_one[k] - at_once[k]).abs() < 1e-15);
        }
        let none = product(&a, &conjugate(&a));
        assert!((none[0] - 1.0).abs() < 1e-15 && none[1].abs() < 1e-16, "{none:?}");
        assert_eq!(normalized(&[0.0; 4]), IDENTITY);
        assert_eq!(normalized(&[2.0, 0.0, 0.0, 0.0]), IDENTITY);
    }
}
