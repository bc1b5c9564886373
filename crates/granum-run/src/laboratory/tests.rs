use granum_core::observer::{Event, Flow, NamedValue, NoObserver, Observer, Progress};
use granum_dem::config::{Rate, Recording};
use granum_dem::observer::{SimulationObserver, SimulationProgress};
use granum_dem::preparation::Phase;
use granum_dem::simulation::Hardware;
use granum_io::Case;
use granum_io::RunKind;
use granum_io::run::{Run, RunFolder, RunStatus};

use super::*;
use crate::record::read_record;

/// A case that runs within one or two seconds.
pub(super) fn small() -> Case {
    let mut case = Case::default();
    case.grains.count = 150;
    case.preparation.friction = Some(0.1);
    case.preparation.solid_fraction = None;
    case.preparation.inertial_number = 5e-3;
    case.preparation.unbalanced_force = 1e-2;
    case = case.with_shear(|shear| {
        shear.deviator_strain = 0.02;
        shear.rate = Rate::InertialNumber(3e-3);
    });
    case.recording = Recording::default().with(|recording| {
        recording.states = 8;
        recording.observations_per_state = 3;
    });
    case
}

pub(super) fn laboratory() -> Laboratory {
    Laboratory::new(Hardware::default(), "test")
}

/// An observer that stops the run after a number of calls.
struct Stopper(u32);
impl SimulationObserver for Stopper {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        assert!(line(progress).contains("kPa"));
        if progress.phase == Phase::Test {
            self.0 = self.0.saturating_sub(1);
        }
        if self.0 == 0 { Flow::Stop } else { Flow::Continue }
    }
}

/// Notes the progress of any work, and stops it after a number of reports.
#[derive(Default)]
struct Listener {
    stop_at: usize,
    heard: Vec<Progress>,
}
impl Observer for Listener {
    fn progress(&mut self, progress: &Progress) -> Flow {
        self.heard.push(progress.clone());
        if self.heard.len() == self.stop_at { Flow::Stop } else { Flow::Continue }
    }
}

/// Notes the events of a run.
#[derive(Default)]
struct Events(Vec<Event>);
impl Observer for Events {
    fn event(&mut self, event: &Event) {
        self.0.push(event.clone());
    }
}

#[test]
fn states_and_ends_of_stages_are_told_as_they_come() {
    let stage =
        "[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.004\ninertial_number = 5e-3\nstates = 3\n";
    let mut case = small();
    case.test = Case::parse(&[stage, stage].concat(), "case").unwrap().test;
    let mut events = Events::default();
    let planned = laboratory().plan(RunKind::Test, &case, &Source::Case, &mut NoObserver).unwrap();
    // What is planned can be executed in another thread.
    let test =
        std::thread::scope(|scope| scope.spawn(|| planned.in_memory(&mut events)).join().unwrap().unwrap());
    let mut row = 0;
    let mut ends = Vec::new();
    for event in &events.0 {
        match event {
            Event::StateRecorded { values } => {
                for NamedValue { name, value, .. } in values {
                    let recorded = test.record.series.values(name).unwrap()[row];
                    assert_eq!(value.to_bits(), recorded.to_bits(), "{name} of row {row}");
                }
                assert!(values.iter().any(|value| value.name == "overlap" || value.name == "mean_stress"));
                row += 1;
            }
            Event::StageEnded { number, name, steps, reason } => {
                assert!(*steps > 0 && reason.contains("reached"), "{name}: {reason}");
                ends.push((*number, row));
            }
            _ => {}
        }
    }
    assert_eq!(row, test.record.series.rows());
    assert_eq!(ends, [(1, row / 2), (2, row)]);
    assert!(test.simulation().is_ok());
}

#[test]
fn an_interrupted_run_resumes_to_the_same_bits() {
    let base = tempfile::tempdir().unwrap();
    let (case, lab) = (small(), laboratory());
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    let record = lab.run(RunKind::Test, &case, &Source::Case, &straight, &mut NoObserver).unwrap();
    assert_eq!(record.status, RunStatus::Finished);
    assert!(record.quality.iter().any(|q| q.name == "energy_gap" && q.passed), "{:?}", record.quality);

    let broken = RunFolder::create(base.path().join("broken"), false).unwrap();
    let mut stopper = Stopper(5);
    let record = lab.run(RunKind::Test, &case, &Source::Case, &broken, &mut stopper).unwrap();
    assert_eq!(record.status, RunStatus::Interrupted);
    // An observer of any work follows a run as well, and stops it.
    let mut listener = Listener { stop_at: 3, ..Listener::default() };
    let record = lab.resume(&broken, &mut listener).unwrap();
    assert_eq!((record.status, listener.heard.len()), (RunStatus::Interrupted, 3));
    let mut listener = Listener::default();
    let record = lab.resume(&broken, &mut listener).unwrap();
    assert_eq!(record.status, RunStatus::Finished);
    let last = listener.heard.last().unwrap();
    assert_eq!((last.activity.as_ref(), last.completed().unwrap() > 0.5), ("test", true), "{last}");
    let bytes = |folder: &RunFolder, name: &str| std::fs::read(folder.path().join(name)).unwrap();
    for name in ["series.parquet", "forces.parquet"] {
        assert_eq!(bytes(&straight, name), bytes(&broken, name), "{name}");
    }
}

#[test]
fn a_prepared_sample_shears_as_a_case_in_one_go() {
    let base = tempfile::tempdir().unwrap();
    let (case, lab) = (small(), laboratory());
    let sample = RunFolder::create(base.path().join("sample"), false).unwrap();
    lab.run(RunKind::Sample, &case, &Source::Case, &sample, &mut NoObserver).unwrap();
    let source = Source::Folder(sample.path().to_path_buf());
    let two = RunFolder::create(base.path().join("two"), false).unwrap();
    lab.run(RunKind::Test, &case, &source, &two, &mut NoObserver).unwrap();
    let one = RunFolder::create(base.path().join("one"), false).unwrap();
    lab.run(RunKind::Test, &case, &Source::Case, &one, &mut NoObserver).unwrap();
    let record = |folder: &RunFolder| read_record(&Run::at(folder.path()).unwrap()).unwrap();
    assert_eq!(record(&one), record(&two));

    let mut other = case.clone();
    other.grains.material.youngs_modulus = 30e9;
    let three = RunFolder::create(base.path().join("three"), false).unwrap();
    let error = lab.run(RunKind::Test, &other, &source, &three, &mut NoObserver).unwrap_err();
    let wanted = "grains.material.youngs_modulus: 7e10 Pa in the sample; 3e10 Pa in the case";
    assert!(error.to_string().contains(wanted), "{error}");
    assert!(Run::at(three.path()).is_err(), "a sample that cannot be used leaves nothing behind");
}

#[test]
fn density_scaling_says_the_same_physics() {
    let base = tempfile::tempdir().unwrap();
    let lab = laboratory();
    let mut case = small().with_shear(|shear| shear.deviator_strain = 0.004);
    let number = RunFolder::create(base.path().join("number"), false).unwrap();
    lab.run(RunKind::Test, &case, &Source::Case, &number, &mut NoObserver).unwrap();
    // A density factor that is a power of four scales time by a power of two, so that even the rounding is the same.
    let scaling = 4f64.powi(20);
    let fast = 3e-3 * (20e3f64 / 2650.0).sqrt() / 1e-4;
    let rate = Rate::StrainRate { strain_rate: fast / 2f64.powi(20), density_scaling: scaling };
    case = case.with_shear(|shear| shear.rate = rate);
    let scaled = RunFolder::create(base.path().join("scaled"), false).unwrap();
    let record = lab.run(RunKind::Test, &case, &Source::Case, &scaled, &mut NoObserver).unwrap();
    // Half of the work of the first step is computed with the power in the last step of the sample, whose time was scaled
    // differently.
    let gap = record.quality.iter().find(|flag| flag.name == "energy_gap").unwrap().value;
    assert!(gap < 1e-3, "{gap}");
    let ratio = |folder: &RunFolder| {
        let record = read_record(&Run::at(folder.path()).unwrap()).unwrap();
        record.series.values("stress_ratio").unwrap().to_vec()
    };
    for (a, b) in ratio(&number).iter().zip(ratio(&scaled)) {
        // Rounding differs, and the dynamics is chaotic; a wrong scaling would differ by orders of magnitude.
        assert!((a - b).abs() < 5e-2, "{a} {b}");
    }
}

/// What global damping takes is not counted, so that such a test says nothing of its energy balance rather than that it closes.
#[test]
fn the_energy_of_a_test_that_came_to_rest_with_damping_is_not_judged() {
    let test =
        Case::parse("[[stage]]\npath = \"isotropic\"\nmean_stress = \"22 kPa\"\n", "case.toml").unwrap().test;
    let case = Case { test, ..small() };
    let quality = laboratory().test(&case).unwrap().about.quality;
    assert!(quality.iter().any(|flag| flag.name == "servo_error_rms"));
    assert!(quality.iter().all(|flag| flag.name != "energy_gap"), "{quality:?}");
}

/// A stage at a strain rate with scaled density is equivalent to a stage at the corresponding inertial number.
#[test]
fn density_scaling_of_a_stage_says_the_same_physics() {
    let scaling = 4f64.powi(20);
    let fast = 3e-3 * (20e3f64 / 2650.0).sqrt() / 1e-4;
    let ratio = |speed: String| {
        let text =
            format!("[[stage]]\npath = \"drained-triaxial\"\naxial_strain = 0.003\nstates = 4\n{speed}\n");
        let test = Case::parse(&text, "case.toml").unwrap().test;
        let recording = Recording::default().with(|recording| recording.observations_per_state = 3);
        let case = Case { test, recording, ..small() };
        let test = laboratory().test(&case).unwrap();
        let gap = test.about.quality.iter().find(|flag| flag.name == "energy_gap").unwrap().value;
        assert!(gap < 1e-3, "{gap}");
        test.record.series.values("von_mises_ratio").unwrap().to_vec()
    };
    let number = ratio("inertial_number = 3e-3".into());
    let scaled = ratio(format!("strain_rate = {:e}\ndensity_scaling = {scaling:e}", fast / 2f64.powi(20)));
    assert_eq!(number.len(), scaled.len());
    for (a, b) in number.iter().zip(scaled) {
        assert!((a - b).abs() < 5e-2, "{a} {b}");
    }
}

#[test]
fn the_lateral_stress_ratio_of_an_oedometer_stands_in_the_record() {
    let text = "[[stage]]\npath = \"oedometer\"\naxial_stress = \"100 kPa\"\nunloading_stress = \"40 kPa\"\ninterval = 1e-5\n";
    let test = Case::parse(text, "case.toml").unwrap().test;
    let recording = Recording::default().with(|recording| recording.observations_per_state = 1);
    let case = Case { test, recording, ..small() };
    let measures = laboratory().test(&case).unwrap().about.measures;
    let [loading, unloading] = ["k0_loading", "k0_unloading"].map(|name| measures[name]);
    assert!((0.3..0.9).contains(&loading) && unloading > loading, "{loading} {unloading}");
}
