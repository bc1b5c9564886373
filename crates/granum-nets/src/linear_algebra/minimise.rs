//! The limited-memory method of Broyden, Fletcher, Goldfarb and Shanno (Liu and Nocedal 1989) for smooth functions of some tens of
//! numbers.
//!
//! A step goes along the quasi-Newton direction and is halved until the value falls enough (Armijo). Pairs of steps and changes of the
//! gradient without positive curvature are left out. Sums have a fixed order, so that the result depends on nothing but the function.

/// Pairs that are remembered.
const PAIRS: usize = 10;
/// Share of the decrease that the gradient promises which a step must reach.
const ARMIJO: f64 = 1e-4;
/// Largest change of a number in one step.
const LONGEST: f64 = 1.5;
/// Halvings of a step before the search ends.
const HALVINGS: usize = 25;

/// Value and gradient of a function.
pub(crate) type Slope = (f64, Vec<f64>);

/// Where a minimisation ended.
pub(crate) struct Minimum {
    pub at: Vec<f64>,
    pub value: f64,
}

/// Follows a function with its gradient downhill from `start`, for at most `iterations` steps, until the value of a step falls by less
/// than `tolerance`. `None` from the function marks points where it has no value; at the start it must have one, or there is no minimum.
pub(crate) fn minimise(
    start: &[f64],
    iterations: usize,
    tolerance: f64,
    function: &mut dyn FnMut(&[f64]) -> Option<Slope>,
) -> Option<Minimum> {
    let mut at = start.to_vec();
    let (mut value, mut gradient) = function(&at)?;
    let mut pairs: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for _ in 0..iterations {
        let mut direction = quasi_newton(&gradient, &pairs);
        let mut slope = dot(&direction, &gradient);
        if slope.is_nan() || slope >= 0.0 {
            pairs.clear();
            direction = quasi_newton(&gradient, &pairs);
            slope = dot(&direction, &gradient);
        }
        let longest = direction.iter().fold(0.0f64, |most, d| most.max(d.abs()));
        if longest == 0.0 || !slope.is_finite() {
            break;
        }
        let mut factor = (LONGEST / longest).min(1.0);
        let mut found = None;
        for _ in 0..HALVINGS {
            let next: Vec<f64> = at.iter().zip(&direction).map(|(x, d)| x + factor * d).collect();
            match function(&next) {
                Some((lower, there)) if lower <= value + ARMIJO * factor * slope => {
                    found = Some((next, lower, there));
                    break;
                }
                _ => factor *= 0.5,
            }
        }
        let Some((next, lower, there)) = found else { break };
        let step: Vec<f64> = next.iter().zip(&at).map(|(new, old)| new - old).collect();
        let change: Vec<f64> = there.iter().zip(&gradient).map(|(new, old)| new - old).collect();
        if dot(&step, &change) > 1e-10 * dot(&change, &change) {
            if pairs.len() == PAIRS {
                pairs.remove(0);
            }
            pairs.push((step, change));
        }
        let decrease = value - lower;
        (at, value, gradient) = (next, lower, there);
        if decrease < tolerance {
            break;
        }
    }
    Some(Minimum { at, value })
}

/// Minus the approximate inverse of the Hessian times the gradient, by the two-loop recursion.
pub(crate) fn quasi_newton(gradient: &[f64], pairs: &[(Vec<f64>, Vec<f64>)]) -> Vec<f64> {
    let mut direction: Vec<f64> = gradient.iter().map(|g| -g).collect();
    let mut factors = Vec::with_capacity(pairs.len());
    for (step, change) in pairs.iter().rev() {
        let factor = dot(step, &direction) / dot(step, change);
        add(&mut direction, -factor, change);
        factors.push(factor);
    }
    let scale = match pairs.last() {
        Some((step, change)) => dot(step, change) / dot(change, change),
        None => 1.0 / dot(gradient, gradient).sqrt().max(1.0),
    };
    direction.iter_mut().for_each(|d| *d *= scale);
    for ((step, change), factor) in pairs.iter().zip(factors.iter().rev()) {
        let correction = factor - dot(change, &direction) / dot(step, change);
        add(&mut direction, correction, step);
    }
    direction
}

/// The scalar product of two vectors, summed in order; the elements that only one of them has are left out.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(to: &mut [f64], factor: f64, what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(to, what)| *to += factor * what);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rosenbrocks_valley_is_followed_to_its_end() {
        let mut calls = 0;
        let mut valley = |x: &[f64]| {
            calls += 1;
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            Some((a * a + 100.0 * b * b, vec![-2.0 * a - 400.0 * x[0] * b, 200.0 * b]))
        };
        let found = minimise(&[-1.2, 1.0], 200, 1e-16, &mut valley).unwrap();
        assert!(found.value < 1e-10 && (found.at[0] - 1.0).abs() < 1e-4, "{:?} {}", found.at, found.value);
        assert!(calls < 150, "{calls}");
    }

    #[test]
    fn points_without_a_value_are_avoided() {
        // x - ln x has its minimum at 1, and no value at 0 and below.
        let mut logarithm = |x: &[f64]| (x[0] > 0.0).then(|| (x[0] - x[0].ln(), vec![1.0 - 1.0 / x[0]]));
        let found = minimise(&[3.0], 100, 1e-14, &mut logarithm).unwrap();
        assert!((found.at[0] - 1.0).abs() < 1e-5, "{:?}", found.at);
        assert!(minimise(&[-1.0], 100, 1e-14, &mut logarithm).is_none());
    }
}
