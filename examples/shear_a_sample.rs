//! Prepares and shears a sample, and prints a table of its series.

use granum::prelude::*;

// ANCHOR: case
/// Keys that are not given have their default values, those of Antony, Zhou and Wang (2006).
const CASE: &str = "
grains.count = 200
preparation.solid_fraction = \"none\"
preparation.unbalanced_force = 0.01
shear.deviator_strain = 0.05
shear.inertial_number = 0.005
recording.states = 10
";
// ANCHOR_END: case

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ANCHOR: test
    let test = Laboratory::here().test(&Case::parse(CASE, "case")?)?;
    let [strain, ratio] = test.record.series.select(["deviator_strain", "stress_ratio"])?;
    println!("eps_d   q/p");
    for (strain, ratio) in strain.iter().zip(ratio) {
        println!("{strain:.4}  {ratio:.3}");
    }
    // ANCHOR_END: test
    // ANCHOR: quality
    for flag in test.about.quality.iter().filter(|flag| !flag.passed) {
        println!("warning: {} is {:.2e}: {}", flag.name, flag.value, flag.advice);
    }
    // ANCHOR_END: quality
    assert!(ratio.iter().any(|ratio| *ratio > 0.3));
    Ok(())
}
