//! The surrogate of the simulations: Gaussian processes of whole curves over the axial strain, which depend on the numbers of the case that
//! variables set.
//!
//! Stresses are learned over the mean stress with which a test begins, so that tests at different stresses tell of each other; stiffness is seen by
//! the processes as the ratio of stress to modulus. The covariance of a prediction contains what more simulations would reduce and the
//! scatter of a single sample, each with its correlation along the curve.

use std::any::Any;
use std::sync::Arc;

use granum_core::observer::Observer;
use granum_core::{Column, Table};
use granum_learn::surrogate::{FittedCurves, GaussianProcessOfCurves, Surrogate, SurrogateMethod, to_json};
use granum_learn::{Dataset, FitSpec, RunStates};

use crate::curve::{ForwardModel, PredictedCurve};
use crate::error::{CalibrationError, Result};
use crate::file::{CalibrationFile, Quantity};
use crate::simulation::{CaseNumbers, Simulated, of_test};
use crate::target::{Target, readings};

/// Name of the coordinate.
const STRAIN: &str = "axial_strain";
/// Fewest simulations from which anything is learned.
pub const FEWEST: usize = 8;

/// Predicts the curves of all targets from the values of the free parameters.
pub struct Emulator<'a> {
    file: &'a CalibrationFile,
    targets: &'a [Target],
    numbers: CaseNumbers,
    fitted: Arc<dyn Surrogate>,
    /// For each number of the case whether it varies over the simulations, and is an input.
    varies: Vec<bool>,
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
    /// Fits the surrogate to simulations.
    ///
    /// # Errors
    /// If there are fewer than [`FEWEST`], a simulation does not reach the compared strains or lacks a quantity, or the fit fails or is stopped.
    pub fn fit(
        file: &'a CalibrationFile,
        targets: &'a [Target],
        simulated: &[Simulated],
        threads: usize,
        observer: &mut dyn Observer,
    ) -> Result<Emulator<'a>> {
        let (numbers, varies, dataset) = learned(file, targets, simulated)?;
        let spec = spec(file, &numbers, &varies, threads);
        let mut method = GaussianProcessOfCurves::default();
        (method.components, method.starts) = (6, 1);
        let fitted = method.fit(&dataset, &spec, observer).map_err(|error| match error {
            granum_learn::LearnError::Stopped { .. } => CalibrationError::Stopped,
            other => other.into(),
        })?;
        Ok(Emulator { file, targets, numbers, fitted: Arc::from(fitted), varies })
    }

    /// The same surrogate for other targets, which have the conditions of these.
    pub fn for_targets<'b>(&self, targets: &'b [Target]) -> Emulator<'b>
    where
        'a: 'b,
    {
        let (numbers, varies) = (self.numbers.clone(), self.varies.clone());
        Emulator { file: self.file, targets, numbers, fitted: self.fitted.clone(), varies }
    }

    /// The file of the surrogate, which `granum predict` reads as well.
    ///
    /// # Errors
    /// If it cannot be written as JSON.
    pub fn to_json(&self) -> Result<String> {
        Ok(to_json(self.fitted.as_ref())?)
    }

    fn curves(&self) -> Result<&FittedCurves> {
        let any: &dyn Any = self.fitted.as_ref();
        any.downcast_ref().ok_or_else(|| {
            CalibrationError::Input("this is no surrogate of the curves of a calibration".into())
        })
    }

    /// The errors over simulations left out of the fit, for each quantity.
    pub fn left_out_errors(&self, simulated: &[Simulated]) -> Vec<LeftOutError> {
        let Ok(curves) = self.curves() else { return Vec::new() };
        let error = |(place, compared): (usize, &crate::file::ComparedQuantity)| {
            let all: Vec<Vec<f64>> = simulated
                .iter()
                .map(|one| {
                    let scale = scale(compared.quantity, &self.targets[one.simulation.test]);
                    at_strains(one, compared.quantity, &compared.strains).iter().map(|y| y / scale).collect()
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

    /// The prediction of each compared quantity of a test at given strains, from the values of the free parameters.
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
        let free = of_test(self.file, self.targets.len(), values, test);
        let numbers = self.numbers.values(&free, &target.conditions)?;
        let inputs: Vec<f64> =
            numbers.iter().zip(&self.varies).filter(|(_, varies)| **varies).map(|(x, _)| *x).collect();
        let curves = self.curves()?;
        let predict = |(place, compared): (usize, &crate::file::ComparedQuantity)| {
            let Some(strain) = strains(place) else { return Ok(None) };
            let found = curves.correlated_curve(&inputs, place, &strain)?;
            let scale = scale(compared.quantity, target);
            Ok(Some(PredictedCurve {
                mean: found.mean.iter().map(|y| scale * y).collect(),
                covariance: found.covariance.iter().map(|y| scale * scale * y).collect(),
            }))
        };
        self.file.calibration.quantities.iter().enumerate().map(predict).collect()
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
            all.extend(self.predict_test(values, test, strains).ok()?.into_iter().flatten());
        }
        Some(all)
    }
}

/// What a quantity is divided by while it is learned.
pub fn scale(quantity: Quantity, target: &Target) -> f64 {
    if quantity.is_stress() { target.mean_stress } else { 1.0 }
}

/// A quantity of a simulation at strains; constant beyond its last state.
pub fn at_strains(simulated: &Simulated, quantity: Quantity, strains: &[f64]) -> Vec<f64> {
    let values = readings(&simulated.curves, quantity);
    let at = |x: &f64| granum_learn::curve::interpolated(*x, &simulated.curves.axial_strain, values);
    strains.iter().map(at).collect()
}

/// Refuses a simulation that does not reach the compared strains, or lacks a quantity.
///
/// # Errors
/// With the name of the run and what it lacks.
pub fn check(file: &CalibrationFile, simulated: &Simulated) -> Result<()> {
    let reached = simulated.curves.axial_strain.last().copied().unwrap_or(0.0);
    for compared in &file.calibration.quantities {
        let word = compared.quantity.word();
        let values = readings(&simulated.curves, compared.quantity);
        if values.len() != simulated.curves.axial_strain.len() || values.iter().any(|y| !y.is_finite()) {
            return Err(CalibrationError::Input(format!("the run {} has no {word}", simulated.name)));
        }
        let last = compared.strains.last().copied().unwrap_or(0.0);
        // The last state may be short of the end of its stage by a step.
        if reached < last * (1.0 - 1e-3) {
            return Err(CalibrationError::Input(format!(
                "the run {} ends at an axial strain of {:.3} %, and {word} is compared up to {:.3} %; let its test go further, or compare \
                 less",
                simulated.name,
                100.0 * reached,
                100.0 * last
            )));
        }
    }
    Ok(())
}

/// The simulations as a data set, with the numbers of their cases as parameters.
fn learned(
    file: &CalibrationFile,
    targets: &[Target],
    simulated: &[Simulated],
) -> Result<(CaseNumbers, Vec<bool>, Dataset)> {
    if simulated.len() < FEWEST {
        return Err(CalibrationError::Input(format!(
            "{} simulations are left to learn from, and {FEWEST} are needed; plan more runs",
            simulated.len()
        )));
    }
    let numbers = CaseNumbers::new(file);
    let mut rows = Vec::new();
    for one in simulated {
        check(file, one)?;
        rows.push(numbers.values(&one.simulation.values, &targets[one.simulation.test].conditions)?);
    }
    let varies: Vec<bool> = (0..rows[0].len()).map(|k| rows.iter().any(|row| row[k] != rows[0][k])).collect();
    let run = |(one, row): (&Simulated, &Vec<f64>)| {
        let target = &targets[one.simulation.test];
        let mut columns = vec![Column::new(STRAIN, "", one.curves.axial_strain.clone())];
        for compared in &file.calibration.quantities {
            let scale = scale(compared.quantity, target);
            let values = readings(&one.curves, compared.quantity).iter().map(|y| y / scale).collect();
            columns.push(Column::new(output(compared.quantity), "", values));
        }
        let table = Table::new(columns).map_err(granum_learn::LearnError::from)?;
        let mut run = RunStates::new(&one.name, table)?;
        for (((name, unit), value), varies) in numbers.columns().zip(row).zip(&varies) {
            if *varies {
                run = run.with_parameter(name, unit, *value)?;
            }
        }
        Ok(run)
    };
    let runs = simulated.iter().zip(&rows).map(run).collect::<Result<Vec<_>>>()?;
    Ok((numbers, varies, Dataset::new(runs)?))
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
