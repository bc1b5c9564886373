//! Free parameters that the simulations from which a surrogate learns do not vary, so that nothing can be known of them.

use crate::error::{CalibrationError, Result};
use crate::file::{CalibrationFile, FreeVariable};
use crate::inference::reach::digits;
use crate::simulations::known::KnownRun;
use crate::simulations::simulation::CaseNumbers;
use crate::simulations::target::TargetTest;

/// Relative difference of numbers that are the same.
const SAME: f64 = 1e-9;
/// Shares of a prior at which it is asked which keys a variable changes.
const ASKED: [f64; 5] = [0.02, 0.25, 0.5, 0.75, 0.98];
/// Shares of a prior between which the runs should have values.
const INNER: [f64; 2] = [0.05, 0.95];
/// Share of a prior below which what the runs vary is told.
const LEAST_COVERED: f64 = 0.5;
/// Correlation of two keys over the runs above which these vary together only.
const TOGETHER: f64 = 0.999;

/// Refuses simulations that never vary what a free variable changes, or have no value of it within its prior; what they vary too little, or only
/// together with something else, is returned in a sentence for each.
///
/// # Errors
/// [`CalibrationError::Input`] with the variable, the value that all runs have and its prior.
pub fn check_varied(
    file: &CalibrationFile,
    targets: &[TargetTest],
    numbers: &CaseNumbers,
    runs: &[KnownRun],
) -> Result<Vec<String>> {
    let columns: Vec<(String, String)> =
        numbers.columns().map(|(key, unit)| (key.to_string(), unit.to_string())).collect();
    let range = |k: usize| granum_learn::curve::range(runs.iter().map(|run| run.numbers[k]));
    let ranges: Vec<[f64; 2]> = (0..columns.len()).map(range).collect();
    let varies = |k: usize| !is_same(ranges[k][0], ranges[k][1]);
    let mut remarks = Vec::new();
    let mut used: Vec<(&FreeVariable, usize)> = Vec::new();
    for (place, free) in file.free.iter().enumerate() {
        let changed = changed_columns(file, targets, numbers, place)?;
        let Some(varied) = changed.iter().copied().find(|k| varies(*k)) else {
            let Some(first) = changed.first().copied() else { continue };
            return Err(never_varied(free, &columns[first], ranges[first][0], runs.len()));
        };
        used.push((free, varied));
        // A variable with a key has the values of the key.
        let variable = file.plan.variables.iter().find(|variable| variable.name == free.name);
        let key = variable.and_then(|variable| variable.keys.first()).map(|key| key.value.as_str());
        let Some(k) = columns.iter().position(|(column, _)| Some(column.as_str()) == key) else { continue };
        remarks.extend(covered(free, &columns[k], ranges[k])?);
    }
    for (i, (one, a)) in used.iter().enumerate() {
        for (other, b) in &used[i + 1..] {
            if a != b && correlation(runs, *a, *b).abs() > TOGETHER {
                remarks.push(format!(
                    "the runs vary {} and {} only together, so that they cannot tell one from the other",
                    one.name.replace('_', " "),
                    other.name.replace('_', " ")
                ));
            }
        }
    }
    Ok(remarks)
}

/// The numbers of the case that a free variable changes.
fn changed_columns(
    file: &CalibrationFile,
    targets: &[TargetTest],
    numbers: &CaseNumbers,
    place: usize,
) -> Result<Vec<usize>> {
    let middle: Vec<f64> = file.free.iter().map(|free| free.prior.value(0.5)).collect();
    let mut changed = Vec::new();
    for target in targets {
        let mut seen: Vec<Vec<f64>> = Vec::new();
        for share in ASKED {
            let mut values = middle.clone();
            values[place] = file.free[place].prior.value(share);
            seen.push(numbers.values(&values, &target.conditions)?);
        }
        for k in 0..numbers.columns().count() {
            if seen.iter().any(|row| !is_same(row[k], seen[0][k])) && !changed.contains(&k) {
                changed.push(k);
            }
        }
    }
    Ok(changed)
}

fn never_varied(
    free: &FreeVariable,
    (key, unit): &(String, String),
    value: f64,
    runs: usize,
) -> CalibrationError {
    let [low, high] = INNER.map(|share| with_unit(free.prior.value(share), &free.unit));
    let name = free.name.replace('_', " ");
    CalibrationError::Input(format!(
        "the runs never vary {name}: {key} is {} in all {runs} of them, and nine tenths of the prior of {name} lie between {low} and {high}, so that no \
         test could tell anything of it; take runs that vary it, leave --runs out so that they are made, or give {name} a value in place of a prior",
        with_unit(value, unit)
    ))
}

/// What is said of runs that cover a part of the prior only.
fn covered(
    free: &FreeVariable,
    (key, unit): &(String, String),
    [low, high]: [f64; 2],
) -> Result<Option<String>> {
    let share = |value: f64| free.prior.share(value);
    let inner = |value: f64| share(value).clamp(INNER[0], INNER[1]);
    let covered = (inner(high) - inner(low)) / (INNER[1] - INNER[0]);
    let name = free.name.replace('_', " ");
    let [from, to] = INNER.map(|share| free.prior.value(share));
    let [runs, prior] =
        [[low, high], [from, to]].map(|[a, b]| format!("{} to {}", with_unit(a, unit), with_unit(b, unit)));
    if share(high) <= 0.0 || share(low) >= 1.0 {
        return Err(CalibrationError::Input(format!(
            "the runs have no value of {name} within its prior: {key} is {runs} in them, and nine tenths of the prior lie between {prior}; take runs \
             that vary it within the prior, or state another prior"
        )));
    }
    Ok((covered < LEAST_COVERED).then(|| {
        format!(
            "the runs vary {name} over {:.0} % of its prior only ({key} is {runs} in them, and nine tenths of the prior are {prior}); beyond them the \
             surrogate guesses",
            100.0 * covered
        )
    }))
}

fn with_unit(value: f64, unit: &str) -> String {
    let scaled = [("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3)];
    match scaled.into_iter().find(|(_, size)| unit == "Pa" && value.abs() >= *size) {
        Some((unit, size)) => format!("{} {unit}", digits(value / size)),
        None if unit.is_empty() => digits(value),
        None => format!("{} {unit}", digits(value)),
    }
}

fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

/// The correlation of two numbers over runs.
fn correlation(runs: &[KnownRun], a: usize, b: usize) -> f64 {
    let count = runs.len() as f64;
    let mean = |k: usize| runs.iter().map(|run| run.numbers[k]).sum::<f64>() / count;
    let (of_a, of_b) = (mean(a), mean(b));
    let product = |x: usize, mean_x: f64, y: usize, mean_y: f64| {
        runs.iter().map(|run| (run.numbers[x] - mean_x) * (run.numbers[y] - mean_y)).sum::<f64>()
    };
    let scale = (product(a, of_a, a, of_a) * product(b, of_b, b, of_b)).sqrt();
    if scale > 0.0 { product(a, of_a, b, of_b) / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{STRESS_AND_FRICTION, file_for_tests};
    use crate::simulations::target::target;
    use granum_io::LaboratoryTest;

    const MODULUS: &str = "[[variable]]
name = \"stiffness\"
prior = \"uniform\"
from = 1
to = 5
[[variable]]
name = \"modulus\"
key = \"grains.material.youngs_modulus\"
expression = \"stiffness * 1e9\"
";

    /// The runs have the numbers of friction and of the modulus.
    fn told(runs: &[[f64; 2]]) -> Result<Vec<String>> {
        let file = file_for_tests(&format!("{STRESS_AND_FRICTION}{MODULUS}"));
        let test = LaboratoryTest {
            name: "T1".into(),
            axial_strain: vec![0.0, 0.2],
            deviator_stress: vec![0.0, 1e5],
            mean_stress: vec![1e5, 1.3e5],
            ..LaboratoryTest::default()
        };
        let targets = [target(&file, &test).unwrap()];
        let known = |numbers: &[f64; 2]| KnownRun {
            name: "a".into(),
            numbers: numbers.to_vec(),
            mean_stress: 1e5,
            curves: test.clone(),
        };
        let runs: Vec<KnownRun> = runs.iter().map(known).collect();
        check_varied(&file, &targets, &CaseNumbers::new(&file), &runs)
    }

    #[test]
    fn runs_that_vary_everything_are_taken() {
        assert_eq!(told(&[[0.2, 1e9], [0.8, 2e9], [0.5, 5e9]]).unwrap(), Vec::<String>::new());
    }

    #[test]
    fn what_runs_never_vary_is_refused_by_its_name_and_value() {
        let told = told(&[[0.2, 2e10], [0.8, 2e10]]).unwrap_err().to_string();
        for part in
            ["never vary stiffness", "grains.material.youngs_modulus is 20 GPa in all 2", "1.2 and 4.8"]
        {
            assert!(told.contains(part), "{told}");
        }
    }

    #[test]
    fn runs_outside_of_a_prior_are_refused_and_those_in_a_part_of_it_are_told() {
        let message = told(&[[0.9, 1e9], [1.0, 5e9], [0.95, 1e9]]).unwrap_err().to_string();
        assert!(message.contains("no value of friction within its prior"), "{message}");
        let remarks = told(&[[0.2, 1e9], [0.3, 5e9], [0.25, 1e9]]).unwrap();
        assert!(remarks[0].contains("vary friction over 13 % of its prior only"), "{remarks:?}");
    }

    #[test]
    fn what_varies_only_together_is_told() {
        let remarks = told(&[[0.2, 1e9], [0.5, 3e9], [0.8, 5e9]]).unwrap();
        assert!(remarks[0].contains("vary friction and stiffness only together"), "{remarks:?}");
    }
}
