//! Convergence of the curves: in the time step, in the inertial number and in the number of grains.

use std::error::Error;

use super::runs::{CURVES, Laws, Test, deviation, distance, mean, of_seeds, sample, sheared, within};

/// Where the curves are compared: beyond the elastic rise.
const RANGE: std::ops::Range<f64> = 0.015..1.0;
/// Friction of the compaction.
const FRICTION: f64 = 0.1;

/// The time step factor 0.2 against 0.1 and 0.05, one sample of 1000 grains.
pub fn time_step(laws: Laws) -> Result<(), Box<dyn Error>> {
    let tests = [0.2, 0.1, 0.05].map(|time_step_factor| Test { time_step_factor, ..Test::default() });
    compare(laws, &tests, |t| format!("time step factor {}", t.time_step_factor))
}

/// I, I/2 and I/4, one sample of 1000 grains.
pub fn rate(laws: Laws) -> Result<(), Box<dyn Error>> {
    let tests = [2e-3, 1e-3, 5e-4, 2.5e-4].map(|inertial_number| Test { inertial_number, ..Test::default() });
    compare(laws, &tests, |t| format!("inertial number {}", t.inertial_number))
}

/// Means over the strain, of two samples of 1000 grains each.
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

/// Numbers of grains for the scatter.
const SIZES: [usize; 5] = [1000, 2000, 5000, 10_000, 20_000];

/// Scatter between seeds against the number of grains, and the exponent with which it falls.
pub fn size(laws: Laws) -> Result<(), Box<dyn Error>> {
    const SEEDS: usize = 6;
    println!(
        "grains: for each of {CURVES:?} the mean, and the deviation between {SEEDS} seeds (rms over the states)"
    );
    // Of each curve and size: the curves of all seeds.
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

/// Deviation between the curves of the seeds, rms over the states, with all seeds or all but one.
fn scatter(curves: &[Vec<f64>], without: Option<usize>) -> f64 {
    let seeds: Vec<&Vec<f64>> =
        curves.iter().enumerate().filter(|(k, _)| Some(*k) != without).map(|(_, c)| c).collect();
    let square = |state: usize| deviation(&seeds.iter().map(|c| c[state]).collect::<Vec<f64>>()).powi(2);
    mean(&(0..curves[0].len()).map(square).collect::<Vec<f64>>()).sqrt()
}

/// Standard error of what depends on `count` samples, from its values without each of them (Efron and Stein 1981).
fn jackknife(count: usize, without: impl Fn(usize) -> f64) -> f64 {
    let values: Vec<f64> = (0..count).map(without).collect();
    let middle = mean(&values);
    let squares: f64 = values.iter().map(|v| (v - middle).powi(2)).sum();
    (squares * (count - 1) as f64 / count as f64).sqrt()
}

/// Slope of the logarithm of the scatter against that of the number of grains.
fn exponent(scatter: &[f64]) -> f64 {
    let x: Vec<f64> = SIZES.iter().map(|&n| (n as f64).ln()).collect();
    let y: Vec<f64> = scatter.iter().map(|s| s.ln()).collect();
    let (mx, my) = (mean(&x), mean(&y));
    let product: f64 = x.iter().zip(&y).map(|(a, b)| (a - mx) * (b - my)).sum();
    product / x.iter().map(|a| (a - mx).powi(2)).sum::<f64>()
}
