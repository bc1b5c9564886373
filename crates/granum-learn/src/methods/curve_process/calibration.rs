//! Conformal calibration by whole runs: by which factor standard deviations must be multiplied so that intervals hold.
//!
//! Each training run is predicted by what was fitted to others. Its errors over their standard deviations, along the whole curve, are as those of a
//! new run would be, if runs can be exchanged. The factor of intervals is the smallest with which the share of states that hold, averaged
//! over the runs and with a further run of which no state holds, is the level; that of bands is the one with which so many whole curves
//! hold (Vovk, Gammerman and Shafer 2005; Lei and others 2018).

use serde::{Deserialize, Serialize};

/// Number of equal steps of the level at which factors of intervals are kept.
const STEPS: usize = 400;

/// Share of a normal distribution within one standard deviation.
const ONE_DEVIATION: f64 = 0.682_689_492_137_085_9;

/// The factors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::methods) struct Calibration {
    /// Number of runs.
    runs: usize,
    /// The errors over their standard deviations below which a share of `k / STEPS` of the states is.
    states: Vec<f64>,
    /// The largest of each run, increasing.
    curves: Vec<f64>,
    /// Root mean square of the errors themselves; absent in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    root_mean_square: Option<f64>,
}

impl Calibration {
    /// From the errors of each run over their standard deviations at points with the given shares of the coordinate.
    pub fn new(errors: &[Vec<f64>], shares: &[f64]) -> Calibration {
        let runs = errors.len();
        let mut all: Vec<(f64, f64)> =
            errors.iter().flat_map(|run| run.iter().map(|e| e.abs()).zip(shares.iter().copied())).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = all.iter().map(|(_, share)| share).sum();
        let (mut states, mut sum, mut next) = (Vec::with_capacity(STEPS + 1), 0.0, 0);
        for k in 0..=STEPS {
            while next + 1 < all.len() && sum + all[next].1 < total * k as f64 / STEPS as f64 {
                sum += all[next].1;
                next += 1;
            }
            states.push(all.get(next).map_or(0.0, |(error, _)| *error));
        }
        let largest = |run: &Vec<f64>| run.iter().fold(0.0f64, |most, e| most.max(e.abs()));
        let mut curves: Vec<f64> = errors.iter().map(largest).collect();
        curves.sort_by(f64::total_cmp);
        Calibration { runs, states, curves, root_mean_square: None }
    }

    /// The same, with the root mean square of the errors themselves.
    pub fn with_root_mean_square(self, error: f64) -> Calibration {
        Calibration { root_mean_square: Some(error).filter(|error| error.is_finite()), ..self }
    }

    /// The same with six significant digits of each number, which take less room in a file.
    pub fn with_six_digits(self) -> Calibration {
        let short = |value: &f64| format!("{value:.5e}").parse().unwrap_or(*value);
        let (states, curves) =
            (self.states.iter().map(short).collect(), self.curves.iter().map(short).collect());
        Calibration { states, curves, ..self }
    }

    /// The root mean square of the errors themselves, if it is known.
    pub fn root_mean_square(&self) -> Option<f64> {
        self.root_mean_square
    }

    /// The factor of intervals that hold a share `level` of the states. With so few runs that the level cannot be reached it is that
    /// of the largest error.
    pub fn interval(&self, level: f64) -> f64 {
        let needed = (level * (self.runs + 1) as f64 / self.runs.max(1) as f64).min(1.0) * STEPS as f64;
        let below = (needed.floor() as usize).min(STEPS - 1);
        let part = needed - below as f64;
        self.states[below] + part * (self.states[below + 1] - self.states[below])
    }

    /// The factor of intervals that hold as many states as one standard deviation of a normal distribution does.
    pub fn one_deviation(&self) -> f64 {
        self.interval(ONE_DEVIATION)
    }

    /// The factor of bands that hold a share `level` of whole curves.
    pub fn band(&self, level: f64) -> f64 {
        let rank = (level * (self.runs + 1) as f64).ceil() as usize;
        self.curves.get(rank.clamp(1, self.runs.max(1)) - 1).copied().unwrap_or(0.0)
    }

    /// True if the numbers are those of a calibration.
    pub fn is_sound(&self) -> bool {
        let rises = |values: &[f64]| values.windows(2).all(|pair| pair[0] <= pair[1]);
        let positive = |values: &[f64]| values.iter().all(|value| *value >= 0.0 && value.is_finite());
        (self.states.len(), self.curves.len()) == (STEPS + 1, self.runs)
            && [&self.states, &self.curves].iter().all(|values| rises(values) && positive(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 99 runs of two states with the errors 0.01 k and 0.01 k + 1.
    #[test]
    fn factors_are_the_quantiles_of_states_and_of_curves() {
        let errors: Vec<Vec<f64>> =
            (1..=99).map(|k| f64::from(k) / 100.0).map(|e| vec![-e, e + 1.0]).collect();
        let calibration = Calibration::new(&errors, &[0.5, 0.5]);
        assert!(calibration.is_sound());
        assert!((calibration.interval(0.495) - 1.0).abs() < 0.015, "{}", calibration.interval(0.495));
        assert!((calibration.interval(0.9) - 1.82).abs() < 0.015, "{}", calibration.interval(0.9));
        assert_eq!(calibration.band(0.9), 1.9);
        // More than 99 of 100 cannot be shown by 99 runs.
        assert_eq!((calibration.interval(0.999), calibration.band(0.999)), (1.99, 1.99));
    }
}
