//! Recurrent networks: a method with memory, for which the same inputs give different outputs after different histories.
//!
//! A gated recurrent unit ([`granum_nets::Gru`]) reads the states of a run one after the other. Its memory before the first
//! state is computed from the inputs of that state, and is carried from state to state; all outputs are read from it. The
//! method thus predicts runs of any length, including their first state, but the distance between states should be that of
//! the training runs.
//!
//! The training runs are divided into parts, and for each part a network is trained on the others, until its error on the
//! part no longer falls. The prediction is the mean of these networks; `scatter_of_networks.rs` has its intervals. With a single run there is one
//! network without intervals.

use std::sync::Arc;

use granum_core::observer::Observer;
use granum_nets::trainer::{Adam, Options, SharedTrainer};
use granum_nets::{Data, ModelColumn, SequenceDefinition, SequenceModel, Sequences};
use serde::{Deserialize, Serialize};

use super::networks_of_parts::networks_of_parts;
use super::recurrent_onnx::onnx_steps;
use super::recurrent_steps::RecurrentSteps;
use super::scatter_of_networks::{RunVariances, predictions};
use crate::dataset::{Dataset, Variable};
use crate::error::{LearnError, Result};
use crate::onnx::{self, OnnxGraph};
use crate::surrogate::content::Content;
use crate::surrogate::prediction::Prediction;
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::run_steps::RunSteps;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod};

/// Recurrent networks with all outputs together.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::surrogate::{FitSpec, Recurrent, RunInputs, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// // The output is the largest input so far.
/// let run = |k: u32| {
///     let x: Vec<f64> = (0..12).map(|i| (f64::from(i * (1 + k % 4)) + f64::from(k)).sin()).collect();
///     let largest = x.iter().scan(-1.0, |most, x| {
///         *most = f64::max(*most, *x);
///         Some(*most)
///     });
///     let y = largest.collect();
///     let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)])?;
///     RunStates::new(&format!("run-{k}"), table)
/// };
/// let dataset = Dataset::new((0..16).map(run).collect::<granum_learn::Result<_>>()?)?;
/// let mut method = Recurrent::default();
/// (method.hidden, method.networks) = (8, 2);
/// let fitted = method.fit(&dataset, &FitSpec::new(["x"], ["y"]), &mut NoObserver)?;
/// let asked = RunInputs::new(vec![-0.5, 0.9, -0.5], 1, vec![3])?;
/// let predictions = fitted.predict(&asked, 0.9)?;
/// // The last row has the input of the first, but another history.
/// assert!(predictions[2].values[0].mean > predictions[0].values[0].mean + 0.5, "{predictions:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Recurrent {
    /// Number of hidden neurons of a network (16).
    pub hidden: usize,
    /// Number of networks, at most one for each run (4).
    pub networks: usize,
    /// The trainer (mini-batch Adam with at most 600 epochs).
    pub trainer: SharedTrainer,
}

impl Default for Recurrent {
    fn default() -> Self {
        let trainer = Adam { epochs: 600, learning_rate: 0.01, maximum_failures: 60, ..Adam::default() };
        Recurrent { hidden: 16, networks: 4, trainer: trainer.into() }
    }
}

const NAME: &str = "recurrent";

fn failed(error: impl std::fmt::Display) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: error.to_string() }
}

impl SurrogateMethod for Recurrent {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "recurrent networks, which remember the states of a run before the present one"
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        if self.networks == 0 {
            return Err(failed("the number of networks must be 1 or more, not 0"));
        }
        let columns = spec.columns(dataset)?;
        let inputs = RunInputs::from_dataset(dataset, &columns)?;
        let targets = dataset.values(&columns.output_names())?;
        let runs = inputs.lengths().len();
        let count = self.networks.min(runs);
        let sequences = Sequences::new(inputs.lengths().to_vec()).map_err(failed)?;
        let data = Data::with_target_columns(
            inputs.values().to_vec(),
            columns.inputs.len(),
            targets.clone(),
            columns.outputs.len(),
        )
        .and_then(|data| data.with_sequences(sequences))
        .map_err(failed)?;
        let definition = SequenceDefinition {
            inputs: columns.inputs.iter().map(network_column).collect(),
            outputs: columns.outputs.iter().map(network_column).collect(),
            hidden: self.hidden,
            seed: spec.seed,
        };
        let networks = networks_of_parts(count, spec.threads, observer, |k, part| {
            let own: Vec<usize> = (0..runs).filter(|run| run % count == k).collect();
            let data = match count {
                1 => data.clone(),
                _ => data.clone().with_validation_blocks(&own).map_err(failed)?,
            };
            let seed = spec.seed.wrapping_add(k as u64);
            let options = Options { seed: Some(seed), ..Options::default() };
            let trainer = self.trainer.adapted(&options).unwrap_or_else(|| self.trainer.clone());
            let definition = SequenceDefinition { seed, ..definition.clone() };
            let (model, report) = SequenceModel::fit(&definition, &data, &*trainer, part).map_err(failed)?;
            Ok((model, report.termination))
        })?;
        let ranges = ranges(&inputs);
        let mut fitted = FittedRecurrent { columns, networks: networks.into(), ranges, run_variances: None };
        if count > 1 {
            let (means, outputs) = (fitted.outputs_of_networks(&inputs)?, fitted.columns.outputs.len());
            fitted.run_variances = Some(RunVariances::new(&means, &targets, outputs, inputs.lengths()));
        }
        Ok(Box::new(Arc::new(fitted)))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let kept: Kept = content.read()?;
        let read = |value: &serde_json::Value| SequenceModel::from_value(value, "network").map_err(failed);
        let networks = kept.networks.iter().map(read).collect::<Result<Vec<_>>>()?;
        let alike = |columns: &[ModelColumn], variables: &[Variable]| {
            columns.iter().map(|column| &column.name).eq(variables.iter().map(|variable| &variable.name))
        };
        let fits = |model: &SequenceModel| {
            alike(model.inputs(), &columns.inputs) && alike(model.outputs(), &columns.outputs)
        };
        let outputs = columns.outputs.len();
        let whole = kept.run_variances.as_ref().is_none_or(|known| known.is_whole(outputs));
        if networks.is_empty()
            || !networks.iter().all(fits)
            || kept.ranges.len() != columns.inputs.len()
            || !whole
        {
            return Err(failed("the networks are not those of its columns"));
        }
        let Kept { ranges, run_variances, .. } = kept;
        Ok(Box::new(Arc::new(FittedRecurrent { columns, networks: networks.into(), ranges, run_variances })))
    }
}

fn network_column(variable: &Variable) -> ModelColumn {
    ModelColumn::new(&variable.name, if variable.unit.is_empty() { "1" } else { &variable.unit })
}

/// Range of each input over the rows.
pub(super) fn ranges(inputs: &RunInputs) -> Vec<[f64; 2]> {
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; inputs.columns()];
    for row in inputs.rows() {
        for ([low, high], value) in ranges.iter_mut().zip(row) {
            (*low, *high) = (low.min(*value), high.max(*value));
        }
    }
    ranges
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    ranges: Vec<[f64; 2]>,
    run_variances: Option<RunVariances>,
    networks: Vec<serde_json::Value>,
}

/// Recurrent networks and what is known of their errors.
struct FittedRecurrent {
    columns: Columns,
    networks: Arc<[SequenceModel]>,
    ranges: Vec<[f64; 2]>,
    run_variances: Option<RunVariances>,
}

impl FittedRecurrent {
    /// The outputs of every network, in row-major order.
    fn outputs_of_networks(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        let outputs = |network: &SequenceModel| network.predict(inputs.values(), inputs.lengths());
        self.networks.iter().map(|network| outputs(network).map_err(failed)).collect()
    }
}

/// Shared, so that a run can own what it needs of it.
impl Surrogate for Arc<FittedRecurrent> {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        if inputs.is_empty() {
            return Ok(Vec::new());
        }
        let means = self.outputs_of_networks(inputs)?;
        let known = self.run_variances.as_ref();
        Ok(predictions(&means, known, (&self.columns, &self.ranges), inputs, level))
    }

    fn steps(&self, level: f64) -> Result<Option<Box<dyn RunSteps>>> {
        let fitted = Arc::clone(self);
        let predict = move |means: &[Vec<f64>], row: &[f64]| {
            let inputs = RunInputs::new(row.to_vec(), row.len(), vec![1])?;
            let known = fitted.run_variances.as_ref();
            let all = predictions(means, known, (&fitted.columns, &fitted.ranges), &inputs, level);
            Ok(all.into_iter().next().unwrap_or_default())
        };
        let (networks, outputs) = (Arc::clone(&self.networks), self.columns.outputs.len());
        Ok(Some(Box::new(RecurrentSteps::new(networks, outputs, Box::new(predict), failed))))
    }

    fn onnx(&self, graph: &mut OnnxGraph, level: f64) -> Result<()> {
        let inputs = onnx::inputs(graph, &self.columns);
        onnx::state_ranges(graph, &self.columns, &self.ranges);
        let known = self.run_variances.as_ref().map(|known| (known, level));
        let estimates = onnx_steps(graph, &self.networks, &inputs, known, self.columns.outputs.len());
        let outside = onnx::outside(graph, &inputs, &self.ranges);
        onnx::outputs(graph, &self.columns, &estimates, &outside);
        Ok(())
    }

    fn content(&self) -> Result<Content> {
        let networks = self.networks.iter().map(|network| network.to_value().map_err(failed));
        Content::new(&Kept {
            ranges: self.ranges.clone(),
            run_variances: self.run_variances.clone(),
            networks: networks.collect::<Result<_>>()?,
        })
    }
}
