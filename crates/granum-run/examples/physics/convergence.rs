//! Convergence of the curves with the time step, the inertial number and the number of grains.

use std::error::Error;

use super::runs::{CURVES, Laws, Test, deviation, distance, mean, of_seeds, sample, sheared, within};

/// Range of strain in which the curves are compared: beyond the initial elastic response.
const RANGE: std::ops::Range<f64> = 0.015..1.0;
/// Friction of the compaction.
const FRICTION: f64 = 0.1;

/// Compares the time step factors 0.2, 0.1 and 0.05 on samples of 1000 grains.
pub fn time_step(laws: Laws) -> Result<(), Box<dyn Error>> {
    let tests = [0.2, 0.1, 0.05].map(|time_step_factor| Test { time_step_factor, ..Test::default() });
    compare(laws, &tests, |t| format!("time step factor {}", t.time_step_factor))
}

/// Compares inertial numbers from 2e-3 to 2.5e-4, each half the one before, on samples of 1000 grains.
pub fn rate(laws: Laws) -> Result<(), Box<dyn Error>> {
    let tests = [2e-3, 1e-3, 5e-4, 2.5e-4].map(|inertial_number| Test { inertial_number, ..Test::default() });
    compare(laws, &tests, |t| format!("inertial number {}", t.inertial_number))
}

/// Prints means over the strain, averaged over two samples of 1000 grains each.
fn compare(laws: Laws, tests: &[Test], name: impl Fn(&Test) -> String) -> Result<(), Box<dyn Error>> {
    let samples = [sample(laws, 1000, FRICTION, 1)?, sample(laws, 1000, FRICTION, 2)?];
    println!("means over the strain, two samples: {CURVES:?}; rms distance of q/p from the first row");
    let mut first = Vec::new();
    for &test in tests {
        let runs = samples.iter().map(|s| sheared(s, test)).collect::<Result<Vec<_>, _>>()?;
        let mut line = format!("{:24}", name(&test));
        for column in CURVES {
            for run in &runs {
                line += &format!(" {:.4}", mean(&within(run, column, RANGE)?));
            }
            line += ";";
        }
        let ratio = within(&runs[0], CURVES[0], RANGE)?;
        if first.is_empty() {
            first.clone_from(&ratio);
        }
        println!("{line} {:.4}", distance(&ratio, &first));
    }
    Ok(())
}

/// Numbers of grains for which the scatter is determined.
const SIZES: [usize; 5] = [1000, 2000, 5000, 10_000, 20_000];

/// Prints the scatter between seeds as a function of the number of grains, and the exponent of its decrease.
pub fn size(laws: Laws) -> Result<(), Box<dyn Error>> {
    const SEEDS: usize = 6;
    println!(
        "grains: for each of {CURVES:?} the mean, and the deviation between {SEEDS} seeds (rms over the states)"
    );
    // Indices: quantity, size, seed, state.
    let mut all: Vec<Vec<Vec<Vec<f64>>>> = vec![Vec::new(); CURVES.len()];
    for count in SIZES {
        let test = Test { inertial_number: 2e-3, states: 10, ..Test::default() };
        let runs = of_seeds(SEEDS, |seed| sheared(&sample(laws, count, FRICTION, seed)?, test))?;
        let mut line = format!("{count:5}");
        for (k, column) in CURVES.iter().enumerate() {
            let curves = runs.iter().map(|r| within(r, column, RANGE)).collect::<Result<Vec<_>, _>>()?;
            line += &format!("; {:.4} {:.5}", mean(&curves.concat()), scatter(&curves, None));
            all[k].push(curves);
        }
        println!("{line}");
    }
    let exponents: Vec<String> = all
        .iter()
        .map(|sizes| {
            let of = |without| exponent(&sizes.iter().map(|c| scatter(c, without)).collect::<Vec<_>>());
            format!("{:.2} +- {:.2}", of(None), jackknife(SEEDS, |seed| of(Some(seed))))
        })
        .collect();
    println!("exponents, with their standard errors (jackknife over the seeds): {}", exponents.join("; "));
    Ok(())
}

/// Standard deviation between the curves of the seeds, as a root mean square over the states, for all seeds or for all but
/// one.
fn scatter(curves: &[Vec<f64>], without: Option<usize>) -> f64 {
    let seeds: Vec<&Vec<f64>> =
        curves.iter().enumerate().filter(|(k, _)| Some(*k) != without).map(|(_, c)| c).collect();
    let square = |state: usize| deviation(&seeds.iter().map(|c| c[state]).collect::<Vec<f64>>()).powi(2);
    mean(&(0..curves[0].len()).map(square).collect::<Vec<f64>>()).sqrt()
}

/// Jackknife estimate of the standard error of a function of `count` samples, from its values without each of them (Efron
/// and Stein 1981).
fn jackknife(count: usize, without: impl Fn(usize) -> f64) -> f64 {
    let values: Vec<f64> = (0..count).map(without).collect();
    let middle = mean(&values);
    let squares: f64 = values.iter().map(|v| (v - middle).powi(2)).sum();
    (squares * (count - 1) as f64 / count as f64).sqrt()
}

/// Slope of the logarithm of the scatter over the logarithm of the number of grains.
fn exponent(scatter: &[f64]) -> f64 {
    let x: Vec<f64> = SIZES.iter().map(|&n| (n as f64).ln()).collect();
    let y: Vec<f64> = scatter.iter().map(|s| s.ln()).collect();
    let (mx, my) = (mean(&x), mean(&y));
    let product: f64 = x.iter().zip(&y).map(|(a, b)| (a - mx) * (b - my)).sum();
    product / x.iter().map(|a| (a - mx).powi(2)).sum::<f64>()
}
