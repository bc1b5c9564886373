//! Fitted processes of curves.

use std::sync::Arc;

use granum_nets::gaussian_process::{GaussianProcess, Rows};
use serde::{Deserialize, Serialize};

use super::calibration::Calibration;
use super::failure::{NAME, failed};
use super::groups::Group;
use crate::curve::{increases, interpolated};
use crate::error::Result;
use crate::surrogate::content::Content;
use crate::surrogate::prediction::{Cause, Estimate, Prediction, outside_of};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::Columns;
use crate::surrogate::surrogate_trait::Surrogate;

/// Fewest runs for intervals.
const FEWEST_RUNS: usize = 3;

/// What is kept in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Kept {
    /// Place of the coordinate among the inputs.
    pub coordinate: usize,
    /// Number of training runs.
    pub runs: usize,
    /// The points of the curves.
    pub points: Vec<f64>,
    /// What the processes see of the inputs beside the coordinate.
    pub groups: Vec<Group>,
    /// Range of each of these inputs.
    pub ranges: Vec<[f64; 2]>,
    /// The values of the groups of the training runs, in row-major order.
    pub rows: Vec<f64>,
    pub outputs: Vec<KeptOutput>,
}

/// The processes of an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptOutput {
    /// The input, of those beside the coordinate, at whose value the curve starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<usize>,
    pub mean: Vec<f64>,
    pub components: Vec<Vec<f64>>,
    /// Variance at each point that the components do not contain.
    pub rest: Vec<f64>,
    /// Logarithms of the parameters of each process.
    pub parameters: Vec<Vec<f64>>,
    /// For each component its weights in the training runs.
    pub weights: Vec<Vec<f64>>,
    pub calibration: Calibration,
}

/// Gaussian processes of curves, fitted to runs.
pub struct FittedCurves {
    columns: Columns,
    kept: Kept,
    /// For each output the process of each component.
    processes: Vec<Vec<GaussianProcess>>,
}

/// The curve of an output, predicted: values at each point.
struct Curve {
    mean: Vec<f64>,
    /// Variance of the mean.
    parameters: Vec<f64>,
    /// Variance of a single run about it.
    noise: Vec<f64>,
}

impl FittedCurves {
    pub(super) fn new(columns: Columns, kept: Kept) -> Result<FittedCurves> {
        let bad = || failed("the content is not that of its columns");
        if !is_sound(&columns, &kept) {
            return Err(bad());
        }
        let mut processes: Vec<Vec<GaussianProcess>> = kept.outputs.iter().map(|_| Vec::new()).collect();
        if !kept.groups.is_empty() {
            let rows = Arc::new(Rows::new(kept.rows.clone(), kept.groups.len()).map_err(failed)?);
            for (output, own) in kept.outputs.iter().zip(&mut processes) {
                for (targets, parameters) in output.weights.iter().zip(&output.parameters) {
                    let process = GaussianProcess::with_parameters(rows.clone(), targets, parameters.clone());
                    own.push(process.map_err(failed)?);
                }
            }
        }
        Ok(FittedCurves { columns, kept, processes })
    }

    /// Bands that should contain the share `level` of the whole curves of new runs, and not only of their states: for each state the
    /// prediction with the band at it as its interval.
    ///
    /// # Errors
    /// As [`Surrogate::predict`].
    pub fn bands(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        // Checks the inputs and the level.
        self.predict(inputs, level)?;
        Ok(self.predictions(inputs, &|calibration| calibration.band(level)))
    }

    fn predictions(&self, inputs: &RunInputs, factor: &dyn Fn(&Calibration) -> f64) -> Vec<Prediction> {
        let Kept { coordinate, runs, points, ranges, outputs, .. } = &self.kept;
        let factors: Vec<f64> = outputs.iter().map(|output| factor(&output.calibration)).collect();
        let mut all_ranges = ranges.clone();
        all_ranges.insert(*coordinate, [points[0], points[points.len() - 1]]);
        let mut known: Option<(Vec<f64>, Vec<Curve>)> = None;
        let mut predictions = Vec::with_capacity(inputs.len());
        for row in inputs.rows() {
            let x = row[*coordinate];
            let mut own = row.to_vec();
            own.remove(*coordinate);
            // The rows of a run differ in the coordinate alone.
            let (_, curves) = match known.take() {
                Some(same) if same.0 == own => known.insert(same),
                _ => {
                    let curves = (0..outputs.len()).map(|output| self.curve(output, &own)).collect();
                    known.insert((own, curves))
                }
            };
            let at = |values: &[f64]| interpolated(x, points, values);
            let estimate = |(curve, factor): (&Curve, &f64)| {
                let mean = Estimate::new(at(&curve.mean));
                // One or two runs say nothing of their scatter.
                if *runs < FEWEST_RUNS {
                    return mean;
                }
                let causes = vec![
                    (Cause::Noise, at(&curve.noise).sqrt()),
                    (Cause::Parameters, at(&curve.parameters).sqrt()),
                ];
                mean.by(causes, *factor)
            };
            let estimates = curves.iter().zip(&factors).map(estimate).collect();
            predictions.push(Prediction::new(estimates).with_outside(outside_of(
                &self.columns,
                &all_ranges,
                row,
            )));
        }
        predictions
    }

    /// The curve of an output for the inputs beside the coordinate.
    fn curve(&self, output: usize, inputs: &[f64]) -> Curve {
        let kept = &self.kept.outputs[output];
        let row: Vec<f64> = self.kept.groups.iter().map(|group| group.value(inputs)).collect();
        let start = kept.start.map_or(0.0, |input| inputs[input]);
        let mut curve = Curve {
            mean: kept.mean.iter().map(|mean| start + mean).collect(),
            parameters: vec![0.0; kept.mean.len()],
            noise: kept.rest.clone(),
        };
        for (component, process) in kept.components.iter().zip(&self.processes[output]) {
            let weight = process.predict(&row);
            for (k, value) in component.iter().enumerate() {
                curve.mean[k] += weight.mean * value;
                curve.parameters[k] += weight.variance * value * value;
                curve.noise[k] += weight.noise * value * value;
            }
        }
        curve
    }
}

fn is_sound(columns: &Columns, kept: &Kept) -> bool {
    let (inputs, points) = (columns.inputs.len(), kept.points.len());
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    let is_curve = |values: &Vec<f64>| values.len() == points && finite(values);
    let (groups, runs) = (kept.groups.len(), kept.runs);
    let output = |output: &KeptOutput| {
        output.start.is_none_or(|start| start + 1 < inputs)
            && is_curve(&output.mean)
            && is_curve(&output.rest)
            && output.rest.iter().all(|variance| *variance >= 0.0)
            && output.components.iter().all(is_curve)
            && (groups > 0 || output.components.is_empty())
            && output.weights.len() == output.components.len()
            && output.parameters.len() == output.components.len()
            && output.weights.iter().all(|weights| weights.len() == runs)
            && output.calibration.is_sound()
    };
    kept.coordinate < inputs
        && points > 1
        && increases(&kept.points)
        && finite(&kept.points)
        && runs > 0
        && kept.rows.len() == runs * groups
        && kept.groups.iter().all(|group| group.is_sound(inputs - 1))
        && kept.ranges.len() + 1 == inputs
        && kept.outputs.len() == columns.outputs.len()
        && kept.outputs.iter().all(output)
}

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

    fn content(&self) -> Result<Content> {
        Content::new(&self.kept)
    }
}
