//! Principal axes of a symmetric matrix.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::cross;

/// Moments whose difference over their sum is below this count as equal: rounding must not choose their axes.
pub(crate) const EQUAL: f64 = 1e-9;
/// Products that are below this share of the sum of the moments count as zero.
const ZERO: f64 = 1e-16;

/// Principal values of a symmetric matrix in rising order, and a right-handed frame of their axes in its columns (Jacobi rotations).
/// Values that are equal but for rounding keep the axes of the matrix, in their order.
pub(crate) fn principal(matrix: &Matrix) -> (Vector, Matrix) {
    let mut a = *matrix;
    let sum = (a[0][0] + a[1][1] + a[2][2]).abs();
    let mut v: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| if r == c { 1.0 } else { 0.0 }));
    for _ in 0..32 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let equal = (a[p][p] - a[q][q]).abs() <= EQUAL * sum && a[p][q].abs() <= EQUAL * sum;
            if !equal && a[p][q].abs() > ZERO * sum {
                rotate(&mut a, &mut v, p, q);
            }
        }
    }
    let mut order = [0, 1, 2];
    for (k, l) in [(0, 1), (1, 2), (0, 1)] {
        if a[order[k]][order[k]] > a[order[l]][order[l]] + EQUAL * sum {
            order.swap(k, l);
        }
    }
    let column = |k: usize| -> Vector { std::array::from_fn(|r| v[r][order[k]]) };
    let (first, second) = (column(0), column(1));
    let third = cross(&first, &second);
    let axes = std::array::from_fn(|r| [first[r], second[r], third[r]]);
    (order.map(|k| a[k][k]), axes)
}

/// The rotation in the plane of two axes after which their product vanishes.
fn rotate(a: &mut Matrix, v: &mut Matrix, p: usize, q: usize) {
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for k in 0..3 {
        let (x, y) = (a[k][p], a[k][q]);
        (a[k][p], a[k][q]) = (c * x - s * y, s * x + c * y);
    }
    for k in 0..3 {
        let (x, y) = (a[p][k], a[q][k]);
        (a[p][k], a[q][k]) = (c * x - s * y, s * x + c * y);
        let (x, y) = (v[k][p], v[k][q]);
        (v[k][p], v[k][q]) = (c * x - s * y, s * x + c * y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::union_of_spheres::tests::ASYMMETRIC;
    use crate::union_of_spheres::{ShapeOfSpheres, moments};
    use granum_core::geometry::{determinant, multiply};
    use granum_core::rotation::{to_body, to_space};

    fn transposed(m: &Matrix) -> Matrix {
        std::array::from_fn(|r| std::array::from_fn(|c| m[c][r]))
    }

    /// Row A2 of the list of known faults: a body and its mirror images, and every sign and order of the given axes. The frame is right-handed,
    /// the inertia is diagonal in it, and the spheres are where they were.
    #[test]
    fn frames_are_right_handed_and_give_the_spheres_back() {
        for mirrored in 0..8 {
            let sign = |a: usize| if mirrored >> a & 1 == 1 { -1.0 } else { 1.0 };
            for order in [[0, 1, 2], [1, 2, 0], [2, 1, 0]] {
                let place = |c: &Vector| -> Vector { std::array::from_fn(|a| sign(a) * c[order[a]]) };
                let spheres: Vec<(Vector, f64)> = ASYMMETRIC.iter().map(|(c, r)| (place(c), *r)).collect();
                let shape = ShapeOfSpheres::new(&spheres).unwrap();
                assert!((determinant(&shape.axes) - 1.0).abs() < 1e-12, "{mirrored} {order:?}");
                let inertia = moments(&spheres).inertia_over_volume();
                let own = multiply(&transposed(&shape.axes), &multiply(&inertia, &shape.axes));
                for (r, c) in [(0, 1), (0, 2), (1, 2), (1, 0), (2, 0), (2, 1)] {
                    assert!(own[r][c].abs() < 1e-12, "{mirrored} {order:?}: {own:?}");
                }
                for (k, golden) in [0.121740791939, 0.142948051739, 0.149471867159].into_iter().enumerate() {
                    assert!((own[k][k] - golden).abs() < 1e-10, "{mirrored} {order:?}: {own:?}");
                }
                for ((centre, radius), piece) in spheres.iter().zip(&shape.shape.pieces) {
                    let there = to_space(&shape.axes, &piece.centre);
                    assert_eq!(*radius, piece.radius);
                    for a in 0..3 {
                        assert!(
                            (there[a] + shape.centre[a] - centre[a]).abs() < 1e-12,
                            "{mirrored} {order:?}"
                        );
                    }
                }
            }
        }
    }

    /// Row A2: a tetrapod keeps the given axes, its spheres in any order.
    #[test]
    fn equal_moments_keep_the_given_axes() {
        let q = 0.25;
        let corners = [[q, q, q], [q, -q, -q], [-q, q, -q], [-q, -q, q]];
        for first in 0..4 {
            for second in (0..4).filter(|k| *k != first) {
                for third in (0..4).filter(|k| *k != first && *k != second) {
                    let order = [first, second, third, 6 - first - second - third];
                    let spheres = order.map(|k| (corners[k], 0.5));
                    let shape = ShapeOfSpheres::new(&spheres).unwrap();
                    assert_eq!(shape.axes, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "{order:?}");
                }
            }
        }
    }

    /// Row A2: two spheres of diameter 1 that touch, under a couple 1 about z, gain spin according to how they lie.
    #[test]
    fn a_dimer_spins_as_it_lies() {
        for (axis, golden) in [2.7283704530, 2.7283704530, 9.5492965855].into_iter().enumerate() {
            let centre = |side: f64| std::array::from_fn(|a| if a == axis { 0.5 * side } else { 0.0 });
            let ShapeOfSpheres { shape, axes, .. } =
                ShapeOfSpheres::new(&[(centre(-1.0), 0.5), (centre(1.0), 0.5)]).unwrap();
            let couple = to_body(&axes, &[0.0, 0.0, 1.0]);
            let spin: Vector =
                std::array::from_fn(|a| couple[a] / (shape.volume * shape.inertia_over_mass[a]));
            assert!((to_space(&axes, &spin)[2] - golden).abs() < 1e-8, "{axis}");
            assert!((determinant(&axes) - 1.0).abs() < 1e-12);
        }
    }

    /// Row A3: the inertia of four unlike spheres in the order xx, yy, zz, xy, xz, yz with `I_xy = -int xy`, and what would come out if it were read
    /// with the last two exchanged or the signs of the products turned.
    #[test]
    fn products_of_inertia_have_their_order_and_sign() {
        let golden =
            [0.089011190087, 0.104960800537, 0.106715878259, 0.003159816897, 0.001050024889, 0.002136792081];
        let found = moments(&ASYMMETRIC);
        let inertia = found.inertia_over_volume().map(|row| row.map(|x| x * found.volume));
        let read =
            [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|(r, c): (usize, usize)| inertia[r][c]);
        for k in 0..6 {
            assert!((read[k] - golden[k]).abs() < 1e-11, "{read:?}");
        }
        let values =
            |[xx, yy, zz, xy, xz, yz]: [f64; 6]| principal(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).0;
        let [xx, yy, zz, xy, xz, yz] = golden;
        for (order, golden, digits) in [
            (golden, [0.0883859292, 0.1037827682, 0.1085191715], 1e-9),
            ([xx, yy, zz, xy, yz, xz], [0.088211, 0.104663, 0.107814], 1e-6),
            ([xx, yy, zz, -xy, -xz, -yz], [0.088295, 0.104198, 0.108195], 1e-6),
        ] {
            let found = values(order);
            for k in 0..3 {
                assert!((found[k] - golden[k]).abs() < digits, "{found:?} {golden:?}");
            }
        }
    }
}
