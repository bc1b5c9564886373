//! Scores of predictions.
//!
//! The main score is the **relative RMSE**: the root mean square error over the root mean square of the DEM values,
//! `sqrt(sum (predicted - dem)^2 / sum dem^2)` over all values of all scored states. In contrast to
//! `R2 = 1 - sum (predicted - dem)^2 / sum (dem - mean dem)^2` it does not diverge if a curve is flat; R2 is reported in
//! addition. A state with a distribution counts with each of its bins.

use serde::{Deserialize, Serialize};

/// The score of predictions in comparison with DEM.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Root mean square error over the root mean square of the DEM values.
    pub relative_rmse: f64,
    /// Coefficient of determination.
    pub r2: f64,
    /// Root mean square error in the unit of the output.
    pub rmse: f64,
    /// Number of states scored.
    pub states: usize,
}

/// Accumulates errors.
///
/// ```
/// use granum_learn::score::Scorer;
///
/// let mut scorer = Scorer::default();
/// scorer.add(&[3.0], &[3.3]);
/// scorer.add(&[4.0], &[3.6]);
/// // The root mean square of the errors is 0.35, that of the values 3.54.
/// assert!((scorer.score().relative_rmse - 0.1).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Scorer {
    states: usize,
    values: usize,
    errors: f64,
    squares: f64,
    sum: f64,
}

impl Scorer {
    /// Adds one state with its DEM values and its prediction.
    pub fn add(&mut self, dem: &[f64], predicted: &[f64]) {
        self.states += 1;
        for (&exact, &value) in dem.iter().zip(predicted) {
            self.values += 1;
            self.errors += (value - exact) * (value - exact);
            self.squares += exact * exact;
            self.sum += exact;
        }
    }

    /// The score; all values are 0 if nothing was added. R2 is 0 if all DEM values are equal.
    pub fn score(&self) -> Score {
        if self.values == 0 {
            return Score::default();
        }
        let n = self.values as f64;
        let about_mean = self.squares - self.sum * self.sum / n;
        let flat = about_mean <= 1e-14 * self.squares;
        Score {
            relative_rmse: if self.squares == 0.0 { 0.0 } else { (self.errors / self.squares).sqrt() },
            r2: if flat { 0.0 } else { 1.0 - self.errors / about_mean },
            rmse: (self.errors / n).sqrt(),
            states: self.states,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_of_a_known_answer() {
        let mut scorer = Scorer::default();
        scorer.add(&[3.0], &[3.3]);
        scorer.add(&[4.0], &[3.6]);
        let score = scorer.score();
        assert!((score.relative_rmse - (0.25f64 / 25.0).sqrt()).abs() < 1e-12);
        assert!((score.rmse - 0.125f64.sqrt()).abs() < 1e-12);
        assert!((score.r2 - (1.0 - 0.25 / 0.5)).abs() < 1e-12);
        assert_eq!(score.states, 2);
        assert_eq!(Scorer::default().score(), Score::default());
        let mut flat = Scorer::default();
        flat.add(&[2.0], &[2.1]);
        assert_eq!(flat.score().r2, 0.0);
    }
}
