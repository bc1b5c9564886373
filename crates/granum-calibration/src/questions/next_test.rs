//! Which further test would tell most of the parameters, before anything is inferred.
//!
//! A test adds its Fisher information to that of the tests at hand, and with both the posterior has about the covariance
//! `(F + F_t + 12 I)^-1` of shares ([`crate::questions::identifiability`]): the test that would leave the smallest part of the priors' widths, on average over the
//! parameters, tells most. What would be read in it need not be known for this.
//!
//! Source: optimal design of experiments by the linearised posterior covariance, Chaloner and Verdinelli, Bayesian experimental design: a review,
//! Statistical Science 10 (1995), 273 to 304 (its criterion A).

use granum_core::words;
use granum_core::{Column, Table};
use granum_learn::regression::cholesky::Cholesky;
use serde::{Deserialize, Serialize};

use crate::compared::curve::MeasuredCurve;
use crate::error::{CalibrationError, Result};
use crate::file::CalibrationFile;
use crate::questions::identifiability::{contractions, fisher_information, precision};
use crate::questions::telling::points_of_priors;
use crate::simulations::emulator::Emulator;
use crate::simulations::simulation::parameters;
use crate::simulations::target::{TargetTest, all_curves};

/// A test that could be added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CandidateTest {
    /// Name of a test of the laboratory's files, or what a new one would be.
    pub name: String,
    /// True if the laboratory has carried it out, so that it only has to be used.
    pub is_measured: bool,
    /// Effective mean stress at its start, Pa.
    pub mean_stress: f64,
    /// Void ratio at its start, if a variable depends on the density.
    pub void_ratio: Option<f64>,
}

/// What would be left of the parameters' priors with a further test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorthOfTest {
    /// The test.
    #[serde(flatten)]
    pub test: CandidateTest,
    /// For each parameter, deviation of its posterior over that of its prior with the test and those at hand.
    pub left: Vec<f64>,
}

/// What further tests would tell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextTest {
    /// Names of the parameters.
    pub parameters: Vec<String>,
    /// For each parameter, deviation of its posterior over that of its prior with the tests at hand.
    pub left_now: Vec<f64>,
    /// The tests that could be added, the one that would tell most first.
    pub tests: Vec<WorthOfTest>,
}

impl NextTest {
    /// From the Fisher information of the tests at hand, of shares and row-major, and that of each further test.
    ///
    /// # Errors
    /// If one is not finite.
    pub fn from_fisher(
        parameters: Vec<String>,
        now: &[f64],
        candidates: Vec<(CandidateTest, Vec<f64>)>,
    ) -> Result<NextTest> {
        let count = parameters.len();
        let left_now = contractions(now, count)?;
        let worth = |(test, own): (CandidateTest, Vec<f64>)| {
            let sum: Vec<f64> = now.iter().zip(&own).map(|(a, b)| a + b).collect();
            Ok(WorthOfTest { test, left: contractions(&sum, count)? })
        };
        let mut tests = candidates.into_iter().map(worth).collect::<Result<Vec<_>>>()?;
        tests.sort_by(|a, b| mean(&a.left).total_cmp(&mean(&b.left)));
        Ok(NextTest { parameters, left_now, tests })
    }

    /// Asks a surrogate what tests would tell beside the targets.
    ///
    /// # Errors
    /// If the surrogate has no prediction at a point of the priors.
    pub fn new(
        file: &CalibrationFile,
        emulator: &Emulator,
        targets: &[TargetTest],
        candidates: Vec<(CandidateTest, TargetTest)>,
    ) -> Result<NextTest> {
        let free = parameters(file, targets);
        let names: Vec<String> = free.iter().map(|free| free.name.clone()).collect();
        // Variables that are own to each test have further coordinates in a further test.
        let shared: Vec<Option<usize>> = file
            .free
            .iter()
            .map(|variable| names.iter().position(|name| !variable.own && *name == variable.name))
            .collect();
        let seed = file.calibration.seed;
        let points = points_of_priors(names.len() + shared.len(), seed);
        let information = |targets: &[TargetTest], points: &[Vec<f64>]| {
            let curves: Vec<MeasuredCurve> = all_curves(targets);
            let all: Vec<usize> = (0..curves.len()).collect();
            let free = parameters(file, targets);
            fisher_information(&free, &curves, &all, &emulator.for_targets(targets), points)
        };
        let of_targets: Vec<Vec<f64>> = points.iter().map(|point| point[..names.len()].to_vec()).collect();
        let now = information(targets, &of_targets)?;
        let of_test: Vec<Vec<f64>> = points
            .iter()
            .map(|point| {
                let coordinate =
                    |(k, place): (usize, &Option<usize>)| point[place.unwrap_or(names.len() + k)];
                shared.iter().enumerate().map(coordinate).collect()
            })
            .collect();
        let mut found = Vec::new();
        for (candidate, target) in candidates {
            let own = information(std::slice::from_ref(&target), &of_test)?;
            found.push((candidate, of_shared(&own, &shared, names.len())?));
        }
        NextTest::from_fisher(names, &now, found)
    }

    /// A line for the test of the laboratory's files and for the new one that would tell most; none if there are no such tests.
    pub fn lines(&self) -> Vec<String> {
        let line = |is_measured: bool| {
            let best = self.tests.iter().find(|one| one.test.is_measured == is_measured)?;
            let start = match is_measured {
                true => {
                    format!("of the laboratory's tests that are not used, {} would tell most", best.test.name)
                }
                false => format!("the next test that would tell most: {}", best.test.name),
            };
            let gain = |k: &usize| self.left_now[*k] - best.left[*k];
            let most = (0..self.parameters.len()).max_by(|a, b| gain(a).total_cmp(&gain(b)))?;
            let percent = |share: f64| words::percent(share, 0);
            Some(format!(
                "{start}: with it {} of the priors' widths would be left on average in place of {}; of {} {} in place of {}",
                percent(mean(&best.left)),
                percent(mean(&self.left_now)),
                self.parameters[most],
                percent(best.left[most]),
                percent(self.left_now[most])
            ))
        };
        [true, false].into_iter().filter_map(line).collect()
    }

    /// A row for the tests at hand and for each further test: what would be left of the prior's width of each parameter and on average.
    ///
    /// # Errors
    /// If the columns do not make a table.
    pub fn table(&self) -> Result<Table> {
        let none =
            CandidateTest { name: "none".into(), is_measured: true, mean_stress: f64::NAN, void_ratio: None };
        let now = WorthOfTest { test: none, left: self.left_now.clone() };
        let rows: Vec<&WorthOfTest> = std::iter::once(&now).chain(&self.tests).collect();
        let numbers = |name: &str, unit: &str, value: &dyn Fn(&WorthOfTest) -> f64| {
            Column::new(name, unit, rows.iter().map(|row| value(row)).collect())
        };
        let measured = |row: &&WorthOfTest| if row.test.is_measured { "yes" } else { "no" }.to_string();
        let mut columns = vec![
            Column::of_words("further_test", rows.iter().map(|row| row.test.name.clone())),
            Column::of_words("measured", rows.iter().map(measured)),
            numbers("mean_stress", "Pa", &|row| row.test.mean_stress),
            numbers("void_ratio", "", &|row| row.test.void_ratio.unwrap_or(f64::NAN)),
            numbers("left", "", &|row| mean(&row.left)),
        ];
        for (k, name) in self.parameters.iter().enumerate() {
            columns.push(numbers(&format!("left_of_{name}"), "", &|row| row.left[k]));
        }
        Ok(Table::new(columns).map_err(granum_learn::LearnError::from)?)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// What a test tells of the parameters that it shares with others, whose places are given: variables that are own to it are free beside
/// them, `F_ss - F_so (F_oo + 12 I)^-1 F_os`.
fn of_shared(own: &[f64], places: &[Option<usize>], count: usize) -> Result<Vec<f64>> {
    let variables = places.len();
    let unshared: Vec<usize> = (0..variables).filter(|k| places[*k].is_none()).collect();
    let entry = |i: usize, j: usize| own[i * variables + j];
    let inner: Vec<f64> = unshared.iter().flat_map(|i| unshared.iter().map(|j| entry(*i, *j))).collect();
    let factor = Cholesky::new(unshared.len(), &precision(&inner, unshared.len()))
        .ok_or_else(|| CalibrationError::Input("the Fisher information is not finite".into()))?;
    let beside = |i: usize| factor.solve_lower(&unshared.iter().map(|j| entry(*j, i)).collect::<Vec<_>>());
    let mut all = vec![0.0; count * count];
    for (i, a) in places.iter().enumerate() {
        for (j, b) in places.iter().enumerate() {
            let (Some(a), Some(b)) = (a, b) else { continue };
            let lost: f64 = beside(i).iter().zip(beside(j)).map(|(x, y)| x * y).sum();
            all[a * count + b] = entry(i, j) - lost;
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compared::curve::{MeasurementError, PredictedCurve};
    use crate::inference::likelihood::FreeParameter;
    use crate::inference::prior::Prior;

    /// A strength c + p f of tests at a stress p, of which cohesion c and friction f are to be found, read with an error of 0.1.
    fn information(stress: f64) -> Vec<f64> {
        let uniform =
            |name: &str| FreeParameter { name: name.into(), prior: Prior::Uniform { from: 0.0, to: 1.0 } };
        let free = ["cohesion", "friction"].map(uniform);
        let curve = MeasuredCurve {
            test: "T".into(),
            quantity: "strength".into(),
            strain: vec![0.1],
            measured: vec![1.0],
            error: MeasurementError { absolute: 0.1, relative: 0.0, correlation_strain: 0.0 },
            weight: 1.0,
        };
        let strength = |values: &[f64]| {
            Some(vec![PredictedCurve {
                mean: vec![values[0] + stress * values[1]],
                ..PredictedCurve::default()
            }])
        };
        fisher_information(&free, &[curve], &[0], &strength, &[vec![0.5; 2]]).unwrap()
    }

    fn at(stress: f64, is_measured: bool) -> (CandidateTest, Vec<f64>) {
        let name = format!("at {stress}");
        (CandidateTest { name, is_measured, mean_stress: stress, void_ratio: None }, information(stress))
    }

    fn found(candidates: Vec<(CandidateTest, Vec<f64>)>) -> NextTest {
        let names = vec!["cohesion".to_string(), "friction".to_string()];
        NextTest::from_fisher(names, &information(1.0), candidates).unwrap()
    }

    /// A line through two points has its intercept and its slope from points that are far apart.
    #[test]
    fn the_test_that_lies_farthest_from_those_at_hand_tells_most() {
        let found = found(vec![at(1.0, false), at(1.5, true), at(3.0, false), at(0.9, true)]);
        let order: Vec<f64> = found.tests.iter().map(|one| one.test.mean_stress).collect();
        assert_eq!(order[..2], [3.0, 1.5], "{found:?}");
        // Golden: F = 100 (1 p; p p^2) for each stress, and the inverse of (200 + 12, 400; 400, 1000 + 12) with p = 1 and 3.
        let determinant: f64 = 212.0 * 1012.0 - 400.0 * 400.0;
        let expected = [1012.0, 212.0].map(|entry: f64| (12.0 * entry / determinant).sqrt());
        for (found, expected) in found.tests[0].left.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        // With the test at hand alone: (112, 100; 100, 112).
        let now = (12.0f64 * 112.0 / (112.0 * 112.0 - 1e4)).sqrt();
        assert!((found.left_now[0] - now).abs() < 1e-9, "{:?}", found.left_now);
        let lines = found.lines();
        assert!(lines[0].contains("not used, at 1.5 would tell most"), "{lines:?}");
        assert!(
            lines[1].contains("would tell most: at 3: with it") && lines[1].contains("of friction"),
            "{lines:?}"
        );
        let table = found.table().unwrap();
        assert_eq!(table.rows(), 5);
        assert_eq!(table.values("left_of_friction").unwrap()[1], found.tests[0].left[1]);
    }

    /// A variable that is own to the test is averaged out: the strength of a test whose own shift is free tells less.
    #[test]
    fn what_is_own_to_a_test_is_free_beside_what_it_tells() {
        // A reading of friction + shift with an error of 0.1: of friction alone its variance is 0.01 + 1/12.
        let own = [100.0, 100.0, 100.0, 100.0];
        let told = of_shared(&own, &[Some(1), None], 2).unwrap();
        assert!((told[3] - 1.0 / (0.01 + 1.0 / 12.0)).abs() < 1e-9, "{told:?}");
        assert_eq!(told[..3], [0.0; 3]);
        assert_eq!(of_shared(&own, &[Some(0), Some(1)], 2).unwrap(), own);
    }
}
