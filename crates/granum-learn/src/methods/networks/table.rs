//! Predictions of networks by sub-model for whole tables, with remarks on their validity.

use std::collections::BTreeSet;

use granum_core::{Column, Table};

use super::fitted::{RowPrediction, SubModelNetworks};
use crate::error::{LearnError, Result};
use crate::inference::{chosen, rows_of};

/// Predictions for the rows of a table.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TablePrediction {
    /// The inputs, then `predicted_NAME`, then `standard_deviation`, `lower` and `upper` if the networks provide them, and
    /// last `sub_model` (from 1) and `outside` (1 if an input is outside the trained range).
    pub table: Table,
    /// Number of rows outside the trained range.
    pub outside: usize,
    /// The sub-models that were used, from 0.
    pub sub_models: Vec<usize>,
}

impl SubModelNetworks {
    /// Predicts every row of a table with a column for each of [`SubModelNetworks::input_names`], with intervals of the given
    /// level.
    ///
    /// # Errors
    /// If a column is missing or a value is not finite; the message gives the position.
    pub fn predict_table(&self, table: &Table, level: f64) -> Result<TablePrediction> {
        let inputs = chosen(table, &self.input_names())?;
        for column in inputs.columns() {
            if let Some(k) = column.values.iter().position(|value| !value.is_finite()) {
                let (name, value) = (&column.name, column.values[k]);
                let reason = format!("data row {}: {name} is {value}, not a finite number", k + 1);
                return Err(LearnError::Rows(reason));
            }
        }
        let predictions = self.predict_single_values(&rows_of(&inputs), level)?;
        let outside = predictions.iter().filter(|predicted| !predicted.outside.is_empty()).count();
        let mut all = inputs.columns().to_vec();
        let mut add = |name: &str, value: &dyn Fn(&RowPrediction) -> f64| {
            all.push(Column::new(name, "", predictions.iter().map(value).collect()));
        };
        add(&format!("predicted_{}", self.mapping().output.name), &|predicted| predicted.value);
        if predictions.iter().any(|predicted| predicted.interval.is_some()) {
            add("standard_deviation", &|predicted| {
                predicted.deviation.map_or(f64::NAN, |deviation| deviation.total)
            });
            add("lower", &|predicted| predicted.interval.map_or(f64::NAN, |[lower, _]| lower));
            add("upper", &|predicted| predicted.interval.map_or(f64::NAN, |[_, upper]| upper));
        }
        add("sub_model", &|predicted| (predicted.sub_model + 1) as f64);
        add("outside", &|predicted| f64::from(u8::from(!predicted.outside.is_empty())));
        let table = Table::new(all)?;
        let sub_models: BTreeSet<usize> = predictions.iter().map(|predicted| predicted.sub_model).collect();
        Ok(TablePrediction { table, outside, sub_models: sub_models.into_iter().collect() })
    }

    /// The numbers, counted from 1, of those of the given sub-models (counted from 0) whose predictions are constant: those of
    /// networks that learned a constant and stand alone.
    pub fn constants(&self, sub_models: &[usize]) -> Vec<usize> {
        if self.share_of_ridge() > 0.0 {
            return Vec::new();
        }
        sub_models.iter().filter(|k| self.networks()[**k].is_constant()).map(|k| k + 1).collect()
    }

    /// Remarks on predictions of the given sub-models (from 0), as sentences.
    pub fn remarks(&self, sub_models: &[usize]) -> Vec<String> {
        let name = &self.mapping().name;
        let constant = self.constants(sub_models).into_iter().map(|number| {
            format!("{name} sub-model {number}: this network learned a constant: it does not use its inputs.")
        });
        let mut remarks: Vec<String> = constant.collect();
        let asked = || sub_models.iter().map(|&k| &self.networks()[k]);
        if asked().any(|network| network.training_fit().evidence.is_none()) {
            let trainer = &self.networks()[0].provenance().trainer;
            remarks.push(format!(
                "There is no interval: networks trained by {trainer} do not estimate their uncertainty."
            ));
        } else if let Some(runs) = asked().map(granum_nets::Model::blocks).min().flatten() {
            remarks.push(format!(
                "The interval includes the scatter between samples, estimated from {runs} training runs."
            ));
        } else {
            remarks.push(
                "The interval does not include the scatter between samples: the network was trained on one run, or \
                 cannot distinguish runs."
                    .into(),
            );
        }
        remarks
    }
}
