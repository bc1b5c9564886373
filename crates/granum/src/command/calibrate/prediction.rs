//! Predictions of tests that were not calibrated on.

use granum_calibration::posterior::prediction::{Prediction, errors_table, predict, readings_table};
use granum_calibration::simulations::emulator::Emulator;
use granum_io::write_table;

use super::calibration::Calibration;
use super::infer::Found;
use crate::failure::Failure;

/// Readings of predicted tests beside their predictions, and the errors.
const FILES: [&str; 2] = ["predictions.csv", "prediction-errors.csv"];

impl Calibration<'_> {
    /// Predicts all tests by the surrogate, first those that were calibrated on, and writes the tables.
    pub fn predictions(&self, found: &Found, emulator: &Emulator) -> Result<Vec<Prediction>, Failure> {
        let all = emulator.for_targets(self.all);
        let mut predictions = Vec::new();
        for test in 0..self.all.len() {
            predictions.extend(predict(self.file, &all, self.all, test, &found.outcome)?);
        }
        write_table(self.out.join(FILES[0]), &readings_table(&predictions)?)?;
        write_table(self.out.join(FILES[1]), &errors_table(&predictions)?)?;
        Ok(predictions)
    }
}

/// A line for each predicted curve, and the means of each quantity.
pub fn summary(predictions: &[Prediction]) -> Vec<String> {
    let line = |one: &Prediction| {
        format!(
            "  {} {}: {:.1} % of the largest reading; intervals of 90 % hold {:.0} % of the readings",
            one.test,
            one.quantity.replace('_', " "),
            100.0 * one.relative_error(),
            100.0 * one.share_inside()
        )
    };
    let mut lines: Vec<String> = predictions.iter().map(line).collect();
    let mut told: Vec<&str> = Vec::new();
    for one in predictions {
        if told.contains(&one.quantity.as_str()) {
            continue;
        }
        told.push(&one.quantity);
        let own: Vec<&Prediction> =
            predictions.iter().filter(|other| other.quantity == one.quantity).collect();
        let mean = |value: fn(&Prediction) -> f64| {
            100.0 * own.iter().map(|one| value(one)).sum::<f64>() / own.len() as f64
        };
        lines.push(format!(
            "  all {}: {:.1} %; {:.0} %",
            one.quantity.replace('_', " "),
            mean(Prediction::relative_error),
            mean(Prediction::share_inside)
        ));
    }
    lines
}
