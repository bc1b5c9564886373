//! Priors: what is known of a property before the laboratory is asked.
//!
//! Inference works on shares: a share of 0.3 stands for the value below which 30 % of the prior lie. In shares every prior is uniform on
//! [0, 1], has bounds where it has them, and scales do not matter.

use granum_nets::normal::{quantile, share_below};
use libm::{exp, log};
use serde::{Deserialize, Serialize};

use crate::error::CalibrationError;

/// A prior of one property.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Prior {
    /// Every value between the bounds is as probable as every other.
    Uniform {
        /// Lower bound.
        from: f64,
        /// Upper bound.
        to: f64,
    },
    /// The logarithm is uniform: every factor is as probable as every other.
    LogUniform {
        /// Lower bound, positive.
        from: f64,
        /// Upper bound.
        to: f64,
    },
    /// A normal distribution, cut off at the bounds if there are any.
    Normal {
        /// Mean, before the cut.
        mean: f64,
        /// Standard deviation, before the cut.
        deviation: f64,
        /// Lower bound; minus infinity without one.
        from: f64,
        /// Upper bound; infinity without one.
        to: f64,
    },
}

impl Prior {
    /// Checks the numbers of a prior.
    ///
    /// # Errors
    /// Which numbers are wrong and what would be right.
    pub fn check(&self, name: &str) -> Result<(), CalibrationError> {
        let refuse = |reason: String| Err(CalibrationError::Prior { name: name.to_string(), reason });
        match *self {
            Prior::Uniform { from, to } | Prior::LogUniform { from, to }
                if !(from < to && from.is_finite() && to.is_finite()) =>
            {
                refuse(format!("from = {from} must be less than to = {to}, and both finite"))
            }
            Prior::LogUniform { from, .. } if from <= 0.0 => {
                refuse(format!("from = {from} must be positive, since a logarithm is taken"))
            }
            Prior::Normal { mean, deviation, .. }
                if !(mean.is_finite() && deviation > 0.0 && deviation.is_finite()) =>
            {
                refuse(format!(
                    "mean = {mean} must be finite, and deviation = {deviation} positive and finite"
                ))
            }
            Prior::Normal { mean, deviation, from, to } => {
                let [low, high] = cut(mean, deviation, from, to);
                if from < to && high > low {
                    return Ok(());
                }
                refuse(format!(
                    "nothing of the normal distribution {mean} ± {deviation} lies between {from} and {to}"
                ))
            }
            _ => Ok(()),
        }
    }

    /// The value below which a share of the prior lies; shares are from 0 to 1.
    ///
    /// ```
    /// use granum_calibration::inference::prior::Prior;
    ///
    /// let modulus = Prior::LogUniform { from: 1e8, to: 1e10 };
    /// assert!((modulus.value(0.5) / 1e9 - 1.0).abs() < 1e-12);
    /// ```
    pub fn value(&self, share: f64) -> f64 {
        match *self {
            Prior::Uniform { from, to } => from + share * (to - from),
            Prior::LogUniform { from, to } => exp(log(from) + share * (log(to) - log(from))).clamp(from, to),
            Prior::Normal { mean, deviation, from, to } => {
                let [low, high] = cut(mean, deviation, from, to);
                (mean + deviation * quantile(low + share * (high - low))).clamp(from, to)
            }
        }
    }

    /// The bounds between which values lie; `None` where there is no bound.
    pub fn bounds(&self) -> [Option<f64>; 2] {
        let (Prior::Uniform { from, to } | Prior::LogUniform { from, to } | Prior::Normal { from, to, .. }) =
            *self;
        [from, to].map(|bound| Some(bound).filter(|bound| bound.is_finite()))
    }

    /// The share of the prior below a value, the inverse of [`Prior::value`].
    pub fn share(&self, value: f64) -> f64 {
        let share = match *self {
            Prior::Uniform { from, to } => (value - from) / (to - from),
            Prior::LogUniform { from, to } => (log(value) - log(from)) / (log(to) - log(from)),
            Prior::Normal { mean, deviation, from, to } => {
                let [low, high] = cut(mean, deviation, from, to);
                (share_below((value - mean) / deviation) - low) / (high - low)
            }
        };
        share.clamp(0.0, 1.0)
    }
}

/// The shares of a normal distribution below its bounds.
fn cut(mean: f64, deviation: f64, from: f64, to: f64) -> [f64; 2] {
    [from, to].map(|bound| share_below((bound - mean) / deviation))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUT: Prior = Prior::Normal { mean: 0.3, deviation: 0.2, from: 0.1, to: f64::INFINITY };

    #[test]
    fn values_and_shares_undo_each_other() {
        let normal = Prior::Normal { mean: -2.0, deviation: 3.0, from: f64::NEG_INFINITY, to: f64::INFINITY };
        for prior in
            [Prior::Uniform { from: -1.0, to: 3.0 }, Prior::LogUniform { from: 1e-3, to: 1e2 }, normal, CUT]
        {
            prior.check("x").unwrap();
            for k in 1..100 {
                let share = f64::from(k) / 100.0;
                assert!((prior.share(prior.value(share)) - share).abs() < 1e-12, "{prior:?} {share}");
            }
        }
        assert!((normal.value(0.5) + 2.0).abs() < 1e-12);
        assert_eq!((CUT.value(0.0), CUT.share(0.0)), (0.1, 0.0));
        assert_eq!((CUT.bounds(), normal.bounds()), ([Some(0.1), None], [None, None]));
    }

    /// Golden: the mean of a normal distribution cut off at one deviation below its mean is larger by
    /// phi(-1) / (1 - Phi(-1)) = 0.287600 deviations.
    #[test]
    fn the_mean_of_a_cut_normal_distribution() {
        let count = 20_000;
        let mean = (0..count).map(|k| CUT.value((f64::from(k) + 0.5) / f64::from(count))).sum::<f64>()
            / f64::from(count);
        assert!((mean - (0.3 + 0.2 * 0.287_600)).abs() < 2e-5, "{mean}");
    }

    #[test]
    fn priors_without_sense_are_refused() {
        for (prior, part) in [
            (Prior::Uniform { from: 1.0, to: 1.0 }, "must be less than"),
            (Prior::Uniform { from: f64::NAN, to: 1.0 }, "must be less than"),
            (Prior::LogUniform { from: 0.0, to: 1.0 }, "must be positive"),
            (Prior::Normal { mean: 0.0, deviation: 0.0, from: -1.0, to: 1.0 }, "positive and finite"),
            (Prior::Normal { mean: 0.0, deviation: 1.0, from: 50.0, to: 60.0 }, "nothing of the normal"),
        ] {
            let message = prior.check("friction").unwrap_err().to_string();
            assert!(message.contains(part) && message.contains("friction"), "{message}");
        }
    }
}
