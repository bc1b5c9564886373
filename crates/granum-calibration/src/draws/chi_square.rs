//! The chi-square distribution, with the same bits on every machine.

use libm::{erfc, exp, sqrt};

/// The share of the chi-square distribution with so many degrees of freedom above x: the regularised incomplete gamma function
/// `Q(degrees / 2, x / 2)`, by its recurrence `Q(a + 1, h) = Q(a, h) + h^a exp(-h) / Gamma(a + 1)` from `Q(1, h) = exp(-h)` and
/// `Q(1/2, h) = erfc(sqrt(h))`.
///
/// ```
/// use granum_calibration::draws::chi_square::share_above;
///
/// assert!((share_above(3.841_458_820_694_124, 1) - 0.05).abs() < 1e-12);
/// assert!((share_above(18.307_038_053_275_146, 10) - 0.05).abs() < 1e-12);
/// ```
pub fn share_above(x: f64, degrees: usize) -> f64 {
    if x.is_nan() {
        return 0.0;
    }
    if degrees == 0 || x <= 0.0 {
        return 1.0;
    }
    if x.is_infinite() {
        return 0.0;
    }
    let half = 0.5 * x;
    let is_even = degrees.is_multiple_of(2);
    let (mut share, mut power) = match is_even {
        true => (exp(-half), 1.0),
        false => (erfc(sqrt(half)), 0.5),
    };
    // h^a exp(-h) / Gamma(a + 1) at the first a.
    let mut term = match is_even {
        true => exp(-half) * half,
        false => exp(-half) * sqrt(half) / (0.5 * sqrt(std::f64::consts::PI)),
    };
    while power < 0.5 * degrees as f64 {
        share += term;
        power += 1.0;
        term *= half / power;
    }
    share.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Golden: quantiles of 5 and 0.1 % from tables.
    #[test]
    fn shares_are_those_of_tables() {
        for (x, degrees, share) in [
            (5.991_464_547_107_98, 2, 0.05),
            (7.814_727_903_251_18, 3, 0.05),
            (24.995_790_139_728_6, 15, 0.05),
            (10.827_566_170_662_7, 1, 0.001),
            (37.697_298_218_353_8, 15, 0.001),
            (233.994_269_4, 200, 0.05),
        ] {
            let share_there = share_above(x, degrees);
            assert!((share_there / share - 1.0).abs() < 1e-6, "{x} {degrees}: {share_there}");
        }
        assert_eq!(
            (share_above(0.0, 4), share_above(3.0, 0), share_above(f64::INFINITY, 3)),
            (1.0, 1.0, 0.0)
        );
        assert!(share_above(1e4, 12) < 1e-300);
    }
}
