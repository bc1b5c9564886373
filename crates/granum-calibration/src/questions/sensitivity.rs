//! Which parameters a curve depends on: Sobol's indices, for a whole curve at once.
//!
//! The first index of a parameter is the share of the variance of a curve, summed over its points, that would vanish if the parameter
//! were known; the total index is the share that would remain if all others were. Parameters follow their priors.
//!
//! Sources: estimators of Saltelli and others, Computer Physics Communications 181 (2010), 259 to 270 (first, their equation b) and Jansen,
//! Computer Physics Communications 117 (1999), 35 to 43 (total); curves after Gamboa, Janon, Klein, Lagnoux, Electronic Journal of Statistics
//! 8 (2014), 575 to 603. Points by the scrambled Sobol sequence of `sobol_burley`.

use granum_core::parallel;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::draws::diagnostics::quantile_of_sorted;
use crate::draws::random::{index, stream};
use crate::error::{CalibrationError, Result};

/// Most parameters: two coordinates of the sequence for each, of which there are 256.
pub const MOST_PARAMETERS: usize = 128;
/// Repetitions with drawn points by which the intervals are found.
const REPETITIONS: usize = 200;

/// An index with the interval that holds it in 90 % of repetitions with other points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SobolIndex {
    /// The index.
    pub value: f64,
    /// Lower end of its interval.
    pub low: f64,
    /// Upper end of its interval.
    pub high: f64,
}

/// The indices of one curve, for each parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// First indices.
    pub first: Vec<SobolIndex>,
    /// Total indices.
    pub total: Vec<SobolIndex>,
    /// Variance of the curve, summed over its points.
    pub variance: f64,
}

/// The indices of each curve that `curves` gives at shares of priors, from `count (parameters + 2)` evaluations.
///
/// # Errors
/// If there are no parameters or too many, or `curves` fails or gives other lengths at other shares.
pub fn sensitivities(
    parameters: usize,
    count: usize,
    seed: u32,
    threads: usize,
    curves: impl Fn(&[f64]) -> Result<Vec<Vec<f64>>> + Sync,
) -> Result<Vec<Sensitivity>> {
    if parameters == 0 || parameters > MOST_PARAMETERS || count < 2 {
        let message =
            format!("Sobol's indices need 1 to {MOST_PARAMETERS} parameters and two points or more");
        return Err(CalibrationError::Input(message));
    }
    let evaluated = parallel::map(count, threads, |point| {
        let coordinate = |k: usize| f64::from(sobol_burley::sample(point as u32, k as u32, seed));
        let a: Vec<f64> = (0..parameters).map(coordinate).collect();
        let b: Vec<f64> = (parameters..2 * parameters).map(coordinate).collect();
        let mut all = vec![curves(&a)?, curves(&b)?];
        for k in 0..parameters {
            let mut mixed = a.clone();
            mixed[k] = b[k];
            all.push(curves(&mixed)?);
        }
        Ok::<_, CalibrationError>(all)
    })?;
    let shape = |curves: &Vec<Vec<f64>>| curves.iter().map(Vec::len).collect::<Vec<_>>();
    let expected = shape(&evaluated[0][0]);
    if evaluated.iter().flatten().any(|curves| shape(curves) != expected) {
        return Err(CalibrationError::Input(
            "a model gave curves of other lengths at other parameters".into(),
        ));
    }
    Ok((0..expected.len()).map(|curve| one_curve(&evaluated, curve, parameters, seed)).collect())
}

fn one_curve(evaluated: &[Vec<Vec<Vec<f64>>>], curve: usize, parameters: usize, seed: u32) -> Sensitivity {
    // Sums over the points of a curve, about its mean: estimates are the more exact the smaller the values.
    let length = evaluated[0][0][curve].len();
    let bases = || evaluated.iter().flat_map(|all| all[..2].iter());
    let mean: Vec<f64> = (0..length)
        .map(|k| bases().map(|curves| curves[curve][k]).sum::<f64>() / (2.0 * evaluated.len() as f64))
        .collect();
    let terms: Vec<(f64, Vec<[f64; 2]>)> = evaluated
        .iter()
        .map(|all| {
            let at = |which: usize, k: usize| all[which][curve][k] - mean[k];
            let over = |term: &dyn Fn(usize) -> f64| (0..length).map(term).sum::<f64>();
            let variance = over(&|k| 0.5 * (at(0, k).powi(2) + at(1, k).powi(2)));
            let of_parameter = |j: usize| {
                let first = over(&|k| at(1, k) * (at(j + 2, k) - at(0, k)));
                [first, over(&|k| 0.5 * (at(0, k) - at(j + 2, k)).powi(2))]
            };
            (variance, (0..parameters).map(of_parameter).collect())
        })
        .collect();
    let estimate = |chosen: &[usize], parameter: usize, which: usize| {
        let variance: f64 = chosen.iter().map(|k| terms[*k].0).sum();
        let part: f64 = chosen.iter().map(|k| terms[*k].1[parameter][which]).sum();
        if variance > 0.0 { part / variance } else { 0.0 }
    };
    let all: Vec<usize> = (0..terms.len()).collect();
    let mut random: ChaCha8Rng = stream(u64::from(seed), 1);
    let drawn: Vec<Vec<usize>> = (0..REPETITIONS)
        .map(|_| (0..terms.len()).map(|_| index(&mut random, terms.len())).collect())
        .collect();
    let with_interval = |parameter: usize, which: usize| {
        let mut repeated: Vec<f64> = drawn.iter().map(|chosen| estimate(chosen, parameter, which)).collect();
        repeated.sort_by(f64::total_cmp);
        let [low, high] = [0.05, 0.95].map(|share| quantile_of_sorted(&repeated, share));
        SobolIndex { value: estimate(&all, parameter, which), low, high }
    };
    Sensitivity {
        first: (0..parameters).map(|k| with_interval(k, 0)).collect(),
        total: (0..parameters).map(|k| with_interval(k, 1)).collect(),
        variance: terms.iter().map(|(variance, _)| variance).sum::<f64>() / terms.len() as f64,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Golden: the function of Ishigami and Homma (1990) with a = 7 and b = 0.1: first indices 0.3139, 0.4424, 0; total ones 0.5576, 0.4424,
    /// 0.2437.
    fn ishigami(shares: &[f64]) -> f64 {
        let [x, y, z] = [shares[0], shares[1], shares[2]].map(|share| PI * (2.0 * share - 1.0));
        x.sin() + 7.0 * y.sin().powi(2) + 0.1 * z.powi(4) * x.sin()
    }

    #[test]
    fn indices_of_ishigamis_function() {
        let found = sensitivities(3, 4096, 1, 0, |x| Ok(vec![vec![ishigami(x)]])).unwrap();
        let check = |indices: &[SobolIndex], expected: [f64; 3]| {
            for (found, expected) in indices.iter().zip(expected) {
                assert!((found.value - expected).abs() < 0.02, "{found:?} {expected}");
                assert!(found.low - 0.02 < expected && expected < found.high + 0.02, "{found:?} {expected}");
            }
        };
        check(&found[0].first, [0.3139, 0.4424, 0.0]);
        check(&found[0].total, [0.5576, 0.4424, 0.2437]);
        assert!((found[0].variance - 13.845).abs() < 0.1, "{}", found[0].variance);
    }

    /// A curve of two points with variances 1 and 4 times that of a share: its first parameter has a fifth of the variance.
    #[test]
    fn a_curve_has_the_indices_of_its_points_by_their_variances() {
        let curves = |x: &[f64]| Ok(vec![vec![x[0], 2.0 * x[1]], vec![x[1]]]);
        let found = sensitivities(2, 512, 3, 1, curves).unwrap();
        for (index, expected) in found[0].first.iter().chain(&found[0].total).zip([0.2, 0.8, 0.2, 0.8]) {
            assert!((index.value - expected).abs() < 0.01, "{index:?} {expected}");
        }
        assert!((found[1].total[0].value).abs() < 1e-12 && (found[1].first[1].value - 1.0).abs() < 0.01);
        assert_eq!(sensitivities(2, 512, 3, 4, curves).unwrap(), found);
        assert!(sensitivities(0, 8, 1, 1, curves).is_err());
    }
}
