//! Tests that an earlier version began are continued to the bytes of the present one.

use std::fs;

use granum_core::observer::{Flow, NoObserver, Progress};
use granum_dem::config::Rate;
use granum_dem::preparation::Phase;
use granum_dem::simulation::Simulation;
use granum_io::Case;
use granum_io::run::{CHECKPOINT, RunFolder, RunKind, RunStatus};
use serde_json::{Value, json};

use super::tests::{laboratory, small};
use super::*;

/// Writes the checkpoint of a test as the first version with stages did: it said whether the test is given as stages, and kept the
/// density scaling of `[shear]` outside its stage.
fn write_as_earlier(folder: &RunFolder, staged: bool) {
    let bytes = fs::read(folder.path().join(CHECKPOINT)).unwrap();
    let (simulation, text) = Simulation::restore(&bytes).unwrap();
    let mut state: Value = serde_json::from_str(&text).unwrap();
    let test = state[0]["test"].as_object_mut().unwrap();
    assert!(test.remove("columns").is_some());
    test.insert("staged".into(), json!(staged));
    if !staged {
        assert_ne!(test["stages"][0]["density_scaling"], json!(1.0));
        test["stages"][0]["density_scaling"] = json!(1.0);
    }
    folder.write_checkpoint(|out| simulation.write_checkpoint(&state.to_string(), out)).unwrap();
}

#[test]
fn a_test_that_an_earlier_version_interrupted_ends_in_the_same_bytes() {
    let speed = 3e-3 * (20e3f64 / 2650.0).sqrt() / 1e-4;
    let rate = Rate::StrainRate { strain_rate: speed / 4.0, density_scaling: 16.0 };
    let short = small().with_shear(|shear| (shear.deviator_strain, shear.rate) = (4e-3, rate));
    let path =
        "[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.003\ninertial_number = 3e-3\nstates = 3\n";
    let staged = Case { test: Case::parse(path, "case.toml").unwrap().test, ..small() };
    let lab = laboratory();
    for (case, staged) in [(short, false), (staged, true)] {
        let base = tempfile::tempdir().unwrap();
        let [whole, broken] =
            ["whole", "broken"].map(|name| RunFolder::create(base.path().join(name), false).unwrap());
        let finished = lab.run(RunKind::Test, &case, &Source::Case, &whole, &mut NoObserver).unwrap();
        let mut calls = 0;
        let mut stopper = |progress: &Progress| {
            calls += u32::from(progress.activity == Phase::Test.name());
            if calls == 3 { Flow::Stop } else { Flow::Continue }
        };
        let stopped = lab.run(RunKind::Test, &case, &Source::Case, &broken, &mut stopper).unwrap();
        assert_eq!(stopped.status, RunStatus::Interrupted);
        write_as_earlier(&broken, staged);
        let resumed = lab.resume(&broken, &mut NoObserver).unwrap();
        assert_eq!(resumed.status, RunStatus::Finished);
        let [whole, broken] = [whole, broken].map(|folder| folder.run().record().unwrap().content);
        assert!(whole.contains_key("series.parquet"));
        assert_eq!(broken, whole);
        assert_eq!((&resumed.steps, &resumed.quality), (&finished.steps, &finished.quality));
    }
}
