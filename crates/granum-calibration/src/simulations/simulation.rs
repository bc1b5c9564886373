//! Simulations of the tests at values of what is free: the plan of a campaign of them, and the curves that they gave.

use std::collections::BTreeMap;

use granum_campaign::data_set::DataSetRun;
use granum_campaign::plan::{DesignKind, Plan, PlanRow, PlanVariable, PlannedRuns, RowPlace, VariableKind};
use granum_core::quantity::format_number;
use granum_io::LaboratoryTest;
use granum_run::strength::as_laboratory;
use serde::{Deserialize, Serialize};

use crate::error::{CalibrationError, Result};
use crate::file::CalibrationFile;
use crate::inference::likelihood::FreeParameter;
use crate::simulations::target::TargetTest;

/// Shares of a prior nearer to 0 or 1 are not simulated: a normal prior has no bound there.
const NEAREST: f64 = 0.005;

/// A simulation of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignPoint {
    /// Place of the test among the targets.
    pub test: usize,
    /// The values of the free variables, in their order.
    pub values: Vec<f64>,
}

/// The free parameters: one of each free variable that all tests share, and one for each test of a variable that is own to the test, named
/// `VARIABLE_TEST`.
pub fn parameters(file: &CalibrationFile, targets: &[TargetTest]) -> Vec<FreeParameter> {
    let of_variable = |free: &crate::file::FreeVariable| -> Vec<FreeParameter> {
        let named = |name: String| FreeParameter { name, prior: free.prior };
        match free.own {
            false => vec![named(free.name.clone())],
            true => targets.iter().map(|target| named(format!("{}_{}", free.name, target.name))).collect(),
        }
    };
    file.free.iter().flat_map(of_variable).collect()
}

/// The values of the free variables that the case of a test gets, from those of the parameters in the order of [`parameters`].
pub fn of_test(file: &CalibrationFile, tests: usize, values: &[f64], test: usize) -> Vec<f64> {
    let mut at = 0;
    let value = |free: &crate::file::FreeVariable| {
        let place = if free.own { at + test } else { at };
        at += if free.own { tests } else { 1 };
        free.in_case(values.get(place).copied().unwrap_or(f64::NAN))
    };
    file.free.iter().map(value).collect()
}

/// A design that fills the priors evenly: so many simulations, each of the next test in turn, at points of a scrambled Sobol sequence.
pub fn design(file: &CalibrationFile, tests: usize) -> Vec<DesignPoint> {
    let seed = file.calibration.seed;
    let simulation = |k: usize| {
        let value = |(j, free): (usize, &crate::file::FreeVariable)| {
            let share = f64::from(sobol_burley::sample(k as u32, j as u32, seed));
            free.in_case(free.prior.value(share.clamp(NEAREST, 1.0 - NEAREST)))
        };
        DesignPoint { test: k % tests.max(1), values: file.free.iter().enumerate().map(value).collect() }
    };
    (0..file.calibration.runs).map(simulation).collect()
}

/// The plan of a campaign with a run of each simulation, in their order.
pub fn plan(file: &CalibrationFile, targets: &[TargetTest], simulations: &[DesignPoint]) -> Plan {
    let free = file.free.first().and_then(|free| file.plan.variables.iter().find(|v| v.name == free.name));
    let span = free.map_or(0..0, |variable| variable.span.clone());
    let row = |simulation: &DesignPoint| {
        let cell = |(name, value): (&String, &f64)| (name.clone(), format_number(*value));
        let free = file.free.iter().map(|free| &free.name).zip(&simulation.values);
        let given = file.conditions.iter().map(|(name, _)| name).zip(&targets[simulation.test].conditions);
        PlanRow { cells: free.chain(given).map(cell).collect(), place: RowPlace::Plan(span.clone()) }
    };
    let mut plan = file.plan.clone();
    plan.design.kind = DesignKind::Rows(simulations.iter().map(row).collect());
    plan
}

/// The runs of a plan that [`plan`] made: one for each simulation.
///
/// # Errors
/// As [`Plan::runs`] for values that no case accepts.
pub fn planned(plan: &Plan) -> Result<PlannedRuns> {
    let runs = plan.runs()?;
    if runs.repeated > 0 {
        return Err(CalibrationError::Input(
            "two simulations are the same; free a variable with a key".into(),
        ));
    }
    Ok(runs)
}

/// A simulation with the curves that it gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// Name of its run.
    pub name: String,
    /// What was simulated.
    pub simulation: DesignPoint,
    /// The curves, in the measures of a laboratory.
    pub curves: LaboratoryTest,
}

/// The simulations whose runs are in a data set, and the number of those that are not: they failed, or did not pass their checks.
pub fn simulated(
    simulations: &[DesignPoint],
    planned: &PlannedRuns,
    runs: Vec<DataSetRun>,
) -> (Vec<Simulated>, usize) {
    let mut by_name: BTreeMap<String, DataSetRun> =
        runs.into_iter().map(|run| (run.name.clone(), run)).collect();
    let mut missing = 0;
    let mut found = Vec::new();
    for (simulation, planned) in simulations.iter().zip(&planned.runs) {
        let Some(run) = by_name.remove(&planned.name) else {
            missing += 1;
            continue;
        };
        let curves = as_laboratory(&run.name, &run.measured, &run.case.test_stages());
        found.push(Simulated { name: run.name, simulation: simulation.clone(), curves });
    }
    (found, missing)
}

/// The numbers that decide a simulation: the values of all variables that set a key of the case.
#[derive(Clone, Debug)]
pub struct CaseNumbers {
    variables: Vec<PlanVariable>,
    /// Names of the free variables, then of those that tests give.
    names: Vec<String>,
    constants: BTreeMap<String, f64>,
    /// The variables with keys.
    with_keys: Vec<usize>,
    /// Further keys with unit and value, which no variable sets.
    fixed: Vec<(String, String, f64)>,
}

impl CaseNumbers {
    /// From the file of a calibration.
    pub fn new(file: &CalibrationFile) -> CaseNumbers {
        let variables = file.plan.variables.clone();
        let mut constants = BTreeMap::new();
        for variable in &variables {
            let VariableKind::Expression(expression) = &variable.kind else { continue };
            for name in expression.value.names() {
                if let Some(number) = file.plan.case_number(name) {
                    constants.insert(name.to_string(), number);
                }
            }
        }
        let free = file.free.iter().map(|free| free.name.clone());
        CaseNumbers {
            names: free.chain(file.conditions.iter().map(|(name, _)| name.clone())).collect(),
            with_keys: (0..variables.len()).filter(|k| !variables[*k].keys.is_empty()).collect(),
            variables,
            constants,
            fixed: Vec::new(),
        }
    }

    /// Adds a key that no variable sets, with its unit and its value.
    pub fn add_constant(&mut self, key: &str, unit: &str, value: f64) {
        self.fixed.push((key.into(), unit.into(), value));
    }

    /// The keys with their units: of each variable its first one, then those that were added.
    pub fn columns(&self) -> impl Iterator<Item = (&str, &str)> {
        self.with_keys
            .iter()
            .map(|k| (self.variables[*k].keys[0].value.as_str(), self.variables[*k].unit.as_str()))
            .chain(self.fixed.iter().map(|(key, unit, _)| (key.as_str(), unit.as_str())))
    }

    /// The numbers, from values of the free variables and the conditions of a test.
    ///
    /// # Errors
    /// If an expression has no value.
    pub fn values(&self, free: &[f64], conditions: &[f64]) -> Result<Vec<f64>> {
        let mut known: BTreeMap<&str, f64> =
            self.names.iter().map(String::as_str).zip(free.iter().chain(conditions).copied()).collect();
        let is_open = |variable: &&PlanVariable| matches!(variable.kind, VariableKind::Expression(_));
        let mut open: Vec<&PlanVariable> = self.variables.iter().filter(is_open).collect();
        while !open.is_empty() {
            let names: Vec<&str> = open.iter().map(|variable| variable.name.as_str()).collect();
            let before = open.len();
            let mut later = Vec::new();
            for variable in open {
                let VariableKind::Expression(expression) = &variable.kind else { continue };
                if expression.value.names().any(|name| names.contains(&name)) {
                    later.push(variable);
                    continue;
                }
                let number = |name: &str| known.get(name).or_else(|| self.constants.get(name)).copied();
                let value = expression
                    .value
                    .value(&number)
                    .map_err(|why| CalibrationError::Input(format!("{}: {why}", variable.name)))?;
                known.insert(&variable.name, value);
            }
            if later.len() == before {
                break;
            }
            open = later;
        }
        let value = |k: &usize| {
            let name = self.variables[*k].name.as_str();
            known.get(name).copied().ok_or_else(|| CalibrationError::Input(format!("{name} has no value")))
        };
        self.with_keys.iter().map(value).chain(self.fixed.iter().map(|(_, _, value)| Ok(*value))).collect()
    }
}
