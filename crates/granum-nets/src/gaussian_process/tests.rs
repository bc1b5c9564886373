//! Gradients by differences, leaving out by leaving out, and functions that are known.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::evidence::posterior;
use super::rows::RowLanes;
use super::*;
use crate::random::uniform;

fn rows(count: usize, columns: usize, seed: u64) -> Rows {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    Rows::new((0..count * columns).map(|_| 1.7 * uniform(&mut random)).collect(), columns).unwrap()
}

/// A function of three inputs of which the last has no effect, and noise with a standard deviation of 0.1.
fn observed(rows: &Rows, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let noise = |random: &mut ChaCha8Rng| (0..12).map(|_| 0.5 * uniform(random)).sum::<f64>();
    (0..rows.count()).map(|k| exact(rows.row(k)) + 0.1 * noise(&mut random)).collect()
}

fn exact(row: &[f64]) -> f64 {
    (1.5 * row[0]).sin() + 0.5 * row[0] * row[1] - row[1]
}

#[test]
fn the_gradient_of_the_posterior_is_that_by_differences() {
    let (rows, inputs) = (rows(13, 3, 1), 3);
    let targets = observed(&rows, 2);
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let prior = Prior::Narrow.of_logarithms(inputs);
    let at: Vec<f64> = prior.iter().map(|[mean, _]| mean + 0.5 * uniform(&mut random)).collect();
    let (_, gradient) = posterior(&RowLanes::new(&rows), &targets, &prior, &at).unwrap();
    for k in 0..at.len() {
        let moved = |by: f64| {
            let mut at = at.clone();
            at[k] += by;
            posterior(&RowLanes::new(&rows), &targets, &prior, &at).unwrap().0
        };
        let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        assert!((gradient[k] - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{k}: {} {slope}", gradient[k]);
    }
}

#[test]
fn a_row_left_out_is_predicted_as_if_it_had_not_been_there() {
    let all = rows(20, 2, 4);
    let targets: Vec<f64> = (0..20).map(|k| exact(all.row(k))).collect();
    let process = GaussianProcess::fit(Arc::new(all.clone()), &targets, &FitOptions::default()).unwrap();
    let left = process.left_out(&targets)[7];
    // The scale of the targets must be that of all of them; a target at their mean on the other rows would change it.
    let others: Vec<usize> = (0..20).filter(|k| *k != 7).collect();
    let without = Arc::new(all.at(&others));
    let rest: Vec<f64> = others.iter().map(|&k| targets[k]).collect();
    let alone = GaussianProcess::with_parameters(without, &rest, process.parameters().to_vec()).unwrap();
    let expected = alone.predict(all.row(7));
    let total = expected.variance + expected.noise;
    // The standard deviation of 19 targets is slightly another one, and so is the mean.
    assert!((left.mean - expected.mean).abs() < 0.3 * total.sqrt(), "{left:?} {expected:?}");
    assert!((left.variance / total - 1.0).abs() < 0.2, "{left:?} {expected:?}");
}

/// The variance after a further observation is that of a process with a row more and the same parameters. Variances are compared over
/// the noise, since they count in those of the targets, of which there is one more.
#[test]
fn a_further_row_reduces_the_variance_as_if_it_had_been_observed() {
    let all = rows(25, 3, 11);
    let targets = observed(&all, 12);
    let known: Vec<usize> = (0..24).collect();
    let process =
        GaussianProcess::fit(Arc::new(all.at(&known)), &targets[..24], &FitOptions::default()).unwrap();
    let more =
        GaussianProcess::with_parameters(Arc::new(all.clone()), &targets, process.parameters().to_vec())
            .unwrap();
    let further = process.further(all.row(24));
    let asked = rows(20, 3, 13);
    let mut largest: f64 = 0.0;
    for row in (0..20).map(|k| asked.row(k)).chain([all.row(24)]) {
        let [before, after] = [&process, &more].map(|process| process.predict(row));
        let found = process.reduction(row, &further) / before.noise;
        let expected = before.variance / before.noise - after.variance / after.noise;
        assert!(
            (found - expected).abs() < 1e-5 * (1.0 + before.variance / before.noise),
            "{found} {expected}"
        );
        largest = largest.max(found);
    }
    assert!(largest > 0.03, "{largest}");
}

/// Noise is told from function, an input without effect is found to have none, and the standard deviations are true.
#[test]
fn a_known_function_is_found_with_its_noise() {
    let rows = Arc::new(rows(120, 3, 5));
    let targets = observed(&rows, 6);
    let process = GaussianProcess::fit(rows, &targets, &FitOptions::default()).unwrap();
    let asked = self::rows(300, 3, 7);
    let predicted: Vec<ProcessPrediction> = (0..300).map(|k| process.predict(asked.row(k))).collect();
    let noise = predicted[0].noise.sqrt();
    assert!((0.08..0.125).contains(&noise), "{noise}");
    let errors: Vec<f64> = predicted.iter().enumerate().map(|(k, p)| p.mean - exact(asked.row(k))).collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 300.0).sqrt();
    assert!(rms < 0.07, "{rms}");
    let held = errors.iter().zip(&predicted).filter(|(e, p)| e.abs() < 1.645 * p.variance.sqrt()).count();
    assert!((240..=297).contains(&held), "{held} of 300 within intervals of 90 %");
    let [moved, other] = [[0.3, 0.2, 1.5], [0.3, 0.2, -1.5]].map(|row| process.predict(&row).mean);
    assert!((moved - other).abs() < 0.1, "{moved} {other}");
}

#[test]
fn the_same_rows_and_parameters_give_the_same_bits() {
    let rows = Arc::new(rows(30, 2, 8));
    let targets: Vec<f64> = (0..30).map(|k| exact(rows.row(k))).collect();
    let options = FitOptions::default();
    let fitted = GaussianProcess::fit(rows.clone(), &targets, &options).unwrap();
    let again =
        GaussianProcess::with_parameters(rows.clone(), &targets, fitted.parameters().to_vec()).unwrap();
    assert_eq!(fitted.predict(&[0.3, -0.2]), again.predict(&[0.3, -0.2]));
    assert_eq!(
        GaussianProcess::fit(rows.clone(), &targets, &options).unwrap().parameters(),
        fitted.parameters()
    );
    // A search from the most probable parameters stays there.
    let from = GaussianProcess::fit_from(rows, &targets, fitted.parameters(), &options).unwrap();
    let moved = from.parameters().iter().zip(fitted.parameters()).map(|(a, b)| (a - b).abs());
    assert!(moved.fold(0.0, f64::max) < 0.1, "{:?} {:?}", from.parameters(), fitted.parameters());
}

#[test]
fn few_rows_judge_the_parameters_and_all_rows_predict() {
    let rows = Arc::new(rows(90, 2, 9));
    let targets: Vec<f64> = (0..90).map(|k| exact(rows.row(k))).collect();
    let options = FitOptions { most_rows: 40, ..FitOptions::default() };
    let process = GaussianProcess::fit(rows.clone(), &targets, &options).unwrap();
    let worst = (0..90).map(|k| (process.predict(rows.row(k)).mean - targets[k]).abs()).fold(0.0, f64::max);
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let told = |error: GaussianProcessError| error.to_string();
    assert!(told(Rows::new(vec![1.0], 1).unwrap_err()).contains("two or more"));
    assert!(told(Rows::new(vec![1.0, f64::NAN], 1).unwrap_err()).starts_with("row 2: input 1 is NaN"));
    let rows = Arc::new(Rows::new(vec![1.0, 2.0], 1).unwrap());
    let fit = |targets: &[f64]| GaussianProcess::fit(rows.clone(), targets, &FitOptions::default());
    assert_eq!(told(fit(&[1.0]).unwrap_err()), "there are 1 targets for 2 rows");
    assert!(told(fit(&[1.0, f64::INFINITY]).unwrap_err()).contains("target 2 is inf"));
    let few = GaussianProcess::with_parameters(rows.clone(), &[1.0, 2.0], vec![0.0; 3]).unwrap_err();
    assert!(told(few).contains("3 parameters are not those"));
    // Targets that are all equal are predicted exactly.
    assert_eq!(fit(&[4.0, 4.0]).unwrap().predict(&[1.5]).mean, 4.0);
}
