//! Targets of a calibration: the tests of a laboratory with their conditions and with what is compared of them.

use std::collections::BTreeSet;
use std::ops::Range;

use granum_core::words;
use granum_io::{Error, LaboratoryTest};
use granum_learn::curve::interpolated;

use crate::compared::curve::MeasuredCurve;
use crate::error::{CalibrationError, Result};
use crate::file::{CalibrationFile, ComparedQuantity, PredictedTests, TestCondition};

/// A test that simulations are to explain.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetTest {
    /// Its name.
    pub name: String,
    /// What it gives to the variables [`CalibrationFile::conditions`], in their order.
    pub conditions: Vec<f64>,
    /// Effective mean stress at its start, Pa, by which stresses of different tests are made comparable.
    pub mean_stress: f64,
    /// Its readings.
    pub laboratory: LaboratoryTest,
    /// What is compared, one curve for each quantity of the file that it has a reading of, with the place of the quantity.
    pub curves: Vec<(usize, MeasuredCurve)>,
}

/// Most tests that are calibrated on, and most that are predicted.
pub const MOST_TESTS: usize = 200;

/// The targets that a file asks for, in its order, or all tests that are not predicted.
///
/// # Errors
/// With the place in the file if there is no such test, and if a test has not what is compared or needed of it.
pub fn targets(file: &CalibrationFile, tests: &[LaboratoryTest]) -> Result<Vec<TargetTest>> {
    let table = &file.calibration;
    let names = || tests.iter().map(|test| test.name.as_str()).collect::<Vec<_>>().join(", ");
    let mut seen = BTreeSet::new();
    for test in tests {
        if !seen.insert(&test.name) {
            return Err(CalibrationError::Input(format!(
                "two tests have the name {:?}; calibrate on one of them, or rename one in its file",
                test.name
            )));
        }
    }
    if tests.is_empty() {
        return Err(CalibrationError::Input("no test of a laboratory is given".into()));
    }
    let is_predicted = |name: &String| match &table.predict {
        PredictedTests::Others => false,
        PredictedTests::Named(names) => names.contains(name),
    };
    let chosen: Vec<&LaboratoryTest> = match table.tests.is_empty() {
        true => tests.iter().filter(|test| !is_predicted(&test.name)).collect(),
        false => named(file, tests, &table.tests, &table.tests_span)?,
    };
    if let Some(both) = chosen.iter().find(|test| is_predicted(&test.name)) {
        let message =
            format!("the test {:?} is calibrated on, so that it cannot be predicted as well", both.name);
        return Err(CalibrationError::File(Error::from(
            file.plan.source.error(&table.predict_span, message),
        )));
    }
    if chosen.is_empty() {
        let message = format!("no test is left to calibrate on ({} are predicted)", names());
        return Err(CalibrationError::File(Error::from(
            file.plan.source.error(&table.predict_span, message),
        )));
    }
    check_number(chosen.len(), "calibrated on")?;
    chosen.into_iter().map(|test| target(file, test)).collect()
}

/// Refuses more tests than a calibration ends with in a reasonable time: each adds curves to every evaluation of the likelihood, and
/// simulations to every round.
fn check_number(tests: usize, what: &str) -> Result<()> {
    if tests <= MOST_TESTS {
        return Ok(());
    }
    Err(CalibrationError::Input(format!(
        "{tests} tests would be {what}, and at most {MOST_TESTS} are possible; choose among them by tests and predict in the table [calibration]"
    )))
}

/// The tests that a file asks to predict from the calibration on the others: those that are not among the targets, or those of its names.
///
/// # Errors
/// With the place in the file if there is no such test or a variable is own to each test, and if a test has not what is needed of it.
pub fn predicted(
    file: &CalibrationFile,
    tests: &[LaboratoryTest],
    targets: &[TargetTest],
) -> Result<Vec<TargetTest>> {
    let table = &file.calibration;
    let chosen: Vec<&LaboratoryTest> = match &table.predict {
        PredictedTests::Others => {
            tests.iter().filter(|test| !targets.iter().any(|target| target.name == test.name)).collect()
        }
        PredictedTests::Named(names) => named(file, tests, names, &table.predict_span)?,
    };
    if let Some(own) = file.free.iter().find(|free| free.own).filter(|_| !chosen.is_empty()) {
        let message =
            format!("{} is own to each test, so that no test can be predicted from other ones", own.name);
        return Err(CalibrationError::File(Error::from(
            file.plan.source.error(&table.predict_span, message),
        )));
    }
    check_number(chosen.len(), "predicted")?;
    chosen.into_iter().map(|test| target(file, test)).collect()
}

/// The first name that is there twice.
pub fn named_twice(names: &[String]) -> Option<&String> {
    names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)).map(|(_, name)| name)
}

/// The tests of these names.
fn named<'a>(
    file: &CalibrationFile,
    tests: &'a [LaboratoryTest],
    wanted: &[String],
    span: &Range<usize>,
) -> Result<Vec<&'a LaboratoryTest>> {
    if let Some(twice) = named_twice(wanted) {
        let message = format!("the test {twice:?} is named twice");
        let error = file.plan.source.error(span, message);
        let help =
            "name it once: a test that counts twice makes the posterior narrower than its readings allow";
        return Err(CalibrationError::File(Error::from(error.with_help(help.to_string()))));
    }
    let find = |name: &String| {
        tests.iter().find(|test| test.name == *name).ok_or_else(|| {
            let known: Vec<&str> = tests.iter().map(|test| test.name.as_str()).collect();
            let message = format!("there is no test {name:?} in the laboratory's files");
            let error = file.plan.source.error(span, message);
            CalibrationError::File(Error::from(error.with_help(format!("there are {}", known.join(", ")))))
        })
    };
    wanted.iter().map(find).collect()
}

fn lacks(test: &LaboratoryTest, what: &str, why: &str) -> CalibrationError {
    CalibrationError::Input(format!("the test {:?} has no {what}, {why}", test.name))
}

/// The mean stress at the start of a test, Pa. Without a scale of stresses in the file it must be positive.
fn mean_stress_at_start(file: &CalibrationFile, test: &LaboratoryTest) -> Result<f64> {
    let first = test.mean_stress.first().copied();
    let usable = |p: &f64| *p > 0.0 || (file.calibration.stress_scale.is_some() && p.is_finite());
    first.filter(usable).ok_or_else(|| {
        let why = "by which stresses of different tests are made comparable: give calibration.stress_scale in its place";
        lacks(test, "mean stress at its start", why)
    })
}

/// What a test gives to the variables [`CalibrationFile::conditions`], in their order.
///
/// # Errors
/// If it has not what is needed of it.
pub(crate) fn conditions(file: &CalibrationFile, test: &LaboratoryTest) -> Result<Vec<f64>> {
    let mean_stress = mean_stress_at_start(file, test)?;
    let condition = |(name, condition): &(String, TestCondition)| {
        let needed = format!("which the variable {name} takes from it");
        let first =
            |values: &[f64], what: &str| values.first().copied().ok_or_else(|| lacks(test, what, &needed));
        Ok(match condition {
            TestCondition::MeanStress => mean_stress,
            TestCondition::LateralStress => {
                mean_stress - first(&test.deviator_stress, "deviator stress")? / 3.0
            }
            TestCondition::VoidRatio => first(&test.void_ratio, "void ratio")?,
            TestCondition::RelativeDensity => {
                let e = first(&test.void_ratio, "void ratio")?;
                // The file was refused without the limits.
                let [densest, loosest] = file.calibration.void_ratio_limits.unwrap_or([0.0, 1.0]);
                (loosest - e) / (loosest - densest)
            }
            TestCondition::StateParameter => {
                let e = first(&test.void_ratio, "void ratio")?;
                // The file was refused without the line.
                e - file.calibration.critical_state.map_or(f64::NAN, |line| line.at(mean_stress))
            }
        })
    };
    file.conditions.iter().map(condition).collect()
}

/// A test as a target.
///
/// # Errors
/// If it has not what is compared or needed of it.
pub(crate) fn target(file: &CalibrationFile, test: &LaboratoryTest) -> Result<TargetTest> {
    let mean_stress = mean_stress_at_start(file, test)?;
    let conditions = conditions(file, test)?;
    let curve =
        |(place, compared): (usize, &ComparedQuantity)| measured(test, compared).map(|curve| (place, curve));
    let curves: Vec<(usize, MeasuredCurve)> =
        file.calibration.quantities.iter().enumerate().filter_map(curve).collect();
    if curves.is_empty() {
        let words: Vec<&str> = file.calibration.quantities.iter().map(|q| q.quantity.word()).collect();
        return Err(CalibrationError::Input(format!(
            "the test {:?} has nothing that is compared ({}) within its strains",
            test.name,
            words.join(", ")
        )));
    }
    Ok(TargetTest { name: test.name.clone(), conditions, mean_stress, laboratory: test.clone(), curves })
}

/// The curve of a quantity at those of the compared strains that the test reaches; `None` if it has no such reading.
pub(crate) fn measured(test: &LaboratoryTest, compared: &ComparedQuantity) -> Option<MeasuredCurve> {
    let values = compared.quantity.readings(test);
    let [first, last] = [*test.axial_strain.first()?, *test.axial_strain.last()?];
    if values.len() != test.axial_strain.len() {
        return None;
    }
    let strain: Vec<f64> = compared.strains.iter().copied().filter(|x| (first..=last).contains(x)).collect();
    let measured = strain.iter().map(|x| interpolated(*x, &test.axial_strain, &values)).collect();
    (!strain.is_empty()).then(|| MeasuredCurve {
        test: test.name.clone(),
        quantity: compared.quantity.word().into(),
        strain,
        measured,
        error: compared.error,
        weight: compared.weight,
    })
}

/// The measured curves of all targets, one target after another.
pub fn all_curves(targets: &[TargetTest]) -> Vec<MeasuredCurve> {
    targets.iter().flat_map(|target| target.curves.iter().map(|(_, curve)| curve.clone())).collect()
}

/// What a reader should know of how the tests were understood, in a sentence for each.
pub fn understood(file: &CalibrationFile, targets: &[TargetTest]) -> Vec<String> {
    let line = |target: &TargetTest| {
        let kilopascal = |stress: f64| format!("{:.1} kPa", stress / 1e3);
        let percent = |strain: f64| words::percent(strain, 3);
        let mut parts = vec![format!("mean stress {}", kilopascal(target.mean_stress))];
        for ((name, condition), value) in file.conditions.iter().zip(&target.conditions) {
            parts.push(match condition {
                TestCondition::LateralStress | TestCondition::MeanStress => {
                    format!("{name} {}", kilopascal(*value))
                }
                TestCondition::VoidRatio | TestCondition::RelativeDensity | TestCondition::StateParameter => {
                    format!("{name} {value:.3}")
                }
            });
        }
        for (_, curve) in &target.curves {
            let (Some(first), Some(last)) = (curve.strain.first(), curve.strain.last()) else { continue };
            let largest =
                curve.measured.iter().fold(0.0, |most: f64, y| if y.abs() > most.abs() { *y } else { most });
            let is_stress = ["stress", "pressure"].iter().any(|end| curve.quantity.ends_with(end));
            let is_strain = curve.quantity.ends_with("strain");
            let largest = match (is_stress, is_strain) {
                (true, _) => kilopascal(largest),
                (_, true) => percent(largest),
                _ => format!("{largest:.4}"),
            };
            parts.push(format!(
                "{} at {} axial strains from {} to {}, extreme {largest}",
                curve.quantity.replace('_', " "),
                curve.strain.len(),
                percent(*first),
                percent(*last),
            ));
        }
        format!("{}: {}", target.name, parts.join("; "))
    };
    targets.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compared::quantity::Quantity;
    use crate::file::{STRESS_AND_FRICTION, file_for_tests};

    /// So many tests, each with a name of its own.
    fn laboratory(count: usize) -> Vec<LaboratoryTest> {
        let test = |k: usize| LaboratoryTest {
            name: format!("T{k}"),
            axial_strain: vec![0.0, 0.01, 0.02],
            deviator_stress: vec![0.0, 8e4, 1e5],
            mean_stress: vec![1e5, 1.2e5, 1.3e5],
            ..LaboratoryTest::default()
        };
        (0..count).map(test).collect()
    }

    /// An unconfined test begins without a stress, and is comparable by the scale that the file gives.
    #[test]
    fn a_test_without_a_stress_at_its_start_needs_a_scale_of_stresses() {
        let mut file = file_for_tests(STRESS_AND_FRICTION);
        let mut tests = laboratory(2);
        tests[0].mean_stress[0] = 0.0;
        let message = targets(&file, &tests).unwrap_err().to_string();
        assert!(
            message.contains("no mean stress at its start") && message.contains("stress_scale"),
            "{message}"
        );
        file.calibration.stress_scale = Some(1e6);
        let found = targets(&file, &tests).unwrap();
        assert_eq!([found[0].mean_stress, found[1].mean_stress], [0.0, 1e5]);
        for target in &found {
            let scale = file.calibration.scale(Quantity::DEVIATOR_STRESS, target.mean_stress);
            assert_eq!(scale, 1e6);
        }
    }

    #[test]
    fn more_tests_than_a_calibration_ends_with_are_refused_with_their_number() {
        let mut file = file_for_tests(STRESS_AND_FRICTION);
        let few = targets(&file, &laboratory(MOST_TESTS)).unwrap();
        assert_eq!(few.len(), MOST_TESTS);
        let many = laboratory(MOST_TESTS + 1);
        let message = targets(&file, &many).unwrap_err().to_string();
        assert!(
            message.contains("201 tests would be calibrated on, and at most 200 are possible"),
            "{message}"
        );
        // Of many tests a file may name a few, and predict as many again.
        file.calibration.tests = vec!["T7".into()];
        let one = targets(&file, &many).unwrap();
        assert_eq!(one[0].name, "T7");
        file.calibration.predict = PredictedTests::Others;
        assert_eq!(predicted(&file, &many, &one).unwrap().len(), MOST_TESTS);
        let message = predicted(&file, &laboratory(MOST_TESTS + 2), &one).unwrap_err().to_string();
        assert!(message.contains("201 tests would be predicted, and at most 200"), "{message}");
    }
}
