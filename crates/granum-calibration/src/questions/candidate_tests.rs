//! Tests that could be added to those that are calibrated on: those of the laboratory's files that are not used, and new ones at other
//! stresses and densities, as far as the simulations reach from which the surrogate learned.

use granum_io::LaboratoryTest;

use crate::compared::curve::MeasuredCurve;
use crate::error::Result;
use crate::file::{CalibrationFile, TestCondition};
use crate::questions::next_test::CandidateTest;
use crate::simulations::emulator::Emulator;
use crate::simulations::target::{TargetTest, conditions, target};

/// Levels of the stress and of the density of new tests.
const LEVELS: usize = 5;
/// Relative width of a range below which it is one value.
const ONE_VALUE: f64 = 1e-3;

/// The tests of the laboratory that are not among the targets and that have all that a target needs.
pub fn unused_tests(
    file: &CalibrationFile,
    emulator: &Emulator,
    tests: &[LaboratoryTest],
    targets: &[TargetTest],
) -> Result<Vec<(CandidateTest, TargetTest)>> {
    let mut found = Vec::new();
    for test in tests.iter().filter(|test| !targets.iter().any(|target| target.name == test.name)) {
        let Ok(target) = target(file, test) else { continue };
        let candidate = CandidateTest {
            name: test.name.clone(),
            is_measured: true,
            mean_stress: target.mean_stress,
            void_ratio: depends_on_density(file).then(|| test.void_ratio.first().copied()).flatten(),
        };
        if is_simulated(file, emulator, &target)? {
            found.push((candidate, target));
        }
    }
    Ok(found)
}

/// New tests with an isotropic start, over the ranges of stress and density of the simulations where variables take these from the tests;
/// of a density that an expression maps, over the range of the laboratory's tests. None where neither varies.
///
/// # Errors
/// If the surrogate has no prediction.
pub fn new_tests(
    file: &CalibrationFile,
    emulator: &Emulator,
    tests: &[LaboratoryTest],
    targets: &[TargetTest],
) -> Result<Vec<(CandidateTest, TargetTest)>> {
    let Some(first) = targets.first() else { return Ok(Vec::new()) };
    let stresses = stresses(file, emulator, tests).unwrap_or_else(|| vec![first.mean_stress]);
    let densities = densities(file, emulator, tests);
    let count = densities.as_ref().map_or(1, |(_, levels)| levels.len());
    if stresses.len() * count < 2 {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    for stress in stresses {
        for k in 0..count {
            let void_ratio =
                densities.as_ref().map(|(condition, levels)| void_ratio(file, *condition, levels[k], stress));
            let name = match void_ratio {
                Some(e) => format!("a new one at {:.0} kPa and a void ratio of {e:.3}", stress / 1e3),
                None => format!("a new one at {:.0} kPa", stress / 1e3),
            };
            let candidate = CandidateTest { name, is_measured: false, mean_stress: stress, void_ratio };
            let target = new_test(file, &candidate, first)?;
            if is_simulated(file, emulator, &target)? {
                let target = with_expected_readings(file, emulator, target)?;
                found.push((candidate, target));
            }
        }
    }
    Ok(found)
}

fn depends_on_density(file: &CalibrationFile) -> bool {
    file.conditions.iter().any(|(_, condition)| is_density(*condition))
}

fn is_density(condition: TestCondition) -> bool {
    match condition {
        TestCondition::VoidRatio | TestCondition::RelativeDensity | TestCondition::StateParameter => true,
        TestCondition::LateralStress | TestCondition::MeanStress => false,
    }
}

/// The range of a variable that tests give: over the simulations if it sets a key, otherwise over the tests.
fn range(
    file: &CalibrationFile,
    emulator: &Emulator,
    tests: &[LaboratoryTest],
    place: usize,
) -> Option<[f64; 2]> {
    let (name, condition) = &file.conditions[place];
    let keys = file.plan.variables.iter().find(|variable| variable.name == *name).map(|found| &found.keys);
    if let Some(key) = keys.and_then(|keys| keys.first()) {
        return emulator.range_of(&key.value);
    }
    // Between the loosest and the densest state of the laboratory, as far as the simulations reach.
    let limits: &[f64] = if *condition == TestCondition::RelativeDensity { &[0.0, 1.0] } else { &[] };
    let of_tests = tests.iter().filter_map(|test| conditions(file, test).ok()).map(|values| values[place]);
    let [low, high] = granum_learn::curve::range(of_tests.chain(limits.iter().copied()));
    (low <= high).then_some([low, high])
}

/// Stresses of new tests, in equal ratios.
fn stresses(file: &CalibrationFile, emulator: &Emulator, tests: &[LaboratoryTest]) -> Option<Vec<f64>> {
    let place = file.conditions.iter().position(|(_, condition)| !is_density(*condition))?;
    let [low, high] = range(file, emulator, tests, place).filter(|[low, _]| *low > 0.0)?;
    if high < low * (1.0 + ONE_VALUE) {
        return Some(vec![low]);
    }
    let level = |k: usize| match k {
        0 => low,
        k if k + 1 == LEVELS => high,
        k => low * libm::pow(high / low, k as f64 / (LEVELS - 1) as f64),
    };
    Some((0..LEVELS).map(level).collect())
}

/// Densities of new tests in the measure by which the first such variable knows them, in equal steps.
fn densities(
    file: &CalibrationFile,
    emulator: &Emulator,
    tests: &[LaboratoryTest],
) -> Option<(TestCondition, Vec<f64>)> {
    let place = file.conditions.iter().position(|(_, condition)| is_density(*condition))?;
    let [low, high] = range(file, emulator, tests, place)?;
    let levels = if high - low < ONE_VALUE { 1 } else { LEVELS };
    let level =
        |k: usize| if k + 1 == levels { high } else { low + (high - low) * k as f64 / (levels - 1) as f64 };
    Some((file.conditions[place].1, (0..levels).map(level).collect()))
}

/// The void ratio of a density in the measure of a condition.
fn void_ratio(file: &CalibrationFile, condition: TestCondition, value: f64, mean_stress: f64) -> f64 {
    let table = &file.calibration;
    match condition {
        TestCondition::RelativeDensity => {
            // The file was refused without the limits.
            let [densest, loosest] = table.void_ratio_limits.unwrap_or([0.0, 1.0]);
            loosest - value * (loosest - densest)
        }
        TestCondition::StateParameter => {
            value + table.critical_state.map_or(0.0, |line| line.at(mean_stress))
        }
        _ => value,
    }
}

/// A test that starts from an isotropic stress, without readings.
fn new_test(file: &CalibrationFile, candidate: &CandidateTest, like: &TargetTest) -> Result<TargetTest> {
    let start = LaboratoryTest {
        name: candidate.name.clone(),
        axial_strain: vec![0.0],
        deviator_stress: vec![0.0],
        mean_stress: vec![candidate.mean_stress],
        void_ratio: candidate.void_ratio.into_iter().collect(),
        ..LaboratoryTest::default()
    };
    Ok(TargetTest {
        name: candidate.name.clone(),
        conditions: conditions(file, &start)?,
        mean_stress: candidate.mean_stress,
        laboratory: LaboratoryTest { name: candidate.name.clone(), ..like.laboratory.clone() },
        curves: Vec::new(),
    })
}

/// The middle of the priors of the free variables.
fn middle(file: &CalibrationFile) -> Vec<f64> {
    file.free.iter().map(|free| free.prior.value(0.5)).collect()
}

/// True if the surrogate has learned from simulations on both sides of a test, at the middle of the priors.
fn is_simulated(file: &CalibrationFile, emulator: &Emulator, target: &TargetTest) -> Result<bool> {
    let one = emulator.for_targets(std::slice::from_ref(target));
    Ok(one.beyond_simulations(&middle(file))?.is_empty())
}

/// The test with the readings that the surrogate expects at the middle of the priors, on which the error of measurement depends.
fn with_expected_readings(
    file: &CalibrationFile,
    emulator: &Emulator,
    target: TargetTest,
) -> Result<TargetTest> {
    let one = emulator.for_targets(std::slice::from_ref(&target));
    let quantities = &file.calibration.quantities;
    let predicted = one.predict_test(&middle(file), 0, |place| Some(quantities[place].strains.clone()))?;
    let curve = |(place, predicted): (usize, Option<crate::compared::curve::PredictedCurve>)| {
        let compared = &quantities[place];
        let measured = MeasuredCurve {
            test: target.name.clone(),
            quantity: compared.quantity.word().into(),
            strain: compared.strains.clone(),
            measured: predicted?.mean,
            error: compared.error,
            weight: compared.weight,
        };
        Some((place, measured))
    };
    let curves = predicted.into_iter().enumerate().filter_map(curve).collect();
    Ok(TargetTest { curves, ..target })
}
