//! The question how well surrogates with a state follow any path.

use std::sync::Arc;

use granum_core::observer::Observer;

use super::answers::{Drift, PathAnswer, PathAnswers};
use super::columns::{Learned, is_of, kinds};
use super::held::{LEVEL, Places, held};
use super::quantities::{self, Quantity, Row};
use super::work::{self, WorkInCycles};
use super::{baselines, scatter};
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::examine::turn::Turn;
use crate::pooled_error::PooledError;
use crate::surrogate::{
    FitSpec, Prediction, RunInputs, Surrogate, SurrogateMethod, SurrogateMethods, method_of_words,
};

/// Share of a long path at its beginning and at its end.
const PART: f64 = 0.1;

/// What is done with a fitted surrogate, such as writing it to a file.
type KeepSurrogate<'a> = dyn FnMut(&dyn Surrogate) -> Result<()> + 'a;

/// Surrogates of any path, and on what they are judged.
#[derive(Clone, Debug, PartialEq)]
pub struct AnyPath {
    /// Methods, with settings where they have some: `path-gru`, `path-tensor:internal=0,hidden=12` (see [`method_of_words`]).
    pub methods: Vec<String>,
    /// True if the volume is an input, as all other strains are: the mean stress is learned in its place. For paths at changing mean stress, and for surrogates
    /// that a finite element can use.
    pub volume_is_input: bool,
    /// Parameters of the runs that are inputs beside the state of the sample: those of the material.
    pub properties: Vec<String>,
    /// Seed of the methods.
    pub seed: u64,
    /// Number of threads; 0 for the number of processors. Answers do not depend on it.
    pub threads: usize,
}

impl AnyPath {
    /// What is learned: stress, fabric, volumetric strain unless it is an input, and mechanical coordination number, from the strains and the state of the sample.
    pub fn spec(&self) -> FitSpec {
        self.learned().spec()
    }

    fn learned(&self) -> Learned {
        Learned { volume_is_input: self.volume_is_input, properties: self.properties.clone() }
    }

    /// Fits each method to the training runs, and judges it on the unseen and the long ones. `keep` is given each surrogate once it is judged.
    ///
    /// # Errors
    /// If a column or method does not exist, a surrogate cannot be fitted, `keep` fails, or the observer stops the measurement.
    pub fn measure(
        &self,
        training: &Dataset,
        unseen: &Dataset,
        long: Option<&Dataset>,
        methods: &SurrogateMethods,
        (keep, observer): (&mut KeepSurrogate, &mut dyn Observer),
    ) -> Result<PathAnswers> {
        let learned = &self.learned();
        let judged = Quantity::judged(learned);
        let spec = learned.spec().with_seed(self.seed).with_threads(self.threads);
        let method = |word: &String| -> Result<(String, Arc<dyn SurrogateMethod>)> {
            Ok((word.clone(), method_of_words(word, methods)?))
        };
        let methods = self.methods.iter().map(method).collect::<Result<Vec<_>>>()?;
        let means = quantities::means(learned, training)?;
        let exact = quantities::rows_of(learned, unseen)?;
        let mut answers = PathAnswers::default();
        let mut add = |name: &str, rows: &[Row]| {
            answers.errors.extend(errors(name, unseen, &exact, rows, &means, &judged));
        };
        add("mean of the training states", &vec![means; exact.len()]);
        add("first state", &baselines::first_states(learned, unseen)?);
        let elastic = baselines::ElasticPerfectlyPlastic::fit(learned, training)?;
        let stresses = elastic.rows(learned, unseen)?;
        answers.errors.extend(errors(
            "elastic, perfectly plastic",
            unseen,
            &exact,
            &stresses,
            &means,
            &[Quantity::Stress],
        ));
        answers.errors.extend(scatter::scatter(unseen, &exact, &means, &judged));
        let cycles = work::cycles(unseen)?;
        answers.work.push(WorkInCycles::new("simulation", &cycles, &exact, &exact));
        answers.work.push(WorkInCycles::new("elastic, perfectly plastic", &cycles, &exact, &stresses));
        let long_exact = long.map(|long| quantities::rows_of(learned, long)).transpose()?;
        let columns = spec.columns(training)?;
        let inputs = |runs: &Dataset| RunInputs::from_dataset(runs, &columns);
        let (unseen_inputs, long_inputs) = (inputs(unseen)?, long.map(inputs).transpose()?);
        let places = Places::new(unseen)?;
        let mut turn = Turn::new(methods.len(), observer);
        for (name, method) in methods {
            turn.next(name.clone())?;
            let fitted = turn.work(|observer| method.fit(training, &spec, observer))?;
            let predicted = |inputs: &RunInputs| -> Result<(Vec<Row>, Vec<Prediction>)> {
                let predictions = fitted.predict(inputs, LEVEL)?;
                check_finite(&name, &predictions)?;
                let row = |own: &Prediction| {
                    Row::of_outputs(learned, &own.values.iter().map(|value| value.mean).collect::<Vec<_>>())
                };
                Ok((predictions.iter().map(row).collect(), predictions))
            };
            let (rows, predictions) = predicted(&unseen_inputs)?;
            answers.intervals.extend(held(&name, unseen, &places, (&columns, &judged), &predictions)?);
            answers.errors.extend(errors(&name, unseen, &exact, &rows, &means, &judged));
            answers.work.push(WorkInCycles::new(&name, &cycles, &exact, &rows));
            if let (Some(long), Some(exact), Some(inputs)) = (long, &long_exact, &long_inputs) {
                let (rows, predictions) = predicted(inputs)?;
                answers.drift.extend(drift(&name, long, exact, &rows, &means, &judged));
                let places = Places::new(long)?;
                answers.intervals_of_long.extend(held(
                    &name,
                    long,
                    &places,
                    (&columns, &judged),
                    &predictions,
                )?);
            }
            keep(fitted.as_ref())?;
        }
        Ok(answers)
    }
}

/// Refuses predictions that are no numbers, as those of a network whose state has grown without bounds.
fn check_finite(method: &str, predictions: &[Prediction]) -> Result<()> {
    let is_bad = |own: &Prediction| own.values.iter().any(|value| !value.mean.is_finite());
    match predictions.iter().position(is_bad) {
        Some(row) => Err(LearnError::Surrogate {
            method: method.into(),
            reason: format!(
                "what it predicts is no number from row {} of the unseen runs on; train it longer, or with a smaller rate",
                row + 1
            ),
        }),
        None => Ok(()),
    }
}

/// Errors by kind of path and quantity.
fn errors(
    method: &str,
    runs: &Dataset,
    exact: &[Row],
    rows: &[Row],
    means: &Row,
    quantities: &[Quantity],
) -> Vec<PathAnswer> {
    let mut found = Vec::new();
    for of_kind in kinds(runs) {
        for quantity in quantities {
            let mut first = 0;
            let mut sums = Vec::new();
            for run in runs.runs() {
                let own = first..first + run.rows();
                first += run.rows();
                if is_of(run, &of_kind) {
                    sums.push(quantity.squares(&exact[own.clone()], &rows[own], means));
                }
            }
            found.push(PathAnswer {
                method: method.into(),
                kind: of_kind.clone(),
                quantity: quantity.name().into(),
                error: PooledError::new(&sums),
            });
        }
    }
    found
}

/// Errors over the first and the last part of each run.
fn drift(
    method: &str,
    runs: &Dataset,
    exact: &[Row],
    rows: &[Row],
    means: &Row,
    quantities: &[Quantity],
) -> Vec<Drift> {
    let of = |quantity: &Quantity| {
        let mut sums = [Vec::new(), Vec::new()];
        let mut first = 0;
        for run in runs.runs() {
            let (end, part) = (first + run.rows(), ((PART * run.rows() as f64) as usize).max(1));
            for (sums, own) in sums
                .iter_mut()
                .zip([first..(first + part).min(end), end.saturating_sub(part).max(first)..end])
            {
                sums.push(quantity.squares(&exact[own.clone()], &rows[own], means));
            }
            first = end;
        }
        let error = sums.map(|sums| PooledError::new(&sums));
        Drift { method: method.into(), quantity: quantity.name().into(), error }
    };
    quantities.iter().map(of).collect()
}
