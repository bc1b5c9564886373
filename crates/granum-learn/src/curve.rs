//! Curves that are given by points.

use crate::dataset::RunStates;
use crate::error::Result;

/// True if every value is larger than the one before.
pub fn increases(xs: &[f64]) -> bool {
    xs.windows(2).all(|pair| pair[1] > pair[0])
}

/// True if no value is smaller than the one before, as those of a coordinate whose test begins with a stage of rest.
pub fn never_falls(xs: &[f64]) -> bool {
    xs.windows(2).all(|pair| pair[1] >= pair[0])
}

/// The smallest and the largest of some values; infinity and minus infinity of none.
///
/// ```
/// assert_eq!(granum_learn::curve::range([2.0, -1.0, 5.0]), [-1.0, 5.0]);
/// ```
pub fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    values.into_iter().fold(ends, |[low, high], value| [low.min(value), high.max(value)])
}

/// The value of a curve at `x` by linear interpolation between points with `xs` that never fall, constant beyond them; NaN if there
/// is no point. At a point it is the end of the interval before it.
///
/// ```
/// use granum_learn::curve::interpolated;
///
/// let (xs, ys) = ([0.0, 2.0], [1.0, 5.0]);
/// assert_eq!([-1.0, 0.5, 9.0].map(|x| interpolated(x, &xs, &ys)), [1.0, 2.0, 5.0]);
/// ```
pub fn interpolated(x: f64, xs: &[f64], ys: &[f64]) -> f64 {
    let after = xs.partition_point(|known| *known < x);
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

/// Ratio of the largest to the smallest value beyond which the logarithm may be taken.
const WIDE: f64 = 10.0;

/// True if values vary by more than a factor of ten and are spread more evenly by their logarithm.
pub(crate) fn is_logarithmic(values: &[f64]) -> bool {
    let [least, most] = range(values.iter().copied());
    let logarithms = || values.iter().map(|v| libm::log(*v)).collect::<Vec<_>>();
    least > 0.0 && most > WIDE * least && lopsidedness(&logarithms()) < lopsidedness(values)
}

/// How far the mean is from the middle of the range, in parts of the range.
fn lopsidedness(values: &[f64]) -> f64 {
    let [least, most] = range(values.iter().copied());
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean - 0.5 * (least + most)).abs() / (most - least)
}

/// Some columns of a run along its coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct RunCurves {
    /// The coordinate of each state.
    pub coordinate: Vec<f64>,
    /// For each column its values.
    pub columns: Vec<Vec<f64>>,
}

impl RunCurves {
    /// The columns of the given names.
    ///
    /// # Errors
    /// If a column is missing.
    pub fn new(run: &RunStates, coordinate: &str, columns: &[String]) -> Result<RunCurves> {
        let columns = columns.iter().map(|name| run.column(name)).collect::<Result<_>>()?;
        Ok(RunCurves { coordinate: run.column(coordinate)?, columns })
    }

    /// The values of the columns at a coordinate, see [`interpolated`].
    pub fn at(&self, x: f64) -> Vec<f64> {
        self.columns.iter().map(|values| interpolated(x, &self.coordinate, values)).collect()
    }

    /// The values of the columns in a state.
    pub fn row(&self, state: usize) -> Vec<f64> {
        self.columns.iter().map(|values| values[state]).collect()
    }
}
