//! The periodic cell: a parallelepiped given by the 3 x 3 matrix H whose columns are its edges, with one corner at
//! the origin.

use granum_simd::mul_add;
use serde::{Deserialize, Serialize};

use crate::geometry::{Matrix, Vector, apply, determinant, invert, multiply};

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

    /// Distances between the two faces of the cell that edge `k` connects, for every k, m.
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
            edges: std::array::from_fn(|r| {
                std::array::from_fn(|c| mul_add(dt, rate[r][c], self.edges[r][c]))
            }),
        }
    }

    /// `H s` for an integer image vector s, m.
    #[inline(always)]
    pub fn image(&self, s: [i32; 3]) -> Vector {
        apply(&self.edges, [f64::from(s[0]), f64::from(s[1]), f64::from(s[2])])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_of_a_cuboid_are_its_edges() {
        let heights = Cell::cuboid([1.0, 2.0, 3.0]).heights();
        for (h, expected) in heights.iter().zip([1.0, 2.0, 3.0]) {
            assert!((h - expected).abs() < 1e-15);
        }
    }
}
