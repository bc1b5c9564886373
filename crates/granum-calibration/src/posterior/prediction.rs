//! Predictions of tests from a posterior, with intervals that hold what a laboratory would read, and their errors.

use granum_core::{Column, Table};
use serde::{Deserialize, Serialize};

use crate::compared::curve::MeasuredCurve;
use crate::error::Result;
use crate::file::CalibrationFile;
use crate::posterior::band::{BAND_DRAWS, Band};
use crate::posterior::outcome::Outcome;
use crate::simulations::emulator::Emulator;
use crate::simulations::target::TargetTest;

/// A predicted curve beside the readings of its test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// The test.
    pub test: String,
    /// The quantity, such as `deviator_stress`.
    pub quantity: String,
    /// Axial strains.
    pub axial_strain: Vec<f64>,
    /// Readings of the laboratory, in SI units.
    pub measured: Vec<f64>,
    /// Mean of the prediction.
    pub mean: Vec<f64>,
    /// Half the width of the interval of 90 %: of the posterior, the surrogate, the inadequacy of the model and the measurement.
    pub half_width: Vec<f64>,
}

impl Prediction {
    /// Root mean square difference between prediction and readings.
    pub fn error(&self) -> f64 {
        let square: f64 = self.mean.iter().zip(&self.measured).map(|(a, b)| (a - b) * (a - b)).sum();
        (square / self.mean.len().max(1) as f64).sqrt()
    }

    /// The error over the largest reading of the test.
    pub fn relative_error(&self) -> f64 {
        self.error() / self.measured.iter().fold(1e-300, |most: f64, y| most.max(y.abs()))
    }

    /// Share of the readings that the intervals hold.
    pub fn share_inside(&self) -> f64 {
        let apart = self.mean.iter().zip(&self.measured).map(|(a, b)| (a - b).abs());
        let inside = apart.zip(&self.half_width).filter(|(apart, half)| apart <= half).count();
        inside as f64 / self.mean.len().max(1) as f64
    }
}

/// Predicts one of the targets of an emulator.
///
/// The variance of a reading is the sum of that between draws, of the surrogate, of the measurement, and of the inadequacy `(s_k r)^2`, with the
/// size `s_k` of the draw k and the root mean square r of the predicted curve.
///
/// # Errors
/// If an expression of the file has no value at a draw.
pub fn predict(
    file: &CalibrationFile,
    emulator: &Emulator,
    targets: &[TargetTest],
    test: usize,
    outcome: &Outcome,
) -> Result<Vec<Prediction>> {
    let draws = outcome.spread(BAND_DRAWS);
    let predict_curve = |(place, curve): &(usize, MeasuredCurve)| {
        let error = file.calibration.quantities[*place].error;
        let size = outcome.names.iter().position(|name| *name == format!("{}_discrepancy", curve.quantity));
        let further = |draw: &[f64], mean: &[f64]| {
            let size = size.map_or(0.0, |at| draw[at]);
            let square = mean.iter().map(|y| y * y).sum::<f64>() / mean.len() as f64;
            mean.iter().map(|y| error.deviation(*y).powi(2) + size * size * square).collect()
        };
        let band = Band::new(emulator, &draws, (test, *place), &curve.strain, further)?;
        Ok(Prediction {
            test: targets[test].name.clone(),
            quantity: curve.quantity.clone(),
            axial_strain: curve.strain.clone(),
            measured: curve.measured.clone(),
            half_width: band.half_width,
            mean: band.mean,
        })
    };
    targets[test].curves.iter().map(predict_curve).collect()
}

/// A row for each reading: test, quantity, axial strain, reading, prediction and the ends of its interval of 90 %, in SI units.
///
/// # Errors
/// If the columns do not make a table.
pub fn readings_table(predictions: &[Prediction]) -> Result<Table> {
    let words = |word: fn(&Prediction) -> &String| -> Vec<String> {
        predictions.iter().flat_map(|one| vec![word(one).clone(); one.mean.len()]).collect()
    };
    let numbers = |name: &str, value: &dyn Fn(&Prediction, usize) -> f64| {
        let values = predictions.iter().flat_map(|one| (0..one.mean.len()).map(|i| value(one, i)));
        Column::new(name, "", values.collect())
    };
    let columns = vec![
        Column::of_words("test", words(|one| &one.test)),
        Column::of_words("quantity", words(|one| &one.quantity)),
        numbers("axial_strain", &|one, i| one.axial_strain[i]),
        numbers("measured", &|one, i| one.measured[i]),
        numbers("predicted", &|one, i| one.mean[i]),
        numbers("low", &|one, i| one.mean[i] - one.half_width[i]),
        numbers("high", &|one, i| one.mean[i] + one.half_width[i]),
    ];
    Ok(Table::new(columns).map_err(granum_learn::LearnError::from)?)
}

/// A row for each curve: its root mean square error, that over the largest reading, and the share of readings inside the intervals.
///
/// # Errors
/// If the columns do not make a table.
pub fn errors_table(predictions: &[Prediction]) -> Result<Table> {
    let numbers = |name: &str, value: fn(&Prediction) -> f64| {
        Column::new(name, "", predictions.iter().map(value).collect())
    };
    let columns = vec![
        Column::of_words("test", predictions.iter().map(|one| one.test.clone())),
        Column::of_words("quantity", predictions.iter().map(|one| one.quantity.clone())),
        numbers("error", Prediction::error),
        numbers("error_over_largest", Prediction::relative_error),
        numbers("share_inside", Prediction::share_inside),
    ];
    Ok(Table::new(columns).map_err(granum_learn::LearnError::from)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_prediction_by_hand() {
        let one = Prediction {
            test: "T".into(),
            quantity: "deviator_stress".into(),
            axial_strain: vec![0.01, 0.02],
            measured: vec![3.0, 10.0],
            mean: vec![0.0, 6.0],
            half_width: vec![2.9, 4.1],
        };
        assert!((one.error() - 12.5f64.sqrt()).abs() < 1e-12);
        assert!((one.relative_error() - 12.5f64.sqrt() / 10.0).abs() < 1e-12);
        assert_eq!(one.share_inside(), 0.5);
        let table = readings_table(std::slice::from_ref(&one)).unwrap();
        assert_eq!(table.values("high").unwrap(), [2.9, 10.1]);
        assert_eq!(errors_table(&[one]).unwrap().values("share_inside").unwrap(), [0.5]);
    }
}
