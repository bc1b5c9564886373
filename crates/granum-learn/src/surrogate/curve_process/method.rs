//! The method that fits processes to curves.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use granum_core::observer::{Event, Flow, Observer, Progress, SharedObserver};
use granum_core::parallel;
use granum_nets::gaussian_process::{FitOptions, GaussianProcess, Rows};

use super::components::Components;
use super::densities::{Densities, histograms_among};
use super::failure::{NAME, failed};
use super::fitted::{FittedCurves, Kept};
use super::groups::groups_of;
use super::kept_curve::KeptCurve;
use super::left_out::{Curves, PARTS};
use super::left_out_curves::LeftOutCurves;
use super::local_calibration::{Calibrated, LeftOutRuns};
use super::predicted_curve::{Curve, curves_of_outputs};
use super::reach::{Reach, within_reach};
use super::run_curves::{RunCurve, common_points, shares};
use crate::curve::range;
use crate::dataset::{ColumnGroup, Dataset, RunStates, Variable};
use crate::error::{LearnError, Result};
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

/// What the fits of all outputs share.
struct Shared {
    runs: Vec<RunCurve>,
    points: Vec<f64>,
    shares: Vec<f64>,
    rows: Option<Arc<Rows>>,
}

/// An output, or a coefficient of a histogram, before its processes are fitted.
struct Prepared {
    /// The input that is its value on the sample.
    start: Option<usize>,
    curves: Vec<Vec<f64>>,
    components: Components,
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
        Ok(Box::new(FittedCurves::new(columns, content.read()?)?))
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
        let shared = Shared { shares: shares(&points), points, rows, runs };
        let starts: Vec<Option<usize>> =
            columns.outputs.iter().map(|output| start_of(output, &names)).collect();
        let histograms = shared.histograms(dataset, &columns.output_names());
        let prepared = self.prepared(&shared, &starts, &histograms);
        let fits: Vec<(usize, usize)> = prepared
            .iter()
            .enumerate()
            .flat_map(|(output, prepared)| {
                (0..prepared.components.components.len()).map(move |j| (output, j))
            })
            .collect();
        let processes = match &shared.rows {
            Some(rows) => self.processes(rows, &prepared, &fits, spec, observer)?,
            None => Vec::new(),
        };
        let mut rest = processes.iter().map(|process| process.parameters().to_vec());
        let parameters: Vec<Vec<Vec<f64>>> = prepared
            .iter()
            .map(|prepared| rest.by_ref().take(prepared.components.components.len()).collect())
            .collect();
        let predicted = self.left_out(&shared, &prepared, &parameters, spec, observer)?;
        let predicted = of_outputs(predicted, &histograms, starts.len());
        let curves = prepared.into_iter().zip(parameters).map(|(prepared, parameters)| {
            let Prepared { start, components: Components { mean, components, weights, rest }, .. } = prepared;
            KeptCurve { start, mean, components, rest, parameters, weights }
        });
        let curves: Vec<KeptCurve> = curves.collect();
        let measured = measured(&shared, &starts);
        let left_out_runs =
            LeftOutRuns { measured: &measured, predicted: &predicted, shares: &shared.shares };
        let Calibrated { calibrations, local, limit } =
            left_out_runs.calibrated(shared.rows.as_deref(), &curves, &histograms, spec.threads, observer)?;
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
        Ok((FittedCurves::new(columns, kept)?, left_out_curves))
    }
}

impl Shared {
    /// The histograms of which all bins are outputs.
    fn histograms(&self, dataset: &Dataset, outputs: &[String]) -> Vec<Densities> {
        let Some(first) = dataset.runs().first() else { return Vec::new() };
        let histogram = |(output, group): (usize, &ColumnGroup)| {
            let of_run = |run: &RunCurve| self.states(run, output, group.centres.len());
            let states: Vec<Vec<f64>> = self.runs.iter().flat_map(of_run).collect();
            Densities::new(group, output, &states, &self.shares.repeat(self.runs.len()))
        };
        histograms_among(first, outputs).into_iter().map(histogram).collect()
    }

    /// The densities of the bins at each point.
    fn states(&self, run: &RunCurve, first: usize, bins: usize) -> Vec<Vec<f64>> {
        let curves: Vec<Vec<f64>> =
            (first..first + bins).map(|output| run.at(&self.points, output, None)).collect();
        (0..self.points.len()).map(|k| curves.iter().map(|curve| curve[k]).collect()).collect()
    }
}

impl GaussianProcessOfCurves {
    /// The curves that are fitted: of each output, and in the place of the bins of a histogram of its coefficients.
    fn prepared(&self, shared: &Shared, starts: &[Option<usize>], histograms: &[Densities]) -> Vec<Prepared> {
        let most = if shared.rows.is_some() { self.components } else { 0 };
        let with = |start: Option<usize>, curves: Vec<Vec<f64>>| {
            let components = Components::new(&curves, &shared.shares, most);
            let components = if self.independent { components.independent() } else { components };
            Prepared { start, curves, components }
        };
        let (mut prepared, mut output) = (Vec::new(), 0);
        while output < starts.len() {
            let Some(densities) = histograms.iter().find(|densities| densities.first == output) else {
                let start = starts[output];
                let curve = |run: &RunCurve| run.at(&shared.points, output, start);
                prepared.push(with(start, shared.runs.iter().map(curve).collect()));
                output += 1;
                continue;
            };
            let coefficients = |run: &RunCurve| -> Vec<Vec<f64>> {
                let states = shared.states(run, output, densities.bins());
                states.iter().map(|state| densities.coefficients(state)).collect()
            };
            let of_runs: Vec<Vec<Vec<f64>>> = shared.runs.iter().map(coefficients).collect();
            for k in 0..densities.directions.len() {
                let curve = |states: &Vec<Vec<f64>>| states.iter().map(|state| state[k]).collect();
                prepared.push(with(None, of_runs.iter().map(curve).collect()));
            }
            output += densities.bins();
        }
        prepared
    }

    /// The processes of all components of all outputs.
    fn processes(
        &self,
        rows: &Arc<Rows>,
        prepared: &[Prepared],
        fits: &[(usize, usize)],
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Vec<GaussianProcess>> {
        let shared = SharedObserver::new(observer);
        let done = AtomicUsize::new(0);
        parallel::map(fits.len(), spec.threads, |k| {
            let mut part = shared.part(format!("process {}", k + 1));
            let (complete, total) = (done.load(Ordering::Relaxed), fits.len());
            let progress = Progress::new("training", "processes", complete as u64).out_of(total as u64);
            if part.progress(&progress) == Flow::Stop {
                return Err(LearnError::Stopped { done: complete, total });
            }
            let (output, component) = fits[k];
            let mut options = FitOptions::default();
            (options.starts, options.most_rows) = (self.starts, self.most_runs);
            options.seed = spec.seed.wrapping_add(k as u64);
            let targets = &prepared[output].components.weights[component];
            let process = GaussianProcess::fit(rows.clone(), targets, &options).map_err(failed)?;
            done.fetch_add(1, Ordering::Relaxed);
            part.completed();
            Ok(process)
        })
    }
}

impl GaussianProcessOfCurves {
    /// For each curve that is fitted those of the runs, in order, each as predicted from other runs.
    fn left_out(
        &self,
        shared: &Shared,
        prepared: &[Prepared],
        parameters: &[Vec<Vec<f64>>],
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Vec<Vec<Curve>>> {
        let follower = SharedObserver::new(observer);
        let (done, total) = (AtomicUsize::new(0), prepared.len() * PARTS);
        let found = parallel::map(total, spec.threads, |k| {
            let (curve, part) = (k / PARTS, k % PARTS);
            let complete = done.load(Ordering::Relaxed);
            let progress = Progress::new("calibration", "parts", complete as u64).out_of(total as u64);
            if follower.part(format!("curve {}", curve + 1)).progress(&progress) == Flow::Stop {
                return Err(LearnError::Stopped { done: complete, total });
            }
            let mut options = FitOptions::default();
            options.most_rows = self.most_runs;
            let curves = Curves {
                curves: &prepared[curve].curves,
                shares: &shared.shares,
                rows: shared.rows.as_deref(),
                parameters: &parameters[curve],
                independent: self.independent,
                options,
            };
            let predicted = curves.predicted(part)?;
            done.fetch_add(1, Ordering::Relaxed);
            Ok(predicted)
        })?;
        let mut found = found.into_iter();
        let mut of_curve = || {
            let mut runs: Vec<(usize, Curve)> = found.by_ref().take(PARTS).flatten().collect();
            runs.sort_by_key(|(run, _)| *run);
            runs.into_iter().map(|(_, curve)| curve).collect()
        };
        Ok(prepared.iter().map(|_| of_curve()).collect())
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

/// For each output the curves of the runs, from their starts.
fn measured(shared: &Shared, starts: &[Option<usize>]) -> Vec<Vec<Vec<f64>>> {
    let of_output = |(output, start): (usize, &Option<usize>)| {
        shared.runs.iter().map(|run| run.at(&shared.points, output, *start)).collect()
    };
    starts.iter().enumerate().map(of_output).collect()
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
