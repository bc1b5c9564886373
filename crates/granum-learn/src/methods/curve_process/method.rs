//! The method that fits processes to curves.

use std::sync::Arc;

use granum_core::observer::{Event, Observer};
use granum_nets::gaussian_process::Rows;

use super::densities::Densities;
use super::failure::{NAME, failed};
use super::fitted::{FittedCurves, Kept};
use super::fitting::Fitting;
use super::groups::groups_of;
use super::kept_curve::KeptCurve;
use super::left_out_curves::LeftOutCurves;
use super::local_calibration::{Calibrated, LeftOutRuns};
use super::predicted_curve::{Curve, curves_of_outputs};
use super::prepared::Shared;
use super::reach::{Reach, within_reach};
use super::run_curves::{RunCurve, common_points, shares};
use crate::curve::range;
use crate::dataset::{Dataset, RunStates, Variable};
use crate::error::Result;
use crate::surrogate::content::Content;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod};

/// The beginning of the names of what was measured on the sample.
const SAMPLE: &str = "sample.";

/// Gaussian processes of whole curves, described in the chapter on data sets and surrogates of the book.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::surrogate::{FitSpec, GaussianProcessOfCurves, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// // Curves that rise to a height that a parameter decides.
/// let run = |k: u32| {
///     let height = f64::from(k * 7 % 20) / 20.0;
///     let x: Vec<f64> = (0..30).map(|i| f64::from(i) / 29.0).collect();
///     let y = x.iter().map(|x| height * height * (1.0 - (-5.0 * x).exp())).collect();
///     let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "", y)])?;
///     RunStates::new(&format!("run-{k}"), table)?.with_parameter("height", "", height)
/// };
/// let dataset = Dataset::new((0..20).map(run).collect::<granum_learn::Result<_>>()?)?;
/// let spec = FitSpec::new(["x", "height"], ["y"]).with_coordinate("x");
/// let fitted = GaussianProcessOfCurves::default().fit(&dataset, &spec, &mut NoObserver)?;
/// let predicted = &fitted.predict_rows(&[1.0, 0.62], 0.9)?[0].values[0];
/// assert!((predicted.mean - 0.62 * 0.62 * (1.0 - (-5.0f64).exp())).abs() < 2e-3, "{predicted:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GaussianProcessOfCurves {
    /// Most principal components of the curves of an output (8).
    pub components: usize,
    /// Whether the components are turned until their weights are independent of each other, and not only uncorrelated (false).
    pub independent: bool,
    /// Searches for the most probable parameters of each process (2).
    pub starts: usize,
    /// Most runs by which parameters are judged (300); all runs are used for predictions.
    pub most_runs: usize,
}

impl Default for GaussianProcessOfCurves {
    fn default() -> Self {
        GaussianProcessOfCurves { components: 8, independent: false, starts: 2, most_runs: 300 }
    }
}

impl SurrogateMethod for GaussianProcessOfCurves {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "Gaussian processes of whole curves, for runs that differ in material, sample and stress"
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        Ok(Box::new(self.fit_with_left_out(dataset, spec, observer)?.0))
    }

    fn check(&self, dataset: &Dataset, spec: &FitSpec) -> Result<()> {
        let columns = spec.columns(dataset)?;
        let place = place_of_coordinate(spec, &columns)?;
        let names = without(&columns.input_names(), place);
        common_points(&RunCurve::all(
            dataset,
            &columns.inputs[place].name,
            &names,
            &columns.output_names(),
        )?)?;
        Ok(())
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        Ok(Box::new(FittedCurves::new(columns, content.read()?, 0)?))
    }
}

impl GaussianProcessOfCurves {
    /// As [`SurrogateMethod::fit`], with the curves of the training runs, each as predicted by what was fitted to other runs.
    ///
    /// # Errors
    /// As [`SurrogateMethod::fit`].
    pub fn fit_with_left_out(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<(FittedCurves, LeftOutCurves)> {
        if self.components == 0 {
            return Err(failed("the number of components must be 1 or more, not 0"));
        }
        let columns = spec.columns(dataset)?;
        let place = place_of_coordinate(spec, &columns)?;
        let names: Vec<String> = without(&columns.input_names(), place);
        let runs = RunCurve::all(dataset, &columns.inputs[place].name, &names, &columns.output_names())?;
        let of_runs: Vec<&str> = dataset.runs().iter().map(RunStates::name).collect();
        let Reach { runs, left_out, remark } = within_reach(runs, &of_runs, &columns.inputs[place].name);
        if let Some(text) = remark {
            observer.event(&Event::Warning { text });
        }
        let inputs: Vec<&[f64]> = runs.iter().map(|run| &run.inputs[..]).collect();
        let units =
            without(&columns.inputs.iter().map(|input| input.unit.clone()).collect::<Vec<_>>(), place);
        let groups = groups_of(&names, &units, &inputs);
        if groups.is_empty() && !names.is_empty() && runs.len() > 1 {
            return Err(failed("all inputs beside the coordinate are the same in all runs"));
        }
        let ranges = ranges(&inputs);
        let values: Vec<f64> =
            inputs.iter().flat_map(|run| groups.iter().map(|group| group.value(run))).collect();
        // Without inputs there is nothing that the weights could depend on, and the mean curve is what remains.
        let rows = match groups.is_empty() {
            true => None,
            false => Some(Arc::new(Rows::new(values.clone(), groups.len()).map_err(failed)?)),
        };
        let points = common_points(&runs)?;
        let most = if rows.is_some() { self.components } else { 0 };
        let independent = self.independent;
        let shared = Shared { shares: shares(&points), points, rows, runs, most, independent };
        let starts: Vec<Option<usize>> =
            columns.outputs.iter().map(|output| start_of(output, &names)).collect();
        let histograms = shared.histograms(dataset, &columns.output_names());
        let fits = Fitting { starts: self.starts, most_runs: self.most_runs, spec, shared: &shared }.fitted(
            &starts,
            &histograms,
            observer,
        )?;
        let (curves, predicted): (Vec<KeptCurve>, Vec<Vec<Curve>>) = fits.into_iter().unzip();
        let predicted = of_outputs(predicted, &histograms, starts.len());
        let measured = shared.measured(&starts);
        let left_out_runs = LeftOutRuns { measured: &measured, predicted: &predicted, shared: &shared };
        let Calibrated { calibrations, local, limit } =
            left_out_runs.calibrated(&curves, &histograms, spec.threads, observer)?;
        let is_used = |name: &&&str| left_out.iter().all(|ended| ended.run != **name);
        let used = of_runs.iter().filter(is_used).map(|name| (*name).to_owned());
        let from = |run: &RunCurve| -> Vec<f64> {
            starts.iter().map(|start| start.map_or(0.0, |input| run.inputs[input])).collect()
        };
        let from: Vec<Vec<f64>> = shared.runs.iter().map(from).collect();
        let left_out_curves = LeftOutCurves::new(shared.points.clone(), used, &from, predicted);
        let (runs, points) = (shared.runs.len(), shared.points);
        let kept = Kept {
            coordinate: place,
            runs,
            points,
            groups,
            ranges,
            rows: values,
            histograms,
            curves,
            calibrations,
            local,
            limit,
            left_out,
        };
        Ok((FittedCurves::new(columns, kept, spec.threads)?, left_out_curves))
    }
}

/// For each run the curves of its outputs, from the curves that are fitted with those of all runs.
fn of_outputs(left_out: Vec<Vec<Curve>>, histograms: &[Densities], outputs: usize) -> Vec<Vec<Curve>> {
    let known = left_out.iter().map(Vec::len).min().unwrap_or(0);
    let mut of_runs: Vec<Vec<Curve>> = (0..known).map(|_| Vec::new()).collect();
    for curves in left_out {
        of_runs.iter_mut().zip(curves).for_each(|(run, curve)| run.push(curve));
    }
    of_runs.into_iter().map(|run| curves_of_outputs(run, histograms, outputs)).collect()
}

/// The input that is the value of an output on the sample.
fn start_of(output: &Variable, inputs: &[String]) -> Option<usize> {
    let sample = format!("{SAMPLE}{}", output.name);
    inputs.iter().position(|name| *name == sample)
}

fn place_of_coordinate(spec: &FitSpec, columns: &Columns) -> Result<usize> {
    let place = spec.place_of_coordinate(columns);
    place.ok_or_else(|| failed("it predicts curves and needs the coordinate that they are over"))
}

fn without(names: &[String], place: usize) -> Vec<String> {
    names.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, name)| name.clone()).collect()
}

/// Range of each input over the runs.
fn ranges(runs: &[&[f64]]) -> Vec<[f64; 2]> {
    let inputs = runs.first().map_or(0, |run| run.len());
    (0..inputs).map(|input| range(runs.iter().map(|run| run[input]))).collect()
}
