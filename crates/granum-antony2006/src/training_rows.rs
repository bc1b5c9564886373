//! The training data of a network: the selection of states, their weights, and the scaling of the inputs.
//!
//! The trainer of the paper receives the data as in the paper: only the states of its sub-model, with every row as a
//! separate example. For the default trainer four things are different. Each was found by experiments on runs that are not
//! used for any evaluation (seeds 101 to 124 with 2000 grains; see the chapter on networks in the book):
//!
//! - **Neighbouring states are not independent.** The deviation of a run from the mean of all runs persists over about
//!   0.03 of deviator strain. If 60 states counted as 60 observations, Bayesian regularisation would fit the
//!   peculiarities of a run. A state counts as [`STATE_OBSERVATIONS`] of an observation, and a distribution as
//!   [`DISTRIBUTION_OBSERVATIONS`], since its bins vary in four to five independent ways.
//! - **The points of a state form one observation.** In point form a state gives one row for each bin of f. If the rows
//!   were fitted separately, every single point would have to predict the target, whereas the mean of 14 predictions is
//!   evaluated. If the mean itself is fitted, the network learns a sum over the distribution.
//! - **Sub-models are trained on all states**, and predict in their own range. A third of the states would be too few for
//!   training, and curves would be discontinuous between sub-models.
//! - **A sensor has as much weight as its information on left-out runs supports.** The bins of a distribution share the
//!   range of one input and keep their proportions, so that bins that contain little but noise are not amplified. These
//!   bins, and all sensors of a network whose output is a distribution, are scaled to a share of the range of an input,
//!   which is chosen by cross-validation over the training runs ([`crate::sensor_share`]).

use granum_nets::{Data, DataError};

use crate::mapping::{Form, Mapping, Quantity};
use crate::mapping_networks::states_of;
use crate::sensor_share::sensor_share;
use crate::study::options::PAPER_TRAINER;
use crate::study_data::{Rows, State, StudyData};
use granum_learn::Result as OrError;

/// Effective number of independent observations of a state if the output is a scalar.
const STATE_OBSERVATIONS: f64 = 0.15;
/// Effective number of independent observations of a state if the output is a distribution.
const DISTRIBUTION_OBSERVATIONS: f64 = 0.5;
/// Initial ratio of Bayesian regularisation for distributions, which have sharp features in f that the data determine well.
const DISTRIBUTION_FIRST_RATIO: f64 = 0.0016;
/// Largest number of training states of one network. With many runs, every run contributes fewer states, and different ones,
/// because neighbouring states contain nearly the same information.
const MOST_STATES: usize = 960;
/// Largest number of training states if the output is a distribution, since each state then contains more information.
const MOST_DISTRIBUTIONS: usize = 480;

/// The rule by which training rows are made from states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// The rule of the paper.
    Paper,
    /// The rule for the default trainer, see the module.
    Pooled,
}

/// The rule for a trainer.
pub(crate) fn rule_of(trainer: &str) -> Rule {
    if trainer == PAPER_TRAINER { Rule::Paper } else { Rule::Pooled }
}

/// Number of rows of a state that form one observation, for a network that is trained by the given rule.
pub(crate) fn points(mapping: &Mapping, form: Form, bins: usize, rule: Rule) -> usize {
    let number = mapping.output != Quantity::ForceDistribution;
    if rule == Rule::Pooled && number && mapping.has_point_rows(form) { bins } else { 1 }
}

/// Initial ratio of Bayesian regularisation, if it differs from the default of the trainer.
pub(crate) fn first_ratio(mapping: &Mapping) -> Option<f64> {
    (mapping.output == Quantity::ForceDistribution).then_some(DISTRIBUTION_FIRST_RATIO)
}

/// The training rows of a sub-model with their weights.
///
/// # Errors
/// If there are no rows.
pub(crate) fn data(
    dataset: &StudyData,
    mapping: &Mapping,
    sub_model: usize,
    form: Form,
    rule: Rule,
) -> Result<Data, DataError> {
    let distribution = mapping.output == Quantity::ForceDistribution;
    let (blocks, states): (Vec<usize>, Vec<&State>) = match rule {
        Rule::Paper => {
            let states = states_of(mapping, dataset.training(), Some(sub_model));
            (vec![0; states.len()], states)
        }
        Rule::Pooled => {
            thinned(dataset, if distribution { MOST_DISTRIBUTIONS } else { MOST_STATES }).into_iter().unzip()
        }
    };
    let rows = Rows::new(mapping, form, &dataset.forces, states.iter().copied());
    let data = Data::new(rows.inputs, rows.input_columns, rows.targets)?;
    if rule == Rule::Paper {
        return Ok(data);
    }
    let each = if distribution { DISTRIBUTION_OBSERVATIONS } else { STATE_OBSERVATIONS };
    // Thinned states are more independent of each other, so that their total number of observations does not change.
    let observations = dataset.training().len() as f64 * each;
    let bins = dataset.forces.len();
    let data = data.with_points(points(mapping, form, bins, rule))?.with_observations(observations)?;
    // For a distribution every bin is an observation. The scatter differs between bins, and f is the last input.
    let each = if distribution { bins } else { 1 };
    let column = if distribution { data.input_columns() - 1 } else { 0 };
    let blocks = blocks.iter().flat_map(|&block| std::iter::repeat_n(block, each)).collect();
    data.with_blocks(blocks)?.with_spread_column(column)
}

/// At most `most` of the training states, with the numbers of their runs. If there are too many, every n-th state of each
/// run is taken, with a different first state in each run.
fn thinned(dataset: &StudyData, most: usize) -> Vec<(usize, &State)> {
    let every = dataset.training().len().div_ceil(most).max(1);
    let runs = dataset.training_runs.iter().enumerate();
    let states = runs.flat_map(|(k, run)| {
        let training = run.states.iter().zip(&run.numbers).filter(|(_, number)| dataset.trains(**number));
        training.map(move |(state, _)| (k, state)).skip(k % every).step_by(every)
    });
    states.collect()
}

/// For each input of a network the number of its quantity, see [`granum_nets::ModelDefinition::quantities`].
pub(crate) fn quantities(mapping: &Mapping, form: Form, bins: usize, rule: Rule) -> Vec<usize> {
    match rule {
        Rule::Paper => Vec::new(),
        Rule::Pooled => mapping.input_quantities(form, bins),
    }
}

/// For each input of a network the share of the range to which it is scaled, see [`granum_nets::ModelDefinition::shares`].
///
/// # Errors
/// If the ridge regression for the choice of the share cannot be solved.
pub(crate) fn shares(dataset: &StudyData, mapping: &Mapping, form: Form, rule: Rule) -> OrError<Vec<f64>> {
    if rule == Rule::Paper {
        return Ok(Vec::new());
    }
    let bins = dataset.forces.len();
    let distribution = mapping.output == Quantity::ForceDistribution;
    let held_back = |input: Quantity| {
        input != Quantity::DeviatorStrain && (distribution || input == Quantity::ForceDistribution)
    };
    // Each bin of a distribution is one observation.
    let each = if distribution { DISTRIBUTION_OBSERVATIONS / bins as f64 } else { STATE_OBSERVATIONS };
    let held_back_share = sensor_share(mapping, &dataset.training_by_run(), each, &held_back)?;
    let mut shares = Vec::new();
    for &input in &mapping.inputs {
        let share = if held_back(input) { held_back_share } else { 1.0 };
        match (input == Quantity::ForceDistribution, form) {
            // f itself is not a sensor.
            (true, Form::Point) => shares.extend([1.0, share]),
            (true, Form::Histogram) => shares.extend(std::iter::repeat_n(share, bins)),
            (false, _) => shares.push(share),
        }
    }
    if distribution {
        shares.push(1.0);
    }
    Ok(shares)
}
