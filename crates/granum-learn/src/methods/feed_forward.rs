//! Feed-forward networks, one for each output.
//!
//! The bins of a histogram are scaled together as one quantity. With two or more runs, the intervals are calibrated by
//! leaving out each run in turn, see [`granum_nets::Intervals`].

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use granum_core::observer::{Observer, SharedObserver};
use granum_core::parallel;
use granum_nets::trainer::SharedTrainer;
use granum_nets::{Data, Model, ModelColumn, ModelDefinition};
use serde::{Deserialize, Serialize};

use crate::dataset::{Dataset, Variable};
use crate::error::{LearnError, Result};
use crate::methods::networks::{
    NetworkCheckpoints, NetworkSettings, NetworkTask, NoCheckpoints, RidgeShare, StoredRidgeShare,
    supported_share,
};
use crate::methods::ridge::RidgeRegression;
use crate::onnx::{self, OnnxEstimate, OnnxGraph};
use crate::surrogate::content::Content;
use crate::surrogate::prediction::{Estimate, Prediction, causes, outside_of};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod};

/// Feed-forward networks of one size for every output.
///
/// ```
/// use granum_learn::surrogate::{FeedForward, SurrogateMethod};
/// use granum_nets::trainer::LevenbergMarquardt;
///
/// // Small networks with a particular trainer.
/// let mut method = FeedForward::default();
/// method.hidden = vec![6];
/// method.trainer = LevenbergMarquardt { epochs: 200, ..Default::default() }.into();
/// assert_eq!(method.name(), "feed-forward");
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FeedForward {
    /// Numbers of neurons of the hidden layers (10 and 10).
    pub hidden: Vec<usize>,
    /// The trainer (Levenberg-Marquardt with Bayesian regularisation).
    pub trainer: SharedTrainer,
    /// Effective number of independent observations of a row (1). Neighbouring states of a test are correlated; in the
    /// study of the paper the value is 0.15 for the states of its default recording.
    pub observations_per_row: f64,
}

impl Default for FeedForward {
    fn default() -> Self {
        FeedForward { hidden: vec![10, 10], trainer: SharedTrainer::default(), observations_per_row: 1.0 }
    }
}

const NAME: &str = "feed-forward";

fn failed(error: impl std::fmt::Display) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: error.to_string() }
}

impl FeedForward {
    /// The training rows of an output.
    fn rows(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        columns: &Columns,
        inputs: &[f64],
        output: &Variable,
    ) -> Result<Data> {
        let targets = dataset.values(&[&output.name])?;
        let observations = targets.len() as f64 * self.observations_per_row;
        Data::new(inputs.to_vec(), columns.inputs.len(), targets)
            .and_then(|data| data.with_observations(observations))
            .and_then(|data| data.with_blocks(dataset.run_of_rows()))
            .and_then(|data| match spec.place_of_coordinate(columns) {
                Some(place) => data.with_spread_column(place),
                None => Ok(data),
            })
            .map_err(failed)
    }
}

/// The networks with the share of ridge regression in each output that left-out runs support, and with intervals that hold for
/// both together. Networks without regularisation, and those of a single run, stand alone.
fn weighed(
    dataset: &Dataset,
    spec: &FitSpec,
    columns: &Columns,
    models: Vec<Model>,
    rows: impl Fn(&Variable) -> Result<Data>,
) -> Result<(Vec<Model>, Option<RidgeShare>)> {
    let runs = dataset.runs().len();
    let Some(means) =
        (runs > 1).then(|| RidgeRegression::default().left_out_means(dataset, spec).ok()).flatten()
    else {
        return Ok((models, None));
    };
    // For each output its rows, and the errors of the network and of ridge regression on them.
    let mut of_outputs: Vec<(Data, Vec<(f64, f64)>)> = Vec::new();
    for (k, (model, output)) in models.iter().zip(&columns.outputs).enumerate() {
        let data = rows(output)?;
        let Some(network) = model.left_out_errors(&data).map_err(failed)? else { return Ok((models, None)) };
        let ridge = means.iter().zip(data.targets()).map(|(means, target)| means[k] - target);
        let errors = network.into_iter().zip(ridge).collect();
        of_outputs.push((data, errors));
    }
    let shares = of_outputs.iter().map(|(_, errors)| supported_share(errors, runs, 1.0)).collect();
    let Some(beside) = RidgeShare::fit(dataset, spec, shares) else { return Ok((models, None)) };
    let calibrated = models.into_iter().zip(of_outputs).enumerate().map(|(k, (model, (data, errors)))| {
        let mixed: Vec<f64> = errors.iter().map(|(a, b)| beside.mixed(k, *a, *b)).collect();
        model.with_left_out_errors(&data, &mixed).map_err(failed)
    });
    Ok((calibrated.collect::<Result<_>>()?, Some(beside)))
}

impl SurrogateMethod for FeedForward {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "feed-forward networks, one for each output"
    }

    fn with_networks(&self, settings: &NetworkSettings) -> Result<Option<Arc<dyn SurrogateMethod>>> {
        let (trainer, hidden) = (settings.trainer()?, settings.hidden.clone());
        Ok(Some(Arc::new(FeedForward { trainer, hidden, ..self.clone() })))
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        self.fit_resumable(dataset, spec, observer, &NoCheckpoints)
    }

    fn fit_resumable(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
        checkpoints: &dyn NetworkCheckpoints,
    ) -> Result<Box<dyn Surrogate>> {
        let columns = spec.columns(dataset)?;
        let inputs = dataset.values(&columns.input_names())?;
        let definition = ModelDefinition {
            quantities: quantities(dataset, &columns),
            ..ModelDefinition::new(
                columns.inputs.iter().map(network_column).collect(),
                ModelColumn::new("", "1"),
                self.hidden.clone(),
            )
        };
        let shared = SharedObserver::new(observer);
        let (done, total) = (AtomicUsize::new(0), columns.outputs.len());
        let models = parallel::map(total, spec.threads, |k| {
            let stopped = || LearnError::Stopped { done: done.load(Ordering::Relaxed), total };
            if shared.stopped() {
                return Err(stopped());
            }
            let output = &columns.outputs[k];
            let mut part = shared.part(&output.name);
            let data = self.rows(dataset, spec, &columns, &inputs, output)?;
            let seed = spec.seed.wrapping_add(k as u64);
            let task = NetworkTask {
                name: output.name.clone(),
                kept_as: spec.network_kept_as(&(k + 1).to_string()),
                definition: ModelDefinition { output: network_column(output), seed, ..definition.clone() },
                data,
                trainer: self.trainer.clone(),
                epochs: None,
            };
            let model = task.train(&mut part, checkpoints)?.ok_or_else(stopped)?;
            done.fetch_add(1, Ordering::Relaxed);
            part.completed();
            Ok(model)
        })?;
        let data = |output: &Variable| self.rows(dataset, spec, &columns, &inputs, output);
        let (models, beside) = weighed(dataset, spec, &columns, models, data)?;
        Ok(Box::new(FittedNetworks { columns, models, beside }))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let kept: Kept = content.read()?;
        let models = kept.networks.iter().map(|value| Model::from_value(value, "network").map_err(failed));
        let models = models.collect::<Result<Vec<_>>>()?;
        let names = columns.input_names();
        let fits = |(model, output): (&Model, &Variable)| {
            model.output().name == output.name && model.inputs().iter().map(|c| &c.name).eq(&names)
        };
        if models.len() != columns.outputs.len() || !models.iter().zip(&columns.outputs).all(fits) {
            return Err(failed("the networks are not those of its columns"));
        }
        let beside = kept.beside.map(|beside| beside.restored(&columns)).transpose()?;
        Ok(Box::new(FittedNetworks { columns, models, beside }))
    }
}

fn network_column(variable: &Variable) -> ModelColumn {
    ModelColumn::new(&variable.name, if variable.unit.is_empty() { "1" } else { &variable.unit })
}

/// For each input the number of its quantity; all bins of a histogram are one quantity.
fn quantities(dataset: &Dataset, columns: &Columns) -> Vec<usize> {
    let histograms: Vec<Vec<String>> = dataset
        .runs()
        .first()
        .map_or(Vec::new(), |run| run.groups().iter().map(|group| group.columns().collect()).collect());
    let histogram_of = |name: &String| histograms.iter().position(|names| names.contains(name));
    let mut numbers: Vec<usize> = Vec::new();
    for (k, input) in columns.inputs.iter().enumerate() {
        let same = histogram_of(&input.name).and_then(|own| {
            columns.inputs[..k].iter().position(|other| histogram_of(&other.name) == Some(own))
        });
        numbers.push(
            same.map_or_else(|| numbers.iter().max().map_or(0, |most| most + 1), |first| numbers[first]),
        );
    }
    numbers
}

/// Networks, one for each output, and the ridge regression that has a share in their predictions.
struct FittedNetworks {
    columns: Columns,
    models: Vec<Model>,
    beside: Option<RidgeShare>,
}

impl FittedNetworks {
    /// The trained ranges of the inputs.
    fn ranges(&self) -> Vec<[f64; 2]> {
        self.models.first().map_or(Vec::new(), |model| {
            model.input_scalers().iter().map(|scaler| [scaler.minimum, scaler.maximum]).collect()
        })
    }

    /// Adds the share of ridge regression to the values of an output.
    fn correct(&self, output: usize, ridge: Option<&Vec<Vec<f64>>>, values: &mut [f64]) {
        if let (Some(beside), Some(ridge)) = (&self.beside, ridge) {
            values
                .iter_mut()
                .zip(ridge)
                .for_each(|(value, ridge)| *value = beside.mixed(output, *value, ridge[output]));
        }
    }

    /// What ridge regression predicts for each row.
    fn ridge(&self, inputs: &RunInputs) -> Result<Option<Vec<Vec<f64>>>> {
        self.beside.as_ref().map(|beside| beside.means(inputs.values().to_vec())).transpose()
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    networks: Vec<serde_json::Value>,
    /// Files of earlier versions, and those of networks that stand alone, have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    beside: Option<StoredRidgeShare>,
}

impl Surrogate for FittedNetworks {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        let flat = inputs.values();
        let mut predictions = vec![Prediction::default(); inputs.len()];
        let ridge = self.ridge(inputs)?;
        for (output, model) in self.models.iter().enumerate() {
            let (mut batch, deviations) = model.predict_batch_with_deviations(flat, 1).map_err(failed)?;
            self.correct(output, ridge.as_ref(), &mut batch.values);
            let quantile = model.quantile(level);
            for (k, (prediction, mean)) in predictions.iter_mut().zip(batch.values).enumerate() {
                let estimate = Estimate::new(mean);
                prediction.values.push(match &deviations {
                    None => estimate,
                    Some(all) => {
                        let half = quantile * all[k].total;
                        estimate.within([mean - half, mean + half], causes(&all[k]))
                    }
                });
            }
        }
        let ranges = self.ranges();
        for (prediction, row) in predictions.iter_mut().zip(inputs.rows()) {
            prediction.outside = outside_of(&self.columns, &ranges, row);
        }
        Ok(predictions)
    }

    fn evaluate_means(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        let mut means = vec![Vec::with_capacity(self.models.len()); inputs.len()];
        let ridge = self.ridge(inputs)?;
        for (output, model) in self.models.iter().enumerate() {
            let mut values = model.predict_batch(inputs.values()).map_err(failed)?.values;
            self.correct(output, ridge.as_ref(), &mut values);
            means.iter_mut().zip(values).for_each(|(row, mean)| row.push(mean));
        }
        Ok(means)
    }

    fn onnx(&self, graph: &mut OnnxGraph, level: f64) -> Result<()> {
        let inputs = onnx::inputs(graph, &self.columns);
        let ridge = self.beside.as_ref().map(|beside| beside.onnx(graph, &inputs));
        let mut estimates = Vec::with_capacity(self.models.len());
        for (output, model) in self.models.iter().enumerate() {
            let network = onnx::network(graph, model, &inputs, 1);
            let mean = match (&self.beside, &ridge) {
                (Some(beside), Some(ridge)) => beside.onnx_mixed(graph, output, &network.values, ridge),
                _ => network.values,
            };
            let spread = onnx::spread(graph, network.deviations, model.quantile(level));
            estimates.push(OnnxEstimate { mean, spread });
        }
        let ranges = self.ranges();
        onnx::state_ranges(graph, &self.columns, &ranges);
        let outside = onnx::outside(graph, &inputs, &ranges);
        onnx::outputs(graph, &self.columns, &estimates, &outside);
        Ok(())
    }

    fn content(&self) -> Result<Content> {
        let networks = self.models.iter().map(|model| model.to_value().map_err(failed));
        let beside = self.beside.as_ref().map(RidgeShare::stored).transpose()?;
        Content::new(&Kept { networks: networks.collect::<Result<_>>()?, beside })
    }
}
