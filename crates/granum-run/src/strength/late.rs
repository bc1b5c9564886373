//! Late values: means and trends over the last quarter of the strain.

use std::ops::Range;

/// Fraction of the strain, at the end of a test, over which late values are averaged.
pub const LATE: f64 = 0.25;

/// Mean of recorded values over the last quarter of the strain, with linear interpolation between states; `None` if there
/// are fewer than two states in it.
///
/// The mean is weighted by strain, so that it does not depend on the spacing of the states.
pub fn late_mean(strains: &[f64], values: &[f64]) -> Option<f64> {
    let points: Vec<(f64, f64)> = (strains.iter().copied().zip(values.iter().copied()))
        .filter(|(strain, value)| strain.is_finite() && value.is_finite())
        .collect();
    let from = (1.0 - LATE) * points.last()?.0;
    let (mut area, mut length) = (0.0, 0.0);
    for pair in points.windows(2) {
        let ((a, at_a), (b, at_b)) = (pair[0], pair[1]);
        if b <= from || b <= a {
            continue;
        }
        let begin = a.max(from);
        let at_begin = at_a + (at_b - at_a) * (begin - a) / (b - a);
        area += 0.5 * (at_begin + at_b) * (b - begin);
        length += b - begin;
    }
    (length > 0.0).then(|| area / length)
}

/// The states of the last quarter of the strain, where the strain only grows in it; `None` otherwise, or with fewer than two.
pub(super) fn late_rows(strains: &[f64]) -> Option<Range<usize>> {
    let last = *strains.last()?;
    // The tolerance keeps a state at exactly three quarters.
    let from = (1.0 - LATE) * last * (1.0 - 1e-9);
    let before = strains.iter().rposition(|strain| *strain < from);
    let first = before.map_or(0, |row| row + 1);
    let rows = first..strains.len();
    let grows = strains[first.saturating_sub(1)..].windows(2).all(|pair| pair[1] > pair[0]);
    (rows.len() >= 2 && grows && last > 0.0).then_some(rows)
}

/// Slope of the least-squares line of values over their strains; `None` with fewer than two different strains.
pub(super) fn slope(strains: &[f64], values: &[f64]) -> Option<f64> {
    let count = strains.len().min(values.len()) as f64;
    let mean = |of: &[f64]| of.iter().sum::<f64>() / count;
    let (x, y) = (mean(strains), mean(values));
    let (mut cross, mut square) = (0.0, 0.0);
    for (strain, value) in strains.iter().zip(values) {
        cross += (strain - x) * (value - y);
        square += (strain - x) * (strain - x);
    }
    (square > 0.0).then(|| cross / square).filter(|slope| slope.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_is_the_last_quarter_of_the_strain_however_states_are_spaced() {
        let line = |strains: &[f64]| {
            let values: Vec<f64> = strains.iter().map(|strain| 1.0 - strain).collect();
            late_mean(strains, &values).unwrap()
        };
        // The exact value is the mean of 1 - x from 0.3 to 0.4.
        for strains in [&[0.0, 0.1, 0.2, 0.3, 0.4][..], &[0.0, 0.001, 0.01, 0.4], &[0.0, 0.31, 0.39, 0.4]] {
            assert!((line(strains) - 0.65).abs() < 1e-12, "{strains:?}");
        }
        assert_eq!(late_mean(&[0.1], &[1.0]), None);
        assert_eq!(late_mean(&[], &[]), None);
        assert!((late_mean(&[0.0, 0.1, 0.2], &[0.0, f64::NAN, 0.8]).unwrap() - 0.7).abs() < 1e-12);
    }

    #[test]
    fn trends_are_those_of_a_strain_that_grows() {
        let strains = [0.0, 0.1, 0.2, 0.3, 0.32, 0.36, 0.4];
        assert_eq!(late_rows(&strains), Some(3..7));
        let values: Vec<f64> = strains.iter().map(|x| 0.7 - 0.2 * x).collect();
        assert!((slope(&strains[3..], &values[3..]).unwrap() + 0.2).abs() < 1e-12);
        assert_eq!(late_rows(&[0.0, 0.4, 0.35, 0.4]), None, "it goes to and fro");
        assert_eq!(late_rows(&[0.0, 0.4]), None);
        assert_eq!(slope(&[0.1, 0.1], &[1.0, 2.0]), None);
    }
}
