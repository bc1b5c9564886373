//! Principal axes of a symmetric matrix.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::cross;

/// Moments whose difference over their sum is below this count as equal: rounding must not choose their axes.
const EQUAL: f64 = 1e-9;
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
