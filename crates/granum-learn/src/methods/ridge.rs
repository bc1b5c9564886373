//! Ridge regression, for each output,
//!
//! ```text
//! output = B(coordinate) a + sum_k b_k z_k,   z_k = (input_k - B(coordinate) c_k) / s_k
//! ```
//!
//! with the cubic B-splines `B` of a coordinate (8 knots that are equidistant in the square root of the distance from 0,
//! or from the smallest value of the coordinate if that is negative). Every other input enters as its deviation from its
//! mean as a function of the coordinate (`c_k`), divided by the standard deviation `s_k` of this deviation. Without a
//! coordinate `B` is 1. The coefficients minimise the sum of squared errors over the n rows plus `1e-6 |a|^2 + 0.05 n
//! |b|^2` (Hoerl and Kennard 1970). This is the baseline of the study of the paper, for columns with arbitrary names.
//!
//! The standard deviation of a new observation at a row `x` of the regression has three parts:
//!
//! ```text
//! s^2 = sum of squared errors / (n - gamma)          noise, gamma the effective number of parameters
//! s^2 x^T (X^T X + P)^-1 x                           coefficients, P the penalties
//! mean of e^2 less the first two, at least 0         runs, e the errors of each run when the others answer it
//! ```
//!
//! and the half width of intervals is given by the quantile of Student's t distribution with the degrees of freedom of
//! Welch and Satterthwaite: n - gamma for the first two parts, and the number of runs minus one for the third.

use granum_core::observer::Observer;
use granum_nets::dot;
use serde::{Deserialize, Serialize};

use crate::curve::range;
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::onnx::{self, OnnxAnswer, OnnxEstimate, OnnxGraph, RidgeRow, Value};
use crate::regression::cholesky::Cholesky;
use crate::regression::deviations::{Deviation, Equations, Regression, row};
use crate::regression::spline::{FUNCTIONS, basis};
use crate::surrogate::content::Content;
use crate::surrogate::prediction::{Cause, Estimate, Prediction, outside_of};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod, report_output};

/// Ridge regression with its penalty.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::surrogate::{Cause, FitSpec, RidgeRegression, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// // y = 2 x + 1 with a scatter of 0.1.
/// let x: Vec<f64> = (0..50).map(f64::from).collect();
/// let y = x.iter().map(|x| 2.0 * x + 1.0 + 0.1 * (7.0 * x).sin()).collect();
/// let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)])?;
/// let dataset = Dataset::new(vec![RunStates::new("run", table)?])?;
///
/// let mut method = RidgeRegression::default();
/// method.penalty = 1e-9;
/// let fitted = method.fit(&dataset, &FitSpec::new(["x"], ["y"]), &mut NoObserver)?;
/// let prediction = &fitted.predict_rows(&[20.0], 0.9)?[0];
/// assert!((prediction.values[0].mean - 41.0).abs() < 0.1);
/// let causes = &prediction.values[0].interval.as_ref().unwrap().causes;
/// assert!(matches!(causes[0], (Cause::Noise, s) if (s - 0.07).abs() < 0.01), "{causes:?}");
/// assert_eq!(fitted.predict_rows(&[90.0], 0.9)?[0].outside[0].range, [0.0, 49.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RidgeRegression {
    /// Penalty on the squared coefficients of the inputs, times the number of rows (0.05).
    pub penalty: f64,
}

impl Default for RidgeRegression {
    fn default() -> Self {
        RidgeRegression { penalty: 0.05 }
    }
}

const NAME: &str = "ridge";
/// Most parts of the runs that are left out one after the other.
const PARTS: usize = 16;

fn failed(reason: impl Into<String>) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: reason.into() }
}

/// The coordinate: its index among the inputs, its start (0, or its smallest value if that is negative) and its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Coordinate {
    input: usize,
    start: f64,
    end: f64,
}

/// The fitted parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Fitted {
    coordinate: Option<Coordinate>,
    /// Range of each input over the rows.
    ranges: Vec<[f64; 2]>,
    /// One deviation for each input except the coordinate.
    deviations: Vec<Deviation>,
    /// The Cholesky factor of the normal equations in row-major order.
    factor: Vec<f64>,
    outputs: Vec<Output>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Output {
    /// Coefficients of the functions of the coordinate, followed by those of the deviations.
    coefficients: Vec<f64>,
    noise_variance: f64,
    /// Variance between runs; 0 for a single run.
    run_variance: f64,
    degrees_of_freedom: f64,
}

impl Fitted {
    fn functions(&self, inputs: &[f64]) -> Vec<f64> {
        match &self.coordinate {
            Some(Coordinate { input, start, end }) => basis(inputs[*input] - start, end - start).to_vec(),
            None => vec![1.0],
        }
    }

    /// The inputs except the coordinate.
    fn others<'a>(&self, inputs: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let coordinate = self.coordinate.as_ref().map(|coordinate| coordinate.input);
        inputs.iter().enumerate().filter(move |(k, _)| Some(*k) != coordinate).map(|(_, value)| *value)
    }

    fn row(&self, inputs: &[f64]) -> Vec<f64> {
        row(&self.deviations, &self.functions(inputs), self.others(inputs))
    }

    /// Refuses inconsistent parameters.
    fn check(&self, columns: &Columns) -> Result<()> {
        let inputs = columns.inputs.len();
        let others = inputs - usize::from(self.coordinate.is_some());
        let functions = if self.coordinate.is_some() { FUNCTIONS } else { 1 };
        let size = functions + others;
        let positive = |x: f64| x >= 0.0 && x.is_finite();
        let output = |output: &Output| {
            output.coefficients.len() == size
                && output.coefficients.iter().all(|c| c.is_finite())
                && positive(output.noise_variance)
                && positive(output.run_variance)
                && output.degrees_of_freedom >= 1.0
        };
        let fits = self.coordinate.as_ref().is_none_or(|c| c.input < inputs && c.start <= c.end)
            && self.ranges.len() == inputs
            && self.deviations.len() == others
            && self.deviations.iter().all(|deviation| deviation.mean.len() == functions)
            && Cholesky::from_lower(size, self.factor.clone()).is_some()
            && self.outputs.len() == columns.outputs.len()
            && self.outputs.iter().all(output);
        if fits { Ok(()) } else { Err(failed("its coefficients are not those of its columns")) }
    }
}

fn unsolved() -> LearnError {
    failed("the equations have no solution; are there infinite or huge values?")
}

impl RidgeRegression {
    /// The regression of any targets on rows of inputs, and its parameters but those that depend on the targets; the coordinate
    /// is given by its place among the inputs.
    fn curves_and_slopes(
        &self,
        coordinate: Option<usize>,
        inputs: &[&[f64]],
    ) -> Result<(Fitted, Regression)> {
        if !(self.penalty > 0.0 && self.penalty.is_finite()) {
            return Err(failed(format!("the penalty must be a positive number, not {}", self.penalty)));
        }
        let width = inputs.first().map_or(0, |row| row.len());
        let ranges: Vec<[f64; 2]> = (0..width).map(|k| range(inputs.iter().map(|row| row[k]))).collect();
        let along =
            |input: usize| Coordinate { input, start: ranges[input][0].min(0.0), end: ranges[input][1] };
        let coordinate = coordinate.map(along);
        let mut fitted =
            Fitted { coordinate, ranges, deviations: Vec::new(), factor: Vec::new(), outputs: Vec::new() };
        let functions: Vec<Vec<f64>> = inputs.iter().map(|row| fitted.functions(row)).collect();
        let others: Vec<Vec<f64>> = (0..width)
            .filter(|&input| fitted.coordinate.as_ref().is_none_or(|coordinate| coordinate.input != input))
            .map(|input| inputs.iter().map(|row| row[input]).collect())
            .collect();
        let penalty = self.penalty * inputs.len() as f64;
        let regression = Regression::new(&functions, &others, &|_, _| penalty).ok_or_else(unsolved)?;
        fitted.factor = regression.factor().lower().to_vec();
        fitted.deviations = regression.deviations().to_vec();
        Ok((fitted, regression))
    }

    /// The means for every row of a data set from the runs of the others: runs are left out one by one, or if they are many in
    /// [`PARTS`] parts. One row of outputs for each row of the data set.
    ///
    /// # Errors
    /// As [`SurrogateMethod::fit`], or if there is one run.
    pub(crate) fn left_out_means(&self, dataset: &Dataset, spec: &FitSpec) -> Result<Vec<Vec<f64>>> {
        let columns = spec.columns(dataset)?;
        let inputs = dataset.values(&columns.input_names())?;
        let inputs: Vec<&[f64]> = inputs.chunks_exact(columns.inputs.len()).collect();
        let outputs = dataset.values(&columns.output_names())?;
        let outputs: Vec<&[f64]> = outputs.chunks_exact(columns.outputs.len()).collect();
        let runs = dataset.run_of_rows();
        let parts = dataset.runs().len().min(PARTS);
        if parts < 2 {
            return Err(failed("a run can be left out of two or more"));
        }
        let mut means = vec![Vec::new(); inputs.len()];
        for part in 0..parts {
            let (left_out, others): (Vec<usize>, Vec<usize>) =
                (0..inputs.len()).partition(|&row| runs[row] % parts == part);
            let rows: Vec<&[f64]> = others.iter().map(|&row| inputs[row]).collect();
            let (fitted, regression) = self.curves_and_slopes(spec.place_of_coordinate(&columns), &rows)?;
            let coefficients = |output: usize| {
                regression.coefficients(&others.iter().map(|&row| outputs[row][output]).collect::<Vec<_>>())
            };
            let coefficients: Vec<Vec<f64>> = (0..columns.outputs.len()).map(coefficients).collect();
            for row in left_out {
                let functions = fitted.row(inputs[row]);
                means[row] = coefficients.iter().map(|of_output| dot(of_output, &functions)).collect();
            }
        }
        Ok(means)
    }

    /// As [`SurrogateMethod::fit`], for the means alone: the scatter of the observations is not estimated.
    ///
    /// # Errors
    /// As [`SurrogateMethod::fit`].
    pub(crate) fn fit_means(&self, dataset: &Dataset, spec: &FitSpec) -> Result<FittedRidge> {
        let columns = spec.columns(dataset)?;
        let values = dataset.values(&columns.input_names())?;
        let inputs: Vec<&[f64]> = values.chunks_exact(columns.inputs.len()).collect();
        let (mut fitted, regression) = self.curves_and_slopes(spec.place_of_coordinate(&columns), &inputs)?;
        for output in &columns.outputs {
            let coefficients = regression.coefficients(&dataset.values(&[&output.name])?);
            let (noise_variance, run_variance, degrees_of_freedom) = (0.0, 0.0, 1.0);
            fitted.outputs.push(Output { coefficients, noise_variance, run_variance, degrees_of_freedom });
        }
        Ok(FittedRidge { columns, fitted })
    }

    /// As [`SurrogateMethod::load`], as its own type.
    ///
    /// # Errors
    /// As [`SurrogateMethod::load`].
    pub(crate) fn loaded(&self, columns: Columns, content: &Content) -> Result<FittedRidge> {
        let fitted: Fitted = content.read()?;
        fitted.check(&columns)?;
        Ok(FittedRidge { columns, fitted })
    }
}

impl SurrogateMethod for RidgeRegression {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "ridge regression, linear in the inputs along a curve"
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        let columns = spec.columns(dataset)?;
        let values = dataset.values(&columns.input_names())?;
        let inputs: Vec<&[f64]> = values.chunks_exact(columns.inputs.len()).collect();
        let (mut fitted, regression) = self.curves_and_slopes(spec.place_of_coordinate(&columns), &inputs)?;
        let scatter = Scatter::new(self.penalty, &regression);
        let runs = dataset.run_of_rows();
        for (done, output) in columns.outputs.iter().enumerate() {
            report_output(observer, &columns.outputs, done)?;
            let targets = dataset.values(&[&output.name])?;
            fitted.outputs.push(scatter.output(&targets, &runs).ok_or_else(unsolved)?);
        }
        Ok(Box::new(FittedRidge { columns, fitted }))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        Ok(Box::new(self.loaded(columns, content)?))
    }
}

/// The scatter of the observations about a regression.
struct Scatter<'a> {
    /// Penalty on the squared coefficients of the inputs, times the number of rows.
    penalty: f64,
    regression: &'a Regression,
    /// Effective number of parameters: the trace of `(X^T X + P)^-1 X^T X`.
    effective: f64,
}

impl<'a> Scatter<'a> {
    fn new(penalty: f64, regression: &'a Regression) -> Scatter<'a> {
        let penalties = regression.penalties();
        let size = penalties.len();
        let taken = |k: usize| {
            let unit: Vec<f64> = (0..size).map(|i| f64::from(u8::from(i == k))).collect();
            penalties[k] * regression.factor().solve(&unit)[k]
        };
        let effective = size as f64 - (0..size).map(taken).sum::<f64>();
        Scatter { penalty, regression, effective }
    }

    /// The coefficients for an output, and the scatter of the observations.
    fn output(&self, targets: &[f64], runs: &[usize]) -> Option<Output> {
        let rows = self.regression.rows();
        let coefficients = self.regression.coefficients(targets);
        let squares =
            rows.iter().zip(targets).map(|(row, target)| (dot(&coefficients, row) - target).powi(2));
        let free = (targets.len() as f64 - self.effective).max(1.0);
        let noise_variance = squares.sum::<f64>() / free;
        let parameters = |row: &Vec<f64>| noise_variance * dot(row, &self.regression.factor().solve(row));
        let parameter_variance = rows.iter().map(parameters).sum::<f64>() / rows.len() as f64;
        let count = runs.last().map_or(0, |last| last + 1);
        let within = noise_variance + parameter_variance;
        let run_variance = match count {
            0 | 1 => 0.0,
            _ => (self.left_out(targets, runs, count)? - within).max(0.0),
        };
        // Degrees of freedom by Welch and Satterthwaite; a variance needs at least two runs.
        let between = run_variance * run_variance / (count.max(2) - 1) as f64;
        let all = (within + run_variance).powi(2);
        let degrees_of_freedom = if all > 0.0 { all / (within * within / free + between) } else { free };
        Some(Output {
            coefficients,
            noise_variance,
            run_variance,
            degrees_of_freedom: degrees_of_freedom.max(1.0),
        })
    }

    /// Mean squared error if every run is predicted from the others.
    fn left_out(&self, targets: &[f64], runs: &[usize], count: usize) -> Option<f64> {
        let rows = self.regression.rows();
        let mut sum = 0.0;
        for run in 0..count {
            let (mut others, mut their_targets) = (Vec::new(), Vec::new());
            for k in (0..rows.len()).filter(|&k| runs[k] != run) {
                others.push(rows[k].clone());
                their_targets.push(targets[k]);
            }
            let equations = Equations::new(&others, &self.penalties(others.len()))?;
            let coefficients = equations.solve(&others, &their_targets);
            let own = (0..rows.len()).filter(|&k| runs[k] == run);
            sum += own.map(|k| (dot(&coefficients, &rows[k]) - targets[k]).powi(2)).sum::<f64>();
        }
        Some(sum / rows.len() as f64)
    }

    /// The penalties for another number of rows.
    fn penalties(&self, rows: usize) -> Vec<f64> {
        let mut penalties = self.regression.penalties().to_vec();
        let functions = penalties.len() - self.regression.deviations().len();
        penalties[functions..].fill(self.penalty * rows as f64);
        penalties
    }
}

/// A fitted ridge regression.
#[derive(Clone, Debug)]
pub(crate) struct FittedRidge {
    columns: Columns,
    fitted: Fitted,
}

impl FittedRidge {
    /// The row of the regression in the graph of an ONNX file.
    fn onnx_row(&self, graph: &mut OnnxGraph, inputs: &Value) -> RidgeRow {
        let fitted = &self.fitted;
        let coordinate = fitted.coordinate.as_ref();
        let functions = coordinate.map(|Coordinate { input, start, end }| {
            onnx::along(graph, inputs, *input, [*start, end - start])
        });
        let others: Vec<usize> =
            (0..self.columns.inputs.len()).filter(|k| coordinate.is_none_or(|own| own.input != *k)).collect();
        let deviations = fitted.deviations.iter().map(|own| (own.mean.as_slice(), own.standard_deviation));
        RidgeRow::new(graph, inputs, functions, &others, &deviations.collect::<Vec<_>>())
    }

    /// The means in such a graph, a column for each output.
    pub(crate) fn onnx_means(&self, graph: &mut OnnxGraph, inputs: &Value) -> Value {
        let row = self.onnx_row(graph, inputs);
        let outputs = &self.fitted.outputs;
        let size = outputs.first().map_or(0, |output| output.coefficients.len());
        let matrix: Vec<f64> =
            (0..size).flat_map(|k| outputs.iter().map(move |output| output.coefficients[k])).collect();
        row.product(graph, &matrix, outputs.len())
    }
}

impl Surrogate for FittedRidge {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        let fitted = &self.fitted;
        let size = fitted.outputs.first().map_or(0, |output| output.coefficients.len());
        let factor = Cholesky::from_lower(size, fitted.factor.clone());
        let factor = factor.ok_or_else(|| failed("its coefficients are not those of its columns"))?;
        let quantiles: Vec<f64> = fitted
            .outputs
            .iter()
            .map(|output| granum_nets::two_sided_quantile(level, output.degrees_of_freedom))
            .collect();
        let predict = |inputs: &[f64]| {
            let row = fitted.row(inputs);
            let leverage = dot(&row, &factor.solve(&row)).max(0.0);
            let estimate = |(output, quantile): (&Output, &f64)| {
                let causes = vec![
                    (Cause::Noise, output.noise_variance.sqrt()),
                    (Cause::Parameters, (output.noise_variance * leverage).sqrt()),
                    (Cause::Runs, output.run_variance.sqrt()),
                ];
                Estimate::new(dot(&output.coefficients, &row)).by(causes, *quantile)
            };
            let estimates = fitted.outputs.iter().zip(&quantiles).map(estimate).collect();
            Prediction::new(estimates).with_outside(outside_of(&self.columns, &fitted.ranges, inputs))
        };
        Ok(inputs.rows().map(predict).collect())
    }

    fn evaluate_means(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        let means = |inputs: &[f64]| {
            let row = self.fitted.row(inputs);
            self.fitted.outputs.iter().map(|output| dot(&output.coefficients, &row)).collect()
        };
        Ok(inputs.rows().map(means).collect())
    }

    fn onnx_answer(&self, graph: &mut OnnxGraph, inputs: &Value, level: f64) -> Result<OnnxAnswer> {
        let fitted = &self.fitted;
        let row = self.onnx_row(graph, inputs);
        let leverage = row.leverage(graph, &fitted.factor);
        let mut estimates = Vec::with_capacity(fitted.outputs.len());
        for output in &fitted.outputs {
            let mean = row.product(graph, &output.coefficients, 1);
            let noise = graph.number(output.noise_variance);
            let parameters = graph.apply("Mul", &[&leverage, &noise]);
            let others = graph.number(output.noise_variance + output.run_variance);
            let variance = graph.apply("Add", &[&parameters, &others]);
            let deviation = graph.apply("Sqrt", &[&variance]);
            let quantile = granum_nets::two_sided_quantile(level, output.degrees_of_freedom);
            estimates.push(OnnxEstimate { mean, spread: onnx::spread(graph, Some(deviation), quantile) });
        }
        let outside = onnx::outside(graph, inputs, &fitted.ranges);
        Ok(OnnxAnswer { estimates, outside, ranges: fitted.ranges.clone() })
    }

    fn content(&self) -> Result<Content> {
        Content::new(&self.fitted)
    }
}
