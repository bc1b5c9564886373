//! The mean curve of the runs: the mean of each output at the coordinate, whatever the other inputs are. It is the baseline that
//! every other surrogate must be better than.
//!
//! The curve has a point at every coordinate of the first run; the other runs are interpolated linearly between their states.
//! Outside its range it is constant. Without a coordinate it is the mean over all rows. With n runs the standard deviation of a
//! new run is `s sqrt(1 + 1/n)`, where `s` is the unbiased standard deviation between the runs at the coordinate, and the
//! half width of intervals follows from Student's t distribution with n - 1 degrees of freedom; for a single run there is no
//! interval.

use granum_core::observer::Observer;
use serde::{Deserialize, Serialize};

use crate::curve::{increases, interpolated, never_falls};
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::onnx::{self, OnnxAnswer, OnnxEstimate, OnnxGraph, Value};
use crate::surrogate::content::Content;
use crate::surrogate::prediction::{Cause, Estimate, Prediction, outside_of};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod, report_output};

/// The mean curve of the runs.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::surrogate::{FitSpec, MeanCurve, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// let run = |name: &str, y: Vec<f64>| {
///     RunStates::new(name, Table::new(vec![Column::new("x", "", vec![0.0, 1.0]), Column::new("y", "", y)])?)
/// };
/// let dataset = Dataset::new(vec![run("a", vec![1.0, 3.0])?, run("b", vec![2.0, 6.0])?])?;
/// let curve = MeanCurve.fit(&dataset, &FitSpec::new(["x"], ["y"]).with_coordinate("x"), &mut NoObserver)?;
/// assert_eq!(curve.predict_rows(&[0.5], 0.9)?[0].values[0].mean, 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct MeanCurve;

pub(crate) const NAME: &str = "mean-curve";

fn failed(reason: impl Into<String>) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: reason.into() }
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Fitted {
    /// True if the only input is the coordinate of the points; otherwise there is one point.
    along_coordinate: bool,
    /// Number of runs.
    runs: usize,
    /// Coordinates of the points, increasing.
    coordinates: Vec<f64>,
    /// For each output its mean at each point.
    means: Vec<Vec<f64>>,
    /// For each output the standard deviation between the runs at each point; empty for a single run.
    deviations: Vec<Vec<f64>>,
}

impl Fitted {
    fn check(&self, columns: &Columns) -> Result<()> {
        let points = self.coordinates.len();
        let curves = |curves: &[Vec<f64>]| {
            curves.len() == columns.outputs.len()
                && curves.iter().all(|curve| curve.len() == points && curve.iter().all(|y| y.is_finite()))
        };
        let sound = points > 0
            && increases(&self.coordinates)
            && self.coordinates.iter().all(|x| x.is_finite())
            && (!self.along_coordinate || columns.inputs.len() == 1)
            && curves(&self.means)
            && (self.deviations.is_empty() || curves(&self.deviations));
        if sound { Ok(()) } else { Err(failed("its points are not those of its columns")) }
    }
}

impl SurrogateMethod for MeanCurve {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "the mean of the runs at the coordinate"
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        let mut columns = spec.columns(dataset)?;
        let Some(place) = spec.place_of_coordinate(&columns) else {
            let fitted = overall_mean(dataset, &columns, observer)?;
            return Ok(Box::new(FittedCurve { columns, fitted }));
        };
        columns.inputs = vec![columns.inputs[place].clone()];
        let runs = dataset.runs().iter().map(|run| curves_of(run, &columns)).collect::<Result<Vec<_>>>()?;
        // A stage of rest before the test has the first coordinate too.
        let mut coordinates = runs.first().map_or(Vec::new(), |(xs, _)| xs.clone());
        coordinates.dedup();
        let at = |output: usize, x: f64| -> Vec<f64> {
            runs.iter().map(|(xs, curves)| interpolated(x, xs, &curves[output])).collect()
        };
        let (mut means, mut deviations) = (Vec::new(), Vec::new());
        for output in 0..columns.outputs.len() {
            report_output(observer, &columns.outputs, output)?;
            let over = |value: &dyn Fn(&[f64]) -> f64| -> Vec<f64> {
                coordinates.iter().map(|x| value(&at(output, *x))).collect()
            };
            means.push(over(&mean));
            if runs.len() > 1 {
                deviations.push(over(&deviation));
            }
        }
        let fitted = Fitted { along_coordinate: true, runs: runs.len(), coordinates, means, deviations };
        fitted.check(&columns)?;
        Ok(Box::new(FittedCurve { columns, fitted }))
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let fitted: Fitted = content.read()?;
        fitted.check(&columns)?;
        Ok(Box::new(FittedCurve { columns, fitted }))
    }
}

fn overall_mean(dataset: &Dataset, columns: &Columns, observer: &mut dyn Observer) -> Result<Fitted> {
    let mut means = Vec::new();
    for (done, output) in columns.outputs.iter().enumerate() {
        report_output(observer, &columns.outputs, done)?;
        means.push(vec![mean(&dataset.values(&[&output.name])?)]);
    }
    let runs = dataset.runs().len();
    Ok(Fitted { along_coordinate: false, runs, coordinates: vec![0.0], means, deviations: Vec::new() })
}

/// The coordinates of a run and the values of each output at them.
fn curves_of(run: &RunStates, columns: &Columns) -> Result<(Vec<f64>, Vec<Vec<f64>>)> {
    let coordinate = &columns.inputs[0].name;
    let xs = run.column(coordinate)?;
    if !never_falls(&xs) {
        return Err(failed(format!(
            "the coordinate {coordinate} falls from a state to the next in {}, so that there is no mean at it",
            run.name()
        )));
    }
    let outputs = columns.output_names();
    let curves = outputs.iter().map(|name| run.column(name)).collect::<Result<Vec<_>>>()?;
    if xs.iter().chain(curves.iter().flatten()).any(|value| !value.is_finite()) {
        return Err(failed(format!("{} contains a value that is not a finite number", run.name())));
    }
    Ok((xs, curves))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The unbiased standard deviation.
fn deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    (squares / (values.len() as f64 - 1.0)).sqrt()
}

struct FittedCurve {
    columns: Columns,
    fitted: Fitted,
}

impl FittedCurve {
    fn ranges(&self) -> Vec<[f64; 2]> {
        let Fitted { along_coordinate, coordinates, .. } = &self.fitted;
        match (along_coordinate, coordinates.first(), coordinates.last()) {
            (true, Some(first), Some(last)) => vec![[*first, *last]],
            _ => vec![[f64::NEG_INFINITY, f64::INFINITY]; self.columns.inputs.len()],
        }
    }
}

impl Surrogate for FittedCurve {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        let Fitted { along_coordinate, runs, coordinates, means, deviations } = &self.fitted;
        let n = *runs as f64;
        let quantile = granum_nets::two_sided_quantile(level, n - 1.0);
        let ranges = self.ranges();
        let predict = |row: &[f64]| {
            let x = if *along_coordinate { row[0] } else { 0.0 };
            let estimate = |k: usize| {
                let estimate = Estimate::new(interpolated(x, coordinates, &means[k]));
                match deviations.get(k) {
                    None => estimate,
                    Some(curve) => {
                        let deviation = interpolated(x, coordinates, curve) * (1.0 + 1.0 / n).sqrt();
                        estimate.by(vec![(Cause::Runs, deviation)], quantile)
                    }
                }
            };
            let values = (0..means.len()).map(estimate).collect();
            Prediction::new(values).with_outside(outside_of(&self.columns, &ranges, row))
        };
        Ok(inputs.rows().map(predict).collect())
    }

    fn onnx_answer(&self, graph: &mut OnnxGraph, inputs: &Value, level: f64) -> Result<OnnxAnswer> {
        let Fitted { runs, coordinates, means, deviations, .. } = &self.fitted;
        let n = *runs as f64;
        let quantile = granum_nets::two_sided_quantile(level, n - 1.0);
        // Without a coordinate there is one value, whatever the first input is.
        let x = graph.columns(inputs, &[0]);
        let mut estimates = Vec::with_capacity(means.len());
        for (k, means) in means.iter().enumerate() {
            let mean = onnx::interpolated(graph, &x, coordinates, means);
            let deviation = deviations.get(k).map(|curve| {
                let curve: Vec<f64> = curve.iter().map(|value| value * (1.0 + 1.0 / n).sqrt()).collect();
                onnx::interpolated(graph, &x, coordinates, &curve)
            });
            estimates.push(OnnxEstimate { mean, spread: onnx::spread(graph, deviation, quantile) });
        }
        let ranges = self.ranges();
        let outside = onnx::outside(graph, inputs, &ranges);
        Ok(OnnxAnswer { estimates, outside, ranges })
    }

    fn content(&self) -> Result<Content> {
        Content::new(&self.fitted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::observer::NoObserver;
    use granum_core::{Column, Table};

    fn run(name: &str, xs: &[f64], y: impl Fn(f64) -> f64) -> RunStates {
        let ys = xs.iter().map(|x| y(*x)).collect();
        RunStates::new(
            name,
            Table::new(vec![Column::new("x", "", xs.to_vec()), Column::new("y", "", ys)]).unwrap(),
        )
        .unwrap()
    }

    #[test]
    fn the_mean_and_its_interval_are_those_by_hand() {
        let xs = [0.0, 1.0, 2.0];
        let runs = vec![run("a", &xs, |x| x), run("b", &[0.0, 2.0], |x| x + 2.0), run("c", &xs, |x| x + 4.0)];
        let dataset = Dataset::new(runs).unwrap();
        let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
        let curve = MeanCurve.fit(&dataset, &spec, &mut NoObserver).unwrap();
        let prediction = &curve.predict_rows(&[1.5], 0.9).unwrap()[0];
        assert!((prediction.values[0].mean - 3.5).abs() < 1e-12);
        // The runs differ by 2 in the standard deviation, and the quantile for two degrees of freedom is 2.92.
        let interval = prediction.values[0].interval.as_ref().unwrap();
        let half = 0.5 * (interval.upper - interval.lower);
        assert!((half - 2.920 * 2.0 * (4.0f64 / 3.0).sqrt()).abs() < 0.02, "{half}");
        let beyond = &curve.predict_rows(&[9.0], 0.9).unwrap()[0];
        assert_eq!((beyond.values[0].mean, beyond.outside.len()), (4.0, 1));
        // Without a coordinate it is the mean of all rows.
        let flat = MeanCurve.fit(&dataset, &FitSpec::new(["x"], ["y"]), &mut NoObserver).unwrap();
        assert_eq!(flat.predict_rows(&[9.0], 0.9).unwrap()[0].values[0].mean, 3.0);
    }

    #[test]
    fn a_test_may_begin_with_a_stage_of_rest() {
        let runs = [run("a", &[0.0, 0.0, 1.0, 2.0], |x| x), run("b", &[0.0, 0.0, 1.0, 2.0], |x| 3.0 * x)];
        let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
        let fitted = MeanCurve.fit(&Dataset::new(runs.to_vec()).unwrap(), &spec, &mut NoObserver).unwrap();
        let rows = fitted.predict_rows(&[0.0, 0.5, 2.0], 0.9).unwrap();
        assert_eq!(rows.iter().map(|row| row.values[0].mean).collect::<Vec<_>>(), [0.0, 1.0, 4.0]);
    }

    #[test]
    fn a_coordinate_that_turns_is_refused() {
        let dataset = Dataset::new(vec![run("a", &[0.0, 1.0, 0.5], |x| x)]).unwrap();
        let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
        let text = MeanCurve.fit(&dataset, &spec, &mut NoObserver).err().unwrap().to_string();
        assert!(text.contains("x falls from a state to the next in a"), "{text}");
    }
}
