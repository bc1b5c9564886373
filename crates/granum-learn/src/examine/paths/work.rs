//! The work in closed cycles of strain, which no material gives for nothing.

use serde::{Deserialize, Serialize};

use super::quantities::{Row, strains};
use crate::dataset::Dataset;
use crate::error::Result;
use crate::methods::COMPONENTS;

/// The work of the deviator of stress, over mean stress, in closed cycles of the deviator of strain, `W = integral of s : de / p`: what is dissipated, but for what
/// the grains keep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorkInCycles {
    /// Whose stresses they are.
    pub method: String,
    /// Number of closed cycles.
    pub cycles: usize,
    /// Number of them with negative work, by more than rounding.
    pub negative: usize,
    /// The least work, over the mean work of the simulations.
    pub least: f64,
    /// Root mean square difference from the work of the simulations, over its root mean square.
    pub error: f64,
}

/// A closed cycle: the rows of its first and last state, and the deviators of strain between.
pub(super) struct Cycle {
    first: usize,
    strains: Vec<[f64; COMPONENTS]>,
}

/// Largest distance between the ends of a closed cycle, over its length.
const CLOSED: f64 = 0.01;

/// Less work than this share of the mean is rounding.
const ROUNDING: f64 = 1e-9;

/// All cycles that lead over two turning points back to the same strain.
pub(super) fn cycles(runs: &Dataset) -> Result<Vec<Cycle>> {
    let strains = strains(runs)?;
    let mut found = Vec::new();
    let mut first = 0;
    let distance = |a: &[f64; COMPONENTS], b: &[f64; COMPONENTS]| {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    for run in runs.runs() {
        let stages = run.values("stage")?;
        let turns: Vec<usize> =
            (1..run.rows()).filter(|row| stages[*row] != stages[row - 1]).map(|row| first + row).collect();
        for ends in turns.windows(3) {
            let own = &strains[ends[0]..=ends[2]];
            let length: f64 = own.windows(2).map(|pair| distance(&pair[0], &pair[1])).sum();
            if length > 0.0 && distance(&own[0], &own[own.len() - 1]) < CLOSED * length {
                found.push(Cycle { first: ends[0], strains: own.to_vec() });
            }
        }
        first += run.rows();
    }
    Ok(found)
}

impl Cycle {
    /// The work with the stresses of rows, by the trapezoidal rule.
    fn work(&self, rows: &[Row]) -> f64 {
        let step = |(k, pair): (usize, &[[f64; COMPONENTS]])| {
            let (a, b) = (&rows[self.first + k].stress, &rows[self.first + k + 1].stress);
            (0..COMPONENTS).map(|c| 0.5 * (a[c] + b[c]) * (pair[1][c] - pair[0][c])).sum::<f64>()
        };
        self.strains.windows(2).enumerate().map(step).sum()
    }
}

impl WorkInCycles {
    pub(super) fn new(method: &str, cycles: &[Cycle], exact: &[Row], rows: &[Row]) -> WorkInCycles {
        let of_exact: Vec<f64> = cycles.iter().map(|cycle| cycle.work(exact)).collect();
        let own: Vec<f64> = cycles.iter().map(|cycle| cycle.work(rows)).collect();
        let count = cycles.len().max(1) as f64;
        let mean = of_exact.iter().sum::<f64>() / count;
        let squares: f64 = own.iter().zip(&of_exact).map(|(a, b)| (a - b) * (a - b)).sum();
        let size: f64 = of_exact.iter().map(|work| work * work).sum();
        let share = |value: f64, of: f64| if of > 0.0 { value / of } else { 0.0 };
        WorkInCycles {
            method: method.into(),
            cycles: cycles.len(),
            negative: own.iter().filter(|work| **work < -ROUNDING * mean).count(),
            least: share(own.iter().copied().fold(f64::INFINITY, f64::min), mean),
            error: share(squares, size).sqrt(),
        }
    }
}
