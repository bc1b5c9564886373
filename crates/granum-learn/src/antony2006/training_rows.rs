//! What a network is given to learn from: which states, how much each of them counts, and how its inputs are weighed.
//!
//! The paper's trainer gets what the paper gave it: the states of its sub-model alone, every row an example of its own. For
//! the default trainer four things are different, each found by experiment on runs that judge nothing (seeds 101 to 124 of
//! 2000 grains; see the chapter on networks in the book):
//!
//! - **Neighbouring states are not independent.** What a run differs by from the mean of all runs lasts over some 0.03 of
//!   deviator strain. Told that 60 states are 60 observations, Bayesian regularisation takes the peculiarities of a run
//!   for structure. A state counts as [`STATE_OBSERVATIONS`] of an observation, a distribution as
//!   [`DISTRIBUTION_OBSERVATIONS`]: its bins differ in four to five independent ways.
//! - **The points of a state answer together.** In point form a state gives one row a bin of f. Trained row by row, every
//!   single point has to guess the answer, and the mean of 14 guesses is judged. Trained on that mean, the network learns a
//!   sum over the distribution.
//! - **Sub-models learn from all states**, and answer in their own range. A third of the states is too little to learn from,
//!   and curves jumped where sub-models met.
//! - **A sensor is believed as far as it tells of runs that are left out.** Bins of a distribution share the range of one
//!   input and keep their proportions, so that bins with little but noise are not blown up; these, and every sensor of a
//!   network that answers with a distribution, get a share of the range of an input that the training runs choose
//!   ([`crate::antony2006::sensor_share`]).

use granum_nets::{Data, DataError};

use crate::antony2006::mapping::{Form, Mapping, Quantity};
use crate::antony2006::mapping_networks::states_of;
use crate::antony2006::sensor_share::sensor_share;
use crate::antony2006::study::PAPER_TRAINER;
use crate::antony2006::study_data::{Rows, State, StudyData};
use crate::error::Result as OrError;

/// How many independent observations a state that answers with a number is worth.
const STATE_OBSERVATIONS: f64 = 0.15;
/// The same for a state that answers with a distribution.
const DISTRIBUTION_OBSERVATIONS: f64 = 0.5;
/// Where Bayesian regularisation starts for distributions, whose shape over f is sharp and well determined.
const DISTRIBUTION_FIRST_RATIO: f64 = 0.0016;
/// Most states that one network learns from. With more runs every run gives fewer, each other ones: neighbouring states
/// say nearly the same.
const MOST_STATES: usize = 960;
/// The same for states that answer with a distribution, each of which says more.
const MOST_DISTRIBUTIONS: usize = 480;

/// How examples are made of states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// As the paper did.
    Paper,
    /// As above.
    Pooled,
}

/// The rule for a trainer.
pub(crate) fn rule_of(trainer: &str) -> Rule {
    if trainer == PAPER_TRAINER { Rule::Paper } else { Rule::Pooled }
}

/// Rows of a state that answer together, for a network that is trained by this rule.
pub(crate) fn points(mapping: &Mapping, form: Form, bins: usize, rule: Rule) -> usize {
    let number = mapping.output != Quantity::ForceDistribution;
    if rule == Rule::Pooled && number && mapping.has_point_rows(form) { bins } else { 1 }
}

/// Where Bayesian regularisation starts, if not at the trainer's default.
pub(crate) fn first_ratio(mapping: &Mapping) -> Option<f64> {
    (mapping.output == Quantity::ForceDistribution).then_some(DISTRIBUTION_FIRST_RATIO)
}

/// The rows that a sub-model learns from, with what they count.
///
/// # Errors
/// If there is none.
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
    // States further apart are more independent: what they count together does not change.
    let observations = dataset.training().len() as f64 * each;
    let bins = dataset.forces.len();
    let data = data.with_points(points(mapping, form, bins, rule))?.with_observations(observations)?;
    // Of a distribution every bin is an observation; its scatter differs from bin to bin, and f is the last input.
    let each = if distribution { bins } else { 1 };
    let column = if distribution { data.input_columns() - 1 } else { 0 };
    let blocks = blocks.iter().flat_map(|&block| std::iter::repeat_n(block, each)).collect();
    data.with_blocks(blocks)?.with_spread_column(column)
}

/// At most so many of the training states with the number of their run: of many runs every so manieth state of each, beginning
/// with another one in each run.
fn thinned(dataset: &StudyData, most: usize) -> Vec<(usize, &State)> {
    let every = dataset.training().len().div_ceil(most).max(1);
    let runs = dataset.training_runs.iter().enumerate();
    let states = runs.flat_map(|(k, run)| {
        let training = run.states.iter().zip(&run.numbers).filter(|(_, number)| dataset.trains(**number));
        training.map(move |(state, _)| (k, state)).skip(k % every).step_by(every)
    });
    states.collect()
}

/// Which quantity each input of a network belongs to, see [`granum_nets::Recipe::quantities`].
pub(crate) fn quantities(mapping: &Mapping, form: Form, bins: usize, rule: Rule) -> Vec<usize> {
    match rule {
        Rule::Paper => Vec::new(),
        Rule::Pooled => mapping.input_quantities(form, bins),
    }
}

/// The share of its range that each input of a network is given, see [`granum_nets::Recipe::shares`].
///
/// # Errors
/// If the ridge regression that judges the sensors cannot be solved.
pub(crate) fn shares(dataset: &StudyData, mapping: &Mapping, form: Form, rule: Rule) -> OrError<Vec<f64>> {
    if rule == Rule::Paper {
        return Ok(Vec::new());
    }
    let bins = dataset.forces.len();
    let distribution = mapping.output == Quantity::ForceDistribution;
    let held_back = |input: Quantity| {
        input != Quantity::DeviatorStrain && (distribution || input == Quantity::ForceDistribution)
    };
    // Each bin of a distribution is one of its observations.
    let each = if distribution { DISTRIBUTION_OBSERVATIONS / bins as f64 } else { STATE_OBSERVATIONS };
    let held_back_share = sensor_share(mapping, &dataset.training_by_run(), each, &held_back)?;
    let mut shares = Vec::new();
    for &input in &mapping.inputs {
        let share = if held_back(input) { held_back_share } else { 1.0 };
        match (input == Quantity::ForceDistribution, form) {
            // f itself is no sensor.
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
