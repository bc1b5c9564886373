//! A tensor among the outputs as networks see it: its deviator, and its mean part where that varies.

use serde::{Deserialize, Serialize};

use super::rotation::{COMPONENTS, parts};

/// An output of six columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TensorChannel {
    pub outputs: [usize; 6],
    /// Inputs with its components before the first row.
    pub start: Option<[usize; 6]>,
    /// Root mean square of a component of the deviator.
    pub scale: f64,
    /// A third of the trace if it is constant.
    pub mean: Option<f64>,
    /// Where the mean part varies by much, as that of a stress does whose pressure changes: what is added to it, a small part of its mean. Networks then see the
    /// deviator over this sum and the logarithm of the sum, since what a strain changes is in proportion to the stress; and a predicted stress is never a tension
    /// beyond this sum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
}

impl TensorChannel {
    /// The deviator of a tensor in the units of networks.
    pub fn deviator(&self, tensor: [f64; 6]) -> [f64; COMPONENTS] {
        let unit = self.scale * self.unit(tensor);
        parts(tensor).0.map(|c| c / unit)
    }

    /// In what the deviator of a tensor and its errors are told: one, or the mean part with its offset.
    pub fn unit(&self, tensor: [f64; 6]) -> f64 {
        self.offset.map_or(1.0, |offset| over_zero(parts(tensor).1, offset))
    }

    /// The mean part of a tensor as a scalar of networks, before it is scaled.
    pub fn mean_part(&self, tensor: [f64; 6]) -> f64 {
        let mean = parts(tensor).1;
        self.offset.map_or(mean, |offset| libm::log(over_zero(mean, offset)))
    }

    /// The mean part from what [`TensorChannel::mean_part`] gave, and the unit of the deviator beside its scale.
    pub fn mean_and_unit(&self, value: f64) -> [f64; 2] {
        match self.offset {
            None => [value, 1.0],
            Some(offset) => {
                let sum = libm::exp(value);
                [sum - offset, sum]
            }
        }
    }
}

/// A mean part and its offset. A tension as large as the offset, which no training state should have, stays above zero.
fn over_zero(mean: f64, offset: f64) -> f64 {
    (mean + offset).max(least_sum(offset))
}

/// The least sum of a mean part and an offset.
pub(super) fn least_sum(offset: f64) -> f64 {
    LEAST_SUM * offset
}

/// A mean part whose deviation is more than this share of its mean varies by much.
const VARIES: f64 = 0.3;
/// The offset of a mean part that varies by much, over its mean.
const OFFSET: f64 = 0.02;
/// The least sum of a mean part and its offset, over the offset.
const LEAST_SUM: f64 = 0.05;

/// The offset of a tensor with such mean parts, if they vary by much and none is a tension of its size.
pub(super) fn offset_of(means: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let [mean, deviation] = moments(means.clone());
    let [least, most] = [f64::min, f64::max].map(|of| means.clone().reduce(of).unwrap_or(0.0));
    let offset = OFFSET * mean;
    // The deviation of a constant is told as one.
    let varies = most > least && deviation > VARIES * mean;
    (mean > 0.0 && varies && least > -0.5 * offset).then_some(offset)
}

/// Mean and standard deviation, which is one for a constant.
pub(super) fn moments(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    let variance = values.map(|value| (value - mean) * (value - mean)).sum::<f64>() / count;
    let deviation = variance.sqrt();
    [mean, if deviation > 1e-12 * mean.abs().max(1e-300) { deviation } else { 1.0 }]
}

/// The components of a tensor in a row.
pub(super) fn six(row: &[f64], places: &[usize; 6]) -> [f64; 6] {
    places.map(|place| row[place])
}

#[cfg(test)]
mod tests {
    use super::super::rotation::whole;
    use super::*;

    #[test]
    fn a_stress_whose_pressure_varies_comes_back_from_its_ratio_and_logarithm() {
        let pressures = [2e4, 1e5, 5e5, 50.0, 0.0];
        let offset = offset_of(pressures.into_iter()).unwrap();
        assert!((offset - 0.02 * 124_010.0).abs() < 1e-9, "{offset}");
        let channel = TensorChannel {
            outputs: [0, 1, 2, 3, 4, 5],
            start: None,
            scale: 0.4,
            mean: None,
            offset: Some(offset),
        };
        for p in pressures {
            let tensor = [1.4, 0.8, 0.8, 0.1, -0.2, 0.3].map(|c| c * p);
            let tensor = [tensor[0], tensor[1], tensor[2], 0.5 * tensor[3], tensor[4], tensor[5]];
            let [mean, unit] = channel.mean_and_unit(channel.mean_part(tensor));
            let back = whole(channel.deviator(tensor).map(|c| channel.scale * c * unit), mean);
            assert!(
                back.iter().zip(tensor).all(|(ours, exact)| (ours - exact).abs() < 1e-9),
                "{back:?} {tensor:?}"
            );
        }
        // A tension that is larger than the offset has a finite logarithm.
        assert!(channel.mean_part([-1e6; 6]).is_finite());
        // A pressure that is held, a fabric, and a tensor without a sign have none.
        for means in [[1e5, 1.01e5, 0.99e5], [1.0, 1.0, 1.0], [-1.0, 2.0, -2.0], [1.0, 2.0, -1.0]] {
            assert_eq!(offset_of(means.into_iter()), None);
        }
    }
}
