//! The surrogate of the simulations: Gaussian processes of whole curves over the axial strain, which depend on the numbers of the case that
//! variables set.
//!
//! Stresses are learned over the mean stress with which a test begins, so that tests at different stresses tell of each other; stiffness is seen by
//! the processes as the ratio of stress to modulus. The covariance of a prediction contains what more simulations would reduce and the
//! scatter of a single sample, each with its correlation along the curve.

use std::any::Any;
use std::ops::Range;
use std::sync::Arc;

use granum_core::observer::Observer;
use granum_core::words;
use granum_core::{Column, Table};
use granum_io::LaboratoryTest;
use granum_learn::surrogate::{
    ErrorCorrelation, FittedCurves, GaussianProcessOfCurves, Surrogate, SurrogateMethod, to_json,
};
use granum_learn::{Dataset, FitSpec, RunStates};

use crate::compared::curve::{ForwardModel, PredictedCurve};
use crate::compared::quantity::Quantity;
use crate::error::{CalibrationError, Result};
use crate::file::CalibrationFile;
use crate::simulations::known::KnownRun;
use crate::simulations::simulation::{CaseNumbers, of_test};
use crate::simulations::target::TargetTest;

/// Name of the coordinate.
const STRAIN: &str = "axial_strain";
/// Fewest simulations from which anything is learned.
pub const FEWEST: usize = 8;

/// Predicts the curves of all targets from the values of the free parameters.
pub struct Emulator<'a> {
    file: &'a CalibrationFile,
    targets: &'a [TargetTest],
    numbers: CaseNumbers,
    fitted: Arc<dyn Surrogate>,
    /// How the errors of the quantities of one sample go together.
    correlation: Arc<ErrorCorrelation>,
    /// For each number of the case whether it varies over the simulations, and is an input.
    varies: Vec<bool>,
    /// For each number of the case its smallest and largest value over the simulations.
    ranges: Vec<[f64; 2]>,
}

/// The error of the surrogate in a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOutError {
    /// The quantity.
    pub quantity: Quantity,
    /// Root mean square error over simulations that the surrogate did not learn from: in strains or void ratios, and of stresses over the
    /// mean stress at the start.
    pub error: f64,
    /// Root mean square of the learned curves about their mean, in the same measure.
    pub scatter: f64,
}

impl<'a> Emulator<'a> {
    /// Fits the surrogate to simulations, whose cases have these numbers.
    ///
    /// # Errors
    /// If there are fewer than [`FEWEST`], a simulation does not reach the compared strains or lacks a quantity, or the fit fails or is stopped.
    pub fn fit(
        file: &'a CalibrationFile,
        targets: &'a [TargetTest],
        numbers: CaseNumbers,
        known: &[KnownRun],
        threads: usize,
        observer: &mut dyn Observer,
    ) -> Result<Emulator<'a>> {
        let (ranges, dataset) = learned(file, &numbers, known)?;
        let varies: Vec<bool> = ranges.iter().map(|[low, high]| low < high).collect();
        let spec = spec(file, &numbers, &varies, threads);
        let mut method = GaussianProcessOfCurves::default();
        (method.components, method.starts) = (6, 1);
        let fitted = method.fit(&dataset, &spec, observer).map_err(|error| match error {
            granum_learn::LearnError::Stopped { .. } => CalibrationError::Stopped,
            other => other.into(),
        })?;
        let fitted: Arc<dyn Surrogate> = Arc::from(fitted);
        let correlation = Arc::new(processes(fitted.as_ref())?.error_correlation());
        Ok(Emulator { file, targets, numbers, fitted, correlation, varies, ranges })
    }

    /// The same surrogate for other targets, which have the conditions of these.
    pub fn for_targets<'b>(&self, targets: &'b [TargetTest]) -> Emulator<'b>
    where
        'a: 'b,
    {
        Emulator {
            file: self.file,
            targets,
            numbers: self.numbers.clone(),
            fitted: self.fitted.clone(),
            correlation: self.correlation.clone(),
            varies: self.varies.clone(),
            ranges: self.ranges.clone(),
        }
    }

    /// The file of the surrogate, which `granum predict` reads as well.
    ///
    /// # Errors
    /// If it cannot be written as JSON.
    pub fn to_json(&self) -> Result<String> {
        Ok(to_json(self.fitted.as_ref())?)
    }

    /// The inputs of the processes in a test, from the values of the free parameters.
    ///
    /// # Errors
    /// If an expression has no value at them.
    pub(crate) fn inputs(&self, values: &[f64], test: usize) -> Result<Vec<f64>> {
        let free = of_test(self.file, self.targets.len(), values, test);
        let numbers = self.numbers.values(&free, &self.targets[test].conditions)?;
        Ok(numbers.iter().zip(&self.varies).filter(|(_, varies)| **varies).map(|(x, _)| *x).collect())
    }

    /// The processes.
    pub(crate) fn curves(&self) -> Result<&FittedCurves> {
        processes(self.fitted.as_ref())
    }

    /// The errors over simulations left out of the fit, for each quantity.
    pub fn left_out_errors(&self, known: &[KnownRun]) -> Vec<LeftOutError> {
        let Ok(curves) = self.curves() else { return Vec::new() };
        let error = |(place, compared): (usize, &crate::file::ComparedQuantity)| {
            let all: Vec<Vec<f64>> = known
                .iter()
                .map(|one| {
                    let scale = self.file.calibration.scale(compared.quantity, one.mean_stress);
                    at_strains(&one.curves, compared.quantity, &compared.strains)
                        .iter()
                        .map(|y| y / scale)
                        .collect()
                })
                .collect();
            let mean = |k: usize| all.iter().map(|curve| curve[k]).sum::<f64>() / all.len() as f64;
            let square = |k: usize| all.iter().map(|curve| (curve[k] - mean(k)).powi(2)).sum::<f64>();
            let total: f64 = (0..compared.strains.len()).map(square).sum();
            Some(LeftOutError {
                quantity: compared.quantity,
                error: curves.left_out_error(place)?,
                scatter: (total / (all.len() * compared.strains.len()) as f64).sqrt(),
            })
        };
        self.file.calibration.quantities.iter().enumerate().filter_map(error).collect()
    }

    /// The prediction of each compared quantity of a test at given strains, from the values of the free parameters; curves are named by the
    /// places of their quantities in the file.
    ///
    /// # Errors
    /// If an expression has no value at them.
    pub fn predict_test(
        &self,
        values: &[f64],
        test: usize,
        strains: impl Fn(usize) -> Option<Vec<f64>>,
    ) -> Result<Vec<Option<PredictedCurve>>> {
        let target = &self.targets[test];
        let inputs = self.inputs(values, test)?;
        let quantities = &self.file.calibration.quantities;
        let asked: Vec<(usize, Vec<f64>)> =
            (0..quantities.len()).filter_map(|place| Some((place, strains(place)?))).collect();
        let at: Vec<(usize, &[f64])> =
            asked.iter().map(|(place, strain)| (*place, strain.as_slice())).collect();
        let found = self.curves()?.correlated_curves(&inputs, &at, &self.correlation)?;
        let count = found.mean.len();
        let mut from = 0;
        let own: Vec<(usize, Range<usize>, f64)> = asked
            .iter()
            .map(|(place, strain)| {
                let rows = from..from + strain.len();
                from = rows.end;
                (*place, rows, self.file.calibration.scale(quantities[*place].quantity, target.mean_stress))
            })
            .collect();
        let block = |(_, rows, scale): &(usize, Range<usize>, f64),
                     (_, columns, other): &(usize, Range<usize>, f64)| {
            let entry = |(i, j): (usize, usize)| scale * other * found.covariance[i * count + j];
            rows.clone().flat_map(|i| columns.clone().map(move |j| (i, j))).map(entry).collect()
        };
        let mut predicted: Vec<Option<PredictedCurve>> = vec![None; quantities.len()];
        for (k, one) in own.iter().enumerate() {
            let (place, rows, scale) = one;
            predicted[*place] = Some(PredictedCurve {
                mean: found.mean[rows.clone()].iter().map(|y| scale * y).collect(),
                covariance: block(one, one),
                across: own[..k].iter().map(|other| (other.0, block(one, other))).collect(),
            });
        }
        Ok(predicted)
    }
}

impl Emulator<'_> {
    /// The smallest and the largest value of a key over the simulations from which the surrogate learned; `None` for a key that it does not
    /// know.
    pub fn range_of(&self, key: &str) -> Option<[f64; 2]> {
        let place = self.numbers.columns().position(|(known, _)| known == key)?;
        self.ranges.get(place).copied()
    }

    /// Where values of the parameters lead beyond the simulations from which the surrogate learned: a sentence for each test and key.
    ///
    /// # Errors
    /// If an expression has no value at them.
    pub fn beyond_simulations(&self, values: &[f64]) -> Result<Vec<String>> {
        let mut told = Vec::new();
        for (test, target) in self.targets.iter().enumerate() {
            let free = of_test(self.file, self.targets.len(), values, test);
            let numbers = self.numbers.values(&free, &target.conditions)?;
            for (((key, unit), value), [low, high]) in self.numbers.columns().zip(numbers).zip(&self.ranges) {
                // A number that all simulations have is not seen by the surrogate.
                let slack = if low < high { 1e-3 * (high - low) } else { 1e-2 * high.abs() };
                if !(low - slack..=high + slack).contains(&value) {
                    told.push(format!(
                        "{}: {key} = {value:.4e} {unit} lies outside of the simulations ({low:.4e} to {high:.4e}), where the surrogate guesses",
                        target.name
                    ));
                }
            }
        }
        Ok(told)
    }
}

impl ForwardModel for Emulator<'_> {
    fn predict(&self, values: &[f64]) -> Option<Vec<PredictedCurve>> {
        let mut all = Vec::new();
        for (test, target) in self.targets.iter().enumerate() {
            let strains = |place: usize| {
                let curve = target.curves.iter().find(|(known, _)| *known == place);
                curve.map(|(_, curve)| curve.strain.clone())
            };
            let mut places = vec![0; self.file.calibration.quantities.len()];
            for (place, curve) in self.predict_test(values, test, strains).ok()?.into_iter().enumerate() {
                let Some(mut curve) = curve else { continue };
                places[place] = all.len();
                curve.across.iter_mut().for_each(|(other, _)| *other = places[*other]);
                all.push(curve);
            }
        }
        Some(all)
    }
}

/// The processes of a surrogate of curves.
fn processes(fitted: &dyn Surrogate) -> Result<&FittedCurves> {
    let any: &dyn Any = fitted;
    any.downcast_ref()
        .ok_or_else(|| CalibrationError::Input("this is no surrogate of the curves of a calibration".into()))
}

/// A quantity of a simulation at strains; constant beyond its last state.
pub fn at_strains(curves: &LaboratoryTest, quantity: Quantity, strains: &[f64]) -> Vec<f64> {
    let values = quantity.readings(curves);
    let at = |x: &f64| granum_learn::curve::interpolated(*x, &curves.axial_strain, &values);
    strains.iter().map(at).collect()
}

/// Refuses a simulation that does not reach the compared strains, or lacks a quantity.
///
/// # Errors
/// With the name of the run and what it lacks.
pub fn check(file: &CalibrationFile, name: &str, curves: &LaboratoryTest) -> Result<()> {
    let reached = curves.axial_strain.last().copied().unwrap_or(0.0);
    for compared in &file.calibration.quantities {
        let word = compared.quantity.word();
        let values = compared.quantity.readings(curves);
        if values.len() != curves.axial_strain.len() || values.iter().any(|y| !y.is_finite()) {
            return Err(CalibrationError::Input(format!("the run {name} has no {word}")));
        }
        let last = compared.strains.last().copied().unwrap_or(0.0);
        // The last state may be short of the end of its stage by a step.
        if reached < last * (1.0 - 1e-3) {
            return Err(CalibrationError::Input(format!(
                "the run {name} ends at an axial strain of {}, and {word} is compared up to {}; let its test go further, or compare \
                 less",
                words::percent(reached, 3),
                words::percent(last, 3)
            )));
        }
    }
    Ok(())
}

/// The smallest and largest value of each number over the simulations, and these as a data set with those that vary as parameters.
fn learned(
    file: &CalibrationFile,
    numbers: &CaseNumbers,
    known: &[KnownRun],
) -> Result<(Vec<[f64; 2]>, Dataset)> {
    if known.len() < FEWEST {
        return Err(CalibrationError::Input(format!(
            "{} simulations are left to learn from, and {FEWEST} are needed; plan more runs",
            known.len()
        )));
    }
    known.iter().try_for_each(|one| check(file, &one.name, &one.curves))?;
    let range = |k: usize| granum_learn::curve::range(known.iter().map(|one| one.numbers[k]));
    let ranges: Vec<[f64; 2]> = (0..numbers.columns().count()).map(range).collect();
    let run = |one: &KnownRun| {
        let mut columns = vec![Column::new(STRAIN, "", one.curves.axial_strain.clone())];
        for compared in &file.calibration.quantities {
            let scale = file.calibration.scale(compared.quantity, one.mean_stress);
            let values = compared.quantity.readings(&one.curves).iter().map(|y| y / scale).collect();
            columns.push(Column::new(output(compared.quantity), "", values));
        }
        let table = Table::new(columns).map_err(granum_learn::LearnError::from)?;
        let mut run = RunStates::new(&one.name, table)?;
        for (((name, unit), value), [low, high]) in numbers.columns().zip(&one.numbers).zip(&ranges) {
            if low < high {
                run = run.with_parameter(name, unit, *value)?;
            }
        }
        Ok(run)
    };
    let runs = known.iter().map(run).collect::<Result<Vec<_>>>()?;
    Ok((ranges, Dataset::new(runs)?))
}

/// The column of a quantity.
fn output(quantity: Quantity) -> String {
    if quantity.is_stress() { format!("{}_ratio_to_start", quantity.word()) } else { quantity.word().into() }
}

fn spec(file: &CalibrationFile, numbers: &CaseNumbers, varies: &[bool], threads: usize) -> FitSpec {
    let inputs = numbers.columns().zip(varies).filter(|(_, varies)| **varies).map(|((name, _), _)| name);
    let inputs: Vec<&str> = std::iter::once(STRAIN).chain(inputs).collect();
    let outputs: Vec<String> = file.calibration.quantities.iter().map(|q| output(q.quantity)).collect();
    FitSpec::new(inputs, outputs)
        .with_coordinate(STRAIN)
        .with_seed(u64::from(file.calibration.seed))
        .with_threads(threads)
        .with_name("calibration")
}
