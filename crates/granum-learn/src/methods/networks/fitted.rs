//! The trained networks of a mapping and their predictions.

use std::any::Any;

use granum_nets::{Deviation, Model, ModelError};
use serde::{Deserialize, Serialize};

use super::mapping::NetworkMapping;
use super::ridge_share::{RidgeShare, StoredRidgeShare};
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::onnx::OnnxGraph;
use crate::surrogate::{Columns, Content, Estimate, Outside, Prediction, RunInputs, Surrogate, causes};

/// A mapping with one trained network for each sub-model, and the ridge regression that has a share in their predictions if
/// they were trained on several runs.
///
/// As a [`Surrogate`] it predicts columns of a data set. [`SubModelNetworks::predict_states`] gives the predictions without
/// intervals, and [`SubModelNetworks::predict_row`] those of single values, with the binned variable as an input if a histogram
/// is the output.
#[derive(Clone, Debug)]
pub struct SubModelNetworks {
    method: String,
    pub(super) mapping: NetworkMapping,
    pub(super) networks: Vec<Model>,
    columns: Columns,
    /// The ridge regression that has a share in the predictions; `None` if the networks stand alone.
    pub(super) beside: Option<RidgeShare>,
}

/// The prediction for a state.
#[derive(Clone, Debug, PartialEq)]
pub struct StatePrediction {
    /// The output: one value, or for a histogram one value for each bin.
    pub values: Vec<f64>,
    /// Number of the sub-model that was used, from 0.
    pub sub_model: usize,
    /// True if the coordinate is outside the ranges of all sub-models, or an input is outside the trained range of the network.
    pub outside: bool,
}

/// The prediction for one row, see [`SubModelNetworks::input_names`].
#[derive(Clone, Debug, PartialEq)]
pub struct RowPrediction {
    /// The output.
    pub value: f64,
    /// Standard deviation of an observation around the output, split by cause, if the network provides it.
    pub deviation: Option<Deviation>,
    /// Lower and upper end of the requested interval, if the network provides it.
    pub interval: Option<[f64; 2]>,
    /// Number of the sub-model that was used, from 0.
    pub sub_model: usize,
    /// The inputs outside the trained range of the network, including the coordinate if no sub-model covers it.
    pub outside: Vec<Outside>,
}

/// The networks of a surrogate, if it consists of networks by sub-model.
pub fn networks_of(surrogate: &dyn Surrogate) -> Option<&SubModelNetworks> {
    (surrogate as &dyn Any).downcast_ref()
}

impl SubModelNetworks {
    /// The networks of a mapping, which were fitted by the method of the given name.
    ///
    /// # Errors
    /// If there is not one network for each sub-model, or the columns of a network are not those of the mapping.
    pub fn new(method: &str, mapping: NetworkMapping, networks: Vec<Model>) -> Result<SubModelNetworks> {
        let problem = |reason: String| LearnError::Network { network: mapping.name.clone(), reason };
        if mapping.sub_models.is_empty() || networks.len() != mapping.sub_models.len() {
            let (found, wanted) = (networks.len(), mapping.sub_models.len());
            return Err(problem(format!("{found} networks for {wanted} sub-models")));
        }
        if mapping.coordinate >= mapping.inputs.len() {
            return Err(problem("the coordinate is no input".into()));
        }
        let (inputs, output) = (mapping.network_inputs(), mapping.network_output());
        for (k, network) in networks.iter().enumerate() {
            let names = |columns: &[granum_nets::ModelColumn]| {
                columns.iter().map(|column| column.name.clone()).collect::<Vec<_>>().join(", ")
            };
            let (found, wanted) = (names(network.inputs()), names(&inputs));
            if found != wanted || network.output().name != output.name {
                return Err(problem(format!(
                    "network {} maps ({found}) to {}, but should map ({wanted}) to {}",
                    k + 1,
                    network.output().name,
                    output.name
                )));
            }
        }
        let columns = mapping.columns();
        Ok(SubModelNetworks { method: method.to_owned(), mapping, networks, columns, beside: None })
    }

    /// The same networks with a ridge regression beside them.
    pub(super) fn beside(self, beside: Option<RidgeShare>) -> SubModelNetworks {
        SubModelNetworks { beside, ..self }
    }

    /// The share of ridge regression in the predictions, from 0 to 1: 0 if the networks stand alone.
    pub fn share_of_ridge(&self) -> f64 {
        self.beside.as_ref().and_then(|beside| beside.shares().first()).map_or(0.0, |share| *share)
    }

    /// The mapping.
    pub fn mapping(&self) -> &NetworkMapping {
        &self.mapping
    }

    /// The networks, one for each sub-model.
    pub fn networks(&self) -> &[Model] {
        &self.networks
    }

    /// Names of the values of a row for [`SubModelNetworks::predict_row`]: the columns that are inputs, and the binned variable
    /// if a histogram is the output.
    pub fn input_names(&self) -> Vec<String> {
        let mut names = self.columns.input_names();
        names.extend(self.mapping.output.bins.as_ref().map(|bins| bins.binned.clone()));
        names
    }

    /// The trained range of a sub-model for each of [`SubModelNetworks::input_names`]; for the coordinate only the part that
    /// the sub-models cover. In point form all bins share the range of the values.
    pub fn trained_ranges(&self, sub_model: usize) -> Vec<[f64; 2]> {
        let scalers = self.networks[sub_model].input_scalers();
        let ends = |k: usize| scalers.get(k).map_or([0.0; 2], |scaler| [scaler.minimum, scaler.maximum]);
        let covered = self
            .mapping
            .sub_models
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| [a.min(s.range[0]), b.max(s.range[1])]);
        let (mut ranges, mut next) = (Vec::new(), 0);
        for (k, input) in self.mapping.inputs.iter().enumerate() {
            if self.mapping.is_point(input) {
                ranges.extend(std::iter::repeat_n(ends(next + 1), input.len()));
                next += 2;
            } else {
                ranges.extend((next..next + input.len()).map(ends));
                next += input.len();
            }
            if k == self.mapping.coordinate
                && let Some([low, high]) = ranges.last_mut()
            {
                (*low, *high) = (low.max(covered[0]), high.min(covered[1]));
            }
        }
        if self.mapping.predicts_histogram() {
            ranges.push(ends(next));
        }
        ranges
    }

    /// The prediction for one row, in which the coordinate selects the sub-model. The interval should contain the share `level`
    /// of the states of unseen runs.
    ///
    /// # Errors
    /// If the row has the wrong length or a value is not finite.
    pub fn predict_row(&self, row: &[f64], level: f64) -> Result<RowPrediction> {
        let one = self.predict_single_values(row, level)?.pop();
        one.ok_or_else(|| LearnError::Network {
            network: self.mapping.name.clone(),
            reason: "there is no row to predict".into(),
        })
    }

    /// As [`SubModelNetworks::predict_row`], for many rows in row-major order.
    ///
    /// # Errors
    /// As [`SubModelNetworks::predict_row`].
    pub fn predict_single_values(&self, rows: &[f64], level: f64) -> Result<Vec<RowPrediction>> {
        let names = self.input_names();
        let problem = |reason: String| LearnError::Network { network: self.mapping.name.clone(), reason };
        if !rows.len().is_multiple_of(names.len()) {
            let (found, list) = (rows.len() % names.len(), names.join(", "));
            return Err(problem(format!("a row has {} values ({list}), not {found}", names.len())));
        }
        if let Some(k) = rows.iter().position(|value| !value.is_finite()) {
            let (row, name) = (k / names.len() + 1, &names[k % names.len()]);
            return Err(problem(format!("row {row}: {name} is {}, not a finite number", rows[k])));
        }
        let rows: Vec<&[f64]> = rows.chunks_exact(names.len()).collect();
        let mut predictions = vec![None; rows.len()];
        for (sub_model, own) in self.by_sub_model(&rows) {
            let mut inputs = Vec::new();
            for &k in &own {
                let (state, at) = rows[k].split_at(self.columns.inputs.len());
                self.mapping.push_inputs(state, at, &mut inputs);
            }
            let mut spread = self.spread(sub_model, &inputs, level)?;
            let width = self.columns.inputs.len();
            let states: Vec<&[f64]> = own.iter().map(|&k| &rows[k][..width]).collect();
            let at: Vec<f64> = own.iter().flat_map(|&k| rows[k][width..].iter().copied()).collect();
            self.correct(sub_model, &states, &at, &mut spread.values)?;
            let ranges = self.trained_ranges(sub_model);
            for (place, &k) in own.iter().enumerate() {
                predictions[k] = Some(RowPrediction {
                    value: spread.values[place],
                    deviation: spread.deviations.as_ref().map(|deviations| deviations[place]),
                    interval: spread.interval(place),
                    sub_model,
                    outside: self.outside(rows[k], &names, &ranges),
                });
            }
        }
        Ok(predictions.into_iter().flatten().collect())
    }

    /// The numbers of the rows of each sub-model that has some.
    fn by_sub_model(&self, rows: &[&[f64]]) -> Vec<(usize, Vec<usize>)> {
        let at: Vec<usize> =
            rows.iter().map(|row| self.mapping.sub_model_at(self.mapping.coordinate_of(row)).0).collect();
        let own = |sub_model: usize| (0..rows.len()).filter(|&k| at[k] == sub_model).collect::<Vec<_>>();
        (0..self.networks.len()).map(|k| (k, own(k))).filter(|(_, own)| !own.is_empty()).collect()
    }

    fn outside(&self, row: &[f64], names: &[String], ranges: &[[f64; 2]]) -> Vec<Outside> {
        let coordinate = self.mapping.place_of_coordinate();
        let uncovered = !self.mapping.sub_model_at(row[coordinate]).1;
        let beyond = |k: &usize| {
            let [low, high] = ranges[*k];
            !(row[*k] >= low && row[*k] <= high) || (*k == coordinate && uncovered)
        };
        let found = (0..row.len()).filter(beyond);
        found.map(|k| Outside { name: names[k].clone(), value: row[k], range: ranges[k] }).collect()
    }

    /// Predictions of a network with their standard deviations.
    fn spread(&self, sub_model: usize, inputs: &[f64], level: f64) -> Result<Spread> {
        let network = &self.networks[sub_model];
        let failed = |error: ModelError| self.failed(sub_model, &error);
        let points = self.mapping.points_of_value();
        let (batch, deviations) = network.predict_batch_with_deviations(inputs, points).map_err(failed)?;
        Ok(Spread {
            values: batch.values.chunks(points).map(mean).collect(),
            deviations,
            quantile: network.quantile(level),
        })
    }

    /// The predictions for states, given as rows of [`NetworkMapping::columns`] in row-major order, without intervals. In point
    /// form a single value is the mean of the outputs over the bins.
    ///
    /// # Errors
    /// If a value is not finite.
    pub fn predict_states(&self, rows: &[f64]) -> Result<Vec<StatePrediction>> {
        self.predict_states_at(rows, self.mapping.output_centres())
    }

    /// As [`SubModelNetworks::predict_states`], but a histogram is predicted at arbitrary values of the binned variable.
    ///
    /// # Errors
    /// As [`SubModelNetworks::predict_states`].
    pub fn predict_states_at(&self, rows: &[f64], at: &[f64]) -> Result<Vec<StatePrediction>> {
        let rows: Vec<&[f64]> = rows.chunks_exact(self.columns.inputs.len().max(1)).collect();
        let mut predictions: Vec<Option<StatePrediction>> = vec![None; rows.len()];
        for (sub_model, own) in self.by_sub_model(&rows) {
            let mut inputs = Vec::new();
            own.iter().for_each(|&k| self.mapping.push_inputs(rows[k], at, &mut inputs));
            let batch = self.networks[sub_model]
                .predict_batch(&inputs)
                .map_err(|error| self.failed(sub_model, &error))?;
            let rows_of_state = batch.values.len() / own.len();
            let mut values = match self.mapping.predicts_histogram() {
                true => batch.values,
                false => batch.values.chunks(rows_of_state).map(mean).collect(),
            };
            let each = values.len() / own.len();
            let states: Vec<&[f64]> = own.iter().flat_map(|&k| std::iter::repeat_n(rows[k], each)).collect();
            self.correct(sub_model, &states, &at.repeat(own.len()), &mut values)?;
            for (place, &k) in own.iter().enumerate() {
                let outside = &batch.outside[place * rows_of_state..(place + 1) * rows_of_state];
                let inside = self.mapping.sub_model_at(self.mapping.coordinate_of(rows[k])).1;
                predictions[k] = Some(StatePrediction {
                    values: values[place * each..(place + 1) * each].to_vec(),
                    sub_model,
                    outside: !inside || outside.contains(&true),
                });
            }
        }
        Ok(predictions.into_iter().flatten().collect())
    }

    pub(super) fn failed(&self, sub_model: usize, error: &ModelError) -> LearnError {
        let network = format!("{} sub-model {}", self.mapping.name, sub_model + 1);
        LearnError::Network { network, reason: error.to_string() }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Predictions with their standard deviations, and the half width of an interval in standard deviations.
struct Spread {
    values: Vec<f64>,
    deviations: Option<Vec<Deviation>>,
    quantile: f64,
}

impl Spread {
    fn interval(&self, k: usize) -> Option<[f64; 2]> {
        let half = self.quantile * self.deviations.as_ref()?[k].total;
        Some([self.values[k] - half, self.values[k] + half])
    }
}

/// A mapping and its networks in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stored {
    mapping: NetworkMapping,
    networks: Vec<serde_json::Value>,
    /// Files of earlier versions, and those of networks that stand alone, have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    beside: Option<StoredRidgeShare>,
}

impl SubModelNetworks {
    /// Recreates the networks from the content of their file, for the method of the given name.
    ///
    /// # Errors
    /// If the content is not that of networks with these columns.
    pub fn from_content(method: &str, columns: &Columns, content: &Content) -> Result<SubModelNetworks> {
        let failed = |reason: String| LearnError::Surrogate { method: method.to_owned(), reason };
        let stored: Stored = content.read()?;
        let models = stored
            .networks
            .iter()
            .map(|value| Model::from_value(value, "network").map_err(|error| failed(error.to_string())));
        let networks = SubModelNetworks::new(method, stored.mapping, models.collect::<Result<_>>()?)?;
        if networks.columns != *columns {
            return Err(failed("the columns of the mapping are not those that the file names".into()));
        }
        let beside = stored.beside.map(|beside| beside.restored(columns)).transpose();
        Ok(networks.beside(beside.map_err(|error| failed(error.to_string()))?))
    }
}

impl Surrogate for SubModelNetworks {
    fn method(&self) -> &str {
        &self.method
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn check(&self, dataset: &Dataset) -> Result<()> {
        self.mapping.check_bins(dataset)
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        // If the output is a histogram, the last value of a row is that of the binned variable.
        let bins: Vec<Option<f64>> = match self.mapping.predicts_histogram() {
            true => self.mapping.output_centres().iter().copied().map(Some).collect(),
            false => vec![None],
        };
        let asked: Vec<f64> = inputs
            .rows()
            .flat_map(|row| bins.iter().flat_map(|bin| row.iter().copied().chain(*bin)))
            .collect();
        let predictions = self.predict_single_values(&asked, level)?;
        Ok(predictions.chunks(bins.len()).map(prediction).collect())
    }

    fn evaluate_means(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        Ok(self.predict_states(inputs.values())?.into_iter().map(|predicted| predicted.values).collect())
    }

    fn onnx(&self, graph: &mut OnnxGraph, level: f64) -> Result<()> {
        self.onnx_form(graph, level);
        Ok(())
    }

    fn content(&self) -> Result<Content> {
        let failed = |error: ModelError| LearnError::Network {
            network: self.mapping.name.clone(),
            reason: error.to_string(),
        };
        let networks = self.networks.iter().map(|model| model.to_value().map_err(failed));
        Content::new(&Stored {
            mapping: self.mapping.clone(),
            networks: networks.collect::<Result<_>>()?,
            beside: self.beside.as_ref().map(RidgeShare::stored).transpose()?,
        })
    }
}

/// The prediction for one state, with one estimate for each output.
fn prediction(predictions: &[RowPrediction]) -> Prediction {
    let estimate = |predicted: &RowPrediction| match (predicted.interval, &predicted.deviation) {
        (Some(ends), Some(deviation)) => Estimate::new(predicted.value).within(ends, causes(deviation)),
        _ => Estimate::new(predicted.value),
    };
    let mut outside: Vec<Outside> = Vec::new();
    for found in predictions.iter().flat_map(|predicted| &predicted.outside) {
        if outside.iter().all(|known| known.name != found.name) {
            outside.push(found.clone());
        }
    }
    Prediction::new(predictions.iter().map(estimate).collect()).with_outside(outside)
}
