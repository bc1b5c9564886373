//! Networks by sub-model are weighed against ridge regression on the runs that each of them leaves out.

use granum_nets::{Data, Model, ModelError};

use super::ridge_share::{RidgeShare, supported_share};
use super::training_rows::{HISTOGRAM_OBSERVATIONS, Rule, STATE_OBSERVATIONS, TrainingStates};
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::surrogate::{FitSpec, RidgeRegression};

/// The networks of a mapping with the share of ridge regression that the left-out runs support, and with intervals that hold for the
/// predictions of both together. Without regularisation, or with a single run, nothing changes.
///
/// # Errors
/// If the training rows are not those of the networks.
pub(super) fn weighed(
    states: &TrainingStates,
    dataset: &Dataset,
    spec: &FitSpec,
    rule: Rule,
    networks: Vec<Model>,
) -> Result<(Vec<Model>, Option<RidgeShare>)> {
    let mapping = states.mapping;
    let failed = |reason: String| LearnError::Network { network: mapping.name.clone(), reason };
    let of_model = |error: ModelError| failed(error.to_string());
    if rule == Rule::Separate || dataset.runs().len() < 2 {
        return Ok((networks, None));
    }
    let mut rows: Vec<(Data, Vec<f64>)> = Vec::new();
    for (k, network) in networks.iter().enumerate() {
        let data = states.data(k, rule).map_err(|error| failed(error.to_string()))?;
        let Some(errors) = network.left_out_errors(&data).map_err(of_model)? else {
            return Ok((networks, None));
        };
        rows.push((data, errors));
    }
    let Ok(means) = RidgeRegression::default().left_out_means(dataset, spec) else {
        return Ok((networks, None));
    };
    // The errors of ridge regression in the order of the observations, and the number of the sub-model that predicts each of them.
    let (mut ridge, mut predicted_by) = (Vec::new(), Vec::new());
    for (row, inputs, outputs) in states.chosen() {
        let sub_model = mapping.sub_model_at(mapping.coordinate_of(inputs)).0;
        for (mean, output) in means[row].iter().zip(outputs) {
            ridge.push(mean - output);
            predicted_by.push(sub_model);
        }
    }
    let errors: Vec<(f64, f64)> =
        predicted_by.iter().enumerate().map(|(k, sub_model)| (rows[*sub_model].1[k], ridge[k])).collect();
    // The bins of a histogram vary in several independent ways.
    let ways = if mapping.predicts_histogram() { HISTOGRAM_OBSERVATIONS / STATE_OBSERVATIONS } else { 1.0 };
    let share = supported_share(&errors, dataset.runs().len(), ways);
    let Some(beside) = RidgeShare::fit(dataset, spec, vec![share; mapping.output.len()]) else {
        return Ok((networks, None));
    };
    let calibrated = networks.into_iter().zip(&rows).map(|(network, (data, errors_alone))| {
        let mixed: Vec<f64> = errors_alone.iter().zip(&ridge).map(|(a, b)| beside.mixed(0, *a, *b)).collect();
        network.with_left_out_errors(data, &mixed).map_err(of_model)
    });
    Ok((calibrated.collect::<Result<_>>()?, Some(beside)))
}
