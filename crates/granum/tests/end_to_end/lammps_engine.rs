//! LAMMPS as an engine: what is refused without it, and, where `lmp` is installed, that a run is carried out, stopped, fails, goes on and is
//! read back like one of granum's own engine.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use granum_io::{Run, RunStatus};

use crate::{done, done_json, refused};

/// A hundred grains with laws that LAMMPS has, dense enough that the sample is soon at rest.
const CASE: &str = r#"
[grains]
count = 100
[contact]
normal = "hertz"
tangential = "no-slip"
[preparation]
friction = 0.1
solid_fraction = "none"
inertial_number = 5e-3
unbalanced_force = 2e-2
[recording]
observations_per_state = 2
"#;

/// A cycle between two deviator stresses at constant volume, as `cyclic` with a stress amplitude, but driven faster.
const STRESS_CYCLE: &str = r#"
[[stage]]
name = "stress cycle"
xx = "free"
yy = "free"
zz = "free"
constraint = [
    { stress = [1, -0.5, -0.5, 0, 0, 0], value = "current", rate = "600 MPa/s" },
    { strain = [1, 1, 1, 0, 0, 0], rate = 0 },
    { strain = [0, 1, -1, 0, 0, 0], rate = 0 },
]
servo_limit = 1
inertial_number = 5e-3
turns = { measure = "axial_deviator_stress", high = "2 kPa", low = "-2 kPa" }
until = { reversals = 2 }
record = { measure = "time", every = 2e-6 }
"#;

/// A short drained test.
const TEST: [&str; 10] = [
    "--path",
    "drained-triaxial",
    "--with",
    "axial_strain=0.003",
    "--with",
    "states=6",
    "--with",
    "inertial_number=3e-3",
    "--engine",
    "lammps",
];

fn has(program: &str) -> bool {
    let found = Command::new(program).arg("-h").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    if !found {
        println!("{program} is not on the PATH: the runs by LAMMPS were not made");
    }
    found
}

fn case(here: &Path) {
    std::fs::write(here.join("case.toml"), CASE).unwrap();
}

/// The arguments of a run of the case.
fn of_run<'a>(test: &[&'a str], out: &'a str) -> Vec<&'a str> {
    [&["run", "case.toml", "--sample", "sample", "--out", out], test].concat()
}

/// The program with settings by which MPI runs here, also as root and beside other programs.
fn granum(here: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_granum"));
    command.args(arguments).current_dir(here).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    command.env("OMPI_MCA_rmaps_base_oversubscribe", "1").env("OMPI_MCA_mpi_yield_when_idle", "1");
    command
}

/// Waits until the events of a run have a line that begins so.
fn wait_for(child: &mut Child, run: &Path, beginning: &str) {
    let since = Instant::now();
    while since.elapsed() < Duration::from_secs(120) && child.try_wait().unwrap().is_none() {
        let events = std::fs::read_to_string(run.join("lammps/events")).unwrap_or_default();
        if events.lines().any(|line| line.starts_with(beginning)) {
            return;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    panic!("no line {beginning} in the events of {}", run.display());
}

#[test]
fn what_lammps_cannot_do_is_refused_before_there_is_a_folder() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    case(here);
    let refused = |more: &[&str]| {
        let error = refused(here, 1, &[&["run", "case.toml", "--out", "run"], more].concat());
        assert!(!here.join("run").exists(), "{error}");
        error
    };
    let lammps = ["--engine", "lammps"];
    let with = |more: &[&'static str]| [&lammps[..], more].concat();
    let error = refused(&with(&["--set", "contact.tangential=mindlin-deresiewicz", "--path", "oedometer"]));
    assert!(error.contains("the engine lammps: contact.tangential = \"mindlin-deresiewicz\""), "{error}");
    let error = refused(&with(&["--set", "contact.normal=jkr", "--path", "oedometer"]));
    assert!(error.contains("contact.normal = \"jkr\"") && error.contains("hold across a gap"), "{error}");
    let error = refused(&with(&["--path", "probes"]));
    assert!(error.contains("it shears the cell without rotation"), "{error}");
    let error = refused(&with(&["--path", "oedometer", "--set", "recording.sensors=[\"sliding\"]"]));
    assert!(error.contains("recording.sensors") && error.contains("leave it out"), "{error}");
    // A program that is not there, and one that is no LAMMPS.
    let error = refused(&with(&["--path", "oedometer", "--command", "no-such-lmp -k on"]));
    assert!(error.contains("there is no program \"no-such-lmp\""), "{error}");
    assert!(error.contains("apt install lammps") && error.contains("--command"), "{error}");
    let error = refused(&with(&["--path", "oedometer", "--command", "true"]));
    assert!(error.contains("`true -h` does not say that it is LAMMPS"), "{error}");
    let error = refused(&with(&["--path", "oedometer", "--command", " "]));
    assert!(error.contains("--command is empty"), "{error}");
    let error = refused(&["--path", "oedometer", "--ranks", "2"]);
    assert!(error.contains("--ranks says how LAMMPS is started: add --engine lammps"), "{error}");
    let error = refused(&["--path", "oedometer", "--engine", "lamps"]);
    assert!(error.contains("there is no engine \"lamps\"; did you mean lammps?"), "{error}");
    let error = refused(&with(&["--ranks", "0", "--path", "oedometer"]));
    assert!(error.contains("--ranks 0: at least one"), "{error}");
}

/// A run whose LAMMPS fails, that goes on on two processors, is stopped, goes on and is complete; then all commands read it.
#[cfg(unix)]
#[test]
fn a_run_by_lammps_fails_is_stopped_goes_on_and_is_read_like_any_other() {
    if !has("lmp") {
        return;
    }
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    case(here);
    done(here, &["prepare", "case.toml", "--out", "sample"]);

    // The program fails at a command that it does not know.
    let failing = "#!/bin/sh\n[ \"$1\" = -h ] && exec lmp -h\nsed -i 's/^print \"stage 0: rest\"/no_such_command/' in.granum\nexec lmp \"$@\"\n";
    std::fs::write(here.join("failing"), failing).unwrap();
    assert!(Command::new("chmod").args(["+x", "failing"]).current_dir(here).status().unwrap().success());
    let program = here.join("failing").display().to_string();
    let error = refused(here, 1, &[&of_run(&TEST, "run")[..], &["--command", &program]].concat());
    assert!(error.contains("ERROR: Unknown command: no_such_command"), "{error}");
    assert!(error.contains("the end of") && error.contains("lammps/log.0"), "{error}");
    let status = done(here, &["status", "run"]);
    assert!(status.contains("failed (by lammps ") && status.contains("granum resume run"), "{status}");

    // It goes on with another command, on two processors where MPI is there, and is stopped in good order.
    let ranks: &[&str] = if has("mpirun") { &["--ranks", "2"] } else { &["--command", "lmp"] };
    let mut child = granum(here, &[&["resume", "run"], ranks].concat()).spawn().unwrap();
    wait_for(&mut child, &here.join("run"), "row,0,");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{told}");
    assert!(told.contains("continue with `granum resume run`"), "{told}");
    let status = done_json(here, &["status", "run"]);
    assert_eq!(status["status"], "interrupted");
    let events = std::fs::read_to_string(here.join("run/lammps/events")).unwrap();
    assert!(events.contains("\nsaved,"), "it was stopped with a restart file");

    // It goes on from the restart file of LAMMPS, also in another place: what it begins with names no folder.
    for name in std::fs::read_dir(here.join("run/lammps")).unwrap().map(|entry| entry.unwrap().path()) {
        let text = std::fs::read(&name).unwrap_or_default();
        let place = here.join("run").display().to_string();
        let is_named = text.windows(place.len()).any(|window| window == place.as_bytes());
        assert!(!is_named, "{} holds the place of the run", name.display());
    }
    std::fs::rename(here.join("run"), here.join("moved")).unwrap();
    done(here, &["resume", "moved", "--command", "lmp"]);
    std::fs::rename(here.join("moved"), here.join("run")).unwrap();
    let logs = std::fs::read_dir(here.join("run/lammps")).unwrap();
    let names: Vec<String> = logs.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.iter().any(|name| name.starts_with("log.") && name != "log.0"), "{names:?}");
    assert!(
        !names.iter().any(|name| name.starts_with("grains.") || name.starts_with("restart.")),
        "{names:?}"
    );
    let told = done(here, &["resume", "run"]);
    assert!(told.contains("it was already finished"), "{told}");
    check_record(here);
    check_results(here);
}

fn check_record(here: &Path) {
    let record = Run::at(here.join("run")).unwrap().record().unwrap();
    assert_eq!((record.engine.as_str(), record.status), ("lammps", RunStatus::Finished));
    assert!(!record.engine_version.is_empty());
    let note = |text: &str| record.notes.iter().any(|note| note.contains(text));
    assert!(
        note("not recorded: ") && note("boundary_work") && note("LAMMPS does not give"),
        "{:?}",
        record.notes
    );
    assert!(note("not judged: energy_gap"), "{:?}", record.notes);
    assert!(note("stage 1 (shear) ended after") && note("xx_strain reached 0.003"), "{:?}", record.notes);
    let flag = |name: &str| record.quality.iter().find(|flag| flag.name == name);
    assert!(flag("energy_gap").is_none() && flag("momentum_drift").is_none());
    // What is recorded is what LAMMPS has: the stresses of its contacts, without those of the dashpots.
    let stress = flag("stress_differs_from_lammps").unwrap();
    assert!(stress.passed && stress.value > 0.0, "{stress:?}");
    assert!(flag("stages_cut_short").unwrap().passed && flag("largest_overlap").unwrap().passed);
}

/// The run beside that of granum's own engine on the same sample.
fn check_results(here: &Path) {
    done(here, &of_run(&TEST[..8], "own"));
    let runs = ["run", "own"].map(|name| Run::at(here.join(name)).unwrap());
    let [theirs, ours] = runs.each_ref().map(|run| run.series().unwrap());
    assert_eq!(theirs.column("state").unwrap(), ours.column("state").unwrap());
    for unknown in ["boundary_work", "sliding_fraction"] {
        assert!(ours.has(unknown) && !theirs.has(unknown), "{unknown}");
    }
    let mean = |table: &granum_io::Table, name: &str| {
        let values = table.column(name).unwrap();
        values[1..].iter().sum::<f64>() / (values.len() - 1) as f64
    };
    // Several times what two runs of either program with other time steps differ by.
    for (column, tolerance) in [
        ("axial_strain", 1e-4),
        ("stress_ratio", 0.1),
        ("stress_22", 600.0),
        ("solid_fraction", 1e-3),
        ("coordination_number", 0.25),
        ("mechanical_coordination_number", 0.25),
        ("deviator_fabric", 0.02),
        ("unbalanced_force", 0.05),
        ("inertial_number", 1e-3),
    ] {
        let [a, b] = [&theirs, &ours].map(|table| mean(table, column));
        println!("{column}: LAMMPS {a}, granum {b}");
        assert!((a - b).abs() < tolerance, "{column}: LAMMPS {a}, granum {b}");
    }
    // The snapshot at the end carries the stresses of the last state, by its contacts with their tangential forces.
    let end = runs[0].snapshot("end").unwrap();
    assert!(end.contacts.iter().any(|contact| contact.tangential_force.iter().any(|force| *force != 0.0)));
    assert!(runs[0].forces().unwrap().rows() > 0);
    // Half the time step moves such curves by 2.4 % (granum) and 3.0 % (LAMMPS); 3.4 % were found between the programs.
    let compared = done_json(here, &["compare", "own", "run", "-o", "compare.svg"]);
    let of = |key: &str| compared["comparisons"][0][key].as_f64().unwrap();
    assert!(of("deviator_stress_error") < 0.06 && of("void_ratio_error") < 2e-5, "{compared}");
    assert!(of("deviator_stress_error") > 0.0 && here.join("compare.svg").exists(), "{compared}");
    let measured = done(here, &["measure", "run"]);
    assert!(measured.contains("coordination_number"), "{measured}");
    done(here, &["export", "run", "-o", "run.csv"]);
    done(here, &["report", "run", "--out", "run.html"]);
    let digest = done(here, &["digest", "run", "own"]);
    let lines: Vec<&str> = digest.lines().collect();
    assert!(lines[0].ends_with("(of what lammps gave here: not the same on every computer)"), "{digest}");
    assert!(lines[1].ends_with("  own"), "{digest}");
    let digest = done_json(here, &["digest", "run"]);
    assert_eq!(
        (&digest["digests"][0]["engine"], &digest["digests"][0]["same_everywhere"]),
        (&"lammps".into(), &false.into())
    );
    let told = done(here, &["export", "run", "--to", "lammps", "--out", "deck"]);
    assert!(told.contains("a deck of 100 grains"), "{told}");
}

/// Ramps, turning points and several stages end where those of granum end, by granum's reasons.
#[test]
fn stages_that_turn_round_and_ramps_are_those_of_granum() {
    if !has("lmp") {
        return;
    }
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let stages = "[[stage]]\nname = \"ramp\"\nxx = { strain_to = 0.0002 }\nyy = { stress_to = '21 kPa' }\nzz = { stress = '20 kPa' }\ninertial_number = 5e-3\n\
                  record = { measure = \"arc_length\", every = 1e-4 }\nresets = true\n\
                  [[stage]]\npath = 'cyclic'\nstrain_amplitude = 1.5e-4\ncycles = 1\ninterval = 4e-5\ninertial_number = 3e-3\n";
    std::fs::write(here.join("case.toml"), format!("{CASE}{stages}{STRESS_CYCLE}")).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    done(here, &of_run(&[], "own"));
    done(here, &of_run(&["--engine", "lammps"], "run"));
    let runs = ["run", "own"].map(|name| Run::at(here.join(name)).unwrap());
    // With the time step of granum, which a deck does not shorten with the stiffest contact, this was 0.22.
    let flags = runs[0].record().unwrap().quality;
    let time_step = flags.iter().find(|flag| flag.name == "time_step_fraction").unwrap();
    assert!(time_step.passed, "{time_step:?}");
    let notes = runs.each_ref().map(|run| {
        let notes = run.record().unwrap().notes;
        let reason = |note: &String| {
            let end = note.split("ended after ").nth(1)?;
            Some(end.split_once(": ")?.1.split(';').next()?.to_string())
        };
        notes.iter().filter_map(reason).collect::<Vec<_>>()
    });
    let turned = "it was reversed 2 times";
    assert_eq!(notes[0], ["its ramp is over", turned, turned]);
    assert_eq!(notes[0], notes[1]);
    let [theirs, ours] = runs.each_ref().map(|run| run.series().unwrap());
    let extremes = |table: &granum_io::Table, name: &str, number: f64| {
        let (values, stages) = (table.column(name).unwrap(), table.column("stage").unwrap());
        let of_stage =
            || values.iter().zip(stages).filter(|(_, stage)| **stage == number).map(|(value, _)| *value);
        [of_stage().fold(f64::INFINITY, f64::min), of_stage().fold(f64::NEG_INFINITY, f64::max)]
    };
    for (stage, column, tolerance) in [
        (1.0, "axial_strain", 1e-4),
        (1.0, "stress_22", 600.0),
        (2.0, "axial_strain", 1e-4),
        (2.0, "mean_stress", 3e3),
        (2.0, "stress_11", 4e3),
        (3.0, "deviator_stress", 900.0),
        (3.0, "mean_stress", 1200.0),
    ] {
        let [a, b] = [&theirs, &ours].map(|table| extremes(table, column, stage));
        println!("stage {stage}, {column}: LAMMPS {a:?}, granum {b:?}");
        for k in 0..2 {
            assert!((a[k] - b[k]).abs() < tolerance, "stage {stage}, {column}: LAMMPS {a:?}, granum {b:?}");
        }
    }
    // In a cycle of strains, state by state: half the time step moves either program by half a per cent on such a path, and they were
    // found to be 0.7 % apart (docs/src/theory/lammps.md).
    let in_cycle = |table: &granum_io::Table| {
        let (values, stages) = (table.column("mean_stress").unwrap(), table.column("stage").unwrap());
        values.iter().zip(stages).filter(|(_, stage)| **stage == 2.0).map(|(p, _)| *p).collect::<Vec<f64>>()
    };
    let [a, b] = [in_cycle(&theirs), in_cycle(&ours)];
    let states = a.len().min(b.len());
    assert!(a.len().abs_diff(b.len()) < 2 && states >= 10, "LAMMPS {a:?}, granum {b:?}");
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum();
    let distance = (squares / states as f64).sqrt() / (b.iter().sum::<f64>() / b.len() as f64);
    println!("rms distance of the mean stress in the cycle of strains: {distance}");
    assert!(distance < 0.03, "{distance}: LAMMPS {a:?}, granum {b:?}");
    // The snapshot between the stages is there, and the ramp ended at its stress.
    assert!(runs[0].snapshots().unwrap().iter().any(|name| name == "stage-1"));
}

/// The samples of a campaign are granum's, its tests those of the engine that the plan names.
#[test]
fn a_campaign_uses_the_engine_of_its_plan() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let test = "[[stage]]\npath = 'oedometer'\naxial_stress = '30 kPa'\ninertial_number = 3e-3\n";
    std::fs::write(here.join("case.toml"), format!("{CASE}{test}")).unwrap();
    let plan = |engine: &str| {
        let text = format!(
            "case = 'case.toml'\nengine = '{engine}'\nset.grains.count = 60\n[design]\nkind = 'list'\n\
             rows = [{{ friction = 0.4 }}, {{ friction = 0.5 }}]\n[[variable]]\nname = 'friction'\nkey = 'grains.material.friction'\n"
        );
        std::fs::write(here.join("plan.toml"), text).unwrap();
    };
    plan("lamps");
    let error = refused(here, 1, &["campaign", "plan.toml"]);
    assert!(error.contains("there is no engine \"lamps\"; did you mean lammps?"), "{error}");
    plan("granum");
    let error = refused(here, 1, &["campaign", "plan.toml", "--ranks", "2"]);
    assert!(error.contains("--ranks says how LAMMPS is started"), "{error}");
    plan("lammps'\nranks = 2\ncommand = 'lmp");
    let error = refused(here, 1, &["campaign", "plan.toml"]);
    assert!(error.contains("ranks and command both say how LAMMPS is started"), "{error}");
    plan("granum'\nranks = '2");
    let error = refused(here, 1, &["campaign", "plan.toml"]);
    assert!(error.contains("ranks says how LAMMPS is started") && error.contains("plan.toml:3"), "{error}");
    // A program that is not there, and a law that no deck has: nothing begins, also not in a dry run.
    plan("lammps'\ncommand = 'no-such-lmp");
    for more in [&[][..], &["--dry-run"]] {
        let error = refused(here, 1, &[&["campaign", "plan.toml"], more].concat());
        assert!(error.contains("there is no program \"no-such-lmp\""), "{error}");
    }
    if !has("lmp") {
        return;
    }
    plan("lammps'\nset.contact.tangential = 'mindlin-deresiewicz");
    for more in [&[][..], &["--dry-run"], &["--list-jobs"]] {
        let error = refused(here, 1, &[&["campaign", "plan.toml"], more].concat());
        assert!(error.contains("contact.tangential = \"mindlin-deresiewicz\""), "{error}");
    }
    assert!(!here.join("plan").exists());
    plan("lammps");
    done(here, &["campaign", "plan.toml", "--command", "lmp"]);
    let kept = std::fs::read_to_string(here.join("plan/campaign.json")).unwrap();
    assert!(kept.contains("\"command\""), "{kept}");
    done(here, &["campaign", "plan.toml"]);
    let mut engines = Vec::new();
    for entry in std::fs::read_dir(here.join("plan/tests")).unwrap() {
        let record = Run::at(entry.unwrap().path()).unwrap().record().unwrap();
        assert_eq!(record.status, RunStatus::Finished);
        engines.push(record.engine);
    }
    assert_eq!(engines, ["lammps", "lammps"]);
    let of = [
        "--input",
        "grains.material.friction",
        "--output",
        "coordination_number",
        "--coordinate",
        "axial_strain",
    ];
    done(here, &[&["train", "plan", "--method", "ridge", "-o", "surrogate"][..], &of].concat());
}
