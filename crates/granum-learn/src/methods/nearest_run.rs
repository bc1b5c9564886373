//! The nearest run: the curves of the training run whose inputs are nearest to those that are asked for. It is what a
//! user without a surrogate would do with a folder of tests, and a baseline that every other method must be better than.
//!
//! The distance is Euclidean over what the runs differ in, in the same dimensionless groups, spreads and scales as the [Gaussian
//! processes of curves](crate::surrogate::GaussianProcessOfCurves) see. Runs at the same distance are averaged: with the coordinate as the only input
//! that is all of them, and the method is the mean curve. Intervals are those of the errors of each training run against its nearest
//! other run.

use granum_core::observer::Observer;
use serde::{Deserialize, Serialize};

use super::curve_process::{Group, RunCurve, common_points, groups_of};
use super::left_out_errors::LeftOutErrors;
use crate::curve::{increases, interpolated, range};
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::surrogate::content::Content;
use crate::surrogate::prediction::{Prediction, outside_of};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod, report_output};

/// The nearest run.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::surrogate::{FitSpec, NearestRun, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// let run = |slope: f64| {
///     let x: Vec<f64> = (0..10).map(f64::from).collect();
///     let y = x.iter().map(|x| slope * x).collect();
///     let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)])?;
///     RunStates::new(&format!("slope {slope}"), table)?.with_parameter("slope", "", slope)
/// };
/// let dataset = Dataset::new([1.0, 2.0, 4.0].map(run).into_iter().collect::<granum_learn::Result<_>>()?)?;
/// let spec = FitSpec::new(["x", "slope"], ["y"]).with_coordinate("x");
/// let nearest = NearestRun.fit(&dataset, &spec, &mut NoObserver)?;
/// assert_eq!(nearest.predict_rows(&[5.0, 2.2], 0.9)?[0].values[0].mean, 10.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct NearestRun;

const NAME: &str = "nearest-run";

fn failed(reason: impl Into<String>) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: reason.into() }
}

/// What is kept in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Fitted {
    /// Place of the coordinate among the inputs.
    coordinate: usize,
    /// The points of the curves.
    points: Vec<f64>,
    /// What the inputs beside the coordinate are compared by.
    groups: Vec<Group>,
    /// Range of each of these inputs over the training runs.
    ranges: Vec<[f64; 2]>,
    runs: Vec<Known>,
    /// For each output.
    errors: Vec<LeftOutErrors>,
}

/// A training run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Known {
    /// The values of the groups.
    groups: Vec<f64>,
    /// For each output its value at each point.
    curves: Vec<Vec<f64>>,
}

impl Fitted {
    /// The runs at the smallest distance, of those for which `counts` is true.
    fn nearest(&self, groups: &[f64], counts: impl Fn(usize) -> bool) -> Vec<usize> {
        let square = |run: &Known| run.groups.iter().zip(groups).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let (mut least, mut nearest) = (f64::INFINITY, Vec::new());
        for (k, run) in self.runs.iter().enumerate().filter(|(k, _)| counts(*k)) {
            let distance = square(run);
            if distance < least {
                (least, nearest) = (distance, vec![k]);
            } else if distance == least {
                nearest.push(k);
            }
        }
        nearest
    }

    /// The mean of an output over some runs, at a coordinate.
    fn mean(&self, runs: &[usize], output: usize, x: f64) -> f64 {
        let at = |run: &usize| interpolated(x, &self.points, &self.runs[*run].curves[output]);
        runs.iter().map(at).sum::<f64>() / runs.len() as f64
    }

    fn check(&self, columns: &Columns) -> Result<()> {
        let (inputs, points) = (columns.inputs.len(), self.points.len());
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        let run = |run: &Known| {
            run.groups.len() == self.groups.len()
                && finite(&run.groups)
                && run.curves.len() == columns.outputs.len()
                && run.curves.iter().all(|curve| curve.len() == points && finite(curve))
        };
        let sound = self.coordinate < inputs
            && points > 1
            && finite(&self.points)
            && increases(&self.points)
            && self.groups.iter().all(|group| group.is_sound(inputs - 1))
            && self.ranges.len() + 1 == inputs
            && !self.runs.is_empty()
            && self.runs.iter().all(run)
            && self.errors.len() == columns.outputs.len()
            && self.errors.iter().all(LeftOutErrors::is_sound);
        if sound { Ok(()) } else { Err(failed("its runs are not those of its columns")) }
    }
}

/// The runs as curves, with the place of the coordinate.
fn curves(dataset: &Dataset, spec: &FitSpec, columns: &Columns) -> Result<(usize, Vec<RunCurve>)> {
    let place = spec.place_of_coordinate(columns);
    let place =
        place.ok_or_else(|| failed("it gives curves of runs and needs the coordinate that they are over"))?;
    let mut names = columns.input_names();
    let coordinate = names.remove(place);
    Ok((place, RunCurve::all(dataset, &coordinate, &names, &columns.output_names())?))
}

impl SurrogateMethod for NearestRun {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "the curve of the training run with the nearest material, sample and stress"
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        let columns = spec.columns(dataset)?;
        let (coordinate, runs) = curves(dataset, spec, &columns)?;
        let mut others = columns.inputs.clone();
        others.remove(coordinate);
        let names: Vec<String> = others.iter().map(|input| input.name.clone()).collect();
        let units: Vec<String> = others.iter().map(|input| input.unit.clone()).collect();
        let inputs: Vec<&[f64]> = runs.iter().map(|run| &run.inputs[..]).collect();
        let groups = if runs.len() > 1 { groups_of(&names, &units, &inputs) } else { Vec::new() };
        let points = common_points(&runs)?;
        let outputs = columns.outputs.len();
        let known = |run: &RunCurve| Known {
            groups: groups.iter().map(|group| group.value(&run.inputs)).collect(),
            curves: (0..outputs).map(|output| run.at(&points, output, None)).collect(),
        };
        let mut fitted = Fitted {
            coordinate,
            runs: runs.iter().map(known).collect(),
            ranges: (0..names.len()).map(|k| range(runs.iter().map(|run| run.inputs[k]))).collect(),
            errors: Vec::new(),
            points,
            groups,
        };
        let others = |run: usize| match fitted.runs.len() {
            1 => vec![run],
            _ => fitted.nearest(&fitted.runs[run].groups, |other| other != run),
        };
        let nearest: Vec<Vec<usize>> = (0..fitted.runs.len()).map(others).collect();
        let errors = |output: usize| {
            let of_run = |(run, nearest): (usize, &Vec<usize>)| -> Vec<(f64, f64)> {
                let error = |x: &f64| fitted.mean(nearest, output, *x) - fitted.mean(&[run], output, *x);
                fitted.points.iter().map(|x| (*x, error(x))).collect()
            };
            LeftOutErrors::new(&nearest.iter().enumerate().map(of_run).collect::<Vec<_>>())
        };
        let mut of_outputs = Vec::with_capacity(outputs);
        for output in 0..outputs {
            report_output(observer, &columns.outputs, output)?;
            of_outputs.push(errors(output));
        }
        fitted.errors = of_outputs;
        Ok(Box::new(FittedRuns { columns, fitted }))
    }

    fn check(&self, dataset: &Dataset, spec: &FitSpec) -> Result<()> {
        let (_, runs) = curves(dataset, spec, &spec.columns(dataset)?)?;
        common_points(&runs).map(drop)
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let fitted: Fitted = content.read()?;
        fitted.check(&columns)?;
        Ok(Box::new(FittedRuns { columns, fitted }))
    }
}

/// The training runs.
struct FittedRuns {
    columns: Columns,
    fitted: Fitted,
}

impl Surrogate for FittedRuns {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        let Fitted { coordinate, points, groups, ranges, errors, .. } = &self.fitted;
        let factors: Vec<f64> = errors.iter().map(|errors| errors.factor(level)).collect();
        let mut all_ranges = ranges.clone();
        all_ranges.insert(*coordinate, [points[0], points[points.len() - 1]]);
        let mut known: Option<(Vec<f64>, Vec<usize>)> = None;
        let mut predictions = Vec::with_capacity(inputs.len());
        for row in inputs.rows() {
            let x = row[*coordinate];
            let mut own = row.to_vec();
            own.remove(*coordinate);
            // The rows of a run differ in the coordinate alone.
            let (_, nearest) = match known.take() {
                Some(same) if same.0 == own => known.insert(same),
                _ => {
                    let values: Vec<f64> = groups.iter().map(|group| group.value(&own)).collect();
                    let nearest = self.fitted.nearest(&values, |_| true);
                    known.insert((own, nearest))
                }
            };
            let estimate =
                |k: usize| errors[k].around(self.fitted.mean(nearest, k, x), x.max(points[0]), factors[k]);
            let values = (0..errors.len()).map(estimate).collect();
            predictions.push(Prediction::new(values).with_outside(outside_of(
                &self.columns,
                &all_ranges,
                row,
            )));
        }
        Ok(predictions)
    }

    fn content(&self) -> Result<Content> {
        Content::new(&self.fitted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::RunStates;
    use crate::surrogate::MeanCurve;
    use granum_core::observer::NoObserver;
    use granum_core::{Column, Table};

    fn run(k: u32, friction: f64) -> RunStates {
        let x: Vec<f64> = (0..30).map(|i| f64::from(i) / 29.0).collect();
        let y = x.iter().map(|x| friction * x).collect();
        let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)]).unwrap();
        let run = RunStates::new(&format!("run-{k}"), table).unwrap();
        run.with_parameter("friction", "", friction).unwrap()
    }

    #[test]
    fn the_nearest_run_is_given_and_errors_between_runs_are_its_intervals() {
        let runs: Vec<RunStates> = (1..=20).map(|k| run(k, 0.04 * f64::from(k))).collect();
        let dataset = Dataset::new(runs).unwrap();
        let spec = FitSpec::new(["x", "friction"], ["y"]).with_coordinate("x");
        let fitted = NearestRun.fit(&dataset, &spec, &mut NoObserver).unwrap();
        let found = &fitted.predict_rows(&[1.0, 0.41, 1.0, 2.0], 0.9).unwrap();
        assert!((found[0].values[0].mean - 0.4).abs() < 1e-12 && found[0].outside.is_empty());
        assert_eq!(found[1].outside[0].name, "friction");
        // The nearest other run differs by 0.04 at the end.
        let interval = found[0].values[0].interval.as_ref().unwrap();
        let half = 0.5 * (interval.upper - interval.lower);
        assert!((half - 0.04).abs() < 0.01, "{half}");
    }

    #[test]
    fn with_the_coordinate_alone_it_is_the_mean_curve_and_needs_constant_inputs() {
        let dataset = Dataset::new(vec![run(1, 0.1), run(2, 0.5), run(3, 0.3)]).unwrap();
        let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
        let fitted = NearestRun.fit(&dataset, &spec, &mut NoObserver).unwrap();
        let mean = MeanCurve.fit(&dataset, &spec, &mut NoObserver).unwrap();
        let at = |fitted: &dyn Surrogate| fitted.predict_rows(&[0.7], 0.9).unwrap()[0].values[0].mean;
        assert!((at(fitted.as_ref()) - at(mean.as_ref())).abs() < 1e-9);
        let varying = FitSpec::new(["x", "y"], ["friction"]).with_coordinate("x");
        let text = NearestRun.check(&dataset, &varying).unwrap_err().to_string();
        assert!(text.contains("y is not constant"), "{text}");
        let none = NearestRun.fit(&dataset, &FitSpec::new(["x"], ["y"]), &mut NoObserver).err().unwrap();
        assert!(none.to_string().contains("needs the coordinate"), "{none}");
        let one = Dataset::new(vec![run(1, 0.1)]).unwrap();
        let alone = NearestRun.fit(&one, &spec, &mut NoObserver).unwrap();
        assert!(alone.predict_rows(&[0.7], 0.9).unwrap()[0].values[0].interval.is_none());
    }
}
