//! Fitted networks with a state.

use granum_nets::{Differentiable, Isa};
use serde::{Deserialize, Serialize};

use super::cell::{CellSizes, PathNetwork};
use super::channels::Channels;
use super::errors::PathErrors;
use super::growth::PathPlaces;
use super::rotation::Rotation;
use super::runs::PathRuns;
use crate::error::{LearnError, Result};
use crate::surrogate::prediction::{Estimate, Outside, Prediction, outside_of};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::Columns;

/// What the length of a path is called where it is beyond that of all training runs.
const PATH_LENGTH: &str = "length of the path";
/// What the ratio of that length to the farthest distance from the start is called where it is beyond that of all training runs.
const PATH_RATIO: &str = "length of the path over its farthest distance from the start";
/// Rounding of lengths.
pub(super) const ROUNDING: f64 = 1e-9;

/// What a file keeps.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Kept {
    pub sizes: CellSizes,
    pub channels: Channels,
    pub is_mean: bool,
    pub ranges: Vec<[f64; 2]>,
    pub errors: Option<PathErrors>,
    pub networks: Vec<Vec<f64>>,
}

/// Networks with a state, and what is known of their errors.
pub(super) struct FittedPath {
    pub columns: Columns,
    pub channels: Channels,
    pub sizes: CellSizes,
    /// True if predictions are means over the rotations of the axes.
    pub is_mean: bool,
    pub networks: Vec<Box<dyn PathNetwork>>,
    pub ranges: Vec<[f64; 2]>,
    pub errors: Option<PathErrors>,
}

impl FittedPath {
    /// The outputs of every network, in row-major order.
    pub fn outputs_of_networks(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        let widths = self.channels.widths();
        let runs = PathRuns {
            widths,
            increments: self.channels.increments(inputs),
            starts: self.channels.starts(inputs),
            targets: Vec::new(),
            lengths: inputs.lengths().to_vec(),
        };
        let rotations = self.rotations();
        let mut sums = vec![vec![0.0; inputs.len() * widths.outputs()]; self.networks.len()];
        for rotation in &rotations {
            let turned = rotation.as_ref().map(|rotation| runs.turned(|| rotation.clone()));
            let back = rotation.as_ref().map(Rotation::inverse);
            for (sum, values) in sums.iter_mut().zip(self.advanced(turned.as_ref().unwrap_or(&runs))?) {
                let mut values = values;
                if let Some(back) = &back {
                    let rows = values.chunks_exact_mut(widths.outputs());
                    rows.for_each(|row| back.turn(row, 0, widths.tensors));
                }
                sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            }
        }
        let count = rotations.len() as f64;
        sums.iter_mut().flatten().for_each(|sum| *sum /= count);
        let outputs = self.columns.outputs.len();
        Ok(sums.iter().map(|values| self.channels.outputs(values, outputs)).collect())
    }

    /// By what errors are divided ([`Channels::units`]), from the outputs of every network in row-major order.
    pub fn units(&self, networks: &[Vec<f64>]) -> Vec<f64> {
        let outputs = self.columns.outputs.len();
        let count = networks.len() as f64;
        let places = 0..networks.first().map_or(0, Vec::len);
        let means: Vec<f64> =
            places.map(|place| networks.iter().map(|values| values[place]).sum::<f64>() / count).collect();
        means.chunks_exact(outputs).flat_map(|row| self.channels.units(row)).collect()
    }

    /// The rotations over which predictions are means; `None` leaves the axes as they are.
    pub fn rotations(&self) -> Vec<Option<Rotation>> {
        match self.is_mean {
            true => Rotation::of_axes().into_iter().map(Some).collect(),
            false => vec![None],
        }
    }

    /// The prediction for a row, of which the number and the inputs are given, from the outputs of each network. Of intervals the factors of each output
    /// are known, and how large errors are for each sample.
    pub fn prediction(
        &self,
        networks: &[Vec<f64>],
        path: &PathPlaces,
        known: Option<(&[f64], &[Vec<f64>])>,
        (row, values): (usize, &[f64]),
    ) -> Prediction {
        let outputs = self.columns.outputs.len();
        let mean =
            |place: usize| networks.iter().map(|values| values[place]).sum::<f64>() / networks.len() as f64;
        let means: Vec<f64> = (0..outputs).map(|output| mean(row * outputs + output)).collect();
        let units = self.channels.units(&means);
        let estimate = |output: usize| match (&self.errors, known) {
            (Some(errors), Some((factors, sizes))) => {
                let by = [sizes[path.run[row]][output], units[output], factors[output]];
                errors.estimate(networks, (row, output), path, by)
            }
            _ => Estimate::new(means[output]),
        };
        let mut outside = outside_of(&self.columns, &self.ranges, values);
        outside.extend(self.beyond(path, row));
        Prediction::new((0..outputs).map(estimate).collect()).with_outside(outside)
    }

    /// What each network predicts, in its units.
    fn advanced(&self, runs: &PathRuns) -> Result<Vec<Vec<f64>>> {
        let sequences = runs.sequences().map_err(|error| self.failed(error))?;
        let rows = self.sizes.inputs(&runs.widths, &runs.increments, &runs.lengths);
        let advance = |network: &dyn Differentiable| {
            network.evaluate(Isa::detect(), &rows, Some(&sequences)).map_err(|error| self.failed(error))
        };
        self.networks.iter().map(|network| advance(network.as_ref())).collect()
    }

    /// What is said of a path that is longer than any of the training runs, or turns more often.
    fn beyond(&self, path: &PathPlaces, row: usize) -> Vec<Outside> {
        let Some(errors) = &self.errors else { return Vec::new() };
        let outside = |name: &str, value: f64, low: f64, most: f64| {
            let is_beyond = value > (1.0 + ROUNDING) * most;
            is_beyond.then(|| Outside { name: name.into(), value, range: [low, most] })
        };
        let length = outside(PATH_LENGTH, path.length[row], 0.0, errors.longest());
        let most = Some(errors.largest_ratio()).filter(|most| *most > 0.0);
        let ratio = most.zip(path.ratio(row)).and_then(|(most, ratio)| outside(PATH_RATIO, ratio, 1.0, most));
        length.into_iter().chain(ratio).collect()
    }

    pub fn failed(&self, error: impl std::fmt::Display) -> LearnError {
        LearnError::Surrogate { method: self.sizes.cell.name().into(), reason: error.to_string() }
    }
}
