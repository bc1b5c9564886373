//! Histograms: counts in bins of equal width, which add up over observations.

use serde::{Deserialize, Serialize};

use crate::ratio::ratio;

/// Largest number of bins of a histogram.
const MOST_BINS: i64 = 1_000_000;

/// The bins of a histogram that a sensor counts into.
///
/// All bins have the same width, and one edge is at zero. For logarithmic bins a sensor can count logarithms.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bins {
    /// Name of the histogram, e.g. `forces`: its table has that name, and the series the columns `forces_below` and
    /// `forces_above`.
    pub name: &'static str,
    /// What is counted, e.g. `force`: the name of the column of the centres of the bins.
    pub quantity: &'static str,
    /// Unit of what is counted; `1` for a number.
    pub unit: &'static str,
    /// Width of a bin.
    pub width: f64,
    /// Smallest value with a bin of its own.
    pub smallest: f64,
    /// Largest value with a bin of its own.
    pub largest: f64,
}

impl Bins {
    /// Ten bins from 0 to 1.
    pub const fn new(name: &'static str, quantity: &'static str, unit: &'static str) -> Bins {
        Bins { name, quantity, unit, width: 0.1, smallest: 0.0, largest: 1.0 }
    }

    /// The same with bins of another width.
    pub const fn width(self, width: f64) -> Bins {
        Bins { width, ..self }
    }

    /// The same with bins from one value to another, rounded outward to whole bins.
    pub const fn range(self, smallest: f64, largest: f64) -> Bins {
        Bins { smallest, largest, ..self }
    }

    /// The empty histogram.
    pub fn empty(&self) -> Histogram {
        Histogram::new(self.width, self.smallest, self.largest)
    }
}

/// A histogram with bins of equal width and one edge at 0. It stores counts, so that observations can be added.
///
/// Bin b covers `[(first + b) w, (first + b + 1) w)`.
///
/// ```
/// let mut histogram = granum_sensors::Histogram::new(0.5, 0.0, 2.0);
/// [0.1, 0.7, 0.9, 3.0].into_iter().for_each(|value| histogram.add(value));
/// assert_eq!((histogram.counts.as_slice(), histogram.above), (&[1, 2, 0, 0][..], 1));
/// assert_eq!(histogram.density(1), 2.0 / (4.0 * 0.5));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// Width w of a bin.
    pub bin_width: f64,
    /// Lower edge of the first bin, in widths.
    pub first_bin: i64,
    /// Counts of the bins, all observations together.
    pub counts: Vec<u64>,
    /// Values below the first bin.
    pub below: u64,
    /// Values above the last bin.
    pub above: u64,
}

impl Histogram {
    /// An empty histogram with bins of a width from `smallest` to `largest`. A width that is not a positive number becomes
    /// 0.25.
    pub fn new(bin_width: f64, smallest: f64, largest: f64) -> Self {
        let bin_width = if bin_width.is_finite() && bin_width > 0.0 { bin_width } else { 0.25 };
        // The tolerance for rounding keeps 6.0 / 0.1 at 60 bins.
        let first = (smallest / bin_width + 1e-9).floor() as i64;
        let last = ((largest / bin_width - 1e-9).ceil() as i64).max(first.saturating_add(1));
        let bins = last.saturating_sub(first).clamp(1, MOST_BINS) as usize;
        Histogram { bin_width, first_bin: first, counts: vec![0; bins], below: 0, above: 0 }
    }

    /// Counts a value; one that is not a number is not counted.
    pub fn add(&mut self, value: f64) {
        self.add_in_widths(value / self.bin_width);
    }

    /// Counts a value that is given in widths of a bin.
    pub fn add_in_widths(&mut self, value: f64) {
        // From the first bin on positions are positive, so that the cast rounds down.
        let position = value - self.first_bin as f64;
        if position < 0.0 {
            self.below += 1;
        } else if position >= self.counts.len() as f64 {
            self.above += 1;
        } else if let Some(count) = self.counts.get_mut(position as usize).filter(|_| !position.is_nan()) {
            *count += 1;
        }
    }

    /// Number N of values counted, those outside the bins included.
    pub fn total(&self) -> u64 {
        self.counts.iter().chain([&self.below, &self.above]).fold(0, |sum, count| sum.saturating_add(*count))
    }

    /// Number of bins.
    pub fn bins(&self) -> usize {
        self.counts.len()
    }

    /// Centre of bin b.
    pub fn centre(&self, bin: usize) -> f64 {
        (self.first_bin as f64 + bin as f64 + 0.5) * self.bin_width
    }

    /// Lower and upper edge of bin b.
    pub fn edges(&self, bin: usize) -> [f64; 2] {
        let low = self.first_bin as f64 + bin as f64;
        [low * self.bin_width, (low + 1.0) * self.bin_width]
    }

    /// Probability density `P_b = n_b / (N w)` of bin b; 0 without values.
    pub fn density(&self, bin: usize) -> f64 {
        ratio(self.counts[bin] as f64, self.total() as f64 * self.bin_width)
    }

    /// Probability density at a value, linear between the centres of bins, 0 outside them.
    pub fn density_at(&self, value: f64) -> f64 {
        let position = value / self.bin_width - self.first_bin as f64 - 0.5;
        let low = position.floor();
        let weight = position - low;
        let value = |bin: f64| {
            if bin >= 0.0 && bin < self.bins() as f64 { self.density(bin as usize) } else { 0.0 }
        };
        (1.0 - weight) * value(low) + weight * value(low + 1.0)
    }

    /// True if it has the bins of another one.
    pub fn has_bins_of(&self, other: &Histogram) -> bool {
        (self.counts.len(), self.first_bin) == (other.counts.len(), other.first_bin)
            && self.bin_width == other.bin_width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_fall_between_the_edges_of_their_bins() {
        let mut histogram = Histogram::new(0.1, -0.25, 0.3);
        assert_eq!((histogram.first_bin, histogram.bins()), (-3, 6));
        for value in [-0.31, -0.29, -1e-12, 0.0, 0.299, 0.3, f64::NAN] {
            histogram.add(value);
        }
        assert_eq!(histogram.counts, [1, 0, 1, 1, 0, 1]);
        assert_eq!((histogram.below, histogram.above, histogram.total()), (1, 1, 6));
        let [low, high] = histogram.edges(5);
        assert!((low - 0.2).abs() < 1e-12 && (high - 0.3).abs() < 1e-12);
        assert!((histogram.centre(5) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn ranges_that_are_none_have_one_bin() {
        for histogram in [Histogram::new(0.1, 1.0, 1.0), Histogram::new(f64::NAN, 3.0, -3.0)] {
            assert_eq!(histogram.bins(), 1);
        }
        assert_eq!(Bins::new("x", "x", "1").empty().bins(), 10);
    }
}
