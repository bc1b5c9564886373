//! Orders of quaternions in files, and the quaternion of a rotation matrix.
//!
//! granum, GSD of HOOMD-blue and the glyphs of ParaView have `w, x, y, z`; OVITO has `x, y, z, w` in the property `Orientation` of extended
//! XYZ; dumps of LAMMPS name each component (`quatw quati quatj quatk`).

use granum_core::assembly::{Matrix, Quaternion};
use granum_core::rotation::normalized;

/// `x, y, z, w`, as OVITO has it.
pub(super) fn w_last([w, x, y, z]: &Quaternion) -> Quaternion {
    [*x, *y, *z, *w]
}

/// The quaternion (`w, x, y, z`, w not negative) of a rotation matrix: from the largest of its components, so that nothing cancels.
pub(super) fn of_matrix(m: &Matrix) -> Quaternion {
    let squares = [
        1.0 + m[0][0] + m[1][1] + m[2][2],
        1.0 + m[0][0] - m[1][1] - m[2][2],
        1.0 - m[0][0] + m[1][1] - m[2][2],
        1.0 - m[0][0] - m[1][1] + m[2][2],
    ];
    let largest = (1..4).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
    let (wx, wy, wz) = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]);
    let (xy, xz, yz) = (m[0][1] + m[1][0], m[0][2] + m[2][0], m[1][2] + m[2][1]);
    let q = match largest {
        0 => [squares[0], wx, wy, wz],
        1 => [wx, squares[1], xy, xz],
        2 => [wy, xy, squares[2], yz],
        _ => [wz, xz, yz, squares[3]],
    };
    let q = normalized(&q);
    if q[0] < 0.0 { q.map(|x| -x) } else { q }
}

#[cfg(test)]
mod tests {
    use granum_core::rotation::{about, matrix};

    use super::*;

    #[test]
    fn a_rotation_is_found_again_whichever_component_is_largest() {
        for (axis, angle) in [
            ([0.0, 0.0, 1.0], 0.0),
            ([1.0, 2.0, -0.5], 0.3),
            ([1.0, 0.1, 0.2], 3.1),
            ([0.1, 1.0, 0.2], 3.1),
            ([0.1, 0.2, -1.0], 3.13),
            ([0.3, 0.2, 1.0], 3.13),
        ] {
            let q = about(&axis, angle);
            let found = of_matrix(&matrix(&q));
            let apart = (0..4).map(|k| (found[k] - q[k]).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-14, "{q:?} {found:?}");
        }
    }

    /// A quarter of a turn about z: of 120 degrees about (1, 1, 1) all four components would be equal.
    #[test]
    fn the_order_of_ovito_has_w_last() {
        let [w, x, y, z] = about(&[0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
        assert_eq!((x, y), (0.0, 0.0));
        assert_eq!(w_last(&[w, x, y, 0.25]), [x, y, 0.25, w]);
        assert!((z - 0.5f64.sqrt()).abs() < 1e-15);
    }
}
