//! Coverage: whether intervals of posteriors hold the truth as often as they say, on tests that are simulations at known parameters.

use granum_io::LaboratoryTest;
use granum_learn::regression::cholesky::Cholesky;
use serde::{Deserialize, Serialize};

use crate::draws::diagnostics::quantile_of_sorted;
use crate::draws::random::{standard_normal, stream};
use crate::error::{CalibrationError, Result};
use crate::file::CalibrationFile;
use crate::inference::likelihood::{FreeParameter, measurement_covariance};
use crate::posterior::outcome::Outcome;
use crate::simulations::target::{TargetTest, measured};

/// Shares of the ends of intervals of 90 %.
const ENDS: [f64; 2] = [0.05, 0.95];
/// Shares of a prior between which truths lie, so that the surrogate has learned on both sides.
const INNER: [f64; 2] = [0.05, 0.95];

/// How often the intervals of a parameter held the truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// The parameter.
    pub parameter: String,
    /// Number of intervals of 90 % that held the truth.
    pub inside: usize,
    /// Number of intervals.
    pub intervals: usize,
    /// Mean width of the intervals over that of the prior's.
    pub width: f64,
}

/// Parameters of so many synthetic targets, spread evenly over the priors, where no simulation of the design lies.
pub fn truths(parameters: &[FreeParameter], count: usize, seed: u32) -> Vec<Vec<f64>> {
    let value = |k: usize, (j, free): (usize, &FreeParameter)| {
        let share = f64::from(sobol_burley::sample(k as u32, j as u32, seed ^ 0x5eed_c0de));
        free.prior.value(INNER[0] + share * (INNER[1] - INNER[0]))
    };
    (0..count).map(|k| parameters.iter().enumerate().map(|free| value(k, free)).collect()).collect()
}

/// A target with the curves of a simulation in place of the readings of its test, with errors drawn from those of the measurement.
///
/// # Errors
/// If the simulation has nothing that is compared.
pub fn synthetic(
    file: &CalibrationFile,
    target: &TargetTest,
    curves: &LaboratoryTest,
    seed: u64,
) -> Result<TargetTest> {
    let mut random = stream(seed, 21);
    let mut found = Vec::new();
    let renamed = LaboratoryTest { name: target.name.clone(), ..curves.clone() };
    for (place, compared) in file.calibration.quantities.iter().enumerate() {
        if !target.curves.iter().any(|(known, _)| *known == place) {
            continue;
        }
        let Some(mut curve) = measured(&renamed, compared) else {
            let message = format!("the run {} has no {}", curves.name, compared.quantity.word());
            return Err(CalibrationError::Input(message));
        };
        let count = curve.measured.len();
        let factor = Cholesky::new(count, &measurement_covariance(&curve))
            .ok_or_else(|| CalibrationError::Input("the error of measurement is not positive".into()))?;
        let normal: Vec<f64> = (0..count).map(|_| standard_normal(&mut random)).collect();
        for (i, y) in curve.measured.iter_mut().enumerate() {
            let row = &factor.lower()[i * count..i * count + i + 1];
            *y += row.iter().zip(&normal).map(|(l, z)| l * z).sum::<f64>();
        }
        found.push((place, curve));
    }
    Ok(TargetTest { curves: found, laboratory: renamed, ..target.clone() })
}

/// Counts for each parameter how many of the intervals of posteriors hold the truths.
pub fn coverage(parameters: &[FreeParameter], posteriors: &[(Vec<f64>, Outcome)]) -> Vec<Coverage> {
    let of_parameter = |(k, free): (usize, &FreeParameter)| {
        let interval = |outcome: &Outcome| {
            let sorted = outcome.sorted(k);
            ENDS.map(|share| quantile_of_sorted(&sorted, share))
        };
        let holds = |(truth, outcome): &&(Vec<f64>, Outcome)| {
            let [low, high] = interval(outcome);
            low <= truth[k] && truth[k] <= high
        };
        let shares = |(_, outcome): &(Vec<f64>, Outcome)| {
            let [low, high] = interval(outcome).map(|value| free.prior.share(value));
            (high - low) / (ENDS[1] - ENDS[0])
        };
        Coverage {
            parameter: free.name.clone(),
            inside: posteriors.iter().filter(holds).count(),
            intervals: posteriors.len(),
            width: posteriors.iter().map(shares).sum::<f64>() / posteriors.len().max(1) as f64,
        }
    };
    parameters.iter().enumerate().map(of_parameter).collect()
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;

    use super::*;
    use crate::compared::curve::{MeasuredCurve, MeasurementError, PredictedCurve};
    use crate::draws::chains::{ChainOptions, draw};
    use crate::draws::sequential::{Sequential, SequentialOptions};
    use crate::inference::likelihood::Posterior;
    use crate::inference::prior::Prior;

    const STRAINS: [f64; 5] = [0.01, 0.02, 0.04, 0.07, 0.1];

    /// A hyperbola: the initial slope and the height are the parameters.
    fn hyperbola(values: &[f64]) -> Option<Vec<PredictedCurve>> {
        let mean = STRAINS.iter().map(|x| x / (1.0 / values[0] + x / values[1])).collect();
        Some(vec![PredictedCurve { mean, ..PredictedCurve::default() }])
    }

    fn parameters() -> Vec<FreeParameter> {
        vec![
            FreeParameter { name: "slope".into(), prior: Prior::LogUniform { from: 5.0, to: 200.0 } },
            FreeParameter { name: "height".into(), prior: Prior::Uniform { from: 0.5, to: 2.0 } },
        ]
    }

    fn observed(truth: &[f64], seed: u64) -> Vec<MeasuredCurve> {
        let error = MeasurementError { absolute: 0.02, relative: 0.0, correlation_strain: 0.0 };
        let mut random = stream(seed, 3);
        let measured = hyperbola(truth).unwrap()[0]
            .mean
            .iter()
            .map(|y| y + 0.02 * standard_normal(&mut random))
            .collect();
        let strain = STRAINS.to_vec();
        vec![MeasuredCurve { test: "T".into(), quantity: "q".into(), strain, measured, error, weight: 1.0 }]
    }

    fn by_chains(curves: &[MeasuredCurve], seed: u64) -> Outcome {
        let free = parameters();
        let posterior = Posterior::new(&free, curves, &hyperbola, None).unwrap();
        let options = ChainOptions { seed, threads: 1, ..ChainOptions::default() };
        Outcome::from_draws(&posterior, &draw(&posterior, &options, &mut NoObserver).unwrap())
    }

    /// With a right model and right errors, intervals of 90 % hold the truth in nine of ten cases: of 60 intervals 54 on average, with a
    /// deviation of 2.3.
    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let free = parameters();
        let posteriors: Vec<(Vec<f64>, Outcome)> = truths(&free, 30, 1)
            .into_iter()
            .enumerate()
            .map(|(k, truth)| {
                let outcome = by_chains(&observed(&truth, k as u64), k as u64);
                (truth, outcome)
            })
            .collect();
        let found = coverage(&free, &posteriors);
        let inside: usize = found.iter().map(|one| one.inside).sum();
        assert!((47..=60).contains(&inside), "{found:?}");
        assert!(found.iter().all(|one| one.intervals == 30 && one.width < 0.6), "{found:?}");
    }

    /// Chains, and rounds of simulations without a surrogate, give the same posterior of a synthetic target, which covers the truth.
    #[test]
    fn both_methods_agree_on_a_synthetic_target() {
        let (free, truth) = (parameters(), [40.0, 1.2]);
        let curves = observed(&truth, 7);
        let chains = by_chains(&curves, 7);
        let posterior = Posterior::new(&free, &curves, &hyperbola, None).unwrap();
        let options =
            SequentialOptions { points: 80, final_effective: 100.0, ..SequentialOptions::default() };
        let mut rounds = Sequential::new(2, options);
        while !rounds.is_settled() {
            assert!(rounds.rounds() < 12, "{} {}", rounds.effective(), rounds.change());
            let points = rounds.propose().unwrap();
            let likelihood = |point: &Vec<f64>| {
                let values: Vec<f64> =
                    free.iter().zip(point).map(|(free, share)| free.prior.value(*share)).collect();
                posterior.marginal_log_likelihood(&hyperbola(&values).unwrap())
            };
            let results: Vec<f64> = points.iter().map(likelihood).collect();
            rounds.take(&points, &results).unwrap();
        }
        let (points, weights) = rounds.weighted();
        let names = free.iter().map(|free| free.name.clone()).collect();
        let priors: Vec<Prior> = free.iter().map(|free| free.prior).collect();
        let simulated = Outcome::from_weighted(names, &priors, &points, &weights, 1);
        for k in 0..2 {
            let [a, b] = [&chains, &simulated].map(|outcome| {
                let sorted = outcome.sorted(k);
                [0.05, 0.5, 0.95].map(|share| quantile_of_sorted(&sorted, share))
            });
            let width = a[2] - a[0];
            assert!((a[1] - b[1]).abs() < 0.15 * width, "{a:?} {b:?}");
            assert!(((b[2] - b[0]) / width - 1.0).abs() < 0.3, "{a:?} {b:?}");
            assert!(a[0] < truth[k] && truth[k] < a[2], "{a:?}");
        }
    }
}
