//! How well surrogates with a state follow any path: fitted to some runs and rolled out freely along whole unseen ones, from the state of the sample
//! to the end, beside baselines and the scatter between samples.

mod baselines;
mod quantities;
mod work;

use std::sync::Arc;

use granum_core::observer::{NoObserver, Observer};
use serde::{Deserialize, Serialize};

use self::quantities::{Quantity, Row};
use super::turn::Turn;
use crate::dataset::{Dataset, RunStates};
use crate::error::Result;
use crate::pooled_error::PooledError;
use crate::surrogate::{FitSpec, PathNetworks, RunInputs, SurrogateMethod, SurrogateMethods};

pub use work::WorkInCycles;

/// Columns of strain, which are the path.
const STRAINS: [&str; 6] = [
    "axial_strain",
    "lateral_strain_2",
    "lateral_strain_3",
    "shear_strain_yz",
    "shear_strain_zx",
    "shear_strain_xy",
];
const TENSORS: [&str; 2] = ["stress", "fabric"];
const SUFFIXES: [&str; 6] = ["11", "22", "33", "23", "13", "12"];
const SCALARS: [&str; 2] = ["volumetric_strain", "mechanical_coordination_number"];
/// The word of a case that says what a random path consists of.
const KIND: &str = "stage.1.kind";
/// The name for runs of all kinds.
const ALL: &str = "all";
/// Share of a long path at its beginning and at its end.
const PART: f64 = 0.1;

/// Surrogates of any path, and on what they are judged.
#[derive(Clone, Debug, PartialEq)]
pub struct AnyPath {
    /// Methods, with settings where they have some: `path-gru`, `path-tensor:internal=0,hidden=12` (see [`PathNetworks::from_words`]).
    pub methods: Vec<String>,
    /// Seed of the methods.
    pub seed: u64,
    /// Number of threads; 0 for the number of processors. Answers do not depend on it.
    pub threads: usize,
}

/// The error of a method for one quantity and kind of path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathAnswer {
    /// The method, a baseline, or `another sample`: the scatter of single runs about the mean of samples on the same path.
    pub method: String,
    /// What the path consists of: a kind of the path `random`, or `all`.
    pub kind: String,
    /// What is judged: `stress deviator`, `volumetric strain`, `fabric deviator` or `coordination number`.
    pub quantity: String,
    /// Its error; for tensors over the root mean square of the tensor, for scalars over that of the difference from the mean of the training states.
    pub error: PooledError,
}

/// The error of a method at the beginning and at the end of long paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    /// The method.
    pub method: String,
    /// What is judged.
    pub quantity: String,
    /// Error over the first and over the last tenth of each path.
    pub error: [PooledError; 2],
}

/// All answers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PathAnswers {
    /// Errors on unseen runs.
    pub errors: Vec<PathAnswer>,
    /// The work in closed cycles of strain, of the simulations first.
    pub work: Vec<WorkInCycles>,
    /// Errors at the beginning and the end of long runs, if there are any.
    pub drift: Vec<Drift>,
}

impl AnyPath {
    /// What is learned: stress, fabric, volumetric strain and mechanical coordination number, from the strains and the state of the sample.
    pub fn spec() -> FitSpec {
        let tensors = TENSORS.iter().flat_map(|name| SUFFIXES.map(|suffix| format!("{name}_{suffix}")));
        let outputs: Vec<String> = tensors.chain(SCALARS.map(String::from)).collect();
        let samples = outputs.iter().filter(|name| *name != SCALARS[0]).map(|name| format!("sample.{name}"));
        let strains = STRAINS.map(String::from).into_iter();
        let inputs: Vec<String> = strains.chain(samples).chain(["sample.void_ratio".into()]).collect();
        FitSpec::new(inputs, outputs)
    }

    /// Fits each method to the training runs, and judges it on the unseen and the long ones.
    ///
    /// # Errors
    /// If a column or method does not exist, a surrogate cannot be fitted, or the observer stops the measurement.
    pub fn measure(
        &self,
        training: &Dataset,
        unseen: &Dataset,
        long: Option<&Dataset>,
        methods: &SurrogateMethods,
        observer: &mut dyn Observer,
    ) -> Result<PathAnswers> {
        let spec = AnyPath::spec().with_seed(self.seed).with_threads(self.threads);
        let method = |word: &String| -> Result<(String, Arc<dyn SurrogateMethod>)> {
            Ok((word.clone(), PathNetworks::from_words(word, methods)?))
        };
        let methods = self.methods.iter().map(method).collect::<Result<Vec<_>>>()?;
        let means = quantities::means(training)?;
        let exact = quantities::rows_of(unseen)?;
        let mut answers = PathAnswers::default();
        let mut add = |name: &str, rows: &[Row]| {
            answers.errors.extend(errors(name, unseen, &exact, rows, &means, &Quantity::ALL));
        };
        add("mean of the training states", &vec![means; exact.len()]);
        add("first state", &baselines::first_states(unseen)?);
        let elastic = baselines::ElasticPerfectlyPlastic::fit(training)?;
        let stresses = elastic.rows(unseen)?;
        answers.errors.extend(errors(
            "elastic, perfectly plastic",
            unseen,
            &exact,
            &stresses,
            &means,
            &[Quantity::Stress],
        ));
        answers.errors.extend(baselines::scatter(unseen, &exact, &means));
        let cycles = work::cycles(unseen)?;
        answers.work.push(WorkInCycles::new("simulation", &cycles, &exact, &exact));
        answers.work.push(WorkInCycles::new("elastic, perfectly plastic", &cycles, &exact, &stresses));
        let long_exact = long.map(quantities::rows_of).transpose()?;
        let mut turn = Turn::new(methods.len(), observer);
        for (name, method) in methods {
            turn.next(name.clone())?;
            let fitted = method.fit(training, &spec, &mut NoObserver)?;
            let predicted = |runs: &Dataset| -> Result<Vec<Row>> {
                let rows = fitted.means(&RunInputs::from_dataset(runs, fitted.columns())?)?;
                Ok(rows.iter().map(|row| Row::of_outputs(row)).collect())
            };
            let rows = predicted(unseen)?;
            answers.errors.extend(errors(&name, unseen, &exact, &rows, &means, &Quantity::ALL));
            answers.work.push(WorkInCycles::new(&name, &cycles, &exact, &rows));
            if let (Some(long), Some(exact)) = (long, &long_exact) {
                answers.drift.extend(drift(&name, long, exact, &predicted(long)?, &means));
            }
        }
        Ok(answers)
    }
}

/// The kind of the path of a run.
fn kind(run: &RunStates) -> String {
    run.word(KIND).unwrap_or_else(|| ALL.into())
}

/// The kinds that occur, after all of them together.
fn kinds(runs: &Dataset) -> Vec<String> {
    let mut found = vec![ALL.to_string()];
    for run in runs.runs() {
        if !found.contains(&kind(run)) {
            found.push(kind(run));
        }
    }
    found
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
                if of_kind == ALL || kind(run) == of_kind {
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
fn drift(method: &str, runs: &Dataset, exact: &[Row], rows: &[Row], means: &Row) -> Vec<Drift> {
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
    Quantity::ALL.iter().map(of).collect()
}
