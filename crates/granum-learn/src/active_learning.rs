//! Active learning: which runs to make next, by a surrogate of those that are there.
//!
//! Gaussian processes of curves are fitted to the runs, with the properties in which the runs differ as inputs: what is measured on a sample is
//! not known before it is made. Of the candidates those are chosen that would reduce most the variance of the mean curves over the ranges of
//! the candidates, each with what the ones before it will tell ([`next_runs`](crate::surrogate::FittedCurves::next_runs)).

use granum_core::observer::Observer;
use granum_io::Case;
use granum_run::derived_columns::single_parameters;

use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::surrogate::{FitSpec, GaussianProcessOfCurves, NextRuns};
use crate::worth::properties;

/// Fewest runs from which something is learned that a choice can be based on.
pub const FEWEST_RUNS: usize = 5;

/// What is learned, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveLearning {
    /// The column along which a test runs, which increases.
    pub coordinate: String,
    /// The outputs, each of which counts alike; the name of a histogram stands for all of its bins.
    pub outputs: Vec<String>,
    /// Seed of the fit.
    pub seed: u64,
    /// Number of threads; 0 for the number of processors. The choice does not depend on it.
    pub threads: usize,
}

impl ActiveLearning {
    /// Learns outputs along a coordinate, with seed 1 and one thread per processor.
    pub fn new(coordinate: &str, outputs: &[String]) -> ActiveLearning {
        ActiveLearning { coordinate: coordinate.into(), outputs: outputs.to_vec(), seed: 1, threads: 0 }
    }

    /// The inputs: the numbers of their cases in which runs differ, without seeds and without what is measured on samples.
    pub fn inputs(runs: &Dataset) -> Vec<String> {
        let mut found = properties(runs);
        found.retain(|name| !name.starts_with("sample."));
        found
    }

    /// Chooses at most `count` of the cases, the one that tells most first; the places of the candidates are those of the list.
    ///
    /// # Errors
    /// If there are fewer than [`FEWEST_RUNS`] runs, they do not differ in any number, a case lacks one of these numbers, an output does not
    /// exist, or the observer stops the fit.
    pub fn choose_cases(
        &self,
        runs: &Dataset,
        candidates: &[Case],
        count: usize,
        observer: &mut dyn Observer,
    ) -> Result<NextRuns> {
        let inputs = ActiveLearning::inputs(runs);
        let row = |case: &Case| -> Result<Vec<f64>> {
            let parameters = single_parameters(case);
            let value = |name: &String| {
                let own = parameters.iter().find(|own| own.key == *name);
                own.and_then(|own| own.number()).ok_or_else(|| {
                    LearnError::Dataset(format!(
                        "{name} is a number in the runs and not in a run that could be next"
                    ))
                })
            };
            inputs.iter().map(value).collect()
        };
        let rows = candidates.iter().map(row).collect::<Result<Vec<_>>>()?;
        self.choose(runs, &inputs, &rows, &vec![true; rows.len()], count, observer)
    }

    /// Chooses at most `count` of the candidates that are free, each given by the values of the inputs. The variance is that over all
    /// candidates, free or not.
    ///
    /// # Errors
    /// As [`ActiveLearning::choose_cases`].
    pub fn choose(
        &self,
        runs: &Dataset,
        inputs: &[String],
        candidates: &[Vec<f64>],
        is_free: &[bool],
        count: usize,
        observer: &mut dyn Observer,
    ) -> Result<NextRuns> {
        let known = runs.runs().len();
        if known < FEWEST_RUNS {
            return Err(LearnError::Dataset(format!(
                "a surrogate of {known} runs is no guide to the next ones; {FEWEST_RUNS} are needed"
            )));
        }
        let all = [self.coordinate.clone()].into_iter().chain(inputs.iter().cloned());
        let spec = FitSpec::new(all, self.outputs.clone()).with_coordinate(&self.coordinate);
        let spec = spec.with_seed(self.seed).with_threads(self.threads);
        let (fitted, _) = GaussianProcessOfCurves::default().fit_with_left_out(runs, &spec, observer)?;
        fitted.next_runs(candidates, is_free, count)
    }
}
