//! The critical state line: void ratio against the logarithm of the mean stress, fitted through the late states of several tests.
//!
//! `e_c = Gamma - lambda ln(p / 1 kPa)` (Roscoe, Schofield and Wroth 1958; Schofield and Wroth 1968), by least squares over the void
//! ratios. The standard errors are those of the linear regression with n - 2 degrees of freedom. Which tests are critical is judged by
//! [`super::CriticalStates`].

use super::regression::Regression;

/// Mean stress at which the line has the void ratio Gamma, Pa.
pub const REFERENCE_STRESS: f64 = 1e3;

/// A late state of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateState {
    /// Mean stress, Pa.
    pub mean_stress: f64,
    /// Void ratio.
    pub void_ratio: f64,
}

/// A fitted line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalStateLine {
    /// Gamma, the void ratio at 1 kPa.
    pub intercept: f64,
    /// Standard error of Gamma; `None` for two tests.
    pub intercept_error: Option<f64>,
    /// lambda, the decrease of the void ratio while the mean stress grows by a factor of e = 2.718.
    pub slope: f64,
    /// Standard error of lambda; `None` for two tests.
    pub slope_error: Option<f64>,
    /// Standard deviation of the void ratios about the line, with n - 2 degrees of freedom; `None` for two tests.
    pub scatter: Option<f64>,
    /// Number of tests.
    pub tests: usize,
    /// Smallest and largest mean stress of the tests, Pa, beyond which the line is extrapolated.
    pub range: [f64; 2],
}

/// Smallest ratio of the largest to the smallest mean stress of a line: with less there is a point and its scatter.
pub const LEAST_RANGE: f64 = 1.2;

impl CriticalStateLine {
    /// The line through late states; `None` with fewer than two tests, or if their mean stresses span less than
    /// [`LEAST_RANGE`].
    ///
    /// ```
    /// use granum_run::strength::critical_state_line::{CriticalStateLine, LateState};
    ///
    /// let on_a_line = |p: f64| LateState { mean_stress: p, void_ratio: 0.9 - 0.02 * (p / 1e3).ln() };
    /// let line = CriticalStateLine::through(&[50e3, 100e3, 400e3].map(on_a_line)).unwrap();
    /// assert!((line.intercept - 0.9).abs() < 1e-12 && (line.slope - 0.02).abs() < 1e-12);
    /// assert!((line.void_ratio(200e3) - on_a_line(200e3).void_ratio).abs() < 1e-12);
    /// ```
    pub fn through(states: &[LateState]) -> Option<CriticalStateLine> {
        let usable = |state: &&LateState| state.mean_stress > 0.0 && state.void_ratio.is_finite();
        let points: Vec<[f64; 2]> = (states.iter().filter(usable))
            .map(|state| [libm::log(state.mean_stress / REFERENCE_STRESS), state.void_ratio])
            .collect();
        let [low, high] =
            points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [x, _]| [a.min(*x), b.max(*x)]);
        if points.len() < 2 || high - low < libm::log(LEAST_RANGE) {
            return None;
        }
        let line = Regression::through(&points)?;
        Some(CriticalStateLine {
            intercept: line.intercept,
            intercept_error: line.intercept_error,
            slope: -line.gradient,
            slope_error: line.gradient_error,
            scatter: line.scatter,
            tests: points.len(),
            range: [low, high].map(|x| REFERENCE_STRESS * libm::exp(x)),
        })
    }

    /// The void ratio of the line at a mean stress, Pa.
    pub fn void_ratio(&self, mean_stress: f64) -> f64 {
        self.intercept - self.slope * libm::log(mean_stress / REFERENCE_STRESS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of a regression worked out by hand: x = ln p of 1, 2, 3; y = 0.80, 0.75, 0.73.
    #[test]
    fn the_standard_errors_are_those_of_a_linear_regression() {
        let state = |x: f64, e: f64| LateState { mean_stress: 1e3 * x.exp(), void_ratio: e };
        let line =
            CriticalStateLine::through(&[state(1.0, 0.80), state(2.0, 0.75), state(3.0, 0.73)]).unwrap();
        assert!((line.slope - 0.035).abs() < 1e-12 && (line.intercept - 0.83).abs() < 1e-12);
        // Residuals 0.005, -0.010, 0.005: their squares add up to 1.5e-4 with one degree of freedom.
        let scatter = 1.5e-4f64.sqrt();
        assert!((line.scatter.unwrap() - scatter).abs() < 1e-12);
        assert!((line.slope_error.unwrap() - scatter / 2f64.sqrt()).abs() < 1e-12);
        assert!((line.intercept_error.unwrap() - scatter * (1.0f64 / 3.0 + 2.0).sqrt()).abs() < 1e-12);
        assert_eq!(line.tests, 3);
    }

    #[test]
    fn tests_at_one_stress_make_no_line() {
        let state = |p: f64| LateState { mean_stress: p, void_ratio: 0.7 };
        assert_eq!(CriticalStateLine::through(&[state(100e3), state(102e3), state(98e3)]), None);
        assert_eq!(CriticalStateLine::through(&[state(100e3)]), None);
        let two = CriticalStateLine::through(&[state(100e3), state(200e3)]).unwrap();
        assert_eq!((two.slope_error, two.tests), (None, 2));
        assert_eq!(
            CriticalStateLine::through(&[state(100e3), state(0.0)]),
            None,
            "no stress has no logarithm"
        );
    }
}
