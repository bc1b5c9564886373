//! Learning curves: error on unseen runs as a function of the number of training runs.
//!
//! The paper trained on one run. On a single path of a single sample every quantity is a function of strain, so that the
//! information of a sensor, which is in the differences between runs, cannot be detected. The same mappings are therefore
//! trained on 1, 2, 4, ... runs and scored on runs with other seeds, and are compared with strain-only networks, with ridge
//! regression, and with the same networks that receive the sensors of another unseen run at the same strain. A difference
//! counts only if it exceeds its scatter over the unseen runs.

use serde::{Deserialize, Serialize};

use crate::baseline::{MappingBaselines, Ridge};
use crate::mapping::Mapping;
use crate::mapping_networks::states_of;
use crate::sensor_use::sensor_use;
use crate::study::observer::StudyObserver;
use crate::study::options::{PAPER_TRAINER, StudyOptions};
use crate::study::trained::{Study, TrainedMapping};
use crate::study_data::{Run, StudyData, StudyDataOptions};
use granum_core::words::listed;
use granum_learn::Result;
use granum_learn::dataset::NamedRecord;
use granum_learn::score::Scorer;
use granum_learn::student_t::PairedTest;

/// Largest number of different sets of training runs of one size; their errors are averaged.
const MOST_SETS: usize = 2;

/// A mean over unseen runs with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Standard error of the mean; 0 for a single run.
    pub standard_error: f64,
    /// Number of unseen runs.
    pub runs: usize,
}

impl Estimate {
    /// The estimate from one value per run.
    pub fn of(values: &[f64]) -> Estimate {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n.max(1.0);
        let square: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let standard_error = if n > 1.0 { (square / (n - 1.0) / n).sqrt() } else { 0.0 };
        Estimate { mean, standard_error, runs: values.len() }
    }
}

/// Errors as a function of the number of training runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LearningCurve {
    /// Number of grains of each run.
    pub grains: usize,
    /// Number of unseen runs.
    pub unseen_runs: usize,
    /// Name of the trainer.
    pub trainer: String,
    /// The points, ordered by mapping and then by number of training runs.
    pub points: Vec<CurvePoint>,
}

/// Results of one mapping for one number of training runs. Errors are relative RMSE on unseen runs, with their standard
/// error over these runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Name of the mapping.
    pub mapping: String,
    /// Formula of the mapping, as in the paper.
    pub formula: String,
    /// Number of training runs.
    pub training_runs: usize,
    /// Number of different sets of this number of runs, whose errors are averaged.
    pub sets: usize,
    /// Error of the networks.
    pub network: Estimate,
    /// Error of strain-only networks of the same size.
    pub strain_only: Estimate,
    /// Error of ridge regression on splines with the same inputs.
    pub ridge: Estimate,
    /// Error of ridge regression on strain alone.
    pub ridge_strain_only: Estimate,
    /// Error of the networks with the sensors of another unseen run at the same strain; `None` for a single unseen run.
    pub other_sensors: Option<Estimate>,
    /// Decrease of the error from the strain-only networks to the networks with sensors, with a test whether it exceeds the
    /// scatter.
    pub help: PairedTest,
    /// Increase of the error of the networks with the sensors of another run; `None` for a single unseen run.
    pub lost_with_other: Option<PairedTest>,
}

impl CurvePoint {
    /// True if the error is smaller than that of strain-only networks and increases with the sensors of another run, both
    /// by more than the scatter over the unseen runs.
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
        // The trainer of the paper takes so many epochs that only one run and all runs are tried.
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

    /// Smallest number of training runs from which on the sensors of a mapping reduce the error by more than the scatter;
    /// `None` if they never do.
    pub fn helps_from(&self, mapping: &str) -> Option<usize> {
        let mut from = None;
        for point in self.of(mapping) {
            from = if point.helps() { from.or(Some(point.training_runs)) } else { None };
        }
        from
    }
}

impl LearningCurve {
    /// Sentences that state which sensors reduce the error, by how much, and from how many runs on.
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
                "In {} the sensors do not reduce the error of strain-only networks by more than its scatter over {} \
                 unseen runs, with up to {most} training runs of {} grains.",
                listed(&idle),
                self.unseen_runs,
                self.grains
            ));
        }
        sentences
    }
}

/// A sentence on a mapping whose sensors reduce the error.
fn helped(point: &CurvePoint, from: usize, unseen: usize) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let runs = |n: usize| if n == 1 { "1 training run".to_owned() } else { format!("{n} training runs") };
    let gain = point.help.mean / point.strain_only.mean;
    let mut text = format!(
        "{}: from {} on its sensors help. With {} they reduce the error of strain-only networks by {:.0} % ({} \
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
            "; with the sensors of another run at the same strain, the error of the same networks is {}",
            percent(other.mean)
        );
    }
    text + "."
}

/// The numbers of training runs: 1, 2, 4, ... and all.
fn numbers(all: usize) -> Vec<usize> {
    let mut numbers: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < all).collect();
    numbers.push(all);
    numbers
}

/// The points of all mappings for one number of training runs.
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

/// For each unseen run, sums over sets of the errors of the networks, the strain-only networks, ridge regression, ridge
/// regression on strain alone, and the networks with other sensors.
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
        let usage = sensor_use(trained, &runs)?;
        for (k, (errors, run)) in usage.runs.iter().zip(&dataset.unseen_runs).enumerate() {
            let found = [
                errors.own,
                errors.coordinate_only,
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
    use crate::mapping::paper_mapping;
    use crate::study::Silent;
    use crate::synthetic::{Law, record};

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
