//! Simulations from which a surrogate learns: those of the calibration itself, and those of an earlier campaign.

use std::collections::{BTreeMap, BTreeSet};

use granum_campaign::data_set::DataSetRun;
use granum_io::LaboratoryTest;
use granum_io::case::{CaseParameter, ParameterValue, SEED};
use granum_run::strength::as_laboratory;

use crate::error::{CalibrationError, Result};
use crate::file::CalibrationFile;
use crate::simulation::{CaseNumbers, Simulated};
use crate::target::TargetTest;

/// Ends of keys that say how a test is observed and how far it goes, and not what the grains do.
const OF_NO_MATTER: [&str; 3] = [".states", ".axial_strain", ".snapshots"];
/// Section of keys that say what is recorded.
const RECORDING: &str = "recording.";
/// Most differences that are named.
const MOST_NAMED: usize = 6;

/// A simulation from which a surrogate learns.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownRun {
    /// Name of its run.
    pub name: String,
    /// The numbers of its case at the columns of [`CaseNumbers`], in SI units.
    pub numbers: Vec<f64>,
    /// Effective mean stress by which its stresses are divided, Pa.
    pub mean_stress: f64,
    /// Its curves, in the measures of a laboratory.
    pub curves: LaboratoryTest,
}

impl KnownRun {
    /// A simulation of one of the targets.
    ///
    /// # Errors
    /// If an expression of the file has no value at it.
    pub fn from_simulated(
        numbers: &CaseNumbers,
        targets: &[TargetTest],
        one: &Simulated,
    ) -> Result<KnownRun> {
        let target = &targets[one.simulation.test];
        Ok(KnownRun {
            name: one.name.clone(),
            numbers: numbers.values(&one.simulation.values, &target.conditions)?,
            mean_stress: target.mean_stress,
            curves: one.curves.clone(),
        })
    }
}

/// The runs of an earlier campaign, as far as a calibration can learn from them.
#[derive(Clone, Debug)]
pub struct EarlierRuns {
    /// The numbers that decide a simulation: those that the file of the calibration sets, and those that vary over the runs beside.
    pub numbers: CaseNumbers,
    /// The runs.
    pub runs: Vec<KnownRun>,
    /// Where the runs are not those that the file describes, in a sentence for each key.
    pub remarks: Vec<String>,
}

impl EarlierRuns {
    /// From the runs of a data set. A number that varies over them and that the file does not set is an input of the surrogate all the same, with
    /// the value of the base case where predictions are made.
    ///
    /// # Errors
    /// If there is no run, a run has no number at a key that the file sets, or runs differ in a word, such as a law.
    pub fn new(file: &CalibrationFile, runs: Vec<DataSetRun>) -> Result<EarlierRuns> {
        let mut numbers = CaseNumbers::new(file);
        let cases: Vec<BTreeMap<String, CaseParameter>> =
            runs.iter().map(|run| by_key(run.case.parameters())).collect();
        let Some(first) = cases.first() else {
            return Err(CalibrationError::Input("the earlier campaign has no run in its data set".into()));
        };
        let set: BTreeSet<&str> = file
            .plan
            .variables
            .iter()
            .flat_map(|variable| variable.keys.iter().map(|key| key.value.as_str()))
            .collect();
        let counts = |key: &str| {
            let observed = key.starts_with(RECORDING) || OF_NO_MATTER.iter().any(|end| key.ends_with(end));
            !(set.contains(key) || observed || key == SEED)
        };
        let mut remarks = Vec::new();
        let base = by_key(file.plan.case.parameters());
        for (key, parameter) in first.iter().filter(|(key, _)| counts(key)) {
            let varies =
                cases.iter().any(|case| case.get(key).map(|known| &known.value) != Some(&parameter.value));
            let here = file.plan.case_number(key);
            match (varies, parameter.number(), here) {
                (true, Some(_), Some(here)) => numbers.add_constant(key, &parameter.unit, here),
                (true, _, _) => {
                    return Err(CalibrationError::Input(format!(
                        "the earlier runs differ in {key}, which is not a number of the base case that a surrogate could learn; take runs that have \
                         one value of it"
                    )));
                }
                (false, Some(there), Some(here)) if (there - here).abs() > 1e-9 * here.abs() => {
                    remarks.push(format!("{key} is {there} in the earlier runs, and {here} in the file"));
                }
                (false, None, _) => {
                    let known =
                        base.get(key).filter(|_| !file.plan.fixed.iter().any(|fixed| fixed.key == *key));
                    if let Some(known) = known.filter(|known| known.value != parameter.value) {
                        let [there, here] = [&parameter.value, &known.value].map(word);
                        remarks.push(format!("{key} is {there} in the earlier runs, and {here} in the file"));
                    }
                }
                _ => {}
            }
        }
        if remarks.len() > MOST_NAMED {
            let more = remarks.len() - MOST_NAMED;
            remarks.truncate(MOST_NAMED);
            remarks.push(format!("{more} more keys differ between the earlier runs and the file"));
        }
        let mut known = Vec::new();
        for (run, case) in runs.into_iter().zip(&cases) {
            let number = |(key, _): (&str, &str)| {
                case.get(key).and_then(CaseParameter::number).ok_or_else(|| {
                    CalibrationError::Input(format!("the earlier run {} has no number at {key}", run.name))
                })
            };
            let values = numbers.columns().map(number).collect::<Result<Vec<f64>>>()?;
            let curves = as_laboratory(&run.name, &run.measured, &run.case.test_stages());
            let Some(mean_stress) = curves.mean_stress.first().copied().filter(|p| *p > 0.0) else {
                return Err(CalibrationError::Input(format!(
                    "the earlier run {} has no mean stress at its start",
                    run.name
                )));
            };
            known.push(KnownRun { name: run.name, numbers: values, mean_stress, curves });
        }
        Ok(EarlierRuns { numbers, runs: known, remarks })
    }
}

fn by_key(parameters: Vec<CaseParameter>) -> BTreeMap<String, CaseParameter> {
    parameters.into_iter().map(|parameter| (parameter.key.clone(), parameter)).collect()
}

fn word(value: &ParameterValue) -> String {
    match value {
        ParameterValue::Number(number) => number.to_string(),
        ParameterValue::Word(word) => word.clone(),
        ParameterValue::List(numbers) => format!("{numbers:?}"),
    }
}
