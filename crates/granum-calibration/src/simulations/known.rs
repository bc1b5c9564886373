//! Simulations from which a surrogate learns: those of the calibration itself, and those of an earlier campaign.

use granum_campaign::data_set::DataSetRun;
use granum_io::case::CaseParameter;
use granum_io::{Case, LaboratoryTest};
use granum_run::strength::as_laboratory;

use crate::error::{CalibrationError, Result};
use crate::file::CalibrationFile;
use crate::simulations::differences::Differences;
use crate::simulations::simulation::{CaseNumbers, Simulated};
use crate::simulations::target::TargetTest;

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
    /// From the runs of a data set, which are compared with the case of a simulation of the calibration itself. A number that varies over them and
    /// that the file does not set is an input of the surrogate all the same, with the value of that case where predictions are made.
    ///
    /// # Errors
    /// If there is no run, a run has no number at a key that the file sets, or runs differ in a word, such as a law.
    pub fn new(file: &CalibrationFile, own: &Case, runs: Vec<DataSetRun>) -> Result<EarlierRuns> {
        if runs.is_empty() {
            return Err(CalibrationError::Input("the earlier campaign has no run in its data set".into()));
        }
        let named: Vec<(&str, &Case)> = runs.iter().map(|run| (run.name.as_str(), &run.case)).collect();
        let Differences { varying, remarks } = Differences::new(file, own, &named)?;
        let mut numbers = CaseNumbers::new(file);
        varying.iter().for_each(|(key, unit, value)| numbers.add_constant(key, unit, *value));
        let mut known = Vec::new();
        for run in runs {
            let parameters = run.case.parameters();
            let number = |(key, _): (&str, &str)| {
                let value = parameters.iter().find(|known| known.key == key).and_then(CaseParameter::number);
                value.ok_or_else(|| {
                    CalibrationError::Input(format!("the earlier run {} has no number at {key}", run.name))
                })
            };
            let values = numbers.columns().map(number).collect::<Result<Vec<f64>>>()?;
            let curves = as_laboratory(&run.name, &run.measured, &run.case.test_stages());
            let usable = |p: &f64| *p > 0.0 || file.calibration.stress_scale.is_some();
            let Some(mean_stress) = curves.mean_stress.first().copied().filter(usable) else {
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
