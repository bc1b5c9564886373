//! One test under two names: the readings of two tests that are the same.

use granum_io::LaboratoryTest;

use crate::compared::quantity::Quantity;
use crate::error::{CalibrationError, Result};
use crate::simulations::target::TargetTest;

/// Fewest readings that two tests cannot have in common by chance.
const FEWEST: usize = 3;
/// Relative difference of readings that are the same number, written in another unit.
const SAME: f64 = 1e-6;

/// The quantity of which two tests have the same readings at the same strains: both are one test. Readings that do not change over the test, as the
/// volume of an undrained one, say nothing.
pub fn same_readings(a: &LaboratoryTest, b: &LaboratoryTest) -> Option<Quantity> {
    if a.axial_strain.len() < FEWEST || !are_same(&a.axial_strain, &b.axial_strain) {
        return None;
    }
    let is_same = |quantity: &Quantity| {
        let [a, b] = [a, b].map(|test| quantity.readings(test));
        changes(&a) && are_same(&a, &b)
    };
    Quantity::ALL.into_iter().filter(|quantity| !quantity.is_derived()).find(is_same)
}

/// Refuses tests that are one test under two names, which would count twice: the posterior would be narrower than the readings allow.
///
/// # Errors
/// With both names and what they have in common.
pub fn check_different(targets: &[TargetTest]) -> Result<()> {
    for (k, target) in targets.iter().enumerate() {
        for other in &targets[..k] {
            let Some(quantity) = same_readings(&other.laboratory, &target.laboratory) else { continue };
            return Err(CalibrationError::Input(format!(
                "the tests {:?} and {:?} have the same {} at the same strains: they are one test, which would count twice; leave one of them out",
                other.name,
                target.name,
                quantity.word().replace('_', " ")
            )));
        }
    }
    Ok(())
}

/// What is said of tests that are predicted from themselves under another name, a sentence for each.
pub fn known_by_another_name(targets: &[TargetTest], predicted: &[TargetTest]) -> Vec<String> {
    let line = |test: &TargetTest| {
        let same =
            targets.iter().find(|target| same_readings(&target.laboratory, &test.laboratory).is_some())?;
        Some(format!(
            "the test {:?} has the readings of {:?}, which is calibrated on: its prediction is not blind",
            test.name, same.name
        ))
    };
    predicted.iter().filter_map(line).collect()
}

fn changes(values: &[f64]) -> bool {
    let largest = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let distinct = values.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > SAME * largest).count();
    distinct + 1 >= FEWEST
}

fn are_same(a: &[f64], b: &[f64]) -> bool {
    let largest = a.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME * largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(factor: f64) -> LaboratoryTest {
        LaboratoryTest {
            axial_strain: vec![0.0, 0.01, 0.02, 0.03],
            deviator_stress: [0.0, 80e3, 95e3, 90e3].map(|q| factor * q).to_vec(),
            volumetric_strain: vec![0.0; 4],
            ..LaboratoryTest::default()
        }
    }

    #[test]
    fn the_same_readings_are_one_test_whatever_its_name() {
        let named = LaboratoryTest { name: "again".into(), ..test(1.0) };
        assert_eq!(same_readings(&test(1.0), &named), Some(Quantity::DEVIATOR_STRESS));
        // Rounded where it was written in another unit.
        assert_eq!(same_readings(&test(1.0), &test(1.0 + 1e-12)), Some(Quantity::DEVIATOR_STRESS));
        // A file without the volume.
        let part = LaboratoryTest { volumetric_strain: Vec::new(), ..test(1.0) };
        assert_eq!(same_readings(&test(1.0), &part), Some(Quantity::DEVIATOR_STRESS));
    }

    #[test]
    fn two_tests_with_one_constant_volume_are_two_tests() {
        assert_eq!(same_readings(&test(1.0), &test(1.01)), None);
        let mut other = test(1.0);
        other.axial_strain[2] = 0.021;
        assert_eq!(same_readings(&test(1.0), &other), None);
        assert_eq!(same_readings(&LaboratoryTest::default(), &LaboratoryTest::default()), None);
    }
}
