//! The split of a data set into training, held-out and unseen parts.

use std::collections::BTreeSet;

use granum_core::digest::Digest;
use serde::{Deserialize, Serialize};

use super::keys::STATE;
use super::named_columns::Dataset;
use super::run_states::RunStates;
use crate::error::{LearnError, Result};

/// The rule for splitting a data set: every n-th state of the training runs is used for training (n is the stride), the others
/// are held out, and the unseen runs are used for evaluation only.
///
/// See [`Dataset`] for an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Split {
    /// Stride n: every n-th state is used for training (2).
    pub stride: usize,
    /// Number of the first state that is used, which is also the first training state; earlier states of a stage are
    /// omitted (0).
    pub first_state: u64,
    /// Names of the unseen runs.
    pub unseen: Vec<String>,
    /// A column and its range, including the ends, to which all parts are restricted.
    pub within: Option<(String, [f64; 2])>,
}

impl Default for Split {
    fn default() -> Self {
        Split { stride: 2, first_state: 0, unseen: Vec::new(), within: None }
    }
}

impl Split {
    /// Sets the stride; with 1 no state is held out.
    pub fn stride(self, stride: usize) -> Split {
        Split { stride, ..self }
    }

    /// Sets the first state.
    pub fn first_state(self, first_state: u64) -> Split {
        Split { first_state, ..self }
    }

    /// Sets the names of the unseen runs.
    pub fn unseen<S: Into<String>>(self, names: impl IntoIterator<Item = S>) -> Split {
        Split { unseen: names.into_iter().map(Into::into).collect(), ..self }
    }

    /// Restricts all parts to a range of a column.
    pub fn within(self, column: &str, range: [f64; 2]) -> Split {
        Split { within: Some((column.into(), range)), ..self }
    }

    fn apply(&self, dataset: &Dataset) -> Result<SplitParts> {
        let bad = |reason: String| Err(LearnError::Dataset(reason));
        if self.stride == 0 {
            return bad("the stride of training states must be 1 or more, not 0".into());
        }
        let known: BTreeSet<&str> = dataset.runs().iter().map(RunStates::name).collect();
        for name in &self.unseen {
            if !known.contains(name.as_str()) {
                let names = dataset.runs().iter().map(RunStates::name);
                let hint = granum_core::names::suggestion(name, names);
                return bad(format!("there is no run {name} to keep unseen; {hint}"));
            }
        }
        if let Some((name, _)) = &self.within {
            dataset.variable(name)?;
        }
        let used = dataset.select(|run, row| self.uses(run, row));
        let unseen: BTreeSet<&str> = self.unseen.iter().map(String::as_str).collect();
        let is_unseen = |run: &RunStates| unseen.contains(run.name());
        let trains = |run: &RunStates, row: usize| {
            (state_of(run, row) - self.first_state).is_multiple_of(self.stride as u64)
        };
        let parts = SplitParts {
            training_runs: used.select(|run, _| !is_unseen(run)),
            training: used.select(|run, row| !is_unseen(run) && trains(run, row)),
            held_out: used.select(|run, row| !is_unseen(run) && !trains(run, row)),
            unseen: used.select(|run, _| is_unseen(run)),
        };
        if parts.training.rows() == 0 {
            return bad("the split leaves no state to train on".into());
        }
        Ok(parts)
    }

    fn uses(&self, run: &RunStates, row: usize) -> bool {
        let inside = |(name, [low, high]): &(String, [f64; 2])| {
            let value = run.parameter(name).or_else(|| run.values(name).ok()?.get(row).copied());
            value.is_some_and(|value| value >= *low && value <= *high)
        };
        state_of(run, row) >= self.first_state && self.within.as_ref().is_none_or(inside)
    }
}

/// The numbers of the runs that a share of whole runs keeps unseen, in their order: at least one, and not all. A run is chosen by the
/// SHA-256 of its name and the seed, so that it does not depend on the order of the runs, and more runs change little.
///
/// ```
/// use granum_learn::dataset::unseen_runs;
///
/// let names: Vec<String> = (0..10).map(|k| format!("run {k}")).collect();
/// let unseen = unseen_runs(&names, 0.3, 1);
/// assert_eq!(unseen.len(), 3);
/// assert_ne!(unseen, unseen_runs(&names, 0.3, 2));
/// ```
pub fn unseen_runs<S: AsRef<str>>(names: &[S], share: f64, seed: u64) -> Vec<usize> {
    let rank = |name: &S| {
        let mut digest = Digest::new();
        digest.text("granum unseen runs 1");
        digest.count(seed as usize);
        digest.text(name.as_ref());
        digest.finish()
    };
    let mut ranked: Vec<(String, usize)> =
        names.iter().enumerate().map(|(k, name)| (rank(name), k)).collect();
    ranked.sort();
    let most = names.len().saturating_sub(1);
    let count = (libm::round(share * names.len() as f64) as usize).clamp(1.min(most), most);
    let mut chosen: Vec<usize> = ranked.into_iter().take(count).map(|(_, k)| k).collect();
    chosen.sort_unstable();
    chosen
}

impl Dataset {
    /// Splits the data set into training, held-out and unseen parts.
    ///
    /// # Errors
    /// If the split names a run that does not exist, or if there are no training rows left.
    pub fn split(&self, split: &Split) -> Result<SplitParts> {
        split.apply(self)
    }
}

/// Number of the state of a row.
fn state_of(run: &RunStates, row: usize) -> u64 {
    run.table().values(STATE).and_then(|states| states.get(row)).map_or(0, |state| *state as u64)
}

/// The parts of a data set.
#[derive(Clone, Debug, PartialEq)]
pub struct SplitParts {
    /// All states of the training runs, training and held-out ones, for methods with memory.
    pub training_runs: Dataset,
    /// Training states.
    pub training: Dataset,
    /// Held-out states of the same runs.
    pub held_out: Dataset,
    /// States of unseen runs.
    pub unseen: Dataset,
}
