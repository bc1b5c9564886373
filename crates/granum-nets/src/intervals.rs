//! How far new blocks of observations (runs of other samples) are off, learned by leaving each training block out.
//!
//! The Laplace approximation takes the training rows for all there is. Rows of one run share what makes that run differ from
//! the next, so its standard deviations hold for more rows of the same runs, not for a new run. The errors that each run
//! would have had if it had not been trained on, `e_k`, tell the difference: over the training observations of a stretch
//!
//! ```text
//! c^2 = sum of e_k^2 / sum of s_k^2
//! ```
//!
//! with the standard deviations `s_k` of the Laplace approximation, and `c s(x)` is the standard deviation of a new run.

use serde::{Deserialize, Serialize};

use crate::data::Data;

/// Stretches of equal numbers of observations.
const STRETCHES: usize = 3;

/// What the standard deviations of the Laplace approximation are multiplied with, as a function of one input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intervals {
    /// Number of blocks that were left out one by one.
    pub blocks: usize,
    /// Degrees of freedom of the factors: how many independent errors stand behind each.
    pub degrees_of_freedom: f64,
    /// The input that tells them apart; none for a single factor.
    pub input: Option<String>,
    /// Its values, rising.
    pub at: Vec<f64>,
    /// The factor at each of them; linear between, constant beyond.
    pub factors: Vec<f64>,
}

impl Intervals {
    /// From the errors of left-out blocks and the standard deviations of the Laplace approximation, one an observation;
    /// none if they make no factor.
    pub(crate) fn new(data: &Data, names: &[&str], errors: &[f64], deviations: &[f64]) -> Option<Intervals> {
        let width = data.input_columns() * data.points();
        let place = |k: usize| data.spread_column.map_or(0.0, |column| data.inputs()[k * width + column]);
        let usable = |k: &usize| errors[*k].is_finite() && deviations[*k].is_finite() && deviations[*k] > 0.0;
        let mut order: Vec<usize> = (0..errors.len()).filter(usable).collect();
        order.sort_by(|a, b| place(*a).total_cmp(&place(*b)));
        let (mut at, mut factors) = (Vec::new(), Vec::new());
        for group in groups(&order, place) {
            let count = group.len() as f64;
            let squares = |values: &[f64]| group.iter().map(|&k| values[k] * values[k]).sum::<f64>();
            let factor = (squares(errors) / squares(deviations)).sqrt();
            if !(factor > 0.0 && factor.is_finite()) {
                return None;
            }
            at.push(group.iter().map(|&k| place(k)).sum::<f64>() / count);
            factors.push(factor);
        }
        let intervals = Intervals {
            blocks: data.block_count(),
            degrees_of_freedom: (data.observations() / factors.len() as f64).max(1.0),
            input: data.spread_column.map(|column| names[column].to_string()),
            at,
            factors,
        };
        intervals.check(names).is_ok().then_some(intervals)
    }

    /// The factor at a value of the input.
    pub fn factor(&self, place: f64) -> f64 {
        let after = self.at.partition_point(|at| *at <= place);
        if after == 0 || after == self.at.len() {
            return self.factors[after.saturating_sub(1)];
        }
        let share = (place - self.at[after - 1]) / (self.at[after] - self.at[after - 1]);
        self.factors[after - 1] + share * (self.factors[after] - self.factors[after - 1])
    }

    /// Refuses a table that is none, for a model with these inputs.
    pub(crate) fn check(&self, names: &[&str]) -> Result<(), String> {
        let rising = self.at.windows(2).all(|pair| pair[0] < pair[1]);
        let finite = self.at.iter().all(|at| at.is_finite());
        let positive = |value: &f64| *value > 0.0 && value.is_finite();
        let known = self.input.as_ref().is_none_or(|input| names.contains(&input.as_str()));
        let shape = !self.at.is_empty() && self.at.len() == self.factors.len();
        let factors = self.factors.iter().all(positive) && positive(&self.degrees_of_freedom);
        if rising && finite && known && shape && factors {
            return Ok(());
        }
        Err("the intervals need rising values of an input of the model, as many positive factors, and positive degrees \
             of freedom"
            .into())
    }
}

/// Observations in order of their places, in groups: one for each value, or stretches where there are too many values.
fn groups(order: &[usize], place: impl Fn(usize) -> f64) -> Vec<Vec<usize>> {
    let values: Vec<Vec<usize>> =
        order.chunk_by(|&a, &b| place(a) == place(b)).map(<[usize]>::to_vec).collect();
    // Bins of a distribution, which all states have; not strains, which only different runs have in common.
    if values.len() * values.len() <= order.len() {
        return values;
    }
    let mut stretches = vec![Vec::new(); STRETCHES];
    let mut before = 0;
    for value in values {
        // Observations at one place stay together, so that places rise.
        let stretch = before * STRETCHES / order.len();
        before += value.len();
        stretches[stretch].extend(value);
    }
    stretches.retain(|stretch| !stretch.is_empty());
    stretches
}
