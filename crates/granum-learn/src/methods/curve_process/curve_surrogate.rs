//! Fitted processes of curves as a surrogate.

use super::densities::Densities;
use super::failure::NAME;
use super::fitted::{FittedCurves, Kept};
use super::onnx_form::onnx_curves;
use super::predicted_curve::Curve;
use crate::curve::interpolated;
use crate::error::Result;
use crate::onnx::{OnnxAnswer, OnnxGraph, Value};
use crate::surrogate::content::Content;
use crate::surrogate::possible_values::possible_values;
use crate::surrogate::prediction::Prediction;
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::Columns;
use crate::surrogate::surrogate_trait::Surrogate;

impl Surrogate for FittedCurves {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        Ok(self.predictions(inputs, &|calibration| calibration.interval(level)))
    }

    fn evaluate_means(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        let Kept { coordinate, points, .. } = &self.kept;
        let mut last: Option<(Vec<f64>, Vec<Curve>)> = None;
        let means = |row: &[f64]| {
            let own = self.beside_coordinate(row);
            // The rows of a run differ in the coordinate alone.
            let (_, curves) = match last.take() {
                Some(same) if same.0 == own => last.insert(same),
                _ => last.insert((own.clone(), self.curves_of_means(&own))),
            };
            curves.iter().map(|curve| interpolated(row[*coordinate], points, &curve.mean)).collect()
        };
        Ok(inputs.rows().map(means).collect())
    }

    fn possible_values(&self, output: usize) -> [f64; 2] {
        let [low, high] = possible_values(&self.columns.outputs[output].name);
        let end = |densities: &&Densities| densities.first + densities.bins();
        let is_bin = self.kept.histograms.iter().any(|own| own.first <= output && output < end(&own));
        // In the place of the bins of each histogram before the output are its directions.
        let before = self.kept.histograms.iter().filter(|own| end(own) <= output);
        let curve = before.fold(output, |curve, own| curve + own.directions.len() - own.bins());
        let root = !is_bin && self.kept.curves.get(curve).is_some_and(|kept| kept.root);
        [if root { low.max(0.0) } else { low }, high]
    }

    fn onnx_answer(&self, graph: &mut OnnxGraph, inputs: &Value, level: f64) -> Result<OnnxAnswer> {
        let (answer, unseen) = onnx_curves(self, graph, inputs, level)?;
        Ok(match unseen {
            Some(unseen) => {
                let outside = graph.apply("Max", &[&answer.outside, &unseen]);
                OnnxAnswer { outside, ..answer }
            }
            None => answer,
        })
    }

    fn content(&self) -> Result<Content> {
        Content::new(&self.kept)
    }
}
