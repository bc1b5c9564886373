//! Which further simulation would reduce most what the surrogate adds to the error of the compared curves, at the posterior.
//!
//! A simulation at x' reduces the variance of a process at x by `c(x, x')^2 / (v(x') + n)`, whatever it turns out to give, with the covariance c of the
//! process at both, its variance v and the noise n of a single run. Candidates are points of the posterior and of the priors, in each test. The one is
//! chosen whose reduction, over the variance of the error of measurement and surrogate together, is the largest on average over draws from
//! the posterior, tests, quantities and strains.
//!
//! Source: Cohn, Neural network exploration using optimal experiment design, Neural Networks 9 (1996), 1071 to 1083; for Gaussian processes
//! Gramacy and Lee, Technometrics 51 (2009), 130 to 145.

use granum_core::parallel;
use serde::{Deserialize, Serialize};

use crate::error::{CalibrationError, Result};
use crate::file::CalibrationFile;
use crate::posterior::outcome::Outcome;
use crate::simulations::emulator::Emulator;
use crate::simulations::simulation::{of_test, parameters};
use crate::simulations::target::TargetTest;

/// Draws from the posterior at which the error is asked.
const DRAWS: usize = 24;
/// Candidates of the posterior and as many of the priors, over all tests.
const CANDIDATES: usize = 96;
/// Fewest and most of them in each test.
const OF_EACH_TEST: [usize; 2] = [4, 24];

/// The simulation that would tell most.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextRun {
    /// The test.
    pub test: String,
    /// Name, SI unit and value of each free variable.
    pub values: Vec<(String, String, f64)>,
    /// Part of the variance of the error of the compared curves, of measurement and surrogate, that more simulations would reduce.
    pub now: f64,
    /// The same after this simulation.
    pub then: f64,
}

/// Where an error is asked: the inputs of the processes, the quantity, the strains and the variance of the error at each.
struct Asked {
    inputs: Vec<f64>,
    place: usize,
    strain: Vec<f64>,
    error: Vec<f64>,
}

impl NextRun {
    /// Asks the surrogate of these targets; `None` if it has nothing that simulations would reduce.
    ///
    /// # Errors
    /// If an expression of the file has no value at a draw.
    pub fn new(
        file: &CalibrationFile,
        emulator: &Emulator,
        targets: &[TargetTest],
        outcome: &Outcome,
        threads: usize,
    ) -> Result<Option<NextRun>> {
        let curves = emulator.curves()?;
        let mut asked = Vec::new();
        let mut now = 0.0;
        for draw in outcome.spread(DRAWS) {
            for (test, target) in targets.iter().enumerate() {
                for one in asked_of(file, emulator, target, test, &draw)? {
                    let variance = curves.reducible_variance(&one.inputs, one.place, &one.strain)?;
                    now += mean_ratio(&variance, &one.error);
                    asked.push(one);
                }
            }
        }
        let number = asked.len().max(1) as f64;
        let candidates = candidates(file, targets, outcome);
        let gains = parallel::map(candidates.len(), threads, |k| {
            let (test, values) = &candidates[k];
            let further = curves.further_run(&emulator.inputs(values, *test)?)?;
            let mut gain = 0.0;
            for one in &asked {
                let reduced = curves.reduced_variance(&one.inputs, one.place, &one.strain, &further)?;
                gain += mean_ratio(&reduced, &one.error);
            }
            Ok::<f64, CalibrationError>(gain / number)
        })?;
        let best = (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]));
        let Some(best) = best.filter(|best| gains[*best] > 0.0) else { return Ok(None) };
        let (test, values) = &candidates[best];
        let own = of_test(file, targets.len(), values, *test);
        let value =
            |(free, value): (&crate::file::FreeVariable, f64)| (free.name.clone(), free.unit.clone(), value);
        Ok(Some(NextRun {
            test: targets[*test].name.clone(),
            values: file.free.iter().zip(own).map(value).collect(),
            now: now / number,
            then: now / number - gains[best],
        }))
    }

    /// The simulation in a line.
    pub fn line(&self) -> String {
        let value = |(name, unit, value): &(String, String, f64)| match unit.is_empty() {
            true => format!("{name} {value:.3}"),
            false => format!("{name} {value:.2e} {unit}"),
        };
        let values: Vec<String> = self.values.iter().map(value).collect();
        format!(
            "the next simulation that would tell most: the test {} with {}; of the variance of the error of the compared curves more simulations \
             would reduce {:.0} % now and {:.0} % after it",
            self.test,
            values.join(", "),
            100.0 * self.now,
            100.0 * self.then
        )
    }
}

fn mean_ratio(variance: &[f64], error: &[f64]) -> f64 {
    let ratio = |(variance, error): (&f64, &f64)| if *error > 0.0 { variance / error } else { 0.0 };
    variance.iter().zip(error).map(ratio).sum::<f64>() / variance.len().max(1) as f64
}

/// The compared curves of a test at a draw, in the measures of the processes.
fn asked_of(
    file: &CalibrationFile,
    emulator: &Emulator,
    target: &TargetTest,
    test: usize,
    draw: &[f64],
) -> Result<Vec<Asked>> {
    let inputs = emulator.inputs(draw, test)?;
    let mut found = Vec::new();
    for (place, curve) in &target.curves {
        let compared = &file.calibration.quantities[*place];
        let predicted = emulator.curves()?.correlated_curve(&inputs, *place, &curve.strain)?;
        let scale = file.calibration.scale(compared.quantity, target.mean_stress);
        let count = curve.strain.len();
        let error = |k: usize| {
            let measurement = compared.error.deviation(scale * predicted.mean[k]) / scale;
            predicted.covariance[k * count + k] + measurement * measurement
        };
        let error = (0..count).map(error).collect();
        found.push(Asked { inputs: inputs.clone(), place: *place, strain: curve.strain.clone(), error });
    }
    Ok(found)
}

/// Points of the posterior and of the priors, each in every test: the place of the test and the values of all parameters.
fn candidates(file: &CalibrationFile, targets: &[TargetTest], outcome: &Outcome) -> Vec<(usize, Vec<f64>)> {
    let count = (CANDIDATES / targets.len().max(1)).clamp(OF_EACH_TEST[0], OF_EACH_TEST[1]);
    let free = parameters(file, targets);
    let seed = file.calibration.seed ^ 0x0ca4_d1da;
    let of_priors = (0..count).map(|k| {
        let share = |j: usize| f64::from(sobol_burley::sample(k as u32, j as u32, seed)).clamp(0.005, 0.995);
        free.iter().enumerate().map(|(j, free)| free.prior.value(share(j))).collect()
    });
    let points: Vec<Vec<f64>> = outcome.spread(count).into_iter().chain(of_priors).collect();
    points.iter().flat_map(|point| (0..targets.len()).map(|test| (test, point.clone()))).collect()
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;
    use granum_io::LaboratoryTest;

    use super::*;
    use crate::file::file_for_tests;
    use crate::inference::prior::Prior;
    use crate::simulations::known::KnownRun;
    use crate::simulations::simulation::CaseNumbers;

    const FILE: &str = "case = \"sand.toml\"
[calibration]
[[calibration.quantity]]
name = \"deviator_stress\"
to = \"10 %\"
points = 4
[[variable]]
name = \"friction\"
key = \"grains.material.friction\"
prior = \"uniform\"
from = 0.1
to = 1
";

    /// A curve whose height is a wave of the friction.
    fn test_of(friction: f64) -> LaboratoryTest {
        let strain: Vec<f64> = (0..=24).map(|k| f64::from(k) / 200.0).collect();
        let height = 1e5 * (1.5 + (7.0 * friction).sin());
        LaboratoryTest {
            name: "T".into(),
            deviator_stress: strain.iter().map(|x| height * x / (x + 0.01)).collect(),
            mean_stress: vec![1e5; strain.len()],
            axial_strain: strain,
            ..LaboratoryTest::default()
        }
    }

    /// The simulation that tells most lies where the posterior is and where there are no simulations, and not where there are none but nothing
    /// is asked.
    #[test]
    fn the_next_run_is_where_the_posterior_is_and_the_runs_are_not() {
        let file = file_for_tests(FILE);
        let targets = crate::simulations::target::targets(&file, &[test_of(0.6)]).unwrap();
        let frictions = [0.1, 0.15, 0.2, 0.22, 0.26, 0.3, 0.34, 0.37, 0.4, 0.43, 0.46, 0.74, 0.78];
        let known: Vec<KnownRun> = frictions
            .iter()
            .map(|friction| KnownRun {
                name: format!("{friction}"),
                numbers: vec![*friction],
                mean_stress: 1e5,
                curves: test_of(*friction),
            })
            .collect();
        let numbers = CaseNumbers::new(&file);
        let emulator = Emulator::fit(&file, &targets, numbers, &known, 1, &mut NoObserver).unwrap();
        let prior = [Prior::Uniform { from: 0.0, to: 1.0 }];
        let points: Vec<Vec<f64>> = (0..41).map(|k| vec![0.55 + 0.0025 * f64::from(k)]).collect();
        let outcome = Outcome::from_weighted(vec!["friction".into()], &prior, &points, &[1.0 / 41.0; 41], 1);
        let next = NextRun::new(&file, &emulator, &targets, &outcome, 1).unwrap().unwrap();
        let (name, _, friction) = &next.values[0];
        assert_eq!((next.test.as_str(), name.as_str()), ("T", "friction"));
        assert!((0.5..0.7).contains(friction), "{next:?}");
        assert!(next.then < 0.7 * next.now && next.then >= 0.0 && next.now < 1.0, "{next:?}");
        let line = next.line();
        assert!(line.contains("the test T with friction 0."), "{line}");
        // With any number of threads the same.
        assert_eq!(NextRun::new(&file, &emulator, &targets, &outcome, 3).unwrap().unwrap(), next);
    }
}
