//! The band of a curve: what the surrogate predicts over draws from a posterior, with the interval of 90 %.

use granum_nets::normal::NINETY_PERCENT;

use crate::error::Result;
use crate::simulations::emulator::Emulator;

/// Draws of which a band is made.
pub const BAND_DRAWS: usize = 100;

/// The mean of a prediction and half the width of its interval of 90 %.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Band {
    /// Mean over the draws.
    pub mean: Vec<f64>,
    /// Half the width of the interval of 90 % of a normal distribution, whose variance is that of the means of the draws plus the mean of
    /// their own variances.
    pub half_width: Vec<f64>,
}

impl Band {
    /// The band of a quantity, by its place in the file, of one of the targets of the surrogate at the given strains.
    ///
    /// The variance of a draw is that of the surrogate and `further(draw, mean)`, which has a value for each strain.
    ///
    /// # Errors
    /// If an expression of the file has no value at a draw.
    pub fn new(
        emulator: &Emulator,
        draws: &[Vec<f64>],
        (test, place): (usize, usize),
        strain: &[f64],
        further: impl Fn(&[f64], &[f64]) -> Vec<f64>,
    ) -> Result<Band> {
        let mut predicted = Vec::new();
        for draw in draws {
            let wanted = |other: usize| (other == place).then(|| strain.to_vec());
            for one in emulator.predict_test(draw, test, wanted)?.into_iter().flatten() {
                let width = one.mean.len();
                let own = (0..width).map(|k| one.covariance.get(k * width + k).copied().unwrap_or(0.0));
                let variance = own.zip(further(draw, &one.mean)).map(|(a, b)| a + b).collect();
                predicted.push((one.mean, variance));
            }
        }
        Ok(Band::from_predictions(&predicted))
    }

    /// From the mean and the variance of each draw.
    fn from_predictions(predicted: &[(Vec<f64>, Vec<f64>)]) -> Band {
        let number = predicted.len().max(1) as f64;
        let width = predicted.first().map_or(0, |(mean, _)| mean.len());
        let mean: Vec<f64> =
            (0..width).map(|k| predicted.iter().map(|(one, _)| one[k]).sum::<f64>() / number).collect();
        let half = |k: usize| {
            let square = |(one, own): &(Vec<f64>, Vec<f64>)| (one[k] - mean[k]) * (one[k] - mean[k]) + own[k];
            NINETY_PERCENT * (predicted.iter().map(square).sum::<f64>() / number).sqrt()
        };
        Band { half_width: (0..width).map(half).collect(), mean }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Golden: means of 0 and 2 have the mean 1 and the variance 1, to which the mean of 3 and 5 is added.
    #[test]
    fn variances_between_and_within_draws_are_added() {
        let predicted = [(vec![0.0, 1.0], vec![3.0, 0.0]), (vec![2.0, 1.0], vec![5.0, 0.0])];
        let band = Band::from_predictions(&predicted);
        assert_eq!(band.mean, [1.0, 1.0]);
        assert!((band.half_width[0] - NINETY_PERCENT * 5.0f64.sqrt()).abs() < 1e-12);
        assert_eq!(band.half_width[1], 0.0);
        assert_eq!(Band::from_predictions(&[]), Band::default());
    }
}
