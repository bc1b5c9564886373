//! The cascade: soft sensors first, and from them what a laboratory measures.
//!
//! ```text
//! material, packing, coordinate --> fabric, coordination, sliding, P(f) --> q/p, volumetric strain
//!                          first stage                        second stage
//! ```
//!
//! The first stage is a [Gaussian process of curves](crate::surrogate::GaussianProcessOfCurves) of each soft sensor. The second stage knows no
//! property of the material: it is fitted to measured sensors and the coordinate, by the method of those in [`Cascade::second`] with which the
//! whole cascade misses left-out training runs least.
//!
//! The variance of a prediction is that of the second stage and, to first order, that of the predicted sensors (the cause `sensors`): each
//! sensor is changed by its standard deviation, and the squares of the changes of the output are added. Intervals are the standard deviation
//! times a factor that is found by predicting each training run by stages that were fitted to other runs (conformal calibration).

use std::collections::BTreeSet;
use std::sync::Arc;

use granum_core::observer::Observer;
use serde::{Deserialize, Serialize};

use super::boosted_trees::BoostedTrees;
use super::cascade_onnx::OnnxSensors;
use super::curve_process::{Calibration, GaussianProcessOfCurves, LeftOutCurves};
use super::ridge::RidgeRegression;
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};
use crate::onnx::{self, OnnxAnswer, OnnxEstimate, OnnxGraph, Value};
use crate::surrogate::content::Content;
use crate::surrogate::prediction::{Cause, Estimate, Prediction};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::{Columns, FitSpec};
use crate::surrogate::surrogate_trait::{Surrogate, SurrogateMethod};

/// Number of parts of the runs, each of which is predicted by what was fitted to the others.
const PARTS: usize = 5;
/// Any level: only standard deviations are used of intervals with it.
const LEVEL: f64 = 0.9;
/// Fewest runs for intervals, and for a choice between second stages.
const FEWEST_RUNS: usize = 3;

/// The cascade with its soft sensors and second stages.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::surrogate::{Cascade, FitSpec, SurrogateMethod};
/// use granum_learn::{Dataset, RunStates};
///
/// // A sensor that follows a parameter, and an output that is twice the sensor.
/// let run = |k: u32| {
///     let height = f64::from(k * 7 % 20) / 20.0;
///     let x: Vec<f64> = (0..30).map(|i| f64::from(i) / 29.0).collect();
///     let sensor: Vec<f64> = x.iter().map(|x| height * x).collect();
///     let y = sensor.iter().map(|s| 2.0 * s).collect();
///     let columns = vec![Column::new("x", "", x), Column::new("sensor", "", sensor), Column::new("y", "", y)];
///     RunStates::new(&format!("run-{k}"), Table::new(columns)?)?.with_parameter("height", "", height)
/// };
/// let dataset = Dataset::new((0..20).map(run).collect::<granum_learn::Result<_>>()?)?;
/// let mut cascade = Cascade::default();
/// cascade.sensors = vec!["sensor".into()];
/// let fitted = cascade.fit(&dataset, &FitSpec::new(["x", "height"], ["y"]).with_coordinate("x"), &mut NoObserver)?;
/// let predicted = &fitted.predict_rows(&[0.8, 0.5], 0.9)?[0].values[0];
/// assert!((predicted.mean - 0.8).abs() < 0.05, "{predicted:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
#[non_exhaustive]
pub struct Cascade {
    /// Names of the soft sensors; those that a data set lacks, or that are inputs or outputs of a fit, are left out. By default
    /// `deviator_fabric`, `mechanical_coordination_number`, `sliding_fraction` and `probability_density`.
    pub sensors: Vec<String>,
    /// The first stage.
    pub first: GaussianProcessOfCurves,
    /// The methods among which the second stage is chosen: ridge regression and boosted trees.
    pub second: Vec<Arc<dyn SurrogateMethod>>,
}

impl Default for Cascade {
    fn default() -> Self {
        let sensors =
            ["deviator_fabric", "mechanical_coordination_number", "sliding_fraction", "probability_density"];
        Cascade {
            sensors: sensors.map(String::from).to_vec(),
            first: GaussianProcessOfCurves::default(),
            second: vec![Arc::new(RidgeRegression::default()), Arc::new(BoostedTrees::default())],
        }
    }
}

const NAME: &str = "cascade";

fn failed(reason: impl Into<String>) -> LearnError {
    LearnError::Surrogate { method: NAME.into(), reason: reason.into() }
}

/// What is kept in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    /// Number of training runs.
    runs: usize,
    /// Place of the coordinate among the inputs.
    coordinate: usize,
    first: CascadeStage,
    second: CascadeStage,
    /// For each output.
    calibrations: Vec<Calibration>,
}

/// A fitted stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CascadeStage {
    method: String,
    columns: Columns,
    content: serde_json::Value,
}

impl CascadeStage {
    fn new(surrogate: &dyn Surrogate) -> Result<CascadeStage> {
        let (method, columns) = (surrogate.method().to_owned(), surrogate.columns().clone());
        Ok(CascadeStage { method, columns, content: surrogate.content()?.0 })
    }
}

/// The specifications of both stages.
struct Stages {
    first: FitSpec,
    second: FitSpec,
    /// Place of the coordinate among the inputs.
    coordinate: usize,
    columns: Columns,
}

impl Cascade {
    fn stages(&self, dataset: &Dataset, spec: &FitSpec) -> Result<Stages> {
        let columns = spec.columns(dataset)?;
        let Some((place, coordinate)) = spec.place_of_coordinate(&columns).zip(spec.coordinate.clone())
        else {
            return Err(failed("it predicts curves of sensors and needs the coordinate that they are over"));
        };
        let used: BTreeSet<String> =
            [columns.input_names(), columns.output_names()].concat().into_iter().collect();
        let is_free = |name: &&String| {
            dataset.expand(&[name]).is_ok_and(|own| own.iter().all(|column| !used.contains(column)))
        };
        let sensors: Vec<String> = self.sensors.iter().filter(is_free).cloned().collect();
        if sensors.is_empty() {
            let list = self.sensors.join(", ");
            return Err(failed(format!(
                "the runs have none of its soft sensors ({list}) beside the inputs and outputs; record one of them"
            )));
        }
        let plain = FitSpec { sub_models: Vec::new(), name: None, kept_as: None, ..spec.clone() };
        let first = FitSpec { outputs: sensors.clone(), ..plain.clone() };
        let second = FitSpec { inputs: [vec![coordinate], sensors].concat(), ..plain };
        Ok(Stages { first, second, coordinate: place, columns })
    }

    fn second(&self, name: &str) -> Result<&dyn SurrogateMethod> {
        let found = self.second.iter().find(|method| method.name() == name);
        found.map(AsRef::as_ref).ok_or_else(|| {
            let known: Vec<&str> = self.second.iter().map(|method| method.name()).collect();
            failed(format!("there is no second stage {name}; there are {}", known.join(", ")))
        })
    }
}

impl SurrogateMethod for Cascade {
    fn name(&self) -> &str {
        NAME
    }

    fn help(&self) -> &str {
        "soft sensors from material, sample and stress, and the outputs from the soft sensors"
    }

    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        observer: &mut dyn Observer,
    ) -> Result<Box<dyn Surrogate>> {
        let stages = self.stages(dataset, spec)?;
        let runs = dataset.runs().len();
        let (first, sensors) = self.first.fit_with_left_out(dataset, &stages.first, observer)?;
        let coordinate = &stages.columns.inputs[stages.coordinate].name;
        let parts = if runs < FEWEST_RUNS { 0 } else { PARTS.min(runs) };
        // For each second stage the errors of each run and output, and the same over their standard deviations.
        let mut found: Vec<Vec<Vec<LeftOut>>> = self.second.iter().map(|_| Vec::new()).collect();
        for part in 0..parts {
            let number = |run: &RunStates| dataset.runs().iter().position(|known| known.name() == run.name());
            let is_own = |run: &RunStates| number(run).is_some_and(|k| k % parts == part);
            // A run that the first stage did not use has no predicted sensors.
            let own = dataset.select(|run, _| is_own(run) && sensors.at(run.name(), 0.0).is_some());
            let others = dataset.select(|run, _| !is_own(run));
            if own.runs().is_empty() {
                continue;
            }
            let sensors = left_out_sensors(&sensors, &own, coordinate)?;
            for (method, found) in self.second.iter().zip(&mut found) {
                let second = method.fit(&others, &stages.second, observer)?;
                found.extend(left_out(second.as_ref(), &sensors, &own)?);
            }
        }
        let square = |name: &String| Ok(dataset.values(&[name])?.iter().map(|value| value * value).sum());
        let squares = stages.columns.output_names().iter().map(square).collect::<Result<Vec<f64>>>()?;
        let errors: Vec<f64> = found.iter().map(|found| error(found, &squares)).collect();
        let best = (0..errors.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b]));
        let best = best.ok_or_else(|| failed("it has no method for its second stage"))?;
        let calibration = |output: usize| {
            let ratios: Vec<Vec<f64>> = found[best].iter().map(|run| run[output].ratios.clone()).collect();
            let longest = ratios.iter().map(Vec::len).max().unwrap_or(0);
            match longest {
                0 => Calibration::new(&[vec![0.0]], &[1.0]),
                _ => Calibration::new(&ratios, &vec![1.0; longest]),
            }
        };
        let calibrations = (0..stages.columns.outputs.len()).map(calibration).collect();
        let second = self.second[best].fit(dataset, &stages.second, observer)?;
        let (coordinate, columns) = (stages.coordinate, stages.columns);
        Ok(Box::new(FittedCascade {
            runs,
            coordinate,
            columns,
            first: Box::new(first),
            second,
            calibrations,
        }))
    }

    fn check(&self, dataset: &Dataset, spec: &FitSpec) -> Result<()> {
        let stages = self.stages(dataset, spec)?;
        self.first.check(dataset, &stages.first)
    }

    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let Kept { runs, coordinate, first, second, calibrations } = content.read()?;
        let sound = first.columns.inputs == columns.inputs
            && second.columns.outputs == columns.outputs
            && coordinate < columns.inputs.len()
            && second.columns.inputs.first() == columns.inputs.get(coordinate)
            && second.columns.inputs.get(1..) == Some(&first.columns.outputs[..])
            && calibrations.len() == columns.outputs.len()
            && calibrations.iter().all(Calibration::is_sound);
        if !sound {
            return Err(failed("its stages are not those of its columns"));
        }
        let method = self.second(&second.method)?;
        Ok(Box::new(FittedCascade {
            runs,
            coordinate,
            columns,
            first: self.first.load(first.columns, &Content(first.content))?,
            second: method.load(second.columns, &Content(second.content))?,
            calibrations,
        }))
    }
}

/// The sensors of each state: what the second stage is given, and their standard deviations.
struct Sensors {
    /// The coordinate and the sensors.
    rows: Vec<Vec<f64>>,
    deviations: Vec<Vec<f64>>,
    lengths: Vec<usize>,
}

impl Sensors {
    /// From the predictions of the first stage, with the coordinate of each state.
    fn new(predictions: &[Prediction], xs: impl Iterator<Item = f64>, lengths: &[usize]) -> Sensors {
        let deviation =
            |estimate: &Estimate| estimate.interval.as_ref().map_or(0.0, |own| own.standard_deviation());
        let row = |(x, prediction): (f64, &Prediction)| {
            let sensors = prediction.values.iter().map(|estimate| estimate.mean);
            std::iter::once(x).chain(sensors).collect()
        };
        Sensors {
            rows: xs.zip(predictions).map(row).collect(),
            deviations: predictions.iter().map(|own| own.values.iter().map(deviation).collect()).collect(),
            lengths: lengths.to_vec(),
        }
    }

    fn inputs(&self, rows: &[Vec<f64>]) -> Result<RunInputs> {
        let width = rows.first().map_or(1, Vec::len);
        RunInputs::new(rows.concat(), width, self.lengths.clone())
    }

    /// For each state the estimates of the second stage, with the variance of the sensors as a cause; the interval is that of the causes
    /// times a factor for each output.
    fn answered(&self, second: &dyn Surrogate, level: f64, factors: &[f64]) -> Result<Vec<Vec<Estimate>>> {
        let predictions = second.predict(&self.inputs(&self.rows)?, level)?;
        let outputs = second.columns().outputs.len();
        let mut variances = vec![vec![0.0; outputs]; self.rows.len()];
        for sensor in 0..self.deviations.first().map_or(0, Vec::len) {
            let mut changed = self.rows.clone();
            for (row, deviations) in changed.iter_mut().zip(&self.deviations) {
                row[sensor + 1] += deviations[sensor];
            }
            let means = second.means(&self.inputs(&changed)?)?;
            for ((variances, means), prediction) in variances.iter_mut().zip(&means).zip(&predictions) {
                for ((variance, mean), estimate) in variances.iter_mut().zip(means).zip(&prediction.values) {
                    *variance += (mean - estimate.mean) * (mean - estimate.mean);
                }
            }
        }
        let estimate = |((estimate, variance), factor): ((&Estimate, &f64), &f64)| {
            let mut causes = estimate.interval.as_ref().map_or(Vec::new(), |own| own.causes.clone());
            causes.push((Cause::Sensors, variance.sqrt()));
            Estimate::new(estimate.mean).by(causes, *factor)
        };
        let each = predictions.iter().zip(&variances);
        Ok(each
            .map(|(own, variances)| own.values.iter().zip(variances).zip(factors).map(estimate).collect())
            .collect())
    }
}

/// The sensors of the states of training runs, each run as predicted by what was fitted to others.
fn left_out_sensors(curves: &LeftOutCurves, runs: &Dataset, coordinate: &str) -> Result<Sensors> {
    let (mut rows, mut deviations, mut lengths) = (Vec::new(), Vec::new(), Vec::new());
    for run in runs.runs() {
        lengths.push(run.rows());
        for x in run.column(coordinate)? {
            let sensors = curves.at(run.name(), x).unwrap_or_default();
            rows.push(std::iter::once(x).chain(sensors.iter().map(|[mean, _]| *mean)).collect());
            deviations.push(sensors.iter().map(|[_, deviation]| *deviation).collect());
        }
    }
    Ok(Sensors { rows, deviations, lengths })
}

/// What is known of an output of a run that was left out of the fit.
#[derive(Default)]
struct LeftOut {
    /// Sum of the squares of its errors.
    square: f64,
    /// Its errors over their standard deviations.
    ratios: Vec<f64>,
}

/// For each run and output of a data set its errors, as predicted from the sensors.
fn left_out(second: &dyn Surrogate, sensors: &Sensors, dataset: &Dataset) -> Result<Vec<Vec<LeftOut>>> {
    let outputs = second.columns().outputs.len();
    let exact = dataset.values(&second.columns().output_names())?;
    let estimates = sensors.answered(second, LEVEL, &vec![1.0; outputs])?;
    let mut states = estimates.iter().zip(exact.chunks_exact(outputs));
    let of_run = |run: &RunStates| {
        let mut found: Vec<LeftOut> = (0..outputs).map(|_| LeftOut::default()).collect();
        for (estimates, exact) in states.by_ref().take(run.rows()) {
            for ((own, estimate), exact) in found.iter_mut().zip(estimates).zip(exact) {
                let error = exact - estimate.mean;
                let deviation = estimate.interval.as_ref().map_or(0.0, |own| own.standard_deviation());
                own.square += error * error;
                own.ratios.push(if deviation > 0.0 { error / deviation } else { 0.0 });
            }
        }
        found
    };
    Ok(dataset.runs().iter().map(of_run).collect())
}

/// The mean over the outputs of the squares of the errors over the squares of the values.
fn error(found: &[Vec<LeftOut>], squares: &[f64]) -> f64 {
    let of_output = |(output, square): (usize, &f64)| {
        let sum: f64 = found.iter().map(|run| run[output].square).sum();
        if *square > 0.0 { sum / square } else { 0.0 }
    };
    squares.iter().enumerate().map(of_output).sum()
}

/// A fitted cascade.
pub struct FittedCascade {
    runs: usize,
    coordinate: usize,
    columns: Columns,
    first: Box<dyn Surrogate>,
    second: Box<dyn Surrogate>,
    calibrations: Vec<Calibration>,
}

impl FittedCascade {
    /// The first stage, which predicts the soft sensors.
    pub fn first(&self) -> &dyn Surrogate {
        self.first.as_ref()
    }

    /// The second stage, which predicts the outputs from the coordinate and the soft sensors.
    pub fn second(&self) -> &dyn Surrogate {
        self.second.as_ref()
    }
}

impl Surrogate for FittedCascade {
    fn method(&self) -> &str {
        NAME
    }

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn evaluate(&self, inputs: &RunInputs, level: f64) -> Result<Vec<Prediction>> {
        let known = self.first.predict(inputs, level)?;
        let sensors = Sensors::new(&known, inputs.rows().map(|row| row[self.coordinate]), inputs.lengths());
        let factors: Vec<f64> = self.calibrations.iter().map(|own| own.interval(level)).collect();
        let answered = sensors.answered(self.second.as_ref(), level, &factors)?;
        let prediction = |(mut values, known): (Vec<Estimate>, Prediction)| {
            // One or two runs say nothing of their scatter.
            if self.runs < FEWEST_RUNS {
                values.iter_mut().for_each(|estimate| estimate.interval = None);
            }
            Prediction::new(values).with_outside(known.outside).with_combination(known.combination)
        };
        Ok(answered.into_iter().zip(known).map(prediction).collect())
    }

    fn evaluate_means(&self, inputs: &RunInputs) -> Result<Vec<Vec<f64>>> {
        let sensors = self.first.means(inputs)?;
        let width = self.first.columns().outputs.len() + 1;
        let coordinates = inputs.rows().map(|row| row[self.coordinate]);
        let rows = coordinates.zip(sensors).flat_map(|(x, sensors)| std::iter::once(x).chain(sensors));
        self.second.means(&RunInputs::new(rows.collect(), width, inputs.lengths().to_vec())?)
    }

    fn onnx_answer(&self, graph: &mut OnnxGraph, inputs: &Value, level: f64) -> Result<OnnxAnswer> {
        let known = self.first.onnx_answer(graph, inputs, level)?;
        let coordinate = graph.columns(inputs, &[self.coordinate]);
        let sensors = OnnxSensors::new(graph, &coordinate, &known.estimates);
        // Intervals of the second stage are not used, but its standard deviations.
        let answer = self.second.onnx_answer(graph, sensors.rows(), level)?;
        let mut estimates = Vec::with_capacity(answer.estimates.len());
        for (estimate, calibration) in answer.estimates.iter().zip(&self.calibrations) {
            let (mean, deviation) = sensors.combined(graph, estimate);
            // One or two runs say nothing of their scatter.
            let deviation = Some(deviation).filter(|_| self.runs >= FEWEST_RUNS);
            estimates.push(OnnxEstimate {
                mean,
                spread: onnx::spread(graph, deviation, calibration.interval(level)),
            });
        }
        Ok(OnnxAnswer { estimates, ..known })
    }

    fn content(&self) -> Result<Content> {
        Content::new(&Kept {
            runs: self.runs,
            coordinate: self.coordinate,
            first: CascadeStage::new(self.first.as_ref())?,
            second: CascadeStage::new(self.second.as_ref())?,
            calibrations: self.calibrations.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::compare;
    use crate::dataset::Split;
    use granum_core::observer::NoObserver;
    use granum_core::{Column, Table};

    /// A material constant decides a sensor, and the sensor with a scatter of each run the output.
    fn dataset(runs: u32) -> Dataset {
        let run = |k: u32| {
            let friction = 0.1 + 0.8 * f64::from(k * 7 % runs) / f64::from(runs);
            let scatter = 0.04 * (f64::from(k * 13 % runs) / f64::from(runs) - 0.5);
            let x: Vec<f64> = (0..40).map(|i| f64::from(i) / 39.0).collect();
            let fabric: Vec<f64> = x.iter().map(|x| (friction + scatter) * x / (0.2 + x)).collect();
            let ratio = fabric.iter().zip(&x).map(|(f, x)| f + 0.5 * x * f).collect();
            let columns = vec![
                Column::new("axial_strain", "", x),
                Column::new("deviator_fabric", "", fabric),
                Column::new("stress_ratio", "", ratio),
            ];
            let run = RunStates::new(&format!("run-{k}"), Table::new(columns).unwrap()).unwrap();
            run.with_parameter("friction", "", friction).unwrap()
        };
        Dataset::new((0..runs).map(run).collect()).unwrap()
    }

    /// Fewer searches for parameters, to save time.
    fn small() -> Cascade {
        let mut cascade = Cascade::default();
        (cascade.first.starts, cascade.first.components) = (1, 2);
        cascade
    }

    fn spec() -> FitSpec {
        FitSpec::new(["axial_strain", "friction"], ["stress_ratio"]).with_coordinate("axial_strain")
    }

    #[test]
    fn outputs_come_from_predicted_sensors_with_the_variance_of_these() {
        let dataset = dataset(24);
        // None of them has the least or the most friction.
        let unseen = [1, 5, 9, 13, 21].map(|k| format!("run-{k}"));
        let parts = dataset.split(&Split::default().stride(1).unseen(unseen)).unwrap();
        let scores = compare(&parts, &spec(), &[&small()], 0.9, &mut NoObserver).unwrap();
        let (score, held) = (&scores[0].unseen, scores[0].coverage.unwrap());
        // The scatter of a run is 0.04 / sqrt(12) times 1.25 at the end, for an output of about 0.5.
        assert!(score.relative_rmse < 0.08, "{score:?}");
        assert!((0.5..=1.0).contains(&held), "{held}");
        let any: &dyn std::any::Any = scores[0].surrogate.as_ref();
        let cascade = any.downcast_ref::<FittedCascade>().unwrap();
        assert_eq!(cascade.second().columns().input_names(), ["axial_strain", "deviator_fabric"]);
        assert_eq!(cascade.first().columns().output_names(), ["deviator_fabric"]);
        let predicted = scores[0].surrogate.predict_rows(&[0.9, 0.5], 0.9).unwrap();
        let interval = predicted[0].values[0].interval.as_ref().unwrap();
        let by_sensors = interval.causes.iter().find(|(cause, _)| *cause == Cause::Sensors).unwrap().1;
        // The scatter of the sensor is carried through the slope of the second stage, about 1.45.
        assert!((0.3..2.0).contains(&(by_sensors / (0.04 / 12.0f64.sqrt() * 0.82 * 1.45))), "{by_sensors}");
    }

    #[test]
    fn runs_without_a_soft_sensor_are_refused_with_their_names() {
        let spec =
            FitSpec::new(["axial_strain", "friction"], ["deviator_fabric"]).with_coordinate("axial_strain");
        let text = Cascade::default().check(&dataset(5), &spec).unwrap_err().to_string();
        assert!(text.contains("none of its soft sensors (deviator_fabric, mechanical"), "{text}");
        let spec = FitSpec::new(["friction"], ["stress_ratio"]);
        let text = Cascade::default().fit(&dataset(5), &spec, &mut NoObserver).err().unwrap().to_string();
        assert!(text.contains("needs the coordinate"), "{text}");
        assert!(
            Cascade::default()
                .second("none")
                .err()
                .unwrap()
                .to_string()
                .contains("there are ridge, boosted-trees")
        );
    }
}
