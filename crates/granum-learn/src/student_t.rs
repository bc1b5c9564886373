//! Student's paired t test, which decides whether the mean of differences is above zero.

use granum_nets::two_sided_quantile;
use serde::{Deserialize, Serialize};

/// Significance level: the probability that differences with a mean of zero are considered positive.
pub const LEVEL: f64 = 0.05;
/// Smallest number of differences that are tested.
pub const FEWEST: usize = 3;

/// A test of differences of errors, one per unseen run, for a mean above zero.
///
/// ```
/// use granum_learn::student_t::PairedTest;
///
/// // The mean is 2 and the standard error 1 / sqrt 3, so that t = 3.46 exceeds the 95 % quantile of 2.92.
/// let test = PairedTest::new(&[1.0, 2.0, 3.0]).unwrap();
/// assert_eq!((test.mean, test.above_zero), (2.0, Some(true)));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PairedTest {
    /// Mean difference.
    pub mean: f64,
    /// Standard error of the mean, i.e. the standard deviation over the square root of the number; null for a single
    /// difference.
    pub standard_error: Option<f64>,
    /// Number of differences.
    pub runs: usize,
    /// The mean over its standard error; null for a single difference, or if all differences are equal.
    pub t: Option<f64>,
    /// Whether the mean is above zero in the one-sided test with `runs - 1` degrees of freedom at 5 %; null for fewer than
    /// three differences, which are too few for a test.
    pub above_zero: Option<bool>,
}

impl PairedTest {
    /// Tests differences; `None` if there are none.
    pub fn new(differences: &[f64]) -> Option<PairedTest> {
        let runs = differences.len();
        if runs == 0 {
            return None;
        }
        let n = runs as f64;
        let mean = differences.iter().sum::<f64>() / n;
        let squares: f64 = differences.iter().map(|d| (d - mean) * (d - mean)).sum();
        let standard_error = (runs > 1).then(|| (squares / (n - 1.0) / n).sqrt());
        let t = standard_error.filter(|error| *error > 0.0).map(|error| mean / error);
        // If all differences are equal there is no scatter, and only their sign matters.
        let above = || t.map_or(mean > 0.0, |t| t > two_sided_quantile(1.0 - 2.0 * LEVEL, n - 1.0));
        Some(PairedTest { mean, standard_error, runs, t, above_zero: (runs >= FEWEST).then(above) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Differences of the given number whose t is the given one: half of them above the mean by the same amount, half below.
    fn differences(count: usize, t: f64) -> Vec<f64> {
        let standard_error = (1.0 / (count as f64 - 1.0)).sqrt();
        (0..count).map(|k| t * standard_error + if k % 2 == 0 { 1.0 } else { -1.0 }).collect()
    }

    /// The test is decided at the quantiles that are printed for one-sided 5 % and one degree of freedom less than differences.
    #[test]
    fn the_limit_is_the_tabled_quantile_of_one_side() {
        for (count, tabled) in [(4, 2.353363), (6, 2.015048), (10, 1.833113), (30, 1.699127)] {
            let above = |t: f64| PairedTest::new(&differences(count, t)).unwrap().above_zero;
            assert_eq!([above(tabled - 3e-6), above(tabled + 3e-6)], [Some(false), Some(true)], "{count}");
        }
    }

    #[test]
    fn tests_as_done_by_hand() {
        // The mean is 2, the standard deviation 1, the standard error 1 / sqrt 3, and t = 2 sqrt 3 = 3.46 > 2.92.
        let test = PairedTest::new(&[1.0, 2.0, 3.0]).unwrap();
        assert_eq!((test.mean, test.runs, test.above_zero), (2.0, 3, Some(true)));
        assert!((test.standard_error.unwrap() - 1.0 / 3f64.sqrt()).abs() < 1e-12);
        assert!((test.t.unwrap() - 2.0 * 3f64.sqrt()).abs() < 1e-12);
        // With t = 1.73 the mean is not significantly above zero.
        assert_eq!(PairedTest::new(&[0.0, 1.0, 2.0]).unwrap().above_zero, Some(false));
        assert_eq!(PairedTest::new(&[-1.0, -2.0, -3.0]).unwrap().above_zero, Some(false));
        let two = PairedTest::new(&[1.0, 1.1]).unwrap();
        assert!(two.above_zero.is_none() && two.standard_error.is_some());
        assert!(PairedTest::new(&[1.0]).unwrap().standard_error.is_none() && PairedTest::new(&[]).is_none());
        assert_eq!(PairedTest::new(&[0.0; 4]).unwrap().above_zero, Some(false));
    }
}
