//! Student's paired t test, which decides whether the mean of differences is above zero.

use serde::{Deserialize, Serialize};

/// Significance level: the probability that differences with a mean of zero are considered positive.
pub const LEVEL: f64 = 0.05;
/// Smallest number of differences that are tested.
pub const FEWEST: usize = 3;

/// The 95 % quantiles of Student's t for 1 to 30 degrees of freedom.
const QUANTILES: [f64; 30] = [
    6.313752, 2.919986, 2.353363, 2.131847, 2.015048, 1.943180, 1.894579, 1.859548, 1.833113, 1.812461,
    1.795885, 1.782288, 1.770933, 1.761310, 1.753050, 1.745884, 1.739607, 1.734064, 1.729133, 1.724718,
    1.720743, 1.717144, 1.713872, 1.710882, 1.708141, 1.705618, 1.703288, 1.701131, 1.699127, 1.697261,
];
/// The limit for infinitely many degrees of freedom: the 95 % quantile of the normal distribution.
const NORMAL_QUANTILE: f64 = 1.6448536269514722;

/// The 95 % quantile of Student's t distribution: from a table for up to 30 degrees of freedom, and above by the expansion
/// of Cornish and Fisher in the inverse of their number (Abramowitz and Stegun 26.7.5), which is accurate to 1e-6 there.
/// It is infinite for 0 degrees of freedom.
pub fn quantile(degrees_of_freedom: usize) -> f64 {
    if degrees_of_freedom == 0 {
        return f64::INFINITY;
    }
    if let Some(&tabled) = QUANTILES.get(degrees_of_freedom - 1) {
        return tabled;
    }
    let (n, x) = (degrees_of_freedom as f64, NORMAL_QUANTILE);
    let square = x * x;
    let first = x * (square + 1.0) / 4.0;
    let second = x * (5.0 * square * square + 16.0 * square + 3.0) / 96.0;
    let third = x * (3.0 * square * square * square + 19.0 * square * square + 17.0 * square - 15.0) / 384.0;
    x + first / n + second / (n * n) + third / (n * n * n)
}

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
        let above = t.map_or(mean > 0.0, |t| t > quantile(runs - 1));
        Some(PairedTest { mean, standard_error, runs, t, above_zero: (runs >= FEWEST).then_some(above) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The quantiles agree with printed tables of the t distribution, one-sided 5 %.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (n, tabled) in [
            (1, 6.314),
            (2, 2.920),
            (5, 2.015),
            (10, 1.812),
            (30, 1.697),
            (40, 1.684),
            (60, 1.671),
            (120, 1.658),
        ] {
            assert!((quantile(n) - tabled).abs() < 6e-4, "{n}: {}", quantile(n));
        }
        assert!((quantile(31) - 1.695519).abs() < 2e-5 && (quantile(1_000_000) - 1.644855).abs() < 1e-5);
        assert!(quantile(0).is_infinite() && (1..200).all(|n| quantile(n) > quantile(n + 1)));
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
