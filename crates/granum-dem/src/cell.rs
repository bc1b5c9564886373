//! The periodic cell: a parallelepiped given by the 3 x 3 matrix H whose columns are its edges, with one corner at
//! the origin.

use serde::{Deserialize, Serialize};

use crate::assembly::{Matrix, Vector, determinant};

/// Periodic cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Edge matrix H: column k is edge k, m.
    pub edges: Matrix,
}

impl Cell {
    /// A cuboid with these edge lengths, m.
    pub fn cuboid(lengths: Vector) -> Cell {
        let mut edges = [[0.0; 3]; 3];
        for a in 0..3 {
            edges[a][a] = lengths[a];
        }
        Cell { edges }
    }

    /// Volume, m3.
    pub fn volume(&self) -> f64 {
        determinant(&self.edges).abs()
    }

    /// Distance between the two faces that edge `k` joins, for every k, m.
    pub fn heights(&self) -> Vector {
        let inverse = invert(&self.edges);
        std::array::from_fn(|k| {
            1.0 / (inverse[k][0].powi(2) + inverse[k][1].powi(2) + inverse[k][2].powi(2)).sqrt()
        })
    }

    /// The cell after a step of length `dt` at velocity gradient `gradient`: `H + dt L H`.
    pub fn strained(&self, gradient: &Matrix, dt: f64) -> Cell {
        let rate = multiply(gradient, &self.edges);
        Cell {
            edges: std::array::from_fn(|r| std::array::from_fn(|c| dt.mul_add(rate[r][c], self.edges[r][c]))),
        }
    }

    /// `H s` for an integer image vector s, m.
    #[inline(always)]
    pub fn image(&self, s: [i32; 3]) -> Vector {
        apply(&self.edges, [f64::from(s[0]), f64::from(s[1]), f64::from(s[2])])
    }
}

/// Matrix times vector.
#[inline(always)]
pub fn apply(m: &Matrix, v: Vector) -> Vector {
    // No closure: it would fall back to the baseline instruction set in a kernel.
    [times(&m[0], v), times(&m[1], v), times(&m[2], v)]
}

#[inline(always)]
fn times(row: &Vector, v: Vector) -> f64 {
    row[0].mul_add(v[0], row[1].mul_add(v[1], row[2] * v[2]))
}

/// Matrix product.
pub fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|r| {
        std::array::from_fn(|c| a[r][0].mul_add(b[0][c], a[r][1].mul_add(b[1][c], a[r][2] * b[2][c])))
    })
}

/// Inverse of a matrix that is not singular.
pub fn invert(m: &Matrix) -> Matrix {
    let d = determinant(m);
    let minor = |r: usize, c: usize| {
        let (r1, r2) = ((r + 1) % 3, (r + 2) % 3);
        let (c1, c2) = ((c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    std::array::from_fn(|r| std::array::from_fn(|c| minor(c, r) / d))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_of_a_skew_cell() {
        let m = [[2.0, 0.3, -0.1], [0.0, 1.5, 0.2], [0.1, 0.0, 3.0]];
        let product = multiply(&m, &invert(&m));
        for r in 0..3 {
            for c in 0..3 {
                assert!((product[r][c] - f64::from(r == c)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn heights_of_a_cuboid_are_its_edges() {
        let heights = Cell::cuboid([1.0, 2.0, 3.0]).heights();
        for (h, expected) in heights.iter().zip([1.0, 2.0, 3.0]) {
            assert!((h - expected).abs() < 1e-15);
        }
    }
}
