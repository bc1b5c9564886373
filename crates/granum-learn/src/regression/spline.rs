//! Cubic B-splines over strain.

/// Number of knots, which are equidistant in `sqrt(strain / end)`, because the curves of granular materials bend at small
/// strain.
const KNOTS: usize = 8;
/// Number of intervals between the knots.
pub const INTERVALS: usize = KNOTS - 1;
/// Number of basis functions: in each interval four are non-zero, three of which continue in the next interval.
pub const FUNCTIONS: usize = KNOTS + 2;

/// The basis functions at a strain, for tests that end at `end`. Their sum is 1. Outside the range from 0 to `end` they are
/// constant.
pub fn basis(strain: f64, end: f64) -> [f64; FUNCTIONS] {
    let intervals = (KNOTS - 1) as f64;
    let share = if end > 0.0 { (strain / end).clamp(0.0, 1.0) } else { 0.0 };
    let place = share.sqrt() * intervals;
    let interval = place.floor().min(intervals - 1.0);
    let t = place - interval;
    let rest = 1.0 - t;
    let first = interval as usize;
    let mut values = [0.0; FUNCTIONS];
    values[first] = rest * rest * rest / 6.0;
    values[first + 1] = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0;
    values[first + 2] = (3.0 * rest * rest * rest - 6.0 * rest * rest + 4.0) / 6.0;
    values[first + 3] = t * t * t / 6.0;
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_is_a_partition_of_unity_and_smooth() {
        for k in 0..=300 {
            let values = basis(0.001 * k as f64, 0.3);
            assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            assert!(values.iter().all(|value| (0.0..0.7).contains(value)));
        }
        // The functions are continuous at a knot.
        let knot = 0.3 * (3.0f64 / 7.0).powi(2);
        let (below, above) = (basis(knot - 1e-12, 0.3), basis(knot + 1e-12, 0.3));
        assert!(below.iter().zip(&above).all(|(a, b)| (a - b).abs() < 1e-9));
        assert!((below[4] - 2.0 / 3.0).abs() < 1e-9 && (below[3] - 1.0 / 6.0).abs() < 1e-9);
        assert_eq!(basis(0.4, 0.3), basis(0.3, 0.3));
        assert_eq!(basis(-0.1, 0.3), basis(0.0, 0.3));
    }
}
