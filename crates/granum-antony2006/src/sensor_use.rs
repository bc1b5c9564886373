//! Tests whether networks use their sensors.
//!
//! A network with a small error may have learned nothing but the curve as a function of strain. Every unseen run is
//! therefore predicted again with other sensor values:
//!
//! - those of **another** unseen run at the same strain, with every other unseen run in turn: they are correct on
//!   average, but not in the deviation of this run from the others;
//! - those of the run itself, **permuted** over its states within the range of each sub-model: they are correct as a
//!   set, but not at each strain.
//!
//! The increase of the error with the sensors of other runs measures the *use* of the sensors. The difference between the
//! error of strain-only networks and that of the networks measures the *help* of the sensors. Each is one number per
//! unseen run, and counts as established if the mean is above zero in a one-sided t test at 5 % ([`granum_learn::student_t`]),
//! where runs are assumed to be independent.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::mapping::Mapping;
use crate::mapping_networks::{MappingNetworks, states_of};
use crate::study::trained::TrainedMapping;
use crate::study_data::{Run, State};
use granum_learn::Result;
use granum_learn::score::{Score, Scorer};
use granum_learn::student_t::{FEWEST, PairedTest};

/// Number of permutations that are averaged.
const PERMUTATIONS: u64 = 5;
/// A network is considered constant if the standard deviation of its predictions is below this fraction of that of the
/// targets.
const CONSTANT: f64 = 1e-3;

/// The conclusion whether a mapping uses its sensors and whether they reduce its error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Its errors are larger with the sensors of another run, and smaller than those of strain-only networks.
    #[serde(rename = "uses its sensors and gains by it")]
    Gains,
    /// Its errors are larger with the sensors of another run, but not smaller than those of strain-only networks.
    #[serde(rename = "uses its sensors without gain")]
    WithoutGain,
    /// Its errors are not significantly larger with the sensors of another run.
    #[serde(rename = "does not use them")]
    DoesNotUse,
    /// There are fewer than three unseen runs.
    #[default]
    #[serde(rename = "cannot be told from so few runs")]
    TooFewRuns,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Gains => "uses its sensors and gains by it",
            Verdict::WithoutGain => "uses its sensors without gain",
            Verdict::DoesNotUse => "does not use them",
            Verdict::TooFewRuns => "cannot be told from so few runs",
        })
    }
}

/// Relative RMSE of a mapping on one unseen run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunErrors {
    /// Name of the run.
    pub run: String,
    /// Error with the sensors of the run itself.
    pub own: f64,
    /// Error of strain-only networks.
    pub strain_only: f64,
    /// Mean error with the sensors of every other unseen run in turn; `None` if there is no other run.
    pub with_other: Option<f64>,
    /// Mean error with the sensors of the run permuted in several ways.
    pub permuted: f64,
}

/// The use that a mapping makes of the sensors of unseen runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorUse {
    /// Errors of each run; runs without a state in the range of the mapping are omitted.
    pub runs: Vec<RunErrors>,
    /// Score of all runs with their own sensors; `None` without runs.
    pub own: Option<Score>,
    /// Score of all runs with the sensors of other runs; `None` for fewer than two runs.
    pub with_other: Option<Score>,
    /// Score of all runs with permuted sensors; `None` without runs.
    pub permuted: Option<Score>,
}

impl SensorUse {
    /// Predicts unseen runs with their own sensors, with those of other runs and with permuted sensors.
    ///
    /// # Errors
    /// If a state contains a value that is not finite.
    pub fn new(trained: &TrainedMapping, runs: &[&Run]) -> Result<SensorUse> {
        let mapping = trained.surrogate.mapping();
        let judged: Vec<(&Run, Vec<&State>)> = runs
            .iter()
            .map(|run| (*run, states_of(mapping, &run.states, None)))
            .filter(|(_, states)| !states.is_empty())
            .collect();
        let (mut all_own, mut all_others, mut all_permuted) =
            (Scorer::default(), Scorer::default(), Scorer::default());
        let mut errors = Vec::new();
        for (k, (run, states)) in judged.iter().enumerate() {
            let given: Vec<State> = states.iter().map(|state| (*state).clone()).collect();
            let own = error(&trained.surrogate, &given, states, &mut all_own)?;
            let mut with_others = Vec::new();
            for (_, (other, _)) in judged.iter().enumerate().filter(|(j, _)| *j != k) {
                let given = sensors_of(other, states);
                with_others.push(error(&trained.surrogate, &given, states, &mut all_others)?);
            }
            let mut permuted = Vec::new();
            for seed in 1..=PERMUTATIONS {
                let given = permuted_sensors(mapping, states, seed);
                permuted.push(error(&trained.surrogate, &given, states, &mut all_permuted)?);
            }
            errors.push(RunErrors {
                run: run.name.clone(),
                own,
                strain_only: trained.strain_only.evaluate(states.iter().copied(), None)?.relative_rmse,
                with_other: (!with_others.is_empty()).then(|| mean(&with_others)),
                permuted: mean(&permuted),
            });
        }
        let some = |scorer: Scorer| Some(scorer.score()).filter(|score| score.states > 0);
        Ok(SensorUse {
            runs: errors,
            own: some(all_own),
            with_other: some(all_others),
            permuted: some(all_permuted),
        })
    }

    fn test(&self, difference: impl Fn(&RunErrors) -> Option<f64>) -> Option<PairedTest> {
        PairedTest::new(&self.runs.iter().filter_map(difference).collect::<Vec<_>>())
    }

    /// Increase of the error with the sensors of other runs; `None` for fewer than two runs.
    pub fn lost_with_other(&self) -> Option<PairedTest> {
        self.test(|run| Some(run.with_other? - run.own))
    }

    /// Increase of the error with permuted sensors; `None` without runs.
    pub fn lost_permuted(&self) -> Option<PairedTest> {
        self.test(|run| Some(run.permuted - run.own))
    }

    /// Error of strain-only networks minus that of the networks; `None` without runs.
    pub fn help(&self) -> Option<PairedTest> {
        self.test(|run| Some(run.strain_only - run.own))
    }

    /// The conclusion from the tests of use and help.
    pub fn verdict(&self) -> Verdict {
        let above = |test: Option<PairedTest>| test.and_then(|test| test.above_zero);
        match (above(self.lost_with_other()), above(self.help())) {
            _ if self.runs.len() < FEWEST => Verdict::TooFewRuns,
            (Some(true), Some(true)) => Verdict::Gains,
            (Some(true), _) => Verdict::WithoutGain,
            _ => Verdict::DoesNotUse,
        }
    }
}

/// Relative RMSE of the predictions for the states `given` in comparison with the states `exact`; the errors are also
/// added to `all`.
fn error(surrogate: &MappingNetworks, given: &[State], exact: &[&State], all: &mut Scorer) -> Result<f64> {
    let mut own = Scorer::default();
    for (answer, state) in surrogate.answer(given)?.iter().zip(exact) {
        let dem = state.values(surrogate.mapping().output);
        own.add(dem, &answer.values);
        all.add(dem, &answer.values);
    }
    Ok(own.score().relative_rmse)
}

/// States with the same strains and with the sensors of another run at these strains.
fn sensors_of(other: &Run, states: &[&State]) -> Vec<State> {
    let at = |state: &&State| Some(State { strain: state.strain, ..other.at(state.strain)? });
    states.iter().filter_map(at).collect()
}

/// States with the same strains and with sensors that are permuted within the range of each sub-model.
fn permuted_sensors(mapping: &Mapping, states: &[&State], seed: u64) -> Vec<State> {
    let mut order: Vec<usize> = (0..states.len()).collect();
    let mut random = SplitMix(seed);
    for sub_model in 0..mapping.sub_models.len() {
        let members: Vec<usize> =
            (0..states.len()).filter(|&k| mapping.sub_model_at(states[k].strain).0 == sub_model).collect();
        // The permutation is drawn by the algorithm of Fisher and Yates.
        for last in (1..members.len()).rev() {
            let other = (random.next() % (last as u64 + 1)) as usize;
            order.swap(members[last], members[other]);
        }
    }
    order.iter().zip(states).map(|(&from, to)| State { strain: to.strain, ..states[from].clone() }).collect()
}

/// The generator SplitMix64 (Steele, Lea and Flood 2014), which gives the same permutations on every computer.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }
}

/// True if the predictions of a sub-model for the training states in its range are nearly constant: their standard
/// deviation is below 1e-3 of that of the targets.
///
/// # Errors
/// If a state contains a value that is not finite.
pub fn is_constant(surrogate: &MappingNetworks, training: &[&State], sub_model: usize) -> Result<bool> {
    let states = states_of(surrogate.mapping(), training.iter().copied(), Some(sub_model));
    let answers = surrogate.answer(states.iter().copied())?;
    let given: Vec<f64> = answers.iter().flat_map(|answer| answer.values.iter().copied()).collect();
    let targets: Vec<f64> =
        states.iter().flat_map(|state| state.values(surrogate.mapping().output).iter().copied()).collect();
    Ok(spread(&given) < CONSTANT * spread(&targets))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn spread(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / values.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::paper_mapping;

    fn errors(own: f64, with_other: f64, strain_only: f64) -> RunErrors {
        RunErrors { run: "run".into(), own, strain_only, with_other: Some(with_other), permuted: with_other }
    }

    fn verdict(runs: &[[f64; 3]]) -> Verdict {
        let runs = runs.iter().map(|&[own, other, alone]| errors(own, other, alone)).collect();
        SensorUse { runs, ..Default::default() }.verdict()
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
    fn sensors_are_exchanged_within_sub_models() {
        let mapping = paper_mapping("F3").unwrap();
        let states: Vec<State> = (0..60)
            .map(|k| State {
                strain: 0.005 * f64::from(k),
                stress_ratio: 0.5,
                deviator_fabric: f64::from(k),
                densities: vec![f64::from(k)],
            })
            .collect();
        let all: Vec<&State> = states.iter().collect();
        let permuted = permuted_sensors(&mapping, &all, 1);
        assert_eq!(permuted, permuted_sensors(&mapping, &all, 1));
        assert_ne!(permuted, permuted_sensors(&mapping, &all, 2));
        let moved = permuted.iter().zip(&states).filter(|(a, b)| a.deviator_fabric != b.deviator_fabric);
        assert!(moved.count() > 40);
        for (state, own) in permuted.iter().zip(&states) {
            assert_eq!((state.strain, state.densities[0]), (own.strain, state.deviator_fabric));
            let home = mapping.sub_model_at(0.005 * state.deviator_fabric).0;
            assert_eq!(home, mapping.sub_model_at(state.strain).0);
        }
        let mut numbers: Vec<f64> = permuted.iter().map(|state| state.deviator_fabric).collect();
        numbers.sort_by(f64::total_cmp);
        assert!(numbers.iter().enumerate().all(|(k, &number)| number == k as f64));
    }
}
