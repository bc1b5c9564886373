//! A method of surrogates with memory: a linear function of the inputs and of their fading means along the run,
//! `m_k = 0.8 m_(k-1) + 0.2 x_k`, fitted by least squares.

use granum::core::observer::Observer;
use granum::learn::regression::cholesky::Cholesky;
use granum::learn::surrogate::{Columns, Content, RunInputs, outside_of};
use granum::learn::{LearnError, Result};
use granum::prelude::*;

pub struct FadingMemory;

/// Its name in the registry and in files.
const NAME: &str = "fading-memory";
/// How much of its mean a run keeps from state to state.
const KEPT: f64 = 0.8;
/// Added to the diagonal of the equations over its mean, so that inputs that depend on each other have a solution.
const RIDGE: f64 = 1e-9;

struct Fitted {
    columns: Columns,
    ranges: Vec<[f64; 2]>,
    /// For each output the factors of 1, of each input and of each fading mean.
    factors: Vec<Vec<f64>>,
}

/// For each state of a run 1, its inputs and their fading means.
fn features(run: &[f64], inputs: usize) -> Vec<Vec<f64>> {
    let mut means = run[..inputs].to_vec();
    let of_state = |row: &[f64]| {
        for (mean, value) in means.iter_mut().zip(row) {
            *mean = KEPT * *mean + (1.0 - KEPT) * value;
        }
        [1.0].iter().chain(row).chain(&means).copied().collect()
    };
    run.chunks_exact(inputs).map(of_state).collect()
}

impl SurrogateMethod for FadingMemory {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "linear in the inputs and in their fading means along the run"
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn fit(&self, dataset: &Dataset, spec: &FitSpec, _: &mut dyn Observer) -> Result<Box<dyn Surrogate>> {
        let columns = spec.columns(dataset)?;
        let inputs = RunInputs::from_dataset(dataset, &columns)?;
        let rows: Vec<Vec<f64>> = inputs.runs().flat_map(|run| features(run, inputs.columns())).collect();
        let count = 1 + 2 * inputs.columns();
        let mut squares = vec![0.0; count * count];
        for row in &rows {
            for (k, square) in squares.iter_mut().enumerate() {
                *square += row[k / count] * row[k % count];
            }
        }
        let ridge = RIDGE * (0..count).map(|k| squares[k * count + k]).sum::<f64>() / count as f64;
        (0..count).for_each(|k| squares[k * count + k] += ridge);
        let problem = || LearnError::Surrogate {
            method: self.name().into(),
            reason: "the states do not determine it; use more states, or inputs that vary".into(),
        };
        let solver = Cholesky::new(count, &squares).ok_or_else(problem)?;
        let factors = |name: String| {
            let values = dataset.column(&name)?;
            let sum = |k: usize| rows.iter().zip(&values).map(|(row, value)| row[k] * value).sum::<f64>();
            Ok(solver.solve(&(0..count).map(sum).collect::<Vec<f64>>()))
        };
        let factors = columns.output_names().into_iter().map(factors).collect::<Result<_>>()?;
        let wider = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
        let range =
            |k: usize| inputs.rows().map(|row| row[k]).fold([f64::INFINITY, f64::NEG_INFINITY], wider);
        let ranges = (0..inputs.columns()).map(range).collect();
        Ok(Box::new(Fitted { columns, ranges, factors }))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let (ranges, factors): (Vec<[f64; 2]>, Vec<Vec<f64>>) = content.read()?;
        let (inputs, outputs) = (columns.inputs.len(), columns.outputs.len());
        let fits = |factors: &Vec<f64>| factors.len() == 1 + 2 * inputs;
        if ranges.len() != inputs || factors.len() != outputs || !factors.iter().all(fits) {
            return Err(LearnError::Content("its factors are not those of its columns".into()));
        }
        Ok(Box::new(Fitted { columns, ranges, factors }))
    }
}

impl Surrogate for Fitted {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn evaluate(&self, inputs: &RunInputs, _level: f64) -> Result<Vec<Prediction>> {
        let predicted = |(features, row): (Vec<f64>, &[f64])| {
            let mean = |factors: &Vec<f64>| factors.iter().zip(&features).map(|(a, x)| a * x).sum::<f64>();
            let estimates = self.factors.iter().map(|factors| Estimate::new(mean(factors))).collect();
            Prediction::new(estimates).with_outside(outside_of(&self.columns, &self.ranges, row))
        };
        let features = inputs.runs().flat_map(|run| features(run, inputs.columns()));
        Ok(features.zip(inputs.rows()).map(predicted).collect())
    }

    fn content(&self) -> Result<Content> {
        Content::new(&(&self.ranges, &self.factors))
    }
}
