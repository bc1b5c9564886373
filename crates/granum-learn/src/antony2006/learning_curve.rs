//! What networks learn from more runs: error on unseen runs against the number of training runs.
//!
//! The paper trained on one run. On one path of one sample every quantity is a function of strain, and what a sensor could
//! add does not show: it is in what runs differ by. So the same mappings are trained on 1, 2, 4, ... runs and scored on runs
//! of other seeds, every time beside networks that see strain only, ridge regression, and the same networks told the sensors
//! of another unseen run at the same strain. A difference counts if it is beyond its scatter over the unseen runs.

use serde::{Deserialize, Serialize};

use crate::antony2006::baseline::{MappingBaselines, Ridge};
use crate::antony2006::mapping::Mapping;
use crate::antony2006::mapping_networks::states_of;
use crate::antony2006::sensor_use::SensorUse;
use crate::antony2006::study::{PAPER_TRAINER, Study, StudyObserver, StudyOptions, TrainedMapping};
use crate::antony2006::study_data::{Run, StudyData, StudyDataOptions};
use crate::dataset::NamedRecord;
use crate::error::Result;
use crate::score::Scorer;
use crate::student_t::PairedTest;

/// Sets of training runs of one number that are tried at the most; their errors are averaged.
const MOST_SETS: usize = 2;

/// A mean over unseen runs with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error; 0 of a single run.
    pub standard_error: f64,
    /// Number of unseen runs.
    pub runs: usize,
}

impl Estimate {
    /// Of one value a run.
    pub fn of(values: &[f64]) -> Estimate {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n.max(1.0);
        let square: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let standard_error = if n > 1.0 { (square / (n - 1.0) / n).sqrt() } else { 0.0 };
        Estimate { mean, standard_error, runs: values.len() }
    }
}

/// Error against number of training runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LearningCurve {
    /// Grains of each run.
    pub grains: usize,
    /// Number of unseen runs.
    pub unseen_runs: usize,
    /// Name of the trainer.
    pub trainer: String,
    /// By mapping, then by number of training runs.
    pub points: Vec<CurvePoint>,
}

/// One mapping trained on one number of runs. Errors are relative RMSE on unseen runs, with their standard error over these.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Name of the mapping.
    pub mapping: String,
    /// As the paper writes it.
    pub formula: String,
    /// Number of training runs.
    pub training_runs: usize,
    /// Number of different sets of so many runs, whose errors are averaged.
    pub sets: usize,
    /// The networks.
    pub network: Estimate,
    /// Networks of the same sizes that see strain only.
    pub strain_only: Estimate,
    /// Ridge regression on splines with the same inputs.
    pub ridge: Estimate,
    /// Ridge regression that sees strain only.
    pub ridge_strain_only: Estimate,
    /// The networks told the sensors of another unseen run at the same strain; `None` of a single unseen run.
    pub other_sensors: Option<Estimate>,
    /// What the sensors take off the error of the strain-only networks, and whether that is beyond scatter.
    pub help: PairedTest,
    /// What the networks lose with the sensors of another run; `None` of a single unseen run.
    pub lost_with_other: Option<PairedTest>,
}

impl CurvePoint {
    /// True if the sensors take something off the error of strain-only networks, and if it is lost with the sensors of
    /// another run, both beyond their scatter over the unseen runs.
    pub fn helps(&self) -> bool {
        let used = self.lost_with_other.is_some_and(|lost| lost.above_zero == Some(true));
        used && self.help.above_zero == Some(true)
    }
}

impl LearningCurve {
    /// Trains the mappings on 1, 2, 4, ... and all of the training runs and scores them on the unseen runs.
    ///
    /// # Errors
    /// As [`Study::train`].
    pub fn new(
        training: &[NamedRecord],
        unseen: &[NamedRecord],
        grains: usize,
        options: &StudyOptions,
        observer: &dyn StudyObserver,
    ) -> Result<LearningCurve> {
        let mut curve = LearningCurve {
            grains,
            unseen_runs: unseen.len(),
            trainer: options.trainer.name().to_owned(),
            points: Vec::new(),
        };
        // The paper's trainer takes so many epochs that one and all must do.
        let thorough = options.trainer.name() != PAPER_TRAINER;
        let sets = if thorough { MOST_SETS } else { 1 };
        for runs in numbers(training.len()).into_iter().filter(|&n| thorough || n == 1 || n == training.len())
        {
            curve.points.extend(points(training, unseen, (runs, sets), options, observer)?);
        }
        let order = |point: &CurvePoint| options.mappings.iter().position(|m| m.name == point.mapping);
        curve.points.sort_by_key(|point| (order(point), point.training_runs));
        Ok(curve)
    }

    /// The points of one mapping, by number of training runs.
    pub fn of<'a>(&'a self, mapping: &'a str) -> impl Iterator<Item = &'a CurvePoint> + 'a {
        self.points.iter().filter(move |point| point.mapping == mapping)
    }

    /// The least number of training runs from which on the sensors of a mapping help beyond scatter; `None` if they never do.
    pub fn helps_from(&self, mapping: &str) -> Option<usize> {
        let mut from = None;
        for point in self.of(mapping) {
            from = if point.helps() { from.or(Some(point.training_runs)) } else { None };
        }
        from
    }
}

impl LearningCurve {
    /// Which sensors help, by how much and from how many runs on, in plain sentences.
    pub fn interpretation(&self) -> Vec<String> {
        let mut names: Vec<&str> = self.points.iter().map(|point| point.mapping.as_str()).collect();
        names.dedup();
        let last = |name: &str| self.of(name).last().cloned();
        let mut sentences: Vec<String> = names
            .iter()
            .filter_map(|name| Some(helped(&last(name)?, self.helps_from(name)?, self.unseen_runs)))
            .collect();
        let idle: Vec<&str> = names.iter().copied().filter(|name| self.helps_from(name).is_none()).collect();
        if !idle.is_empty() {
            let most = self.points.iter().map(|point| point.training_runs).max().unwrap_or(0);
            sentences.push(format!(
                "In {} the sensors take nothing off the error of networks that see strain only, beyond its scatter over \
                 {} unseen runs, with up to {most} training runs of {} grains.",
                listed(&idle),
                self.unseen_runs,
                self.grains
            ));
        }
        sentences
    }
}

/// A mapping whose sensors help.
fn helped(point: &CurvePoint, from: usize, unseen: usize) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let runs = |n: usize| if n == 1 { "1 training run".to_owned() } else { format!("{n} training runs") };
    let gain = point.help.mean / point.strain_only.mean;
    let mut text = format!(
        "{}: from {} on its sensors help. With {} they take {:.0} % off the error of networks that see strain only ({} \
         instead of {}, on {unseen} unseen runs; ridge regression {})",
        point.formula,
        runs(from),
        runs(point.training_runs),
        100.0 * gain,
        percent(point.network.mean),
        percent(point.strain_only.mean),
        percent(point.ridge.mean),
    );
    if let Some(other) = point.other_sensors {
        text += &format!(
            "; told the sensors of another run at the same strain, the same networks miss by {}",
            percent(other.mean)
        );
    }
    text + "."
}

/// `a, b and c`.
fn listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// 1, 2, 4, ... and all.
fn numbers(all: usize) -> Vec<usize> {
    let mut numbers: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < all).collect();
    numbers.push(all);
    numbers
}

/// All mappings trained on so many runs.
fn points(
    training: &[NamedRecord],
    unseen: &[NamedRecord],
    (runs, most_sets): (usize, usize),
    options: &StudyOptions,
    observer: &dyn StudyObserver,
) -> Result<Vec<CurvePoint>> {
    let sets: Vec<&[NamedRecord]> = training.chunks_exact(runs).take(most_sets).collect();
    let mut errors: Vec<Errors> = vec![Errors::default(); options.mappings.len()];
    for set in &sets {
        let dataset = StudyData::new(set, unseen, &StudyDataOptions::default())?;
        let study = Study::train(&dataset, options, observer)?;
        for (trained, errors) in study.mappings.iter().zip(&mut errors) {
            errors.add(trained, &dataset)?;
        }
    }
    let count = sets.len() as f64;
    let point = |(mapping, errors): (&Mapping, &Errors)| CurvePoint {
        mapping: mapping.name.clone(),
        formula: mapping.formula(),
        training_runs: runs,
        sets: sets.len(),
        network: Estimate::of(&errors.mean(0, count)),
        strain_only: Estimate::of(&errors.mean(1, count)),
        ridge: Estimate::of(&errors.mean(2, count)),
        ridge_strain_only: Estimate::of(&errors.mean(3, count)),
        other_sensors: (unseen.len() > 1).then(|| Estimate::of(&errors.mean(4, count))),
        help: PairedTest::new(&errors.difference(1, 0, count)).unwrap_or_default(),
        lost_with_other: PairedTest::new(&errors.difference(4, 0, count)).filter(|_| unseen.len() > 1),
    };
    Ok(options.mappings.iter().zip(&errors).map(point).collect())
}

/// Sums over sets, for each unseen run: of the network, strain only, ridge, ridge strain only, and with other sensors.
#[derive(Clone, Debug, Default)]
struct Errors {
    by_run: Vec<[f64; 5]>,
}

impl Errors {
    fn add(&mut self, trained: &TrainedMapping, dataset: &StudyData) -> Result<()> {
        self.by_run.resize(dataset.unseen_runs.len(), [0.0; 5]);
        let mapping = trained.surrogate.mapping();
        let ridges = MappingBaselines::fit(mapping, dataset)?;
        let runs: Vec<&Run> = dataset.unseen_runs.iter().collect();
        let usage = SensorUse::new(trained, &runs)?;
        for (k, (errors, run)) in usage.runs.iter().zip(&dataset.unseen_runs).enumerate() {
            let found = [
                errors.own,
                errors.strain_only,
                ridge_error(&ridges.ridge, mapping, run),
                ridge_error(&ridges.strain_only, mapping, run),
                errors.with_other.unwrap_or(errors.own),
            ];
            for (sum, value) in self.by_run[k].iter_mut().zip(found) {
                *sum += value;
            }
        }
        Ok(())
    }

    fn mean(&self, kind: usize, sets: f64) -> Vec<f64> {
        self.by_run.iter().map(|errors| errors[kind] / sets).collect()
    }

    fn difference(&self, a: usize, b: usize, sets: f64) -> Vec<f64> {
        self.by_run.iter().map(|errors| (errors[a] - errors[b]) / sets).collect()
    }
}

fn ridge_error(ridge: &Ridge, mapping: &Mapping, run: &Run) -> f64 {
    let mut scorer = Scorer::default();
    for state in states_of(mapping, &run.states, None) {
        scorer.add(state.values(mapping.output), &ridge.answer(state));
    }
    scorer.score().relative_rmse
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::antony2006::mapping::paper_mapping;
    use crate::antony2006::study::Silent;
    use crate::antony2006::synthetic::{Law, record};

    #[test]
    fn a_sensor_that_shows_a_hidden_variable_helps_and_one_that_does_not_does_not() {
        let curve = |law| {
            let records: Vec<_> = (1..=6).map(|seed| record(law, seed, 60)).collect();
            let named: Vec<NamedRecord> =
                records.iter().map(|record| NamedRecord { name: "run", seed: 0, record }).collect();
            let options =
                StudyOptions { mappings: vec![paper_mapping("F3").unwrap()], ..StudyOptions::default() };
            LearningCurve::new(&named[..2], &named[2..], 100, &options, &Silent).unwrap()
        };
        let hidden = curve(Law::Hidden);
        assert_eq!(hidden.of("F3").map(|point| point.training_runs).collect::<Vec<_>>(), [1, 2]);
        assert!(hidden.helps_from("F3").is_some(), "{hidden:?}");
        let last = hidden.of("F3").last().unwrap();
        assert!(last.network.mean < 0.5 * last.strain_only.mean);
        assert!(last.other_sensors.unwrap().mean > 2.0 * last.network.mean);
        assert_eq!(curve(Law::Blind).helps_from("F3"), None);
    }

    #[test]
    fn numbers_of_runs_double_and_end_with_all() {
        assert_eq!(numbers(1), [1]);
        assert_eq!(numbers(8), [1, 2, 4, 8]);
        assert_eq!(numbers(6), [1, 2, 4, 6]);
    }
}
