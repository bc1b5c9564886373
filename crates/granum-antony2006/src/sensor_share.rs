//! The weight of the sensors in the networks of a mapping, chosen by cross-validation over runs.
//!
//! The regularisation is the same for all weights of a network, and it must permit the steep curve as a function of
//! strain. A sensor that contains no information on other runs could then get equally steep slopes. Inputs that can do
//! harm are therefore scaled to a share of the range of an input, since a small share makes slopes expensive. The share is
//! chosen with ridge regression, which costs hardly any time: every training run is predicted from the others,
//!
//! ```text
//! answer = B(strain) a + sum_k b_k x_k,   x_k = deviation of sensor k from its mean over strain, scaled as in the network
//! ```
//!
//! where `b_k` has a normal prior distribution with the variance [`SLOPE_VARIANCE`] that is typical of slopes in networks,
//! and the share with the smallest squared error is chosen. This needs at least two runs; for a single run an intermediate
//! share is used.

use crate::baseline::Ridge;
use crate::mapping::{Mapping, Quantity};
use crate::study_data::State;
use granum_learn::Result;

/// The shares that are tried.
const SHARES: [f64; 5] = [0.03, 0.055, 0.1, 0.17, 0.3];
/// The share for a single training run, for which there is no cross-validation.
const SHARE_OF_ONE_RUN: f64 = 0.1;
/// Variance of the slope of an output as a function of an input, both in the scaled units of a network.
const SLOPE_VARIANCE: f64 = 1.0;
/// Smallest penalty, which keeps the equations solvable if an output does not vary.
const LEAST_PENALTY: f64 = 1e-6;
/// Fraction of the output range of a network that the targets cover.
const TARGET_RANGE: f64 = 0.8;

/// The share for those sensors of a mapping for which `held_back` is true, from the training states of each run. Each state
/// counts as the given number of `observations` of every value of the output.
///
/// # Errors
/// If a ridge regression cannot be solved.
pub(crate) fn sensor_share(
    mapping: &Mapping,
    runs: &[Vec<&State>],
    observations: f64,
    held_back: &dyn Fn(Quantity) -> bool,
) -> Result<f64> {
    if runs.len() < 2 || !mapping.inputs.iter().any(|&input| held_back(input)) {
        return Ok(SHARE_OF_ONE_RUN);
    }
    let penalties = Penalties::new(mapping, runs, observations)?;
    let mut best = (f64::INFINITY, SHARE_OF_ONE_RUN);
    for share in SHARES {
        let share_of = |quantity| if held_back(quantity) { share } else { 1.0 };
        let penalty = |quantity, deviation| penalties.of(quantity, deviation, share_of(quantity));
        let error = left_out_error(mapping, runs, &penalty)?;
        if error < best.0 {
            best = (error, share);
        }
    }
    Ok(best.1)
}

/// Sum of the squared errors over the states of all runs, where each run is predicted from the others.
fn left_out_error(
    mapping: &Mapping,
    runs: &[Vec<&State>],
    penalty: &dyn Fn(Quantity, f64) -> f64,
) -> Result<f64> {
    let mut error = 0.0;
    for (k, run) in runs.iter().enumerate() {
        let others: Vec<&State> = runs
            .iter()
            .enumerate()
            .filter(|(j, _)| *j != k)
            .flat_map(|(_, run)| run.iter().copied())
            .collect();
        error += squared_error(&Ridge::fit_with(mapping, &others, penalty)?, mapping, run);
    }
    Ok(error)
}

fn squared_error(ridge: &Ridge, mapping: &Mapping, states: &[&State]) -> f64 {
    let of = |state: &&State| -> f64 {
        let answer = ridge.answer(state);
        state.values(mapping.output).iter().zip(answer).map(|(value, answer)| (value - answer).powi(2)).sum()
    };
    states.iter().map(of).sum()
}

/// The penalties on the coefficients of ridge regression that correspond to the prior of the slopes.
struct Penalties {
    /// Variance of the noise over that of a slope, in the scaled units of a network, per observation.
    ratio: f64,
    /// Scaled units per unit of each quantity.
    factors: Vec<(Quantity, f64)>,
    /// Largest penalty, for sensors that do not vary.
    most: f64,
}

impl Penalties {
    fn new(mapping: &Mapping, runs: &[Vec<&State>], observations: f64) -> Result<Penalties> {
        let states: Vec<&State> = runs.concat();
        let values = |quantity| states.iter().map(move |state| state.values(quantity));
        let count = |quantity| values(quantity).next().map_or(1, <[f64]>::len);
        // The width is the largest range of any value of the quantity.
        let width = |quantity| {
            let range = |k: usize| {
                let ends = values(quantity).map(|v| v[k]);
                ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
            };
            (0..count(quantity)).map(|k| range(k).1 - range(k).0).fold(0.0, f64::max)
        };
        let all = values(mapping.output).flatten();
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
        let unit = if high > low { TARGET_RANGE / (high - low) } else { 0.0 };
        let alone = mapping.strain_only();
        let residual = squared_error(&Ridge::fit(&alone, &states)?, &alone, &states);
        let n = runs.len() as f64;
        let noise = residual / (states.len() * count(mapping.output)) as f64 * n / (n - 1.0);
        let factors = mapping.inputs.iter().map(|&quantity| {
            let widest = width(quantity);
            let columns = count(quantity) as f64;
            (quantity, if widest > 0.0 { 2.0 / (widest * columns.sqrt()) } else { 0.0 })
        });
        Ok(Penalties {
            ratio: noise * unit * unit / (SLOPE_VARIANCE * observations),
            factors: factors.collect(),
            most: 1e9 * states.len() as f64,
        })
    }

    /// The penalty on the coefficient of a value with the given standard deviation from its mean, for the given share.
    fn of(&self, quantity: Quantity, deviation: f64, share: f64) -> f64 {
        let factor = self.factors.iter().find(|(q, _)| *q == quantity).map_or(0.0, |(_, factor)| *factor);
        let seen = (factor * share * deviation).powi(2);
        if seen > 0.0 { (self.ratio / seen).clamp(LEAST_PENALTY, self.most) } else { self.most }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::paper_mapping;
    use crate::study_data::{StudyData, StudyDataOptions};
    use crate::synthetic::{Law, record};
    use granum_learn::dataset::NamedRecord;

    fn share(mapping: &str, law: Law, runs: u64) -> f64 {
        let records: Vec<_> = (1..=runs).map(|seed| record(law, seed, 60)).collect();
        let named: Vec<_> =
            records.iter().map(|record| NamedRecord { name: "run", seed: 0, record }).collect();
        let dataset = StudyData::new(&named, &[], &StudyDataOptions::default()).unwrap();
        let mapping = paper_mapping(mapping).unwrap();
        let held_back = |quantity| quantity != Quantity::DeviatorStrain;
        sensor_share(&mapping, &dataset.training_by_run(), 0.15, &held_back).unwrap()
    }

    /// A relation between fabric and stress ratio that changes its sign from run to run gives a small share, in contrast
    /// to one that is the same in all runs.
    #[test]
    fn what_only_holds_within_a_run_is_not_believed() {
        let state = |k: u32, sign: f64| {
            let strain = 0.005 * f64::from(k);
            let wave = (0.9 * f64::from(k)).sin();
            State {
                strain,
                stress_ratio: 0.5 + strain + 0.1 * sign * wave,
                deviator_fabric: 0.1 + 0.03 * wave,
                densities: vec![0.5],
            }
        };
        let mut mapping = paper_mapping("F4").unwrap();
        mapping.output = Quantity::StressRatio;
        for (signs, expected) in [([1.0; 4], SHARES[4]), ([1.0, -1.0, 1.0, -1.0], SHARES[0])] {
            let runs = signs.map(|sign| (1..60).map(|k| state(k, sign)).collect::<Vec<State>>());
            let runs: Vec<Vec<&State>> = runs.iter().map(|run| run.iter().collect()).collect();
            let held_back = |quantity| quantity == Quantity::DeviatorFabric;
            assert_eq!(sensor_share(&mapping, &runs, 0.15, &held_back).unwrap(), expected);
        }
    }

    #[test]
    fn sensors_that_tell_of_other_runs_are_believed() {
        for runs in [2, 4, 8] {
            assert_eq!(share("F1", Law::Hidden, runs), SHARES[4], "{runs} runs");
            assert_eq!(share("F6", Law::Hidden, runs), SHARES[4], "{runs} runs");
        }
        assert_eq!(share("F1", Law::Hidden, 1), SHARE_OF_ONE_RUN);
        assert_eq!(share("F6", Law::Blind, 1), SHARE_OF_ONE_RUN);
    }

    /// A fabric that never changes is a sensor with a range of zero.
    #[test]
    fn sensors_that_do_not_vary_do_no_harm() {
        let state = |k: u32, ratio: f64| State {
            strain: 0.01 * f64::from(k),
            stress_ratio: ratio * f64::from(k % 7),
            deviator_fabric: 0.1,
            densities: vec![0.5, 0.5],
        };
        let runs: Vec<Vec<State>> =
            [0.9, 1.1].iter().map(|&ratio| (1..30).map(|k| state(k, ratio)).collect()).collect();
        let runs: Vec<Vec<&State>> = runs.iter().map(|run| run.iter().collect()).collect();
        for name in ["F1", "F3", "F4", "F5", "F6"] {
            let share = sensor_share(&paper_mapping(name).unwrap(), &runs, 0.15, &|_| true).unwrap();
            assert!(SHARES.contains(&share), "{name}: {share}");
        }
    }
}
