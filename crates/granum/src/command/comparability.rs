//! Whether runs can be compared with the tests of a laboratory's file, and whether the units of this file are probably right.

use granum_io::LaboratoryTest;
use granum_report::comparison::{ComparedRun, errors};

use crate::failure::Failure;
use crate::numbers::rounded;

/// Refuses runs and tests of which no two have a state in common beyond their starts.
pub fn check_common(runs: &[ComparedRun], tests: &[&LaboratoryTest]) -> Result<(), Failure> {
    let common = |run: &ComparedRun| tests.iter().any(|test| errors(run, test).up_to > 0.0);
    if runs.iter().any(common) {
        return Ok(());
    }
    let range = |strains: &[f64]| {
        let [low, high] =
            granum_learn::curve::range(strains.iter().copied()).map(|end| rounded(100.0 * end, 4));
        format!("from {low} % to {high} %")
    };
    let run = runs
        .iter()
        .map(|run| format!("the axial strain of {} goes {}", run.name, range(&run.curves.axial_strain)));
    let test = tests.iter().map(|test| {
        let name = if test.name.is_empty() { "the test".into() } else { format!("the test {}", test.name) };
        let first = test.axial_strain.iter().find(|strain| **strain > 0.0).copied().unwrap_or(0.0);
        format!(
            "that of {name} {}, its first beyond zero is {} %",
            range(&test.axial_strain),
            rounded(100.0 * first, 4)
        )
    });
    let all: Vec<String> = run.chain(test).collect();
    Err(Failure::new(format!(
        "there is nothing to compare, since no test has a reading at an axial strain of a run: {}; are strains in per cent? (the header \
         names it, as axial_strain (%))",
        all.join("; ")
    )))
}

/// How many times larger or smaller a stress may be before its unit is in doubt.
const FAR: f64 = 100.0;

/// A remark for each run and test whose stresses are so far from each other that the unit of the test is probably another one.
pub fn unlike_stresses(runs: &[ComparedRun], tests: &[&LaboratoryTest]) -> Vec<String> {
    runs.iter().flat_map(|run| tests.iter().filter_map(|test| unlike(run, test))).collect()
}

/// A remark if the largest deviator stress of a test is so far from that of the run that its unit is probably another one.
fn unlike(run: &ComparedRun, test: &LaboratoryTest) -> Option<String> {
    let up_to = errors(run, test).up_to;
    let largest = |curves: &LaboratoryTest| {
        let values = curves.deviator_stress.iter().zip(&curves.axial_strain);
        values.filter(|(_, strain)| **strain <= up_to).fold(0.0, |most: f64, (stress, _)| most.max(*stress))
    };
    let [own, other] = [&run.curves, test].map(largest);
    let far = own > 0.0 && other > 0.0 && !(1.0 / FAR..FAR).contains(&(own / other));
    far.then(|| {
        let [own, other] = [own, other].map(|stress| rounded(stress / 1e3, 3));
        let name = if test.name.is_empty() { "the test".to_string() } else { format!("the test {}", test.name) };
        format!(
            "the largest deviator stress of {} is {own} kPa, and that of {name} {other} kPa: is the unit in the header of the file right \
             (Pa, kPa, MPa)?",
            run.name
        )
    })
}
