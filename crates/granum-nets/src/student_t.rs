//! Student's t distribution.

/// Number of steps of the numerical integration.
const STEPS: usize = 4000;
/// Upper limit of the degrees of freedom, with which the distribution agrees with the normal one to three digits.
const MOST: f64 = 2000.0;

/// The value `t` with `P(|T| < t) = level` for Student's t distribution with so many degrees of freedom, with a relative
/// accuracy of about 1e-3; infinite for a level of one.
///
/// With `T = sqrt(n) tan(a)` the density of the angle `a` is proportional to `cos(a)^(n - 1)`, which is integrated by the
/// midpoint rule.
pub fn two_sided_quantile(level: f64, degrees_of_freedom: f64) -> f64 {
    let n = degrees_of_freedom.clamp(1.0, MOST);
    let step = std::f64::consts::FRAC_PI_2 / STEPS as f64;
    let share = |k: usize| ((k as f64 + 0.5) * step).cos().powf(n - 1.0);
    let wanted = level * (0..STEPS).map(share).sum::<f64>();
    let mut sum = 0.0;
    for k in 0..STEPS {
        let next = share(k);
        if sum + next > wanted {
            let quantile = n.sqrt() * (step * (k as f64 + (wanted - sum) / next)).tan();
            // Cosines and powers of the system library differ in their last digits between processors, whereas six decimals
            // agree on all of them.
            return (quantile * 1e6).round() / 1e6;
        }
        sum += next;
    }
    f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (n, level, expected) in [
            (1.0, 0.9, 6.314),
            (2.0, 0.9, 2.920),
            (7.0, 0.9, 1.895),
            (30.0, 0.95, 2.042),
            (f64::INFINITY, 0.9, 1.645),
        ] {
            let found = two_sided_quantile(level, n);
            assert!((found / expected - 1.0).abs() < 2e-3, "{n}: {found} {expected}");
        }
        assert_eq!((two_sided_quantile(0.0, 5.0), two_sided_quantile(1.0, 5.0)), (0.0, f64::INFINITY));
    }
}
