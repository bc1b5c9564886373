//! What tests can tell of the free parameters before anything is inferred: Sobol indices of each compared curve, and identifiability by
//! each quantity alone and by all together.

use serde::{Deserialize, Serialize};

use crate::compared::curve::{ForwardModel, MeasuredCurve};
use crate::error::{CalibrationError, Result};
use crate::inference::likelihood::FreeParameter;
use crate::questions::identifiability::{Identifiability, identifiability};
use crate::questions::sensitivity::{Sensitivity, sensitivities};

/// Points of the priors at which identifiability is asked.
const POINTS: u32 = 8;
/// Points from which Sobol indices are estimated, times the number of parameters and two.
const SOBOL_POINTS: usize = 128;
/// A total index below this is none.
const NOTHING: f64 = 0.02;

/// What tests can tell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WhatTestsTell {
    /// Names of the parameters.
    pub parameters: Vec<String>,
    /// Test and quantity of each compared curve.
    pub curves: Vec<[String; 2]>,
    /// Sobol indices of each compared curve.
    pub sensitivities: Vec<Sensitivity>,
    /// Identifiability by each quantity alone, of all tests.
    pub by_quantity: Vec<(String, Identifiability)>,
    /// Identifiability by everything that is compared.
    pub together: Identifiability,
}

impl WhatTestsTell {
    /// Asks a model what the curves tell.
    ///
    /// # Errors
    /// If the model has no prediction at a point of the priors.
    pub fn new(
        parameters: &[FreeParameter],
        curves: &[MeasuredCurve],
        model: &dyn ForwardModel,
        seed: u32,
        threads: usize,
    ) -> Result<WhatTestsTell> {
        let values = |shares: &[f64]| -> Vec<f64> {
            parameters.iter().zip(shares).map(|(free, share)| free.prior.value(inside(*share))).collect()
        };
        let means = |shares: &[f64]| {
            let predicted = model.predict(&values(shares)).ok_or_else(|| {
                CalibrationError::Input(format!(
                    "there is no prediction at the parameters {:?}",
                    values(shares)
                ))
            })?;
            Ok(predicted.into_iter().map(|curve| curve.mean).collect())
        };
        let sensitivities = sensitivities(parameters.len(), SOBOL_POINTS, seed, threads, means)?;
        let points = points_of_priors(parameters.len(), seed);
        let ask = |chosen: &[usize]| identifiability(parameters, curves, chosen, model, &points);
        let mut by_quantity: Vec<(String, Identifiability)> = Vec::new();
        for curve in curves {
            if by_quantity.iter().any(|(known, _)| *known == curve.quantity) {
                continue;
            }
            let own: Vec<usize> =
                (0..curves.len()).filter(|k| curves[*k].quantity == curve.quantity).collect();
            by_quantity.push((curve.quantity.clone(), ask(&own)?));
        }
        Ok(WhatTestsTell {
            parameters: parameters.iter().map(|free| free.name.clone()).collect(),
            curves: curves.iter().map(|curve| [curve.test.clone(), curve.quantity.clone()]).collect(),
            sensitivities,
            by_quantity,
            together: ask(&(0..curves.len()).collect::<Vec<_>>())?,
        })
    }

    /// Warnings in words: parameters that the tests do not see or do not separate, with what would help.
    pub fn warnings(&self) -> Vec<String> {
        let name = |k: usize| self.parameters[k].replace('_', " ");
        let words: Vec<String> =
            self.by_quantity.iter().map(|(quantity, _)| quantity.replace('_', " ")).collect();
        let compared = words.join(" and ");
        let help = match self.by_quantity.iter().any(|(quantity, _)| quantity == "volumetric_strain") {
            false => "compare the volumetric strain as well, or add a test at another density or stress",
            true => "add a test at another density or stress, or state a narrower prior",
        };
        let mut told = Vec::new();
        for k in self.together.not_seen() {
            told.push(format!(
                "{compared} of these tests tell next to nothing of {}, whose posterior will be its prior",
                name(k)
            ));
        }
        for [i, j] in self.together.not_separated() {
            let correlation = self.together.correlation[i * self.parameters.len() + j];
            told.push(format!(
                "{compared} of these tests do not separate {} from {} (correlation {correlation:.2}); {help}",
                name(i),
                name(j)
            ));
        }
        told
    }

    /// A line for each parameter: how much of its prior the curves leave, and which quantity depends on it most.
    pub fn lines(&self) -> Vec<String> {
        let line = |k: usize| {
            let total = |curve: &usize| self.sensitivities[*curve].total[k].value;
            let most = (0..self.curves.len()).max_by(|a, b| total(a).total_cmp(&total(b)));
            let seen = match most.filter(|curve| total(curve) > NOTHING) {
                Some(curve) => {
                    let [test, quantity] = &self.curves[curve];
                    format!(
                        "total Sobol index {:.2} of {} of {test}",
                        total(&curve),
                        quantity.replace('_', " ")
                    )
                }
                None => "no compared curve depends on it".into(),
            };
            format!(
                "{}: {:.0} % of its prior's width would be left ({:.0} % with the others known); {seen}",
                self.parameters[k],
                100.0 * self.together.contraction[k],
                100.0 * self.together.alone[k]
            )
        };
        (0..self.parameters.len()).map(line).collect()
    }
}

/// The points of the priors, as shares, at which it is asked what curves tell.
pub(crate) fn points_of_priors(parameters: usize, seed: u32) -> Vec<Vec<f64>> {
    let coordinate = |k: u32, j: usize| inside(f64::from(sobol_burley::sample(k, j as u32, seed)));
    (0..POINTS).map(|k| (0..parameters).map(|j| coordinate(k, j)).collect()).collect()
}

/// A share at which every prior is finite.
fn inside(share: f64) -> f64 {
    share.clamp(0.005, 0.995)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compared::curve::PredictedCurve;
    use crate::inference::prior::Prior;

    fn constant(value: f64) -> PredictedCurve {
        PredictedCurve { mean: vec![value; 2], ..PredictedCurve::default() }
    }

    #[test]
    fn what_is_not_separated_is_said_with_what_would_help() {
        let uniform =
            |name: &str| FreeParameter { name: name.into(), prior: Prior::Uniform { from: 0.0, to: 1.0 } };
        let parameters = ["friction", "rolling_friction", "modulus"].map(uniform);
        let sum = |values: &[f64]| Some(vec![constant(values[0] + values[1])]);
        let told = WhatTestsTell::new(&parameters, &[MeasuredCurve::of_ones("deviator_stress")], &sum, 1, 1)
            .unwrap();
        let warnings = told.warnings();
        assert!(warnings[0].contains("next to nothing of modulus"), "{warnings:?}");
        let parts =
            ["deviator stress", "do not separate friction from rolling friction", "volumetric strain"];
        assert!(parts.iter().all(|part| warnings[1].contains(part)), "{warnings:?}");
        assert!(told.lines()[2].contains("no compared curve depends on it"), "{:?}", told.lines());
        let both =
            |values: &[f64]| Some(vec![constant(values[0] + values[1]), constant(values[0] - values[1])]);
        let curves = [MeasuredCurve::of_ones("deviator_stress"), MeasuredCurve::of_ones("volumetric_strain")];
        let told = WhatTestsTell::new(&parameters, &curves, &both, 1, 1).unwrap();
        assert_eq!(told.warnings().len(), 1, "{:?}", told.warnings());
        assert!((told.sensitivities[0].first[0].value - 0.5).abs() < 0.05, "{:?}", told.sensitivities[0]);
    }
}
