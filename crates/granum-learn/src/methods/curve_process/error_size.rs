//! How large the errors of curves are in one part of the inputs and in another.
//!
//! The scatter of samples and the errors of a surrogate are not the same everywhere: some materials scatter more than others, and less is known
//! where there are few runs. With the places `u_d` of the inputs among the runs (0 to 1), the size of the errors over their standard deviations is
//!
//! ```text
//! ln s(u) = sum_d a_d (2 u_d - 1) + b_d ((2 u_d - 1)^2 - 1/3)
//! ```
//!
//! fitted to the root mean square errors of training runs, each predicted from others, by ridge regression. Its penalty is the one with the least error
//! on runs left out; where that is not better than without any coefficients by more than its standard error, there are none. Source: Lei and others, Distribution-free predictive inference
//! for regression, Journal of the American Statistical Association 113 (2018), section 5.2 (locally weighted conformal inference).

use serde::{Deserialize, Serialize};

use crate::onnx::{OnnxGraph, Value};
use crate::regression::cholesky::Cholesky;

/// Penalties that are tried.
const PENALTIES: [f64; 6] = [3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];
/// Share of the root mean square of all runs below which the errors of a run are not told apart.
const LEAST_ERROR: f64 = 0.05;
/// The size is between this and its reciprocal.
const LEAST_SIZE: f64 = 0.25;

/// The size of errors as a function of the inputs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::methods) struct ErrorSize {
    /// Two for each input; none if errors are equally large everywhere.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    coefficients: Vec<f64>,
}

/// A fit with what it says of each run without it.
pub(in crate::methods) struct FittedErrorSize {
    pub size: ErrorSize,
    /// The size at each training run, by a fit to the others.
    pub left_out: Vec<f64>,
}

impl ErrorSize {
    /// From the places of runs and the root mean square of the errors of each.
    pub fn fit(places: &[Vec<f64>], errors: &[f64]) -> FittedErrorSize {
        let count = errors.len() as f64;
        let nothing = FittedErrorSize { size: ErrorSize::default(), left_out: vec![1.0; errors.len()] };
        let typical = (errors.iter().map(|e| e * e).sum::<f64>() / count.max(1.0)).sqrt();
        if !(typical > 0.0 && typical.is_finite()) {
            return nothing;
        }
        let targets: Vec<f64> = errors.iter().map(|e| libm::log(e.max(LEAST_ERROR * typical))).collect();
        let rows: Vec<Vec<f64>> = places.iter().map(|places| terms(places)).collect();
        // Without coefficients the answer for a run is the mean of the others.
        let mean = targets.iter().sum::<f64>() / count;
        let factor = count / (count - 1.0);
        let without: Vec<f64> = targets.iter().map(|y| (factor * (y - mean)).powi(2)).collect();
        let mut best: Option<(f64, Vec<f64>, FittedErrorSize)> = None;
        for penalty in PENALTIES {
            let Some((fitted, squares)) = ridge(&rows, &targets, penalty) else { continue };
            let error: f64 = squares.iter().sum();
            if best.as_ref().is_none_or(|(least, ..)| error < *least) {
                best = Some((error, squares, fitted));
            }
        }
        match best {
            Some((_, squares, fitted)) if is_better(&squares, &without) => fitted,
            _ => nothing,
        }
    }

    /// The size at a place.
    pub fn at(&self, places: &[f64]) -> f64 {
        if self.coefficients.is_empty() {
            return 1.0;
        }
        size(terms(places).iter().zip(&self.coefficients).map(|(term, c)| term * c).sum())
    }

    /// The size at the places in the rows of a graph; `None` if it is one everywhere.
    pub fn onnx(&self, graph: &mut OnnxGraph, places: &Value) -> Option<Value> {
        if self.coefficients.is_empty() {
            return None;
        }
        let numbers = [0.0, 1.0, 2.0, 1.0 / 3.0, LEAST_SIZE, 1.0 / LEAST_SIZE];
        let [zero, one, two, third, least, most] = numbers.map(|value| graph.number(value));
        let places = graph.apply("Max", &[places, &zero]);
        let places = graph.apply("Min", &[&places, &one]);
        let twice = graph.apply("Mul", &[&places, &two]);
        let linear = graph.apply("Sub", &[&twice, &one]);
        let square = graph.apply("Mul", &[&linear, &linear]);
        let square = graph.apply("Sub", &[&square, &third]);
        let (a, b): (Vec<f64>, Vec<f64>) = self.coefficients.chunks(2).map(|pair| (pair[0], pair[1])).unzip();
        let (a, b) = (graph.linear(&linear, a.len(), &a, None), graph.linear(&square, b.len(), &b, None));
        let logarithm = graph.apply("Add", &[&a, &b]);
        let size = graph.apply("Exp", &[&logarithm]);
        let size = graph.apply("Max", &[&size, &least]);
        Some(graph.apply("Min", &[&size, &most]))
    }

    /// True if it can be that of so many inputs.
    pub fn is_sound(&self, inputs: usize) -> bool {
        (self.coefficients.is_empty() || self.coefficients.len() == 2 * inputs)
            && self.coefficients.iter().all(|c| c.is_finite())
    }
}

fn size(logarithm: f64) -> f64 {
    libm::exp(logarithm).clamp(LEAST_SIZE, 1.0 / LEAST_SIZE)
}

/// True if the mean of the first squares is smaller than that of the second by more than the standard error of the difference.
fn is_better(squares: &[f64], without: &[f64]) -> bool {
    let count = squares.len() as f64;
    let gains: Vec<f64> = without.iter().zip(squares).map(|(without, with)| without - with).collect();
    let mean = gains.iter().sum::<f64>() / count;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    mean > (variance / count).sqrt()
}

/// The terms of a place; beyond the ends they are those at the ends.
fn terms(places: &[f64]) -> Vec<f64> {
    let of_input = |place: &f64| {
        let x = 2.0 * place.clamp(0.0, 1.0) - 1.0;
        [x, x * x - 1.0 / 3.0]
    };
    places.iter().flat_map(of_input).collect()
}

/// Ridge regression about the mean, with its squared errors on rows left out one by one: `e_i / (1 - h_i)`, where `h_i` is the diagonal of the
/// matrix that maps targets to answers (Allen 1974).
fn ridge(rows: &[Vec<f64>], targets: &[f64], penalty: f64) -> Option<(FittedErrorSize, Vec<f64>)> {
    let (count, width) = (rows.len() as f64, rows.first()?.len());
    let means: Vec<f64> = (0..width).map(|k| rows.iter().map(|row| row[k]).sum::<f64>() / count).collect();
    let mean = targets.iter().sum::<f64>() / count;
    let centred: Vec<Vec<f64>> =
        rows.iter().map(|row| row.iter().zip(&means).map(|(x, mean)| x - mean).collect()).collect();
    let mut matrix = vec![0.0; width * width];
    let mut right = vec![0.0; width];
    for (row, target) in centred.iter().zip(targets) {
        for i in 0..width {
            right[i] += row[i] * (target - mean);
            for j in 0..=i {
                matrix[i * width + j] += row[i] * row[j];
            }
        }
    }
    (0..width).for_each(|i| matrix[i * width + i] += penalty);
    let factor = Cholesky::new(width, &matrix)?;
    let coefficients = factor.solve(&right);
    let mut squares = Vec::with_capacity(rows.len());
    let mut left_out = Vec::with_capacity(rows.len());
    for ((row, centred), target) in rows.iter().zip(&centred).zip(targets) {
        let own: f64 = centred.iter().zip(&coefficients).map(|(x, c)| x * c).sum();
        let half = factor.solve_lower(centred);
        let leverage = 1.0 / count + half.iter().map(|y| y * y).sum::<f64>();
        let missed = (target - mean - own) / (1.0 - leverage).max(1e-9);
        squares.push(missed * missed);
        // Without its mean over the runs, as `ErrorSize::at` is; a constant belongs to the factor of the calibration.
        let at: f64 = row.iter().zip(&coefficients).map(|(x, c)| x * c).sum();
        left_out.push(size(at + (target - mean - own) - missed));
    }
    Some((FittedErrorSize { size: ErrorSize { coefficients }, left_out }, squares))
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;

    fn uniform(random: &mut ChaCha8Rng) -> f64 {
        (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Errors that the first of three inputs makes larger by a factor of e from one end to the other, with scatter of their own.
    fn runs(count: usize, slope: f64) -> (Vec<Vec<f64>>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let places: Vec<Vec<f64>> =
            (0..count).map(|_| (0..3).map(|_| uniform(&mut random)).collect()).collect();
        let error = |places: &Vec<f64>| (slope * places[0] + 0.6 * (uniform(&mut random) - 0.5)).exp();
        let errors = places.iter().map(error).collect();
        (places, errors)
    }

    #[test]
    fn errors_that_grow_along_an_input_are_found() {
        let (places, errors) = runs(200, 1.0);
        let fitted = ErrorSize::fit(&places, &errors);
        let ratio = fitted.size.at(&[0.95, 0.5, 0.5]) / fitted.size.at(&[0.05, 0.5, 0.5]);
        assert!((ratio.ln() - 0.9).abs() < 0.15, "{ratio}");
        let across = fitted.size.at(&[0.5, 0.95, 0.5]) / fitted.size.at(&[0.5, 0.05, 0.5]);
        assert!(across.ln().abs() < 0.15, "{across}");
        // Beyond the ends nothing more is assumed.
        assert_eq!(fitted.size.at(&[1.0, 0.5, 0.5]), fitted.size.at(&[3.0, 0.5, 0.5]));
    }

    #[test]
    fn a_run_left_out_is_one_that_was_not_there() {
        let (places, errors) = runs(60, 1.0);
        let rows: Vec<Vec<f64>> = places.iter().map(|places| terms(places)).collect();
        let targets: Vec<f64> = errors.iter().map(|e| e.ln()).collect();
        let (all, _) = ridge(&rows, &targets, 10.0).unwrap();
        let (without, _) = ridge(&rows[1..], &targets[1..], 10.0).unwrap();
        // The mean over the runs is another one without it, and not a part of the size.
        let mean = |targets: &[f64]| targets.iter().sum::<f64>() / targets.len() as f64;
        let centre = |rows: &[Vec<f64>], size: &ErrorSize| {
            let each = |row: &Vec<f64>| row.iter().zip(&size.coefficients).map(|(x, c)| x * c).sum::<f64>();
            rows.iter().map(each).sum::<f64>() / rows.len() as f64
        };
        let exact =
            without.size.at(&places[0]).ln() - centre(&rows[1..], &without.size) + mean(&targets[1..]);
        let found = all.left_out[0].ln() - centre(&rows, &all.size) + mean(&targets);
        // The penalty acts on the deviations from the mean, which the formula takes as unchanged.
        assert!((exact - found).abs() < 0.02, "{exact} {found}");
    }

    #[test]
    fn errors_without_a_trend_and_few_runs_give_no_coefficients() {
        for (count, slope) in [(100, 0.0), (3, 0.0)] {
            let (places, errors) = runs(count, slope);
            let fitted = ErrorSize::fit(&places, &errors);
            assert_eq!(fitted.size, ErrorSize::default(), "{count}");
            assert_eq!(fitted.left_out, vec![1.0; count]);
        }
        assert_eq!(ErrorSize::fit(&[vec![0.5], vec![0.7]], &[0.0, 0.0]).size, ErrorSize::default());
    }
}
