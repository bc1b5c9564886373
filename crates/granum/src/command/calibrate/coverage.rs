//! `granum calibrate --coverage N`: whether the intervals hold the truth, on simulations at known parameters in place of the tests.

use granum_calibration::posterior::confirmation::simulations;
use granum_calibration::posterior::coverage::{Coverage, coverage, synthetic, truths};
use granum_calibration::posterior::outcome::Outcome;
use granum_calibration::simulations::target::TargetTest;
use granum_io::shell::ShowPath;
use granum_io::{Column, Table, write_table};
use serde_json::json;

use super::calibration::Calibration;
use super::simulate::Runs;
use crate::failure::Failure;
use crate::{command::text_table, output};

/// Number of the campaign of truths, by which its samples have seeds that nobody learned from.
const NUMBER: usize = 100_000;
/// The file of the result.
const FILE: &str = "coverage.csv";

impl Calibration<'_> {
    /// Counts how often the intervals of 90 % hold the parameters of so many synthetic targets.
    pub fn coverage(&self, count: usize) -> Result<(), Failure> {
        let tests = self.targets.len();
        let truths = truths(&self.parameters, count, self.file.calibration.seed);
        let wanted = simulations(self.file, tests, &truths);
        let Runs { simulated } = self.simulate("coverage", NUMBER, &wanted)?;
        let (emulator, _) = self.learned()?;
        let mut posteriors: Vec<(Vec<f64>, Outcome)> = Vec::new();
        for (number, (truth, wanted)) in truths.into_iter().zip(wanted.chunks(tests)).enumerate() {
            let own = wanted.iter().map(|wanted| simulated.iter().find(|one| one.simulation == *wanted));
            let Some(own) = own.collect::<Option<Vec<_>>>() else {
                self.context.warn(&format!(
                    "target {}: a simulation of it is not used, and so neither is it",
                    number + 1
                ));
                continue;
            };
            let targets = self
                .targets
                .iter()
                .zip(own)
                .map(|(target, one)| synthetic(self.file, target, &one.curves, number as u64))
                .collect::<Result<Vec<TargetTest>, _>>()?;
            // The simulations are what the model says, so that it is not inadequate.
            let phase = format!("target {} of {count}", number + 1);
            let found = self.infer_for(&phase, &emulator.for_targets(&targets), &targets, None)?;
            posteriors.push((truth, found.outcome));
        }
        let found = coverage(&self.parameters, &posteriors);
        let table = table(&found)?;
        let path = self.out.join(FILE);
        write_table(&path, &table)?;
        let result = json!({ "folder": output::path(&self.out), "coverage": found });
        output::say_complete(self.context, &self.out, &result, || {
            let mut lines = text_table::lines(&table);
            lines.push(format!(
                "intervals of 90 % that hold the parameters of {} synthetic targets, simulations with samples that nobody learned from; width: over \
                 that of the prior",
                posteriors.len()
            ));
            lines.push(format!("wrote {}", path.shown()));
            lines.join("\n")
        })
    }
}

fn table(found: &[Coverage]) -> Result<Table, Failure> {
    let numbers =
        |name: &str, value: fn(&Coverage) -> f64| Column::new(name, "", found.iter().map(value).collect());
    Ok(Table::new(vec![
        Column::of_words("parameter", found.iter().map(|one| one.parameter.clone())),
        numbers("inside", |one| one.inside as f64),
        numbers("intervals", |one| one.intervals as f64),
        numbers("width", |one| one.width),
    ])?)
}
