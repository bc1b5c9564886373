//! Outputs that are learned by their square root, such as a mean stress that vanishes in some samples and grows a hundredfold in others.
//!
//! ```text
//! y = t^2,   E y = m^2 + v,   var y = 4 m^2 v + 2 v^2
//! ```
//!
//! for a normal root `t` with the mean `m` and the variance `v`. The scatter of such an output grows with its value, and that of its root much
//! less; moreover its mean is never negative.

use super::predicted_curve::Curve;

/// How many times the median the largest value must be.
const HEAVY: f64 = 10.0;

/// True if the values of curves are never negative and the largest of them is far from most others.
pub(super) fn needs_root(curves: &[Vec<f64>]) -> bool {
    let mut values: Vec<f64> = curves.iter().flatten().copied().collect();
    values.sort_by(f64::total_cmp);
    match values[..] {
        [least, .., most] => least >= 0.0 && most > HEAVY * values[values.len() / 2],
        _ => false,
    }
}

/// The output, from the curve of its root.
pub(super) fn squared(mut curve: Curve) -> Curve {
    for k in 0..curve.mean.len() {
        let (mean, variance) = (curve.mean[k], curve.parameters[k] + curve.noise[k]);
        let factor = 4.0 * mean * mean + 2.0 * variance;
        curve.mean[k] = mean * mean + variance;
        curve.parameters[k] *= factor;
        curve.noise[k] *= factor;
    }
    curve
}

/// The mean at each place and the covariance of values, from those of their roots where there is a factor in `roots`: the one by which the standard
/// deviations in the covariance were calibrated, while means are those of the processes as they are.
pub(super) fn square_jointly(mean: &mut [f64], covariance: &mut [f64], factors: &[Option<f64>]) {
    let count = mean.len();
    let (roots, variances): (Vec<f64>, Vec<f64>) =
        (0..count).map(|p| (mean[p], covariance[p * count + p])).unzip();
    for p in 0..count {
        for q in 0..count {
            let own = &mut covariance[p * count + q];
            match (factors[p].is_some(), factors[q].is_some()) {
                (true, true) => *own *= 4.0 * roots[p] * roots[q] + 2.0 * *own,
                (true, false) => *own *= 2.0 * roots[p],
                (false, true) => *own *= 2.0 * roots[q],
                (false, false) => {}
            }
        }
        if let Some(factor) = factors[p] {
            let variance = if factor > 0.0 { variances[p] / (factor * factor) } else { 0.0 };
            mean[p] = roots[p] * roots[p] + variance;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Function = fn(f64) -> f64;

    /// Two correlated normal numbers by three points each, exact for polynomials of up to the fifth degree.
    fn expected(mean: [f64; 2], [own, both, other]: [f64; 3], f: impl Fn(f64, f64) -> f64) -> f64 {
        let points = [(-1.0, 1.0 / 6.0), (0.0, 2.0 / 3.0), (1.0, 1.0 / 6.0)];
        let root = 3.0f64.sqrt();
        let (first, across) = (own.sqrt(), both / own.sqrt());
        let second = (other - across * across).sqrt();
        let each = points.iter().flat_map(|a| points.iter().map(move |b| (a, b)));
        each.map(|(a, b)| {
            let (x, y) = (root * a.0, root * b.0);
            a.1 * b.1 * f(mean[0] + first * x, mean[1] + across * x + second * y)
        })
        .sum()
    }

    #[test]
    fn squares_have_the_moments_of_normal_numbers() {
        let (mean, [own, both, other]) = ([0.7, -1.3], [0.4, 0.25, 0.9]);
        let moments = |f: Function, g: Function| {
            let e = |h: &dyn Fn(f64, f64) -> f64| expected(mean, [own, both, other], h);
            let (first, second) = (e(&|x, _| f(x)), e(&|_, y| g(y)));
            let variance = e(&|x, _| f(x) * f(x)) - first * first;
            (first, variance, e(&|x, y| f(x) * g(y)) - first * second)
        };
        let (square, same): (Function, Function) = (|x| x * x, |x| x);
        for (factors, g) in [([Some(1.0); 2], square), ([Some(1.0), None], same)] {
            let (first, variance, covariance) = moments(square, g);
            let (mut means, mut matrix) = (mean, [own, both, both, other]);
            square_jointly(&mut means, &mut matrix, &factors);
            for (found, exact) in [(means[0], first), (matrix[0], variance), (matrix[1], covariance)] {
                assert!((found - exact).abs() < 1e-12, "{found} {exact}");
            }
            assert_eq!(matrix[1], matrix[2]);
        }
        let root = Curve { mean: vec![0.7], parameters: vec![0.3], noise: vec![0.1] };
        let (first, variance, _) = moments(square, same);
        let found = squared(root);
        assert!((found.mean[0] - first).abs() < 1e-12);
        assert!((found.parameters[0] + found.noise[0] - variance).abs() < 1e-12);
        assert!((found.parameters[0] / found.noise[0] - 3.0).abs() < 1e-12);
    }

    #[test]
    fn without_errors_the_mean_is_the_square() {
        let (mut mean, mut covariance) = ([0.5], [0.0]);
        square_jointly(&mut mean, &mut covariance, &[Some(0.0)]);
        assert_eq!((mean, covariance), ([0.25], [0.0]));
    }

    #[test]
    fn what_is_never_negative_and_far_from_the_median_needs_a_root() {
        let curves = |most: f64, least: f64| vec![vec![1.0, 1.1, 0.9, least], vec![1.0, 1.2, most]];
        assert!(needs_root(&curves(11.0, 0.0)));
        assert!(!needs_root(&curves(9.0, 0.0)) && !needs_root(&curves(11.0, -0.01)) && !needs_root(&[]));
    }
}
