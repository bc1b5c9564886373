//! Learning curves: error on unseen runs as a function of the number of training runs.
//!
//! The paper trained on one run. On a single path of a single sample every quantity is a function of strain, so that the
//! information of a sensor, which is in the differences between runs, cannot be detected. The same mappings are therefore
//! trained on 1, 2, 4, ... runs and scored on runs with other seeds, and are compared with strain-only networks, with ridge
//! regression, and with the same networks that receive the sensors of another unseen run at the same strain. A difference
//! counts only if it exceeds its scatter over the unseen runs.

use serde::{Deserialize, Serialize};

use granum_core::words::{self, listed};
use granum_learn::Result;
use granum_learn::learning_curve::{LearningCurve, LearningPoint, MeanError, doubled};
use granum_learn::student_t::PairedTest;
use granum_learn::study::StudyObserver;

use crate::data::PaperData;
use crate::mapping::Mapping;
use crate::method::PAPER_TRAINER;
use crate::options::PaperOptions;

/// Largest number of different sets of training runs of one size; their errors are averaged.
const MOST_SETS: usize = 2;

/// Errors as a function of the number of training runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PaperLearningCurve {
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
    pub network: MeanError,
    /// Error of strain-only networks of the same size.
    pub strain_only: MeanError,
    /// Error of ridge regression on splines with the same inputs.
    pub ridge: MeanError,
    /// Error of ridge regression on strain alone.
    pub ridge_strain_only: MeanError,
    /// Error of the networks with the sensors of another unseen run at the same strain; `None` for a single unseen run.
    pub other_sensors: Option<MeanError>,
    /// Decrease of the error from the strain-only networks to the networks with sensors, with a test whether it exceeds the
    /// scatter.
    pub help: PairedTest,
    /// Increase of the error of the networks with the sensors of another run; `None` for a single unseen run.
    pub lost_with_other: Option<PairedTest>,
}

impl CurvePoint {
    fn new(mapping: &Mapping, point: LearningPoint) -> CurvePoint {
        CurvePoint {
            mapping: mapping.name.clone(),
            formula: mapping.formula(),
            training_runs: point.training_runs,
            sets: point.sets,
            network: point.error,
            strain_only: point.coordinate_only,
            ridge: point.ridge.unwrap_or_default(),
            ridge_strain_only: point.ridge_coordinate_only.unwrap_or_default(),
            other_sensors: point.with_other,
            help: point.help,
            lost_with_other: point.lost_with_other,
        }
    }

    /// True if the error is smaller than that of strain-only networks and increases with the sensors of another run, both
    /// by more than the scatter over the unseen runs.
    pub fn helps(&self) -> bool {
        let used = self.lost_with_other.is_some_and(|lost| lost.above_zero == Some(true));
        used && self.help.above_zero == Some(true)
    }
}

impl PaperLearningCurve {
    /// Trains the mappings on 1, 2, 4, ... and all of the training runs and scores them on the unseen runs.
    ///
    /// # Errors
    /// As [`LearningCurve::measure`].
    pub fn measure(
        data: &PaperData,
        grains: usize,
        options: &PaperOptions,
        observer: &dyn StudyObserver,
    ) -> Result<PaperLearningCurve> {
        // The trainer of the paper takes so many epochs that only one run and all runs are tried.
        let thorough = options.trainer.name() != PAPER_TRAINER;
        let (sets, all) = (if thorough { MOST_SETS } else { 1 }, data.parts.training_runs.runs().len());
        let mut numbers = doubled(all);
        numbers.retain(|&n| thorough || n == 1 || n == all);
        let (definition, methods) = (options.definition(data), options.methods());
        let curve = LearningCurve::measure(&data.dataset, &definition, &methods, (&numbers, sets), observer)?;
        let point = |point: LearningPoint| {
            let mapping = options.mappings.iter().find(|mapping| mapping.name == point.fit)?;
            Some(CurvePoint::new(mapping, point))
        };
        Ok(PaperLearningCurve {
            grains,
            unseen_runs: curve.unseen_runs,
            trainer: options.trainer.name().to_owned(),
            points: curve.points.into_iter().filter_map(point).collect(),
        })
    }

    /// The points of one mapping, by number of training runs.
    pub fn points_of<'a>(&'a self, mapping: &'a str) -> impl Iterator<Item = &'a CurvePoint> + 'a {
        self.points.iter().filter(move |point| point.mapping == mapping)
    }

    /// Smallest number of training runs from which on the sensors of a mapping reduce the error by more than the scatter;
    /// `None` if they never do.
    pub fn helps_from(&self, mapping: &str) -> Option<usize> {
        let mut from = None;
        for point in self.points_of(mapping) {
            from = if point.helps() { from.or(Some(point.training_runs)) } else { None };
        }
        from
    }
}

impl PaperLearningCurve {
    /// Sentences that state which sensors reduce the error, by how much, and from how many runs on.
    pub fn interpretation(&self) -> Vec<String> {
        let mut names: Vec<&str> = self.points.iter().map(|point| point.mapping.as_str()).collect();
        names.dedup();
        let last = |name: &str| self.points_of(name).last().cloned();
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
    let percent = |share: f64| words::percent(share, 1);
    let runs = |n: usize| if n == 1 { "1 training run".to_owned() } else { format!("{n} training runs") };
    let gain = point.help.mean / point.strain_only.mean;
    let mut text = format!(
        "{}: from {} on its sensors help. With {} they reduce the error of strain-only networks by {} ({} \
         instead of {}, on {unseen} unseen runs; ridge regression {})",
        point.formula,
        runs(from),
        runs(point.training_runs),
        words::percent(gain, 0),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::PaperDataOptions;
    use crate::mapping::paper_mapping;
    use crate::synthetic::{Law, record};
    use granum_learn::NamedRecord;
    use granum_learn::study::NoStudyObserver;

    #[test]
    fn a_sensor_that_shows_a_hidden_variable_helps_and_one_that_does_not_does_not() {
        let curve = |law| {
            let records: Vec<_> = (1..=6).map(|seed| record(law, seed, 60)).collect();
            let names = ["a", "b", "c", "d", "e", "f"];
            let named: Vec<NamedRecord> = records
                .iter()
                .zip(names)
                .map(|(record, name)| NamedRecord { name, seed: 0, record })
                .collect();
            let data =
                PaperData::from_records(&named[..2], &named[2..], &PaperDataOptions::default()).unwrap();
            let options =
                PaperOptions { mappings: vec![paper_mapping("F3").unwrap()], ..PaperOptions::default() };
            PaperLearningCurve::measure(&data, 100, &options, &NoStudyObserver).unwrap()
        };
        let hidden = curve(Law::Hidden);
        assert_eq!(hidden.points_of("F3").map(|point| point.training_runs).collect::<Vec<_>>(), [1, 2]);
        assert!(hidden.helps_from("F3").is_some(), "{hidden:?}");
        let last = hidden.points_of("F3").last().unwrap();
        assert!(last.network.mean < 0.5 * last.strain_only.mean);
        assert!(last.other_sensors.unwrap().mean > 2.0 * last.network.mean);
        assert_eq!(curve(Law::Blind).helps_from("F3"), None);
    }
}
