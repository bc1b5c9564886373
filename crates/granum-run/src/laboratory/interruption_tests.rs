//! Runs that are interrupted and resumed, and checkpoints that cannot be used.

use granum_io::RunKind;

use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use granum_dem::config::{AdhesionKind, ContactModel, NormalKind, TangentialKind};
use granum_dem::observer::{Flow, NoObserver, SimulationObserver, SimulationProgress};
use granum_dem::simulation::Hardware;
use granum_io::Case;
use granum_io::run::{Machine, REFUSED_CHECKPOINT, Run, RunFolder, RunRecord, RunStatus};

use super::tests::{laboratory, small};
use super::*;
use crate::engine::Resources;

/// An observer that stops the run after a number of observations and stores the warnings.
struct Stopper {
    observations: u32,
    warnings: Vec<String>,
}

impl Stopper {
    fn after(observations: u32) -> Stopper {
        Stopper { observations, warnings: Vec::new() }
    }
}

impl SimulationObserver for Stopper {
    fn progress(&mut self, _: &SimulationProgress) -> Flow {
        self.observations = self.observations.saturating_sub(1);
        if self.observations == 0 { Flow::Stop } else { Flow::Continue }
    }
    fn warn(&mut self, text: &str) {
        self.warnings.push(text.to_string());
    }
}

/// A case in which the search for the solid fraction takes several trials.
fn searching() -> Case {
    let mut case = small();
    case.grains.count = 80;
    case.grains.spread = 0.1;
    case.preparation.initial_solid_fraction = 0.3;
    case.preparation.friction = None;
    case.preparation.solid_fraction = Some(0.6);
    case.preparation.solid_fraction_tolerance = 1e-4;
    case.preparation.inertial_number = 1e-2;
    case.preparation.unbalanced_force = 2e-2;
    case.with_shear(|shear| shear.deviator_strain = 0.01)
}

/// All files of a folder except the lock and the times.
fn contents(folder: &RunFolder) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for place in ["", "snapshots", "histograms"].map(|name| folder.path().join(name)) {
        if !place.is_dir() {
            continue;
        }
        for entry in fs::read_dir(place).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder.path()).unwrap().to_path_buf();
            let other = [".granum-lock", "seconds.json", PREVIOUS_CHECKPOINT, REFUSED_CHECKPOINT];
            if path.is_file() && !other.iter().any(|o| name.as_os_str() == *o) {
                found.push((name, fs::read(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

fn assert_same(a: &RunFolder, b: &RunFolder) {
    let (a, b) = (contents(a), contents(b));
    let names = |list: &[(PathBuf, Vec<u8>)]| list.iter().map(|(n, _)| n.clone()).collect::<Vec<_>>();
    assert_eq!(names(&a), names(&b));
    assert!(names(&a).contains(&CHECKPOINT.into()));
    for ((name, a), (_, b)) in a.iter().zip(&b) {
        assert!(a == b, "{}", name.display());
    }
}

#[test]
fn a_run_stopped_again_and_again_ends_in_the_same_bytes() {
    let base = tempfile::tempdir().unwrap();
    let (case, lab) = (searching(), laboratory());
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    let whole = lab.run(RunKind::Test, &case, &Source::Case, &straight, &mut NoObserver).unwrap();
    assert!(whole.measures["preparation_trials"] >= 2.0, "{:?}", whole.measures);

    let broken = RunFolder::create(base.path().join("broken"), false).unwrap();
    let mut record = lab.run(RunKind::Test, &case, &Source::Case, &broken, &mut Stopper::after(2)).unwrap();
    let (mut stops, mut phases) = (1, std::collections::BTreeSet::new());
    while record.status == RunStatus::Interrupted {
        phases.insert(record.phase.clone());
        record = lab.resume(&broken, &mut Stopper::after(5)).unwrap();
        stops += 1;
    }
    assert!(stops > 10, "{stops}");
    for phase in ["compaction", "relaxation", "compaction, trial 2", "shear"] {
        assert!(phases.contains(phase), "{phases:?}");
    }
    assert_eq!(record.status, RunStatus::Finished);
    assert_same(&straight, &broken);
    assert_eq!((&record.steps, &record.measures), (&whole.steps, &whole.measures));
    assert_eq!((&record.quality, &record.phase, record.grains), (&whole.quality, &whole.phase, whole.grains));
}

/// Strain cycles, an oedometer and a stage with another density in each trial of the search of a preparation.
#[test]
fn a_preparation_with_stages_stopped_again_and_again_ends_in_the_same_bytes() {
    let text = "[[preparation.stage]]\npath = \"oedometer\"\naxial_stress = \"60 kPa\"\nunloading_stress = \"30 kPa\"\n\
                inertial_number = 1e-2\n[[preparation.stage]]\nname = \"extension\"\nstrain_rate = \"5 /s\"\n\
                density_scaling = 64\nxx = { rate = -1 }\nyy = { stress = \"current\" }\nzz = { stress = \"current\" }\n\
                until = { xx_strain = -0.002 }\n";
    let preparation_stages = Case::parse(text, "case.toml").unwrap().preparation_stages;
    let mut case = Case { preparation_stages, ..searching() };
    (case.preparation.cycles, case.preparation.cycle_strain) = (1, 2e-3);
    let base = tempfile::tempdir().unwrap();
    let lab = laboratory();
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    let whole = lab.run(RunKind::Sample, &case, &Source::Case, &straight, &mut NoObserver).unwrap();
    assert!(whole.measures["preparation_trials"] >= 2.0, "{:?}", whole.measures);
    assert_ne!(whole.preparation_digest, searching().preparation_digest());

    let broken = RunFolder::create(base.path().join("broken"), false).unwrap();
    let mut record = lab.run(RunKind::Sample, &case, &Source::Case, &broken, &mut Stopper::after(2)).unwrap();
    let mut phases = std::collections::BTreeSet::new();
    while record.status == RunStatus::Interrupted {
        phases.insert(record.phase.clone());
        record = lab.resume(&broken, &mut Stopper::after(3)).unwrap();
    }
    for phase in ["cycles", "preparation stage", "preparation stage, trial 2", "relaxation, trial 2"] {
        assert!(phases.contains(phase), "{phases:?}");
    }
    assert_same(&straight, &broken);
    assert_eq!((&record.steps, &record.measures), (&whole.steps, &whole.measures));
}

/// A stage of the preparation that does not reach its end leaves no sample: the error gives the stage and the reason.
#[test]
fn a_stage_of_the_preparation_that_is_cut_short_is_an_error() {
    let text = "[[preparation.stage]]\npath = \"isotropic\"\nmean_stress = \"30 kPa\"\n[[preparation.stage]]\nname = \"far\"\n\
                inertial_number = 1e-2\nxx = { rate = 1 }\nuntil = { mean_stress = \"1 Pa\" }\nmost_arc_length = 1e-3\n";
    let preparation_stages = Case::parse(text, "case.toml").unwrap().preparation_stages;
    let mut case = Case { preparation_stages, ..small() };
    case.grains.count = 80;
    let planned = laboratory().plan(RunKind::Sample, &case, &Source::Case, &mut NoObserver);
    let error = planned.and_then(|planned| planned.in_memory(&mut NoObserver)).err().unwrap().to_string();
    assert!(
        error.contains("2 stages of the preparation (far): none of its end conditions was met"),
        "{error}"
    );
    assert!(super::limits::densest(&case).preparation_stages.is_empty());
}

/// A program may set a parameter to its default; a case that is read from a file takes such a value as not given.
#[test]
fn parameters_set_to_their_defaults_give_the_same_bytes_after_a_resumption() {
    let base = tempfile::tempdir().unwrap();
    let mut case = searching();
    case.preparation.friction = Some(0.1);
    case.contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.2);
    case.contact.adhesion = AdhesionKind::VAN_DER_WAALS;
    case.contact.parameters.set("least_separation", 4e-10).unwrap();
    case.grains.material.interface_energy = 0.0;
    let lab = laboratory();
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    lab.run(RunKind::Test, &case, &Source::Case, &straight, &mut NoObserver).unwrap();
    let broken = RunFolder::create(base.path().join("broken"), false).unwrap();
    let record = lab.run(RunKind::Test, &case, &Source::Case, &broken, &mut Stopper::after(3)).unwrap();
    assert_eq!(record.phase, "compaction");
    lab.resume(&broken, &mut NoObserver).unwrap();
    assert_same(&straight, &broken);
}

/// A test of several stages: a consolidation, a standard path and a user-defined stage.
fn staged() -> Case {
    let text = "[[stage]]\npath = \"drained-triaxial\"\naxial_strain = 0.004\nlateral_stress = \"25 kPa\"\n\
                inertial_number = 5e-3\nstates = 5\n\
                [[stage]]\nname = \"unloading\"\ninertial_number = 5e-3\nxx = { rate = -1 }\n\
                yy = { stress = \"current\" }\nzz = { stress = \"current\" }\n\
                until = { xx_strain = 0.002 }\nrecord = { every = 2e-4 }\n";
    let test = Case::parse(text, "case.toml").unwrap().test;
    let mut case = Case { test, ..small() };
    // Sensors that compare observations, and a further histogram, are resumed with identical bytes as well.
    let sensors = ["nonaffine_displacement", "second_order_work", "overlap_distribution"].map(String::from);
    case.recording = granum_dem::config::Recording::default().with(|recording| {
        recording.observations_per_state = 3;
        recording.sensors = sensors.to_vec();
        // Without effect in a case with stages, and no reason to refuse its checkpoints.
        recording.snapshots = vec![0.001];
    });
    case
}

#[test]
fn stages_stopped_again_and_again_end_in_the_same_bytes() {
    let base = tempfile::tempdir().unwrap();
    let (case, lab) = (staged(), laboratory());
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    let whole = lab.run(RunKind::Test, &case, &Source::Case, &straight, &mut NoObserver).unwrap();
    assert_eq!(whole.status, RunStatus::Finished);
    let ends: Vec<&String> = whole.notes.iter().filter(|note| note.starts_with("stage ")).collect();
    assert!(ends.len() == 3 && ends[1].contains("xx_strain reached 0.004"), "{:?}", whole.notes);
    let record = crate::record::read_record(&straight.run()).unwrap();
    let column = |name: &str| record.series.values(name).unwrap().to_vec();
    let (stages, states) = (column("stage"), column("state"));
    assert!([1.0, 2.0, 3.0].iter().all(|stage| stages.contains(stage)));
    let unloading: Vec<f64> =
        states.iter().zip(&stages).filter(|(_, stage)| **stage == 3.0).map(|(state, _)| *state).collect();
    assert!(unloading.len() > 5 && unloading[0] == 0.0, "{unloading:?}");
    let held = column("stress_33").into_iter().zip(&stages).filter(|(_, stage)| **stage == 2.0);
    assert!(
        held.clone().all(|(stress, _)| (stress / 25e3 - 1.0).abs() < 0.05),
        "{:?}",
        held.collect::<Vec<_>>()
    );
    assert!(column("nonaffine_displacement").iter().any(|moved| *moved > 0.0));
    assert!(column("second_order_work").iter().any(|work| *work > 0.0));
    assert_eq!(record.histograms("overlaps").len(), states.len());
    assert!(column("arc_length").iter().all(|arc| arc.is_finite()));
    assert_eq!(straight.run().snapshots().unwrap(), ["end", "stage-1", "stage-2", "start"]);

    let broken = RunFolder::create(base.path().join("broken"), false).unwrap();
    let mut record = lab.run(RunKind::Test, &case, &Source::Case, &broken, &mut Stopper::after(2)).unwrap();
    let mut phases = std::collections::BTreeSet::new();
    while record.status == RunStatus::Interrupted {
        phases.insert(record.phase.clone());
        record = lab.resume(&broken, &mut Stopper::after(7)).unwrap();
    }
    for phase in ["consolidation", "shear", "unloading"] {
        assert!(phases.contains(phase), "{phases:?}");
    }
    assert_same(&straight, &broken);
    assert_eq!((&record.steps, &record.measures), (&whole.steps, &whole.measures));
    assert_eq!((&record.quality, &record.phase), (&whole.quality, &whole.phase));
}

/// Repetitions, ramps and stages that go back to a kept state, stopped wherever it may be and on other numbers of threads.
#[test]
fn repeated_stages_and_probes_stopped_again_and_again_end_in_the_same_bytes() {
    let text = "[[stage]]\nrepeat = 2\n[[stage.stage]]\npath = \"drained-triaxial\"\naxial_strain = 0.001\nstates = 2\n\
                inertial_number = 5e-3\n[[stage.stage]]\nname = \"back\"\nxx = { strain_by = -5e-4 }\n\
                yy = { stress = \"current\" }\nzz = { stress = \"current\" }\n\
                [[stage]]\nrepeat = 2\n[[stage.stage]]\npath = \"probes\"\ndirections = 3\nunbalanced_force = 0.01\n\
                [[stage]]\npath = \"constant-p\"\ndeviator_strain = 0.001\nstates = 2\nstrain_rate = 1e-3\n\
                density_scaling = 1e12\n";
    let test = Case::parse(text, "case.toml").unwrap().test;
    let case = Case { test, ..staged() };
    assert_eq!(case.test_stages().len(), 2 * 2 + 2 * (1 + 2 * 3) + 1);
    let base = tempfile::tempdir().unwrap();
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    let lab = laboratory();
    let whole = lab.run(RunKind::Test, &case, &Source::Case, &straight, &mut NoObserver).unwrap();
    assert_eq!(whole.status, RunStatus::Finished);
    let cut = whole.quality.iter().find(|flag| flag.name == "stages_cut_short").unwrap();
    assert!(cut.passed, "{:?}", whole.notes);
    let record = crate::record::read_record(&straight.run()).unwrap();
    let [stage, stress] = ["stage", "stress_11"].map(|name| record.series.values(name).unwrap().to_vec());
    // Every probe of one set begins from one state.
    let first =
        |number: usize| stage.iter().position(|s| *s == number as f64).map(|row| stress[row]).unwrap();
    assert_eq!((first(6), first(8)), (first(8), first(10)));
    assert_eq!((first(13), first(15)), (first(15), first(17)));
    assert!(first(6) != first(13) && first(7) != first(9));

    let broken = RunFolder::create(base.path().join("broken"), false).unwrap();
    let threads = |threads: usize| {
        let hardware = Hardware { threads, ..Hardware::default() };
        Laboratory {
            resources: Resources { grains_per_thread: 1, ..Resources::new(hardware) },
            ..laboratory()
        }
    };
    let mut record = lab.run(RunKind::Test, &case, &Source::Case, &broken, &mut Stopper::after(2)).unwrap();
    let mut rounds = 0;
    while record.status == RunStatus::Interrupted {
        rounds += 1;
        record = threads(1 + rounds % 2).resume(&broken, &mut Stopper::after(9)).unwrap();
    }
    assert!(rounds > 5, "{rounds}");
    assert_same(&straight, &broken);
    assert_eq!((&record.measures, &record.quality), (&whole.measures, &whole.quality));
}

/// A stage that does not reach its goal ends the test; the notes give the reason, and a quality flag is not passed.
#[test]
fn a_stage_cut_short_is_told_and_ends_the_test() {
    let base = tempfile::tempdir().unwrap();
    let text = "[[stage]]\ninertial_number = 1e-2\nxx = { rate = 1 }\nuntil = { mean_stress = \"1 Pa\" }\n\
                most_arc_length = 1e-3\n[[stage]]\npath = \"isotropic\"\n";
    let test = Case::parse(text, "case.toml").unwrap().test;
    let case = Case { test, ..staged() };
    let folder = RunFolder::create(base.path().join("run"), false).unwrap();
    let mut stopper = Stopper::after(u32::MAX);
    let record = laboratory().run(RunKind::Test, &case, &Source::Case, &folder, &mut stopper).unwrap();
    assert_eq!(record.status, RunStatus::Finished);
    let warned = stopper.warnings.iter().find(|text| text.contains("number of later stages not run: 1"));
    assert!(
        warned.is_some_and(|text| text.contains("none of its end conditions was met")),
        "{:?}",
        stopper.warnings
    );
    assert!(record.quality.iter().any(|flag| flag.name == "stages_cut_short" && !flag.passed));
}

#[test]
fn a_packing_is_needed_only_until_the_first_checkpoint() {
    let base = tempfile::tempdir().unwrap();
    let (case, lab) = (small(), laboratory());
    let made = RunFolder::create(base.path().join("made"), false).unwrap();
    lab.run(RunKind::Sample, &case, &Source::Case, &made, &mut NoObserver).unwrap();
    let grains = made.run().snapshot(SAMPLE).unwrap();
    let edge = grains.cell[0][0];
    let mut text = format!(
        "# periodic cell, m: ox=0 oy=0 oz=0 ax={edge} ay=0 az=0 bx=0 by={} bz=0 cx=0 cy=0 cz={}\nid,x,y,z,radius\n",
        grains.cell[1][1], grains.cell[2][2]
    );
    for g in &grains.bodies {
        let [x, y, z] = g.position;
        text += &format!("{},{x},{y},{z},{}\n", g.id, g.equivalent_radius);
    }
    let file = base.path().join("packing.csv");
    fs::write(&file, &text).unwrap();
    let source = Source::Packing(file.clone());
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    lab.run(RunKind::Test, &case, &source, &straight, &mut NoObserver).unwrap();

    let broken = RunFolder::create(base.path().join("broken"), false).unwrap();
    let record = lab.run(RunKind::Test, &case, &source, &broken, &mut Stopper::after(1)).unwrap();
    assert_eq!((record.status, record.phase.as_str()), (RunStatus::Interrupted, "relaxation"));
    // A run that was killed before its first checkpoint needs the unchanged packing.
    let early = RunFolder::create(base.path().join("early"), false).unwrap();
    lab.run(RunKind::Test, &case, &source, &early, &mut Stopper::after(1)).unwrap();
    for name in [CHECKPOINT, PREVIOUS_CHECKPOINT] {
        fs::remove_file(early.path().join(name)).unwrap();
    }
    fs::write(&file, text.replace("\n1,", "\n001,")).unwrap();
    let message = lab.resume(&early, &mut NoObserver).unwrap_err().to_string();
    assert!(message.contains("packing.csv: was changed since the run began"), "{message}");
    fs::remove_file(&file).unwrap();
    let message = lab.resume(&early, &mut NoObserver).unwrap_err().to_string();
    assert!(message.contains("packing.csv"), "{message}");

    lab.resume(&broken, &mut NoObserver).unwrap();
    assert_same(&straight, &broken);
}

#[test]
fn a_run_killed_before_its_first_checkpoint_begins_again() {
    let base = tempfile::tempdir().unwrap();
    let (case, lab) = (small(), laboratory());
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    lab.run(RunKind::Sample, &case, &Source::Case, &straight, &mut NoObserver).unwrap();
    // The contents of the folder after the first file has been written.
    let killed = RunFolder::create(base.path().join("killed"), false).unwrap();
    let mut record = RunRecord::new(RunKind::Sample, "test", &case, Machine::here("portable", 1));
    record.unwritten_case = Some(case.resolved_toml());
    killed.write_record(&record).unwrap();
    let record = lab.resume(&killed, &mut NoObserver).unwrap();
    assert!(record.status == RunStatus::Finished && record.unwritten_case.is_none());
    assert_same(&straight, &killed);
    // A run with a changed case is not resumed.
    killed.write_case(&Case::default(), None).unwrap();
    let message = lab.resume(&killed, &mut NoObserver).unwrap_err().to_string();
    assert!(message.contains("case.toml: the case was changed since the run began"), "{message}");
}

#[test]
fn the_checkpoint_before_is_used_where_the_last_one_cannot_be() {
    let base = tempfile::tempdir().unwrap();
    let (case, lab) = (small(), laboratory());
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    lab.run(RunKind::Test, &case, &Source::Case, &straight, &mut NoObserver).unwrap();
    type Damage = fn(&mut Vec<u8>);
    let damages: [(&str, Damage); 4] = [
        ("truncated", |bytes| bytes.truncate(bytes.len() / 2)),
        ("damaged", |bytes| {
            let middle = bytes.len() / 2;
            bytes[middle] ^= 16;
        }),
        ("version 99", |bytes| bytes[8] = 99),
        ("not a granum checkpoint", |bytes| bytes.clear()),
    ];
    for (k, (word, damage)) in damages.into_iter().enumerate() {
        let folder = RunFolder::create(base.path().join(format!("damaged-{k}")), false).unwrap();
        lab.run(RunKind::Test, &case, &Source::Case, &folder, &mut Stopper::after(30 * (k as u32 + 1)))
            .unwrap();
        let path = folder.path().join(CHECKPOINT);
        let mut bytes = fs::read(&path).unwrap();
        damage(&mut bytes);
        fs::write(&path, &bytes).unwrap();
        let mut observer = Stopper::after(3);
        lab.resume(&folder, &mut observer).unwrap();
        let text = observer.warnings.join("\n");
        assert!(text.contains(word) || (k == 3 && text.contains("truncated")), "{text}");
        assert!(
            text.contains("continues from the previous one") && text.contains("checkpoint.previous"),
            "{text}"
        );
        assert_eq!(fs::read(folder.path().join(REFUSED_CHECKPOINT)).unwrap(), bytes);
        let mut observer = Stopper::after(u32::MAX);
        lab.resume(&folder, &mut observer).unwrap();
        assert!(observer.warnings.is_empty(), "{:?}", observer.warnings);
        assert_same(&straight, &folder);
    }
}

#[test]
fn a_missing_checkpoint_falls_back_and_two_bad_ones_are_refused() {
    let base = tempfile::tempdir().unwrap();
    let (case, mut lab) = (small(), laboratory());
    lab.resources.checkpoint_every = Duration::ZERO;
    let straight = RunFolder::create(base.path().join("straight"), false).unwrap();
    lab.run(RunKind::Sample, &case, &Source::Case, &straight, &mut NoObserver).unwrap();
    let folder = RunFolder::create(base.path().join("run"), false).unwrap();
    lab.run(RunKind::Sample, &case, &Source::Case, &folder, &mut Stopper::after(20)).unwrap();
    let (current, previous) = (folder.path().join(CHECKPOINT), folder.path().join(PREVIOUS_CHECKPOINT));
    fs::remove_file(&current).unwrap();
    let mut observer = Stopper::after(5);
    lab.resume(&folder, &mut observer).unwrap();
    assert!(observer.warnings[0].contains("there is no checkpoint; the run continues from the previous one"));
    let good = fs::read(&current).unwrap();
    fs::write(&current, &good[..100]).unwrap();
    fs::write(&previous, "x").unwrap();
    let message = lab.resume(&folder, &mut NoObserver).unwrap_err().to_string();
    for part in ["checkpoint: ", "truncated", "checkpoint.previous: ", "not a granum", "granum run"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    fs::remove_file(&previous).unwrap();
    let message = lab.resume(&folder, &mut NoObserver).unwrap_err().to_string();
    assert!(message.contains("there is no checkpoint.previous"), "{message}");
    fs::write(&current, &good).unwrap();
    lab.resume(&folder, &mut NoObserver).unwrap();
    assert_same(&straight, &folder);

    // A finished sample whose checkpoint is damaged is restored by resuming from the previous one; the message of a test
    // says so.
    let mut bytes = fs::read(&current).unwrap();
    bytes[1000] ^= 1;
    fs::write(&current, bytes).unwrap();
    let other = RunFolder::create(base.path().join("other"), false).unwrap();
    let source = Source::Folder(folder.path().to_path_buf());
    let message = lab.run(RunKind::Test, &case, &source, &other, &mut NoObserver).unwrap_err().to_string();
    assert!(message.contains("checksum") && message.contains("granum resume"), "{message}");
    lab.resume(&folder, &mut NoObserver).unwrap();
    assert_same(&straight, &folder);
    assert!(Run::at(folder.path()).unwrap().record().unwrap().is_good());
}

#[test]
fn an_unfinished_sample_is_not_sheared() {
    let base = tempfile::tempdir().unwrap();
    let (case, lab) = (small(), laboratory());
    let sample = RunFolder::create(base.path().join("sample"), false).unwrap();
    lab.run(RunKind::Sample, &case, &Source::Case, &sample, &mut Stopper::after(3)).unwrap();
    let run = RunFolder::create(base.path().join("run"), false).unwrap();
    let source = Source::Folder(sample.path().to_path_buf());
    let message = lab.run(RunKind::Test, &case, &source, &run, &mut NoObserver).unwrap_err().to_string();
    assert!(
        message.contains("its preparation is not finished; continue it with `granum resume"),
        "{message}"
    );
    // Once the sample is finished, the same run folder can be used, since the refused test left nothing in it.
    lab.resume(&sample, &mut NoObserver).unwrap();
    assert_eq!(
        lab.run(RunKind::Test, &case, &source, &run, &mut NoObserver).unwrap().status,
        RunStatus::Finished
    );
}
