//! The training data of a network: the selection of states, their weights, and the scaling of the inputs.
//!
//! By [`Rule::Separate`] a network learns only from the states in the range of its sub-model, with every row as a separate
//! example, as in Antony, Zhou and Wang (2006). By [`Rule::Pooled`] four things are different. Each was found by experiments on
//! runs that are not used for any evaluation (seeds 101 to 124 with 2000 grains; see the chapter on networks in the book):
//!
//! - **Neighbouring states are not independent.** The deviation of a run from the mean of all runs persists over about
//!   0.03 of deviator strain. If 60 states counted as 60 observations, Bayesian regularisation would fit the
//!   peculiarities of a run. A state counts as [`STATE_OBSERVATIONS`] of an observation, and a histogram as
//!   [`HISTOGRAM_OBSERVATIONS`], since its bins vary in four to five independent ways.
//! - **The points of a state form one observation.** In point form a state gives one row for each bin. If the rows
//!   were fitted separately, every single point would have to predict the target, whereas the mean of the predictions is
//!   evaluated. If the mean itself is fitted, the network learns a sum over the histogram.
//! - **Sub-models are trained on all states**, and predict in their own range. A third of the states would be too few for
//!   training, and curves would be discontinuous between sub-models.
//! - **An input has as much weight as its information on left-out runs supports.** The bins of a histogram share the
//!   range of one input and keep their proportions, so that bins that contain little but noise are not amplified. These
//!   bins, and all inputs besides the coordinate of a network whose output is a histogram, are scaled to a share of the range of
//!   an input, which is chosen by cross-validation over the training runs ([`super::sensor_share`]).

use granum_nets::{Data, DataError};

use super::mapping::{MappingQuantity, NetworkMapping};
use super::sensor_share::{RunRows, sensor_share};
use crate::dataset::Dataset;
use crate::error::Result;
use crate::surrogate::sub_model::is_within;

/// Effective number of independent observations of a state if the output is a column.
pub const STATE_OBSERVATIONS: f64 = 0.15;
/// Effective number of independent observations of a state if the output is a histogram.
pub const HISTOGRAM_OBSERVATIONS: f64 = 0.5;
/// Initial ratio of Bayesian regularisation for histograms, which have sharp features in the binned variable that the data
/// determine well.
const HISTOGRAM_FIRST_RATIO: f64 = 0.0016;
/// Largest number of training states of one network. With many runs, every run contributes fewer states, and different ones,
/// because neighbouring states contain nearly the same information.
pub const MOST_STATES: usize = 960;
/// Largest number of training states if the output is a histogram, since each state then contains more information.
pub const MOST_HISTOGRAMS: usize = 480;

/// The rule by which training rows are made from states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// Each network learns from the states in the range of its sub-model.
    Separate,
    /// Each network learns from the states of all sub-models, see [the module](self).
    #[default]
    Pooled,
}

/// Initial ratio of Bayesian regularisation, if it differs from the default of the trainer.
pub(super) fn first_ratio(mapping: &NetworkMapping) -> Option<f64> {
    mapping.predicts_histogram().then_some(HISTOGRAM_FIRST_RATIO)
}

/// The training states of a mapping.
pub(super) struct TrainingStates<'a> {
    pub mapping: &'a NetworkMapping,
    pub runs: Vec<RunRows>,
}

impl<'a> TrainingStates<'a> {
    /// The states of a data set.
    ///
    /// # Errors
    /// If a column is missing or a value is not finite.
    pub fn new(mapping: &'a NetworkMapping, dataset: &Dataset) -> Result<TrainingStates<'a>> {
        let columns = mapping.columns();
        let inputs = dataset.values(&columns.input_names())?;
        let outputs = dataset.values(&columns.output_names())?;
        let (mut at, mut runs) = (0, Vec::new());
        for run in dataset.runs() {
            let end = at + run.rows();
            let part = |values: &[f64], width: usize| -> Vec<Vec<f64>> {
                values[at * width..end * width].chunks_exact(width).map(<[f64]>::to_vec).collect()
            };
            runs.push(RunRows {
                inputs: part(&inputs, columns.inputs.len()),
                outputs: part(&outputs, columns.outputs.len()),
            });
            at = end;
        }
        Ok(TrainingStates { mapping, runs })
    }

    fn count(&self) -> usize {
        self.runs.iter().map(|run| run.inputs.len()).sum()
    }

    /// Number of states in the range of a sub-model.
    pub fn count_in(&self, sub_model: usize) -> usize {
        let states = self.runs.iter().flat_map(|run| &run.inputs);
        states.filter(|row| self.is_in(row, sub_model)).count()
    }

    fn is_in(&self, row: &[f64], sub_model: usize) -> bool {
        is_within(&self.mapping.sub_models, self.mapping.coordinate_of(row), Some(sub_model))
    }

    /// The training rows of a sub-model with their weights.
    ///
    /// # Errors
    /// If there are no rows.
    pub fn data(&self, sub_model: usize, rule: Rule) -> std::result::Result<Data, DataError> {
        let mapping = self.mapping;
        let histogram = mapping.predicts_histogram();
        let chosen = match rule {
            Rule::Separate => self.own_states(sub_model),
            Rule::Pooled => self.thinned(self.most()),
        };
        let (mut inputs, mut targets, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
        for &(run, state) in &chosen {
            let (input, output) = (&self.runs[run].inputs[state], &self.runs[run].outputs[state]);
            mapping.push_inputs(input, mapping.output_centres(), &mut inputs);
            match histogram {
                true => targets.extend_from_slice(output),
                false => targets.extend(std::iter::repeat_n(output[0], mapping.rows_of_state())),
            }
            // Each bin of a histogram that is predicted is an observation.
            blocks.extend(std::iter::repeat_n(run, output.len()));
        }
        let data = Data::new(inputs, mapping.network_inputs().len(), targets)?;
        if rule == Rule::Separate {
            return Ok(data);
        }
        let each = if histogram { HISTOGRAM_OBSERVATIONS } else { STATE_OBSERVATIONS };
        // Thinned states are more independent of each other, so that their total number of observations does not change.
        let observations = self.count() as f64 * each;
        let data = data.with_points(mapping.points_of_value())?.with_observations(observations)?;
        // The scatter differs between bins, and the binned variable is the last input.
        let column = if histogram { data.input_columns() - 1 } else { mapping.place_in_networks() };
        data.with_blocks(blocks)?.with_spread_column(column)
    }

    fn own_states(&self, sub_model: usize) -> Vec<(usize, usize)> {
        let runs = self.runs.iter().enumerate();
        let states = runs.flat_map(|(k, run)| (0..run.inputs.len()).map(move |state| (k, state)));
        states.filter(|&(run, state)| self.is_in(&self.runs[run].inputs[state], sub_model)).collect()
    }

    /// The states from which each network learns by [`Rule::Pooled`]: the number of the row in the data set, the inputs and the outputs.
    pub fn chosen(&self) -> impl Iterator<Item = (usize, &[f64], &[f64])> {
        let first: Vec<usize> = (self.runs.iter())
            .scan(0, |next, run| {
                let first = *next;
                *next += run.inputs.len();
                Some(first)
            })
            .collect();
        let state = move |(run, state): (usize, usize)| {
            let rows = &self.runs[run];
            (first[run] + state, rows.inputs[state].as_slice(), rows.outputs[state].as_slice())
        };
        self.thinned(self.most()).into_iter().map(state)
    }

    /// Largest number of training states.
    fn most(&self) -> usize {
        if self.mapping.predicts_histogram() { MOST_HISTOGRAMS } else { MOST_STATES }
    }

    /// At most `most` of the states, by the numbers of their runs and their numbers in the run, see [`every_nth`].
    fn thinned(&self, most: usize) -> Vec<(usize, usize)> {
        let lengths: Vec<usize> = self.runs.iter().map(|run| run.inputs.len()).collect();
        every_nth(&lengths, most)
    }

    /// For each input of a network the number of its quantity, see [`granum_nets::ModelDefinition::quantities`].
    pub fn quantities(&self, rule: Rule) -> Vec<usize> {
        match rule {
            Rule::Separate => Vec::new(),
            Rule::Pooled => self.mapping.input_quantities(),
        }
    }

    /// For each input of a network the share of the range to which it is scaled, see [`granum_nets::ModelDefinition::shares`].
    ///
    /// # Errors
    /// If the ridge regression for the choice of the share cannot be solved.
    pub fn shares(&self, rule: Rule) -> Result<Vec<f64>> {
        if rule == Rule::Separate {
            return Ok(Vec::new());
        }
        let mapping = self.mapping;
        let histogram = mapping.predicts_histogram();
        let held_back: Vec<bool> = (mapping.inputs.iter().enumerate())
            .map(|(k, input)| k != mapping.coordinate && (histogram || input.bins.is_some()))
            .collect();
        // Each bin of a histogram is one observation.
        let each = match histogram {
            true => HISTOGRAM_OBSERVATIONS / mapping.output.len() as f64,
            false => STATE_OBSERVATIONS,
        };
        let held_back_share = sensor_share(mapping, &self.runs, each, &held_back)?;
        let mut shares = Vec::new();
        for (input, held_back) in mapping.inputs.iter().zip(held_back) {
            let share = if held_back { held_back_share } else { 1.0 };
            // The binned variable itself is no measurement.
            match mapping.is_point(input) {
                true => shares.extend([1.0, share]),
                false => shares.extend(std::iter::repeat_n(share, MappingQuantity::len(input))),
            }
        }
        if histogram {
            shares.push(1.0);
        }
        Ok(shares)
    }
}

/// At most `most` of the states of runs with the given numbers of states, by the number of the run and of the state in it. If
/// there are too many, every n-th state of each run is taken, with a different first state in each run.
///
/// ```
/// use granum_learn::networks::training_rows::every_nth;
///
/// assert_eq!(every_nth(&[4, 4], 4), [(0, 0), (0, 2), (1, 1), (1, 3)]);
/// assert_eq!(every_nth(&[2, 1], 4), [(0, 0), (0, 1), (1, 0)]);
/// ```
pub fn every_nth(lengths: &[usize], most: usize) -> Vec<(usize, usize)> {
    let every = lengths.iter().sum::<usize>().div_ceil(most.max(1)).max(1);
    let runs = lengths.iter().enumerate();
    runs.flat_map(|(k, length)| (k % every..*length).step_by(every).map(move |state| (k, state))).collect()
}
