//! Confirmation: real simulations at draws from the posterior, beside what the surrogate said of them and over the laboratory.

use granum_nets::normal::NINETY_PERCENT;
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::file::CalibrationFile;
use crate::simulations::emulator::{Emulator, at_strains};
use crate::simulations::simulation::{DesignPoint, Simulated, of_test};
use crate::simulations::target::TargetTest;

/// Share of the curves that may leave their intervals: a tenth does by chance.
pub const MOST_OUTSIDE: f64 = 0.25;

/// The simulations of so many tests at draws of all parameters.
pub fn simulations(file: &CalibrationFile, tests: usize, draws: &[Vec<f64>]) -> Vec<DesignPoint> {
    let of_draw = |draw: &Vec<f64>| -> Vec<DesignPoint> {
        (0..tests).map(|test| DesignPoint { test, values: of_test(file, tests, draw, test) }).collect()
    };
    draws.iter().flat_map(of_draw).collect()
}

/// A compared curve of a simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Confirmed {
    /// The test.
    pub test: String,
    /// The quantity.
    pub quantity: String,
    /// Name of the run.
    pub run: String,
    /// Root mean square difference of the simulation from the laboratory, over the largest reading of the test.
    pub misfit: f64,
    /// The same of the surrogate's mean.
    pub misfit_of_surrogate: Option<f64>,
    /// Root mean square difference of the simulation from the surrogate's mean, over the surrogate's standard deviation.
    pub deviations: Option<f64>,
}

impl Confirmed {
    /// True if the simulation differs from the surrogate by more than its interval of 90 %.
    pub fn is_outside(&self) -> bool {
        self.deviations.is_some_and(|deviations| deviations > NINETY_PERCENT)
    }
}

/// Compares simulations with the laboratory and, if there is one, with the surrogate, which did not learn from them.
///
/// # Errors
/// If the surrogate has no prediction.
pub fn confirm(
    file: &CalibrationFile,
    targets: &[TargetTest],
    simulated: &[Simulated],
    draws: &[Vec<f64>],
    emulator: Option<&Emulator>,
) -> Result<Vec<Confirmed>> {
    let mut found = Vec::new();
    for one in simulated {
        let target = &targets[one.simulation.test];
        let draw = draws
            .iter()
            .find(|draw| of_test(file, targets.len(), draw, one.simulation.test) == one.simulation.values);
        let strains = |place: usize| {
            target.curves.iter().find(|(known, _)| *known == place).map(|(_, curve)| curve.strain.clone())
        };
        let predicted = match (emulator, draw) {
            (Some(emulator), Some(draw)) => emulator.predict_test(draw, one.simulation.test, strains)?,
            _ => Vec::new(),
        };
        for (place, curve) in &target.curves {
            let quantity = file.calibration.quantities[*place].quantity;
            let simulation = at_strains(&one.curves, quantity, &curve.strain);
            let largest = curve.measured.iter().fold(0.0, |most: f64, y| most.max(y.abs())).max(1e-300);
            let apart = |a: &[f64], b: &[f64]| {
                let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
                (square / a.len() as f64).sqrt()
            };
            let predicted = predicted.get(*place).and_then(Option::as_ref);
            let deviations = predicted.map(|predicted| {
                let count = curve.strain.len();
                let square = |k: usize| {
                    let variance = predicted.covariance[k * count + k].max(1e-300);
                    (simulation[k] - predicted.mean[k]).powi(2) / variance
                };
                ((0..count).map(square).sum::<f64>() / count as f64).sqrt()
            });
            found.push(Confirmed {
                test: target.name.clone(),
                quantity: curve.quantity.clone(),
                run: one.name.clone(),
                misfit: apart(&simulation, &curve.measured) / largest,
                misfit_of_surrogate: predicted.map(|p| apart(&p.mean, &curve.measured) / largest),
                deviations,
            });
        }
    }
    Ok(found)
}

/// The share of the curves whose simulations leave the intervals of the surrogate; `None` if nothing was compared with a surrogate.
pub fn share_outside(confirmed: &[Confirmed]) -> Option<f64> {
    let compared = confirmed.iter().filter(|one| one.deviations.is_some()).count();
    let outside = confirmed.iter().filter(|one| one.is_outside()).count();
    (compared > 0).then(|| outside as f64 / compared as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_outside_needs_something_that_was_compared() {
        let one = |deviations: Option<f64>| Confirmed {
            test: "T".into(),
            quantity: "deviator_stress".into(),
            run: "a".into(),
            misfit: 0.1,
            misfit_of_surrogate: None,
            deviations,
        };
        assert_eq!(share_outside(&[]), None);
        assert_eq!(share_outside(&[one(None)]), None);
        assert_eq!(share_outside(&[one(Some(1.0)), one(Some(2.0)), one(None)]), Some(0.5));
    }
}
