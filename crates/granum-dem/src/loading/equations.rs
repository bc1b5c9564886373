//! The six equations for the strain rates of a stage, and their solution.

use super::control_error::ControlError;
use crate::servo::{Row, STIFFNESS};

/// One equation for the strain rates.
pub(super) struct Equation {
    /// Where it comes from, for messages.
    pub(super) name: String,
    /// Weights of the strain rates, with stresses already replaced by stiffness times strain, in affine bulk moduli.
    pub(super) weights: [f64; 6],
    /// Strain rate on the right-hand side, 1/s; zero for stresses.
    pub(super) rate: f64,
    /// The controlled stress, if it is an equation for one.
    pub(super) row: Option<Row>,
}

pub(super) fn dot(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (x, y)| sum + x * y)
}

/// Change of a controlled combination per strain of each component, in bulk moduli of the sample.
pub(super) fn resistance(row: &Row, modulus: f64) -> [f64; 6] {
    std::array::from_fn(|k| row.stress[k] * STIFFNESS[k] / row.divisor + row.strain[k] / modulus)
}

/// Pivots below this fraction of the largest weight of their equation count as zero.
const SINGULAR: f64 = 1e-9;

/// The inverse of the matrix of the equations, by elimination with exchange of columns.
pub(super) fn inverse(equations: &[Equation]) -> Result<[[f64; 6]; 6], ControlError> {
    let mut left: [[f64; 6]; 6] = std::array::from_fn(|k| equations[k].weights);
    let mut right: [[f64; 6]; 6] =
        std::array::from_fn(|r| std::array::from_fn(|c| f64::from(u8::from(r == c))));
    // For each component, the equation that determines it.
    let mut decides = [usize::MAX; 6];
    for r in 0..6 {
        let largest = equations[r].weights.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let free = (0..6).filter(|&k| decides[k] == usize::MAX);
        let pivot = free.fold(None, |best: Option<usize>, k| match best {
            Some(b) if left[r][b].abs() >= left[r][k].abs() => Some(b),
            _ => Some(k),
        });
        let Some(pivot) = pivot.filter(|&k| left[r][k].abs() > SINGULAR * largest) else {
            return Err(ControlError::Singular(equations[r].name.clone()));
        };
        decides[pivot] = r;
        let scale = 1.0 / left[r][pivot];
        left[r] = left[r].map(|x| x * scale);
        right[r] = right[r].map(|x| x * scale);
        for other in (0..6).filter(|&other| other != r) {
            let factor = left[other][pivot];
            if factor != 0.0 {
                for k in 0..6 {
                    left[other][k] -= factor * left[r][k];
                    right[other][k] -= factor * right[r][k];
                }
            }
        }
    }
    Ok(std::array::from_fn(|k| right[decides[k]]))
}

/// Combines the strain rates of the rows, where necessary, so that each changes its own combination of stresses and no
/// other.
pub(super) fn decouple(rows: &mut [(Row, [f64; 6])], modulus: f64) -> Result<(), ControlError> {
    let n = rows.len().min(6);
    let mut weights = [[0.0; 6]; 6];
    for k in 0..6 {
        weights[k][k] = 1.0;
    }
    let mut coupled = false;
    for k in 0..n {
        for j in 0..n {
            weights[k][j] = dot(&resistance(&rows[k].0, modulus), &rows[j].1);
            coupled |= k != j && weights[k][j].abs() > 1e-12;
        }
        coupled |= weights[k][k] <= 0.0;
    }
    if !coupled {
        return Ok(());
    }
    let equations: Vec<Equation> = (0..6)
        .map(|k| Equation {
            name: format!("controlled stress {}", k + 1),
            weights: weights[k],
            rate: 0.0,
            row: None,
        })
        .collect();
    let mix = inverse(&equations)?;
    let before: Vec<[f64; 6]> = rows.iter().map(|(_, moves)| *moves).collect();
    for j in 0..n {
        rows[j].1 = std::array::from_fn(|c| 3.0 * (0..n).fold(0.0, |sum, k| sum + before[k][c] * mix[k][j]));
    }
    Ok(())
}
