//! Tests whether predictions use their inputs.
//!
//! A surrogate with a small error may have learned nothing but the curve as a function of its coordinate. Every unseen run is
//! therefore predicted again with other values of the other inputs:
//!
//! - those of **another** unseen run at the same coordinate, with every other unseen run in turn: they are correct on
//!   average, but not in the deviation of this run from the others;
//! - those of the run itself, **permuted** over its states: they are correct as a set, but not at each coordinate.
//!
//! The increase of the error with the inputs of other runs measures the *use* of the inputs. The difference between the
//! error of a surrogate whose only input is the coordinate and that of the surrogate measures the *help* of the inputs. Each
//! is one number per unseen run, and counts as established if the mean is above zero in a one-sided t test at 5 %
//! ([`crate::student_t`]), where runs are assumed to be independent.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::score::{Score, Scorer};
use crate::student_t::{FEWEST, PairedTest};

/// Number of permutations that are averaged.
const PERMUTATIONS: u64 = 5;

/// The conclusion whether a surrogate uses its inputs and whether they reduce its error. In the paper the inputs are sensors,
/// and its files call them so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Its errors are larger with the inputs of another run, and smaller than those from the coordinate alone.
    #[serde(rename = "uses its sensors and gains by it")]
    Gains,
    /// Its errors are larger with the inputs of another run, but not smaller than those from the coordinate alone.
    #[serde(rename = "uses its sensors without gain")]
    WithoutGain,
    /// Its errors are not significantly larger with the inputs of another run.
    #[serde(rename = "does not use them")]
    DoesNotUse,
    /// There are fewer than three unseen runs.
    #[default]
    #[serde(rename = "cannot be told from so few runs")]
    TooFewRuns,
}

impl Verdict {
    /// The conclusion in words, where `inputs` is what the inputs are called: `uses its inputs and gains by it`.
    pub fn words(self, inputs: &str) -> String {
        match self {
            Verdict::Gains => format!("uses its {inputs} and gains by it"),
            Verdict::WithoutGain => format!("uses its {inputs} without gain"),
            Verdict::DoesNotUse => "does not use them".into(),
            Verdict::TooFewRuns => "cannot be told from so few runs".into(),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words("sensors"))
    }
}

/// Relative RMSE of a surrogate on one unseen run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunErrors {
    /// Name of the run.
    pub run: String,
    /// Error with the inputs of the run itself.
    pub own: f64,
    /// Error of a surrogate of the same kind whose only input is the coordinate.
    pub coordinate_only: f64,
    /// Mean error with the inputs of every other unseen run in turn; `None` if there is no other run.
    pub with_other: Option<f64>,
    /// Mean error with the inputs of the run permuted in several ways.
    pub permuted: f64,
}

/// The values that a surrogate is given for its inputs other than the coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Given {
    /// Those of the run that is predicted.
    Own,
    /// Those of the run with this number, at the same coordinate.
    OfRun(usize),
    /// Those of the run that is predicted, permuted with this seed.
    Permuted(u64),
}

/// What the test asks of a surrogate and its unseen runs, which are numbered from 0.
pub trait InputTest {
    /// Names of the unseen runs.
    fn runs(&self) -> Vec<String>;

    /// True if inputs of one run can be given to another, which needs a coordinate along which the states of both are in
    /// order.
    fn is_exchangeable(&self) -> bool {
        true
    }

    /// Relative RMSE of the predictions for a run; the errors are also added to `all`.
    ///
    /// # Errors
    /// If a state cannot be predicted.
    fn error(&self, run: usize, given: Given, all: &mut Scorer) -> Result<f64>;

    /// Relative RMSE from the coordinate alone.
    ///
    /// # Errors
    /// If a state cannot be predicted.
    fn coordinate_only_error(&self, run: usize) -> Result<f64>;
}

/// The use that a surrogate makes of the inputs of unseen runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InputUse {
    /// Errors of each run.
    pub runs: Vec<RunErrors>,
    /// Score of all runs with their own inputs; `None` without runs.
    pub own: Option<Score>,
    /// Score of all runs with the inputs of other runs; `None` for fewer than two runs.
    pub with_other: Option<Score>,
    /// Score of all runs with permuted inputs; `None` without runs.
    pub permuted: Option<Score>,
}

impl InputUse {
    /// Predicts unseen runs with their own inputs, with those of other runs and with permuted inputs.
    ///
    /// # Errors
    /// If a state cannot be predicted.
    pub fn measure(test: &dyn InputTest) -> Result<InputUse> {
        let (mut all_own, mut all_others, mut all_permuted) =
            (Scorer::default(), Scorer::default(), Scorer::default());
        let names = test.runs();
        let count = if test.is_exchangeable() { names.len() } else { 0 };
        let mut runs = Vec::new();
        for (k, run) in names.into_iter().enumerate() {
            let own = test.error(k, Given::Own, &mut all_own)?;
            let mut with_others = Vec::new();
            for j in (0..count).filter(|j| *j != k) {
                with_others.push(test.error(k, Given::OfRun(j), &mut all_others)?);
            }
            let mut permuted = Vec::new();
            for seed in 1..=PERMUTATIONS {
                permuted.push(test.error(k, Given::Permuted(seed), &mut all_permuted)?);
            }
            runs.push(RunErrors {
                run,
                own,
                coordinate_only: test.coordinate_only_error(k)?,
                with_other: (!with_others.is_empty()).then(|| mean(&with_others)),
                permuted: mean(&permuted),
            });
        }
        let some = |scorer: Scorer| Some(scorer.score()).filter(|score| score.states > 0);
        Ok(InputUse { runs, own: some(all_own), with_other: some(all_others), permuted: some(all_permuted) })
    }

    fn test(&self, difference: impl Fn(&RunErrors) -> Option<f64>) -> Option<PairedTest> {
        PairedTest::new(&self.runs.iter().filter_map(difference).collect::<Vec<_>>())
    }

    /// Increase of the error with the inputs of other runs; `None` for fewer than two runs, or if inputs cannot be exchanged.
    pub fn lost_with_other(&self) -> Option<PairedTest> {
        self.test(|run| Some(run.with_other? - run.own))
    }

    /// Increase of the error with permuted inputs; `None` without runs.
    pub fn lost_permuted(&self) -> Option<PairedTest> {
        self.test(|run| Some(run.permuted - run.own))
    }

    /// Error from the coordinate alone minus that of the surrogate; `None` without runs.
    pub fn help(&self) -> Option<PairedTest> {
        self.test(|run| Some(run.coordinate_only - run.own))
    }

    /// The conclusion from the tests of use and help; where inputs cannot be exchanged between runs, from permuted inputs.
    pub fn verdict(&self) -> Verdict {
        let above = |test: Option<PairedTest>| test.and_then(|test| test.above_zero);
        let lost = self.lost_with_other().or_else(|| self.lost_permuted());
        match (above(lost), above(self.help())) {
            _ if self.runs.len() < FEWEST => Verdict::TooFewRuns,
            (Some(true), Some(true)) => Verdict::Gains,
            (Some(true), _) => Verdict::WithoutGain,
            _ => Verdict::DoesNotUse,
        }
    }
}

/// A permutation of rows within their groups, which are numbered from 0: row `k` receives what row `permutation[k]` has.
pub fn permutation(groups: &[usize], seed: u64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..groups.len()).collect();
    let mut random = SplitMix(seed);
    for group in 0..groups.iter().max().map_or(0, |last| last + 1) {
        let members: Vec<usize> = (0..groups.len()).filter(|&k| groups[k] == group).collect();
        // The permutation is drawn by the algorithm of Fisher and Yates.
        for last in (1..members.len()).rev() {
            let other = (random.next() % (last as u64 + 1)) as usize;
            order.swap(members[last], members[other]);
        }
    }
    order
}

/// The generator SplitMix64 (Steele, Lea and Flood 2014), which gives the same permutations on every computer.
pub(crate) struct SplitMix(pub(crate) u64);

impl SplitMix {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(own: f64, with_other: f64, coordinate_only: f64) -> RunErrors {
        RunErrors {
            run: "run".into(),
            own,
            coordinate_only,
            with_other: Some(with_other),
            permuted: with_other,
        }
    }

    fn verdict(runs: &[[f64; 3]]) -> Verdict {
        let runs = runs.iter().map(|&[own, other, alone]| errors(own, other, alone)).collect();
        InputUse { runs, ..Default::default() }.verdict()
    }

    #[test]
    fn verdicts_follow_the_tests() {
        let gains = [[0.02, 0.04, 0.03], [0.021, 0.038, 0.031], [0.019, 0.043, 0.029]];
        assert_eq!(verdict(&gains), Verdict::Gains);
        assert_eq!(verdict(&gains[..2]), Verdict::TooFewRuns);
        assert_eq!(verdict(&[]), Verdict::TooFewRuns);
        let idle = [[0.02, 0.04, 0.02], [0.021, 0.038, 0.020], [0.019, 0.043, 0.0195]];
        assert_eq!(verdict(&idle), Verdict::WithoutGain);
        // The network is better than strain alone, but equally good with the sensors of other runs, and hence does not use
        // them.
        let smooth = [[0.02, 0.02, 0.03], [0.021, 0.0205, 0.031], [0.019, 0.0193, 0.029]];
        assert_eq!(verdict(&smooth), Verdict::DoesNotUse);
        for verdict in [Verdict::Gains, Verdict::WithoutGain, Verdict::DoesNotUse, Verdict::TooFewRuns] {
            assert_eq!(serde_json::to_value(verdict).unwrap(), verdict.to_string());
        }
    }

    #[test]
    fn permutations_stay_within_their_groups() {
        let groups: Vec<usize> = (0..60).map(|k| k / 20).collect();
        let order = permutation(&groups, 1);
        assert_eq!(order, permutation(&groups, 1));
        assert_ne!(order, permutation(&groups, 2));
        assert!(order.iter().enumerate().all(|(k, from)| groups[k] == groups[*from]));
        let mut all = order.clone();
        all.sort_unstable();
        assert_eq!(all, (0..60).collect::<Vec<_>>());
        assert!(order.iter().enumerate().filter(|(k, from)| k != *from).count() > 40);
        assert!(permutation(&[], 1).is_empty());
    }
}
