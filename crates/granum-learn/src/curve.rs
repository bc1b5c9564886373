//! Curves that are given by points.

/// True if every value is larger than the one before.
pub fn increases(xs: &[f64]) -> bool {
    xs.windows(2).all(|pair| pair[1] > pair[0])
}

/// The value of a curve at `x` by linear interpolation between points with increasing `xs`, constant beyond them; NaN if there
/// is no point.
///
/// ```
/// use granum_learn::curve::interpolated;
///
/// let (xs, ys) = ([0.0, 2.0], [1.0, 5.0]);
/// assert_eq!([-1.0, 0.5, 9.0].map(|x| interpolated(x, &xs, &ys)), [1.0, 2.0, 5.0]);
/// ```
pub fn interpolated(x: f64, xs: &[f64], ys: &[f64]) -> f64 {
    let after = xs.partition_point(|known| *known <= x);
    match (after, xs.len().min(ys.len())) {
        (_, 0) => f64::NAN,
        (0, _) => ys[0],
        (after, points) if after >= points => ys[points - 1],
        (after, _) => {
            let (a, b) = (after - 1, after);
            ys[a] + (x - xs[a]) / (xs[b] - xs[a]) * (ys[b] - ys[a])
        }
    }
}
