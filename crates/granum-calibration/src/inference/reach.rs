//! What the priors reach: whether any value of the parameters comes near to the readings of a test.
//!
//! A posterior says which values explain the readings best, also where none explains them. It is therefore asked first how far the readings lie
//! from all that a model gives within the priors. With the reading y of a strain, the prediction m there and the deviation
//! `s = sqrt(measurement^2 + prediction^2 + (scale r)^2)` with the scale of the inadequacy and the root mean square r of the curve, the distance of
//! a prediction is `(y - m) / s`. A curve lies beyond the reach of the priors if, at half of its strains at least, all predictions are on the same
//! side of the reading, each [`FAR`] deviations or more and [`GAP`] of the largest reading away.

use granum_core::quantity::format_number;
use granum_core::words;
use serde::{Deserialize, Serialize};

use crate::compared::curve::{MeasuredCurve, PredictedCurve};
use crate::inference::likelihood::{Discrepancy, FreeParameter};

/// Deviations between a reading and a prediction beyond which one does not explain the other.
const FAR: f64 = 4.0;
/// The same over the largest reading of the curve.
const GAP: f64 = 0.25;
/// Share of the strains of a curve that must be out of reach.
const SHARE: f64 = 0.5;
/// Points of the priors at which a model is asked, beside their corners.
const POINTS: u32 = 512;
/// Most parameters of whose priors all corners are asked.
const MOST_CORNERS: usize = 8;
/// Share of a prior that stands for its end: a normal prior has none.
const END: f64 = 0.001;

/// A curve that lies beyond everything that the priors reach.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BeyondReach {
    /// The test.
    pub test: String,
    /// The quantity.
    pub quantity: String,
    /// Number of the strains at which readings are out of reach.
    pub strains: usize,
    /// Number of the compared strains.
    pub of: usize,
    /// The axial strain where the reading is farthest from what can be reached.
    pub strain: f64,
    /// The reading there.
    pub reading: f64,
    /// The nearest prediction there.
    pub nearest: f64,
}

impl BeyondReach {
    /// What is out of reach, as a sentence.
    pub fn line(&self) -> String {
        let BeyondReach { test, quantity, strains, of, strain, reading, nearest } = self;
        let [side, end] = match reading > nearest {
            true => ["above", "largest"],
            false => ["below", "smallest"],
        };
        let [reading, nearest] = [reading, nearest].map(|value| shown(*value, quantity));
        format!(
            "{} of {test}: at {strains} of {of} strains the readings lie far {side} everything that the priors reach; at an axial strain of {} \
             {reading} was measured, and {nearest} is the {end} that any value of the parameters gives",
            quantity.replace('_', " "),
            words::percent(*strain, 3)
        )
    }
}

/// A value of a quantity in the unit in which it is readable.
pub(crate) fn shown(value: f64, quantity: &str) -> String {
    if ["stress", "pressure"].iter().any(|end| quantity.ends_with(end)) {
        return format!("{} kPa", digits(value / 1e3));
    }
    if quantity.ends_with("strain") {
        return format!("{} %", digits(100.0 * value));
    }
    digits(value)
}

/// A number with three digits; zero has no sign.
pub(crate) fn digits(value: f64) -> String {
    format!("{value:.2e}")
        .parse::<f64>()
        .map_or_else(|_| value.to_string(), |value| format_number(value + 0.0))
}

/// Values of the parameters that fill their priors, and the corners of these.
pub fn values_of_priors(parameters: &[FreeParameter], seed: u32) -> Vec<Vec<f64>> {
    let value = |(k, share): (usize, f64)| parameters[k].prior.value(share.clamp(END, 1.0 - END));
    let filling = (0..POINTS).map(|k| -> Vec<f64> {
        let share = |j: usize| f64::from(sobol_burley::sample(k, j as u32, seed));
        (0..parameters.len()).map(|j| value((j, share(j)))).collect()
    });
    let corners = if parameters.len() > MOST_CORNERS { 0 } else { 1usize << parameters.len() };
    let corner = |corner: usize| -> Vec<f64> {
        (0..parameters.len()).map(|j| value((j, ((corner >> j) & 1) as f64))).collect()
    };
    filling.chain((0..corners).map(corner)).collect()
}

/// The curves that no prediction comes near to; each prediction has the measured curves in their order. Nothing is out of reach of no predictions.
pub fn beyond_reach<'a>(
    curves: &[MeasuredCurve],
    predictions: impl Iterator<Item = &'a [PredictedCurve]>,
    inadequacy: Option<Discrepancy>,
) -> Vec<BeyondReach> {
    let mut nearest: Vec<Vec<Nearest>> =
        curves.iter().map(|curve| vec![Nearest::default(); curve.strain.len()]).collect();
    for predicted in predictions {
        for ((curve, predicted), nearest) in curves.iter().zip(predicted).zip(&mut nearest) {
            let width = curve.strain.len();
            let mean_square = curve.measured.iter().map(|y| y * y).sum::<f64>() / width as f64;
            let scale = inadequacy.map_or(0.0, |inadequacy| inadequacy.scale);
            for (k, (reading, mean)) in curve.measured.iter().zip(&predicted.mean).enumerate() {
                let variance = curve.error.deviation(*reading).powi(2)
                    + predicted.covariance.get(k * width + k).copied().unwrap_or(0.0).max(0.0)
                    + scale * scale * mean_square;
                nearest[k].see(reading - mean, variance.sqrt(), *mean);
            }
        }
    }
    curves.iter().zip(&nearest).filter_map(|(curve, nearest)| of_curve(curve, nearest)).collect()
}

fn of_curve(curve: &MeasuredCurve, nearest: &[Nearest]) -> Option<BeyondReach> {
    let largest = curve.measured.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    let is_far = |one: &&(usize, &Nearest)| one.1.deviations() > FAR && one.1.apart() > GAP * largest;
    let numbered: Vec<(usize, &Nearest)> = nearest.iter().enumerate().collect();
    let far: Vec<&(usize, &Nearest)> = numbered.iter().filter(is_far).collect();
    if far.is_empty() || (far.len() as f64) < SHARE * nearest.len() as f64 {
        return None;
    }
    let (at, worst) = far.iter().max_by(|a, b| a.1.apart().total_cmp(&b.1.apart()))?;
    Some(BeyondReach {
        test: curve.test.clone(),
        quantity: curve.quantity.clone(),
        strains: far.len(),
        of: nearest.len(),
        strain: curve.strain[*at],
        reading: curve.measured[*at],
        nearest: worst.value,
    })
}

/// The prediction that is nearest to a reading.
#[derive(Clone, Copy, Debug, Default)]
struct Nearest {
    /// True if a prediction was seen.
    is_known: bool,
    /// True if predictions lie on both sides of the reading.
    is_reached: bool,
    /// The smallest distance in deviations, with its sign.
    deviations: f64,
    /// The smallest difference, with its sign, and the prediction that has it.
    apart: f64,
    value: f64,
}

impl Nearest {
    fn see(&mut self, apart: f64, deviation: f64, value: f64) {
        let deviations = apart / deviation.max(f64::MIN_POSITIVE);
        if deviations.is_nan() {
            return;
        }
        if !self.is_known {
            *self = Nearest { is_known: true, is_reached: false, deviations, apart, value };
            return;
        }
        self.is_reached |= (apart > 0.0) != (self.apart > 0.0);
        if deviations.abs() < self.deviations.abs() {
            self.deviations = deviations;
        }
        if apart.abs() < self.apart.abs() {
            (self.apart, self.value) = (apart, value);
        }
    }

    fn deviations(&self) -> f64 {
        if self.is_known && !self.is_reached { self.deviations.abs() } else { 0.0 }
    }

    fn apart(&self) -> f64 {
        if self.is_known && !self.is_reached { self.apart.abs() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compared::curve::MeasurementError;
    use crate::inference::prior::Prior;

    fn curve(factor: f64) -> MeasuredCurve {
        MeasuredCurve {
            test: "T1".into(),
            quantity: "deviator_stress".into(),
            strain: vec![0.01, 0.02, 0.03, 0.04],
            measured: [80e3, 90e3, 100e3, 90e3].map(|q| factor * q).to_vec(),
            error: MeasurementError { absolute: 1e3, relative: 0.02, correlation_strain: 0.02 },
            weight: 1.0,
        }
    }

    fn found(curve: &MeasuredCurve, factors: &[f64]) -> Vec<BeyondReach> {
        let predicted: Vec<[PredictedCurve; 1]> = factors
            .iter()
            .map(|factor| {
                let mean = [80e3, 90e3, 100e3, 90e3].map(|q| factor * q).to_vec();
                [PredictedCurve { mean, covariance: Vec::new(), across: Vec::new() }]
            })
            .collect();
        let all = predicted.iter().map(|one| one.as_slice());
        beyond_reach(std::slice::from_ref(curve), all, Some(Discrepancy::default()))
    }

    #[test]
    fn readings_above_and_below_everything_are_out_of_reach() {
        for (factor, side, largest) in [(3.0, "far above", "130 kPa"), (0.2, "far below", "70 kPa")] {
            let all = found(&curve(factor), &[0.7, 1.0, 1.3]);
            assert_eq!((all.len(), all[0].strains, all[0].of), (1, 4, 4), "{all:?}");
            let line = all[0].line();
            assert!(line.contains(side) && line.contains(largest) && line.contains("3.000 %"), "{line}");
        }
    }

    #[test]
    fn what_lies_between_predictions_or_near_to_one_is_within_reach() {
        assert_eq!(found(&curve(1.1), &[0.7, 1.3]), []);
        // Further than the errors say, but by little.
        assert_eq!(found(&curve(1.5), &[0.7, 1.3]), []);
        // Nothing is known.
        assert_eq!(found(&curve(3.0), &[]), []);
        // A prediction that has no value tells nothing.
        assert_eq!(found(&curve(3.0), &[f64::NAN]), []);
        // Two of four strains are enough, and one is not.
        let mut bent = curve(1.0);
        bent.measured[1] = 400e3;
        assert_eq!(found(&bent, &[1.0]), []);
        bent.measured[2] = 400e3;
        assert_eq!(found(&bent, &[1.0])[0].strains, 2);
    }

    #[test]
    fn priors_are_asked_at_their_corners_as_well() {
        let parameter =
            |name: &str| FreeParameter { name: name.into(), prior: Prior::Uniform { from: 0.0, to: 1.0 } };
        let all = values_of_priors(&["a", "b"].map(parameter), 1);
        assert_eq!(all.len(), POINTS as usize + 4);
        assert!(all.iter().any(|values| values[0] < 0.002 && values[1] > 0.998), "a corner is missing");
        let spread = all.iter().filter(|values| values[0] < 0.5).count();
        assert!(spread.abs_diff(all.len() / 2) < 5, "{spread}");
    }
}
