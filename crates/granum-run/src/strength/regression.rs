//! The straight line through points by least squares, with the standard errors of a linear regression.

/// A straight line `y = intercept + gradient x` through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Regression {
    pub(super) intercept: f64,
    pub(super) gradient: f64,
    /// Standard error of the intercept, with n - 2 degrees of freedom; `None` for two points.
    pub(super) intercept_error: Option<f64>,
    /// Standard error of the gradient; `None` for two points.
    pub(super) gradient_error: Option<f64>,
    /// Standard deviation of the points about the line; `None` for two points.
    pub(super) scatter: Option<f64>,
}

impl Regression {
    /// The line through two points or more; `None` for fewer, or where all have one x.
    pub(super) fn through(points: &[[f64; 2]]) -> Option<Regression> {
        if points.len() < 2 {
            return None;
        }
        let count = points.len() as f64;
        let [x, y] = [0, 1].map(|k| points.iter().map(|point| point[k]).sum::<f64>() / count);
        let square: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
        let cross: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
        if square <= 0.0 {
            return None;
        }
        let gradient = cross / square;
        let left: f64 = points.iter().map(|point| (point[1] - y - gradient * (point[0] - x)).powi(2)).sum();
        let scatter = (points.len() > 2).then(|| (left / (count - 2.0)).sqrt());
        Some(Regression {
            intercept: y - gradient * x,
            gradient,
            intercept_error: scatter.map(|scatter| scatter * (1.0 / count + x * x / square).sqrt()),
            gradient_error: scatter.map(|scatter| scatter / square.sqrt()),
            scatter,
        })
    }
}
