//! Repeated inference on one surrogate: each test left out of it in turn and predicted, and each test alone.

use granum_calibration::posterior::outcome::Outcome;
use granum_calibration::posterior::prediction::{Prediction, errors_table, predict, readings_table};
use granum_calibration::simulations::emulator::Emulator;
use granum_calibration::simulations::known::KnownRun;
use granum_calibration::simulations::target::TargetTest;
use granum_io::shell::ShowPath;
use granum_io::{Column, Table, write_table};
use serde_json::json;

use super::calibration::Calibration;
use super::prediction::summary;
use crate::failure::Failure;
use crate::{command::text_table, output};

/// Readings, errors and parameters of tests that were left out, and parameters by each test alone.
const FILES: [&str; 4] =
    ["leave-one-out.csv", "leave-one-out-errors.csv", "leave-one-out-parameters.csv", "each-alone.csv"];

impl Calibration<'_> {
    /// Leaves each test out of the inference, and predicts it from the others.
    pub fn leave_one_out(&self) -> Result<(), Failure> {
        if self.targets.len() < 2 {
            return Err(Failure::new("--leave-one-out needs two tests at least"));
        }
        let (emulator, runs) = self.learned()?;
        self.check_reach(&emulator, &runs, &FILES[..3])?;
        let (mut predictions, mut outcomes): (Vec<Prediction>, Vec<(String, Outcome)>) =
            (Vec::new(), Vec::new());
        let mut not_explained = Vec::new();
        for (k, left_out) in self.targets.iter().enumerate() {
            let rest: Vec<TargetTest> =
                self.targets.iter().filter(|target| target.name != left_out.name).cloned().collect();
            let phase = format!("without {} ({} of {})", left_out.name, k + 1, self.targets.len());
            let (outcome, against) = self.infer_on(&emulator, &phase, &rest)?;
            not_explained.extend(against);
            let all = emulator.for_targets(self.targets);
            predictions.extend(predict(self.file, &all, self.targets, k, &outcome)?);
            outcomes.push((left_out.name.clone(), outcome));
        }
        let paths = FILES.map(|name| self.out.join(name));
        write_table(&paths[0], &readings_table(&predictions)?)?;
        write_table(&paths[1], &errors_table(&predictions)?)?;
        write_table(&paths[2], &parameters_table(&outcomes)?)?;
        let result = json!({ "folder": output::path(&self.out), "predictions": predictions, "not_explained": not_explained });
        output::say_complete(self.context, &self.out, &result, || {
            let mut lines = not_explained;
            lines.extend(["each test predicted from the others, by the surrogate:".to_string()]);
            lines.extend(summary(&predictions));
            lines.push(format!("wrote {}, {}, {}", paths[0].shown(), paths[1].shown(), paths[2].shown()));
            lines.join("\n")
        })
    }

    /// Calibrates on each test alone.
    pub fn each_alone(&self) -> Result<(), Failure> {
        let (emulator, runs) = self.learned()?;
        self.check_reach(&emulator, &runs, &FILES[3..])?;
        let (mut outcomes, mut not_explained) = (Vec::new(), Vec::new());
        for (k, target) in self.targets.iter().enumerate() {
            let phase = format!("{} alone ({} of {})", target.name, k + 1, self.targets.len());
            let (outcome, against) = self.infer_on(&emulator, &phase, std::slice::from_ref(target))?;
            not_explained.extend(against);
            outcomes.push((target.name.clone(), outcome));
        }
        let table = parameters_table(&outcomes)?;
        let path = self.out.join(FILES[3]);
        write_table(&path, &table)?;
        let rows = |(test, outcome): &(String, Outcome)| json!({ "test": test, "mean": outcome.mean(), "parameters": outcome.names });
        let each_alone: Vec<serde_json::Value> = outcomes.iter().map(rows).collect();
        let result = json!({ "folder": output::path(&self.out), "each_alone": each_alone, "not_explained": not_explained });
        output::say_complete(self.context, &self.out, &result, || {
            let mut lines = not_explained;
            lines.extend(text_table::lines(&table));
            lines.push(format!("each test calibrated alone, by the surrogate; wrote {}", path.shown()));
            lines.join("\n")
        })
    }

    /// The posterior of some tests, and what speaks against it.
    fn infer_on(
        &self,
        emulator: &Emulator,
        phase: &str,
        targets: &[TargetTest],
    ) -> Result<(Outcome, Vec<String>), Failure> {
        let emulator = emulator.for_targets(targets);
        let outcome = self.infer_for(phase, &emulator, targets, self.file.calibration.inadequacy)?.outcome;
        let lines = self.fit(targets, Some(&emulator), &outcome, &[])?.lines();
        let against: Vec<String> = lines.iter().map(|line| format!("{phase}: {line}")).collect();
        against.iter().for_each(|line| self.context.warn(line));
        Ok((outcome, against))
    }

    /// The surrogate and the simulations from which it learned.
    pub fn learned(&self) -> Result<(Emulator<'_>, Vec<KnownRun>), Failure> {
        let (numbers, known) = self.known()?;
        Ok((self.emulator(numbers, &known)?, known))
    }
}

/// A row for each test and parameter: mean and quantiles.
fn parameters_table(found: &[(String, Outcome)]) -> Result<Table, Failure> {
    let (mut tests, mut names) = (Vec::new(), Vec::new());
    let mut numbers: [Vec<f64>; 4] = Default::default();
    for (test, outcome) in found {
        let mean = outcome.mean();
        for (k, name) in outcome.names.iter().enumerate() {
            tests.push(test.clone());
            names.push(name.clone());
            let sorted = outcome.sorted(k);
            let at = |share| granum_calibration::draws::diagnostics::quantile_of_sorted(&sorted, share);
            for (numbers, value) in numbers.iter_mut().zip([mean[k], at(0.05), at(0.5), at(0.95)]) {
                numbers.push(value);
            }
        }
    }
    let names_of = ["mean", "quantile_5", "median", "quantile_95"];
    let mut columns = vec![Column::of_words("test", tests), Column::of_words("parameter", names)];
    columns.extend(names_of.iter().zip(numbers).map(|(name, values)| Column::new(*name, "", values)));
    Ok(Table::new(columns)?)
}
