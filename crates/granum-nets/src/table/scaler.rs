//! Linear scaling of columns between their units and the scaled range of a network.

use granum_simd::mul_add;
use serde::{Deserialize, Serialize};

/// Maps [`Scaler::minimum`, `maximum`] of one column onto [`low`, `high`].
///
/// `scaled = low + (value - minimum) (high - low) / (maximum - minimum)`. A constant column is scaled to the middle of the
/// range, and back to its constant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scaler {
    /// Smallest value in the training rows, in the unit of the column.
    pub minimum: f64,
    /// Largest value in the training rows, in the unit of the column.
    pub maximum: f64,
    /// Scaled value of the minimum.
    pub low: f64,
    /// Scaled value of the maximum.
    pub high: f64,
}

impl Scaler {
    /// Inputs are scaled to [-1, 1].
    pub const INPUT_RANGE: (f64, f64) = (-1.0, 1.0);
    /// Targets of a sigmoid neuron are scaled to [0.1, 0.9], where it can reach them with finite weights.
    pub const SIGMOID_RANGE: (f64, f64) = (0.1, 0.9);

    /// The scaler that maps the smallest and the largest of `values` onto `range`. If there are no values, or only NaN, it
    /// is that of a constant column of zeros.
    pub fn fit(values: impl Iterator<Item = f64>, range: (f64, f64)) -> Scaler {
        let (minimum, maximum) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (f64::min(a, v), f64::max(b, v)));
        let (minimum, maximum) = if minimum <= maximum { (minimum, maximum) } else { (0.0, 0.0) };
        Scaler { minimum, maximum, low: range.0, high: range.1 }
    }

    /// Fits one scaler for every column of a flat table in row-major order.
    pub fn fit_columns(table: &[f64], columns: usize, range: (f64, f64)) -> Vec<Scaler> {
        (0..columns).map(|c| Scaler::fit(table.iter().skip(c).step_by(columns).copied(), range)).collect()
    }

    /// Gives all columns of one quantity a common scale: columns with the same number in `quantities` keep their
    /// proportions, and together have the magnitude of a single column. A distribution with many bins thus has no more
    /// weight than a scalar, and bins that contain little but noise are not amplified. Nothing changes for a quantity of
    /// one column, or if the number of entries differs from that of the scalers.
    pub fn share(scalers: &mut [Scaler], quantities: &[usize]) {
        if quantities.len() != scalers.len() {
            return;
        }
        let spans: Vec<f64> = scalers.iter().map(|s| s.maximum - s.minimum).collect();
        for k in 0..scalers.len() {
            let members: Vec<usize> =
                (0..scalers.len()).filter(|&j| quantities[j] == quantities[k]).collect();
            if members.len() < 2 || members[0] != k {
                continue;
            }
            let widest = members.iter().map(|&j| spans[j]).fold(0.0, f64::max);
            for &j in &members {
                let share = spans[j] / (widest * (members.len() as f64).sqrt());
                if share > 0.0 && share.is_finite() {
                    (scalers[j].low, scalers[j].high) = (share * scalers[j].low, share * scalers[j].high);
                }
            }
        }
    }

    /// True if all values are equal, or if their span is so small or so large that it has no finite reciprocal or is not
    /// finite.
    #[inline]
    pub fn is_constant(&self) -> bool {
        let span = self.maximum - self.minimum;
        !(span > 0.0 && span.is_finite() && (1.0 / span).is_finite())
    }

    /// Scaled units per unit of the column; zero for a constant column.
    #[inline]
    pub fn factor(&self) -> f64 {
        if self.is_constant() { 0.0 } else { (self.high - self.low) / (self.maximum - self.minimum) }
    }

    /// Scaled value of the minimum, or the middle of the range for a constant column.
    #[inline]
    pub fn offset(&self) -> f64 {
        if self.is_constant() { 0.5 * (self.low + self.high) } else { self.low }
    }

    /// Converts a value from the unit of the column to the scaled range.
    #[inline]
    pub fn scale(&self, value: f64) -> f64 {
        mul_add(value - self.minimum, self.factor(), self.offset())
    }

    /// Units of the column per scaled unit; zero for a constant column.
    #[inline]
    pub fn inverse_factor(&self) -> f64 {
        if self.is_constant() { 0.0 } else { (self.maximum - self.minimum) / (self.high - self.low) }
    }

    /// Converts a scaled value back to the unit of the column.
    #[inline]
    pub fn unscale(&self, scaled: f64) -> f64 {
        mul_add(scaled - self.offset(), self.inverse_factor(), self.minimum)
    }

    /// True if the value is outside the trained range, or NaN.
    #[inline]
    pub fn is_outside(&self, value: f64) -> bool {
        !(value >= self.minimum && value <= self.maximum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ends_meet_the_range() {
        let scaler = Scaler::fit([3.0, -1.0, 2.0].into_iter(), (0.1, 0.9));
        assert!((scaler.scale(-1.0) - 0.1).abs() < 1e-15 && (scaler.scale(3.0) - 0.9).abs() < 1e-15);
        assert!(scaler.is_outside(3.0001) && scaler.is_outside(f64::NAN) && !scaler.is_outside(3.0));
    }

    #[test]
    fn a_constant_column_goes_to_the_middle_and_back() {
        let scaler = Scaler::fit([5.0, 5.0].into_iter(), (-1.0, 1.0));
        assert_eq!(scaler.scale(5.0), 0.0);
        assert_eq!(scaler.scale(7.0), 0.0);
        assert_eq!(scaler.unscale(0.3), 5.0);
        assert!(scaler.is_outside(7.0));
        for (a, b) in [(0.0, 5e-324), (-1e308, 1e308)] {
            let scaler = Scaler::fit([a, b].into_iter(), (-1.0, 1.0));
            assert_eq!((scaler.scale(a), scaler.unscale(0.5)), (0.0, a), "no infinity appears");
        }
    }

    #[test]
    fn columns_are_told_apart() {
        let scalers = Scaler::fit_columns(&[0.0, 10.0, 1.0, 30.0, 2.0, 20.0], 2, (-1.0, 1.0));
        assert_eq!((scalers[0].minimum, scalers[0].maximum), (0.0, 2.0));
        assert_eq!((scalers[1].minimum, scalers[1].maximum), (10.0, 30.0));
    }

    proptest! {
        #[test]
        fn scaling_is_undone(a in -1e6..1e6f64, span in 1e-3..1e6f64, t in 0.0..1.0f64) {
            let scaler = Scaler { minimum: a, maximum: a + span, low: 0.1, high: 0.9 };
            let value = a + t * span;
            prop_assert!((scaler.unscale(scaler.scale(value)) - value).abs() < 1e-12 * (a.abs() + span));
        }
    }
}
