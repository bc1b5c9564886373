//! The weight of the inputs in the networks of a mapping, chosen by cross-validation over runs.
//!
//! The regularisation is the same for all weights of a network, and it must permit the steep curve along the
//! coordinate. An input that contains no information on other runs could then get equally steep slopes. Inputs that can do
//! harm are therefore scaled to a share of the range of an input, since a small share makes slopes expensive. The share is
//! chosen with ridge regression, which costs hardly any time: every training run is predicted from the others,
//!
//! ```text
//! predicted = B(coordinate) a + sum_k b_k x_k,   x_k = deviation of input k from its mean along the coordinate, scaled as in the network
//! ```
//!
//! where `b_k` has a normal prior distribution with the variance [`SLOPE_VARIANCE`] that is typical of slopes in networks,
//! and the share with the smallest squared error is chosen. This needs at least two runs; for a single run an intermediate
//! share is used.

use granum_nets::dot;

use super::mapping::NetworkMapping;
use crate::error::{LearnError, Result};
use crate::regression::deviations::{Deviation, Regression, row};
use crate::regression::spline::basis;

/// The shares that are tried.
pub const SHARES: [f64; 5] = [0.03, 0.055, 0.1, 0.17, 0.3];
/// The share for a single training run, for which there is no cross-validation.
pub const SHARE_OF_ONE_RUN: f64 = 0.1;
/// Variance of the slope of an output as a function of an input, both in the scaled units of a network.
pub const SLOPE_VARIANCE: f64 = 1.0;
/// Smallest penalty, which keeps the equations solvable if an output does not vary.
const LEAST_PENALTY: f64 = 1e-6;
/// Penalty on the squared coefficients of the inputs of a regression without a prior, times the number of states.
const INPUT_PENALTY: f64 = 0.05;
/// Fraction of the output range of a network that the targets cover.
const TARGET_RANGE: f64 = 0.8;

/// The states of one run: the values of the inputs and of the output of a mapping.
#[derive(Clone, Debug, Default)]
pub struct RunRows {
    /// For each state a row of the inputs in [`NetworkMapping::columns`].
    pub inputs: Vec<Vec<f64>>,
    /// For each state the values of the output.
    pub outputs: Vec<Vec<f64>>,
}

/// A state: its inputs and its outputs.
type State<'a> = (&'a [f64], &'a [f64]);

impl RunRows {
    fn states(&self) -> impl Iterator<Item = State<'_>> {
        self.inputs.iter().map(Vec::as_slice).zip(self.outputs.iter().map(Vec::as_slice))
    }
}

/// The share for those inputs of a mapping for which `held_back` is true, from the training states of each run. Each state
/// counts as the given number of `observations` of every value of the output.
///
/// # Errors
/// If a ridge regression cannot be solved.
pub fn sensor_share(
    mapping: &NetworkMapping,
    runs: &[RunRows],
    observations: f64,
    held_back: &[bool],
) -> Result<f64> {
    if runs.len() < 2 || !held_back.contains(&true) {
        return Ok(SHARE_OF_ONE_RUN);
    }
    let penalties = Penalties::new(mapping, runs, observations)?;
    let mut best = (f64::INFINITY, SHARE_OF_ONE_RUN);
    for share in SHARES {
        let share_of = |quantity: usize| if held_back[quantity] { share } else { 1.0 };
        let penalty = |quantity, deviation| penalties.penalty(quantity, deviation, share_of(quantity));
        let error = left_out_error(mapping, runs, &penalty)?;
        if error < best.0 {
            best = (error, share);
        }
    }
    Ok(best.1)
}

/// Sum of the squared errors over the states of all runs, where each run is predicted from the others.
fn left_out_error(
    mapping: &NetworkMapping,
    runs: &[RunRows],
    penalty: &dyn Fn(usize, f64) -> f64,
) -> Result<f64> {
    let mut error = 0.0;
    for (k, run) in runs.iter().enumerate() {
        let others = runs.iter().enumerate().filter(|(j, _)| *j != k);
        let others: Vec<State> = others.flat_map(|(_, run)| run.states()).collect();
        let own: Vec<State> = run.states().collect();
        error += PriorRegression::fit(mapping, &others, penalty)?.squared_error(&own);
    }
    Ok(error)
}

/// Ridge regression on splines of the coordinate with a penalty for each input.
struct PriorRegression<'a> {
    mapping: &'a NetworkMapping,
    /// Start and end of the coordinate.
    ends: [f64; 2],
    /// One deviation for each value of the inputs besides the coordinate; empty for a regression on the coordinate alone.
    deviations: Vec<Deviation>,
    /// For each value of the output the coefficients of the splines, followed by those of the deviations.
    coefficients: Vec<Vec<f64>>,
}

impl<'a> PriorRegression<'a> {
    /// Fits states; the penalty is a function of the number of the input and of the standard deviation of the value from its
    /// mean along the coordinate.
    fn fit(
        mapping: &'a NetworkMapping,
        states: &[State],
        penalty: &dyn Fn(usize, f64) -> f64,
    ) -> Result<PriorRegression<'a>> {
        PriorRegression::fit_to(mapping, states, true, penalty)
    }

    /// Fits the coordinate alone.
    fn fit_alone(mapping: &'a NetworkMapping, states: &[State]) -> Result<PriorRegression<'a>> {
        PriorRegression::fit_to(mapping, states, false, &|_, _| INPUT_PENALTY * states.len() as f64)
    }

    fn fit_to(
        mapping: &'a NetworkMapping,
        states: &[State],
        with_inputs: bool,
        penalty: &dyn Fn(usize, f64) -> f64,
    ) -> Result<PriorRegression<'a>> {
        if states.is_empty() {
            return Err(LearnError::Dataset("ridge regression has no training state".to_owned()));
        }
        let unsolved =
            || LearnError::Dataset(format!("{}: the ridge regression has no solution", mapping.name));
        let ends = states.iter().fold([0.0f64, 0.0], |[start, end], (inputs, _)| {
            let x = mapping.coordinate_of(inputs);
            [start.min(x), end.max(x)]
        });
        let splines: Vec<Vec<f64>> = states
            .iter()
            .map(|(inputs, _)| basis(mapping.coordinate_of(inputs) - ends[0], ends[1] - ends[0]).to_vec())
            .collect();
        let places = if with_inputs { values_besides_coordinate(mapping) } else { Vec::new() };
        let inputs: Vec<Vec<f64>> = (places.iter())
            .map(|(_, place)| states.iter().map(|(inputs, _)| inputs[*place]).collect())
            .collect();
        let penalty = |input: usize, deviation: f64| penalty(places[input].0, deviation);
        let regression = Regression::new(&splines, &inputs, &penalty).ok_or_else(unsolved)?;
        let coefficients = (0..mapping.output.len())
            .map(|k| {
                regression.coefficients(&states.iter().map(|(_, outputs)| outputs[k]).collect::<Vec<_>>())
            })
            .collect();
        Ok(PriorRegression { mapping, ends, deviations: regression.into_deviations(), coefficients })
    }

    fn squared_error(&self, states: &[State]) -> f64 {
        let [start, end] = self.ends;
        let places = values_besides_coordinate(self.mapping);
        let error = |(inputs, outputs): &State| -> f64 {
            let functions = basis(self.mapping.coordinate_of(inputs) - start, end - start);
            let row = row(&self.deviations, &functions, places.iter().map(|(_, place)| inputs[*place]));
            let errors =
                outputs.iter().zip(&self.coefficients).map(|(value, c)| (value - dot(c, &row)).powi(2));
            errors.sum()
        };
        states.iter().map(error).sum()
    }
}

/// For each value of the inputs besides the coordinate: the number of its input, and its place in a row.
fn values_besides_coordinate(mapping: &NetworkMapping) -> Vec<(usize, usize)> {
    let inputs = mapping.inputs.iter().enumerate();
    let all = inputs.flat_map(|(k, input)| std::iter::repeat_n(k, input.len()));
    all.enumerate().map(|(place, k)| (k, place)).filter(|(k, _)| *k != mapping.coordinate).collect()
}

/// The penalties on the coefficients of ridge regression that correspond to the prior of the slopes.
struct Penalties {
    /// Variance of the noise over that of a slope, in the scaled units of a network, per observation.
    ratio: f64,
    /// Scaled units per unit of each input.
    factors: Vec<f64>,
    /// Largest penalty, for inputs that do not vary.
    most: f64,
}

impl Penalties {
    fn new(mapping: &NetworkMapping, runs: &[RunRows], observations: f64) -> Result<Penalties> {
        let states: Vec<State> = runs.iter().flat_map(RunRows::states).collect();
        let ends = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
        };
        let (low, high) = ends(&mut states.iter().flat_map(|(_, outputs)| outputs.iter().copied()));
        let unit = if high > low { TARGET_RANGE / (high - low) } else { 0.0 };
        let residual = PriorRegression::fit_alone(mapping, &states)?.squared_error(&states);
        let n = runs.len() as f64;
        let noise = residual / (states.len() * mapping.output.len()) as f64 * n / (n - 1.0);
        let mut first = 0;
        let factor = |count: usize| {
            // The width is the largest range of any value of the quantity.
            let range = |place: usize| {
                let (a, b) = ends(&mut states.iter().map(|(inputs, _)| inputs[place]));
                b - a
            };
            let widest = (first..first + count).map(range).fold(0.0, f64::max);
            first += count;
            if widest > 0.0 { 2.0 / (widest * (count as f64).sqrt()) } else { 0.0 }
        };
        let factors = mapping.inputs.iter().map(|input| input.len()).map(factor).collect();
        Ok(Penalties {
            ratio: noise * unit * unit / (SLOPE_VARIANCE * observations),
            factors,
            most: 1e9 * states.len() as f64,
        })
    }

    /// The penalty on the coefficient of a value with the given standard deviation from its mean, for the given share.
    fn penalty(&self, input: usize, deviation: f64, share: f64) -> f64 {
        let seen = (self.factors[input] * share * deviation).powi(2);
        if seen > 0.0 { (self.ratio / seen).clamp(LEAST_PENALTY, self.most) } else { self.most }
    }
}
