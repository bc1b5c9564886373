//! Whether networks use the sensors they are given, judged by what it means.
//!
//! A network that scores well may have learned nothing but the curve against strain. So every unseen run is answered
//! again with sensors that are not its own:
//!
//! - those of **another** unseen run at the same strain, every other unseen run in turn: right on average, wrong in what
//!   makes this run differ from others;
//! - its own, **permuted** over its states within the range of each sub-model: right as a set, wrong at each strain.
//!
//! What a run loses by the sensors of others is the *use* its networks make of its own. What strain-only networks miss
//! it by more is the *help* they have of them. Both are one number an unseen run, and are called so if their mean is above
//! zero by a one-sided t test at 5 % ([`crate::student`]); runs are taken for independent.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::antony2006::mapping::Mapping;
use crate::antony2006::mapping_networks::{MappingNetworks, states_of};
use crate::antony2006::study::TrainedMapping;
use crate::antony2006::study_data::{Run, State};
use crate::error::Result;
use crate::score::{Score, Scorer};
use crate::student_t::{FEWEST, PairedTest};

/// Orders of the states that are averaged.
const PERMUTATIONS: u64 = 5;
/// Networks whose answers spread by less than this share of the spread of the targets answer with a constant.
const CONSTANT: f64 = 1e-3;

/// Whether a mapping uses its sensors, and whether it gains by it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Its errors are larger with the sensors of another run, and smaller than those of strain-only networks.
    #[serde(rename = "uses its sensors and gains by it")]
    Gains,
    /// Its errors are larger with the sensors of another run, but not smaller than those of strain-only networks.
    #[serde(rename = "uses its sensors without gain")]
    WithoutGain,
    /// Its errors are no larger with the sensors of another run, as far as the runs tell.
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
    /// With its own sensors.
    pub own: f64,
    /// Of strain-only networks.
    pub strain_only: f64,
    /// With the sensors of every other unseen run in turn, their mean; `None` without another run.
    pub with_other: Option<f64>,
    /// With its own sensors permuted, the mean over some orders.
    pub permuted: f64,
}

/// What a mapping makes of the sensors of unseen runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorUse {
    /// Errors run by run; runs without a state in the range of the mapping are left out.
    pub runs: Vec<RunErrors>,
    /// Score of all runs with their own sensors; `None` without runs.
    pub own: Option<Score>,
    /// Score of all runs with the sensors of others; `None` of fewer than two runs.
    pub with_other: Option<Score>,
    /// Score of all runs with permuted sensors; `None` without runs.
    pub permuted: Option<Score>,
}

impl SensorUse {
    /// Answers unseen runs with sensors that are not theirs.
    ///
    /// # Errors
    /// If a state holds a value that is not finite.
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

    /// What is lost by the sensors of other runs; `None` of fewer than two runs.
    pub fn lost_with_other(&self) -> Option<PairedTest> {
        self.test(|run| Some(run.with_other? - run.own))
    }

    /// What is lost by permuted sensors; `None` without runs.
    pub fn lost_permuted(&self) -> Option<PairedTest> {
        self.test(|run| Some(run.permuted - run.own))
    }

    /// What strain-only networks miss by more than the networks; `None` without runs.
    pub fn help(&self) -> Option<PairedTest> {
        self.test(|run| Some(run.strain_only - run.own))
    }

    /// The verdict that follows from the tests of use and help.
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

/// Relative RMSE of the answers to some states against those of others; it is added to the score of all.
fn error(surrogate: &MappingNetworks, given: &[State], exact: &[&State], all: &mut Scorer) -> Result<f64> {
    let mut own = Scorer::default();
    for (answer, state) in surrogate.answer(given)?.iter().zip(exact) {
        let dem = state.values(surrogate.mapping().output);
        own.add(dem, &answer.values);
        all.add(dem, &answer.values);
    }
    Ok(own.score().relative_rmse)
}

/// The strains of states with the sensors that another run has there.
fn sensors_of(other: &Run, states: &[&State]) -> Vec<State> {
    let at = |state: &&State| Some(State { strain: state.strain, ..other.at(state.strain)? });
    states.iter().filter_map(at).collect()
}

/// The strains of states with each other's sensors, exchanged within the range of each sub-model.
fn permuted_sensors(mapping: &Mapping, states: &[&State], seed: u64) -> Vec<State> {
    let mut order: Vec<usize> = (0..states.len()).collect();
    let mut random = SplitMix(seed);
    for sub_model in 0..mapping.sub_models.len() {
        let members: Vec<usize> =
            (0..states.len()).filter(|&k| mapping.sub_model_at(states[k].strain).0 == sub_model).collect();
        // Fisher and Yates.
        for last in (1..members.len()).rev() {
            let other = (random.next() % (last as u64 + 1)) as usize;
            order.swap(members[last], members[other]);
        }
    }
    order.iter().zip(states).map(|(&from, to)| State { strain: to.strain, ..states[from].clone() }).collect()
}

/// The generator SplitMix64 (Steele, Lea and Flood 2014): the same orders on every machine.
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

/// True if the network of a sub-model answers the training states in its range with nearly one number: the standard
/// deviation of its answers is below 1e-3 of that of the targets.
///
/// # Errors
/// If a state holds a value that is not finite.
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
    use crate::antony2006::mapping::paper_mapping;

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
        // Better than strain alone, but as good with the sensors of others: not by its sensors.
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
