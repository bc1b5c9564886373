//! In which order runs teach most: the order of the data set, random orders, and that of active learning, which takes next what a surrogate of the
//! runs so far is least sure of. The training runs are the pool from which each order takes its first so many runs; the error is that of a surrogate
//! fitted to them on unseen runs.

use granum_core::observer::Observer;
use serde::{Deserialize, Serialize};

use super::errors::errors_on;
use super::turn::Turn;
use crate::active_learning::{ActiveLearning, FEWEST_RUNS};
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::input_use::permutation;
use crate::pooled_error::PooledError;
use crate::surrogate::{FitSpec, GaussianProcessOfCurves, SurrogateMethod};
use crate::worth::properties;

/// An order of runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// That of the data set, such as the points of a Sobol sequence.
    DataSet,
    /// A random one.
    Random,
    /// The first runs of a random order, or with seed 0 of the data set; from then on those that a surrogate is least sure of, in batches.
    Active,
}

/// Which orders are compared, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderOfRuns {
    /// The column along which a test runs.
    pub coordinate: String,
    /// What is learned and judged.
    pub outputs: Vec<String>,
    /// Numbers of runs, increasing; active learning chooses from the first of them on.
    pub counts: Vec<usize>,
    /// Number of runs that are chosen at once.
    pub batch: usize,
    /// Number of random orders, and of active ones beside that with seed 0.
    pub seeds: usize,
    /// Number of threads; 0 for the number of processors. Answers do not depend on it.
    pub threads: usize,
}

/// The error with the first so many runs of an order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrderAnswer {
    /// The order.
    pub order: Order,
    /// Its seed.
    pub seed: u64,
    /// Number of runs.
    pub runs: usize,
    /// The output.
    pub output: String,
    /// Its error on the unseen runs.
    pub error: PooledError,
}

impl OrderOfRuns {
    /// Measures all orders.
    ///
    /// # Errors
    /// If the numbers of runs do not increase from five or exceed the runs, a column does not exist, a surrogate cannot be fitted, or the observer
    /// stops the measurement.
    pub fn measure(
        &self,
        training: &Dataset,
        unseen: &Dataset,
        observer: &mut dyn Observer,
    ) -> Result<Vec<OrderAnswer>> {
        let all = training.runs().len();
        let increases = self.counts.windows(2).all(|pair| pair[0] < pair[1]);
        let [Some(first), Some(most)] = [self.counts.first(), self.counts.last()] else {
            return Err(LearnError::Dataset("at least one number of runs must be given".into()));
        };
        if !increases || *first < FEWEST_RUNS || *most > all || self.batch == 0 {
            return Err(LearnError::Dataset(format!(
                "the numbers of runs must increase from {FEWEST_RUNS} or more to {all} or fewer, which is how many there are, with batches of one or more"
            )));
        }
        let choices = (most - first).div_ceil(self.batch);
        let orders = 2 + 2 * self.seeds;
        let total = orders * self.counts.len() + (1 + self.seeds) * choices;
        let mut turn = Turn::new(total, observer);
        let seeds = 1..=self.seeds as u64;
        let random = seeds.clone().map(|seed| (Order::Random, seed));
        let active = (0..=self.seeds as u64).map(|seed| (Order::Active, seed));
        let mut answers = Vec::new();
        for (order, seed) in [(Order::DataSet, 0)].into_iter().chain(random).chain(active) {
            let start: Vec<usize> = match seed {
                0 => (0..all).collect(),
                seed => permutation(&vec![0; all], seed),
            };
            let taken = match order {
                Order::Active => self.active(training, &start, *first, *most, &mut turn)?,
                Order::DataSet | Order::Random => start,
            };
            for count in &self.counts {
                turn.next(format!("{count} runs"))?;
                for (output, error) in self.errors(training, unseen, &taken[..*count], &mut turn)? {
                    answers.push(OrderAnswer { order, seed, runs: *count, output, error });
                }
            }
        }
        Ok(answers)
    }

    /// The runs in the order in which they are chosen.
    fn active(
        &self,
        training: &Dataset,
        start: &[usize],
        first: usize,
        most: usize,
        turn: &mut Turn,
    ) -> Result<Vec<usize>> {
        let inputs = ActiveLearning::inputs(training);
        let value = |name: &String, run: &crate::RunStates| {
            run.parameter(name).ok_or_else(|| LearnError::Dataset(format!("{} has no {name}", run.name())))
        };
        let row = |run| inputs.iter().map(|name| value(name, run)).collect();
        let pool: Vec<Vec<f64>> = training.runs().iter().map(row).collect::<Result<_>>()?;
        let learning = ActiveLearning::new(&self.coordinate, &self.outputs);
        let learning = ActiveLearning { threads: self.threads, ..learning };
        let mut taken = start[..first].to_vec();
        while taken.len() < most {
            turn.next("choice of runs")?;
            let known = subset(training, &taken);
            let is_free: Vec<bool> = (0..pool.len()).map(|run| !taken.contains(&run)).collect();
            let count = self.batch.min(most - taken.len());
            let next =
                turn.work(|observer| learning.choose(&known, &inputs, &pool, &is_free, count, observer))?;
            taken.extend(next.chosen);
        }
        Ok(taken)
    }

    fn errors(
        &self,
        training: &Dataset,
        unseen: &Dataset,
        runs: &[usize],
        turn: &mut Turn,
    ) -> Result<Vec<(String, PooledError)>> {
        let known = subset(training, runs);
        let inputs = [self.coordinate.clone()].into_iter().chain(properties(&known));
        let spec = FitSpec::new(inputs, self.outputs.clone()).with_coordinate(&self.coordinate);
        let spec = spec.with_threads(self.threads);
        let fitted = turn.work(|observer| GaussianProcessOfCurves::default().fit(&known, &spec, observer))?;
        let errors = errors_on(fitted.as_ref(), unseen, &self.outputs)?;
        Ok(self.outputs.iter().cloned().zip(errors).collect())
    }
}

/// Some of the runs, in the order of the data set.
fn subset(dataset: &Dataset, runs: &[usize]) -> Dataset {
    let names: Vec<&str> = runs.iter().map(|run| dataset.runs()[*run].name()).collect();
    dataset.select(|run, _| names.contains(&run.name()))
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;

    use super::*;
    use crate::examine::noise::tests::{family, split};

    /// All orders have the same error once all runs are taken, and active learning begins with the first runs of its order.
    #[test]
    fn orders_differ_until_all_runs_are_taken() {
        let (training, unseen) = split(&family(24), 18);
        let question = OrderOfRuns {
            coordinate: "x".into(),
            outputs: vec!["y".into()],
            counts: vec![6, 10, 18],
            batch: 4,
            seeds: 1,
            threads: 1,
        };
        let answers = question.measure(&training, &unseen, &mut NoObserver).unwrap();
        assert_eq!(answers.len(), 4 * 3);
        let of = |order: Order, seed: u64, runs: usize| {
            let is = |own: &&OrderAnswer| own.order == order && own.seed == seed && own.runs == runs;
            answers.iter().find(is).unwrap().error.relative
        };
        let all = of(Order::DataSet, 0, 18);
        assert_eq!([of(Order::Random, 1, 18), of(Order::Active, 0, 18), of(Order::Active, 1, 18)], [all; 3]);
        assert_eq!(of(Order::Active, 0, 6), of(Order::DataSet, 0, 6));
        assert_eq!(of(Order::Active, 1, 6), of(Order::Random, 1, 6));
        assert_ne!(of(Order::Active, 0, 10), of(Order::DataSet, 0, 10));
        let few = OrderOfRuns { counts: vec![3, 19], ..question };
        let error = few.measure(&training, &unseen, &mut NoObserver).unwrap_err().to_string();
        assert!(error.contains("to 18 or fewer"), "{error}");
    }
}
