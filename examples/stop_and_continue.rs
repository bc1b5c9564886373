//! Stops a test half-way and continues it later: the results have the bits of a test that was never stopped.

use granum::io::RunStatus;
use granum::prelude::*;

const CASE: &str = "
[grains]
count = 100
[preparation]
solid_fraction = \"none\"
unbalanced_force = 0.02
[shear]
deviator_strain = 0.03
inertial_number = 0.005
[recording]
states = 10
";

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let base = std::env::temp_dir().join(format!("granum-stop-and-continue-{}", std::process::id()));
    let case = Case::parse(CASE, "case")?;
    let laboratory = Laboratory::here();

    // ANCHOR: stop
    // A closure that sees the progress and returns a `Flow` is an observer. The activity of a test is `test`; before it the sample is prepared.
    let mut half = |progress: &Progress| {
        let in_test = progress.activity == "test";
        if in_test && progress.completed() > Some(0.5) { Flow::Stop } else { Flow::Continue }
    };
    let folder = RunFolder::create(base.join("run"), false)?;
    let record = laboratory.run(RunKind::Test, &case, &Source::Case, &folder, &mut half)?;
    println!("stopped: {} states are recorded", folder.run().series()?.rows());
    // ANCHOR_END: stop
    assert_eq!(record.status, RunStatus::Interrupted);
    let before = folder.run().series()?.rows();
    // A process that works in a folder holds it; the next one opens it.
    drop(folder);

    // ANCHOR: resume
    // Another program, another day, another computer.
    let folder = RunFolder::open(base.join("run"))?;
    let record = laboratory.resume(&folder, &mut NoObserver)?;
    let series = folder.run().series()?;
    println!("finished: {} states are recorded", series.rows());
    // ANCHOR_END: resume
    assert_eq!(record.status, RunStatus::Finished);
    assert!(0 < before && before < series.rows());

    // ANCHOR: same
    let undisturbed = laboratory.test(&case)?.record.series;
    assert_eq!(series.column("stress_ratio")?, undisturbed.column("stress_ratio")?);
    // ANCHOR_END: same
    drop(folder);
    std::fs::remove_dir_all(base)?;
    Ok(())
}
