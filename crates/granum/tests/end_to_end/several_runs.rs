//! Several values of a key make several runs, whose results are compared in one table.

use std::path::Path;

use crate::common::{json, run, stderr, stdout};
use crate::{SMALL, digest, done, done_json, refused};

/// Two stresses and two frictions, so that each of two samples serves two tests.
const STUDY: [&str; 13] = [
    "run",
    "case.toml",
    "--path",
    "drained-triaxial",
    "--with",
    "axial_strain=0.005",
    "--with",
    "inertial_number=5e-3",
    "--with",
    "lateral_stress=20 kPa,30 kPa",
    "--set",
    "grains.material.friction=0.2,0.4",
    "--out=study",
];

fn folder_with_case() -> tempfile::TempDir {
    let base = tempfile::tempdir().unwrap();
    let case = SMALL.replace("count = 150", "count = 80");
    std::fs::write(base.path().join("case.toml"), case).unwrap();
    base
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name != ".granum-lock")
        .collect();
    names.sort();
    names
}

#[test]
fn values_between_commas_make_all_combinations() {
    let base = folder_with_case();
    let here = base.path();
    let told = done_json(here, &STUDY);
    let runs = told["runs"].as_array().unwrap();
    let names: Vec<&str> = runs.iter().map(|run| run["name"].as_str().unwrap()).collect();
    let wanted = [
        "lateral_stress=20kPa_friction=0.2",
        "lateral_stress=20kPa_friction=0.4",
        "lateral_stress=30kPa_friction=0.2",
        "lateral_stress=30kPa_friction=0.4",
    ];
    assert_eq!(names, wanted);
    assert_eq!(files(&here.join("study")), [&wanted[..], &["runs.json", "samples"]].concat());
    assert_eq!(told["samples"].as_array().unwrap().len(), 2, "a sample for each friction");
    assert_eq!(runs[3]["values"]["stage.1.lateral_stress"], "30 kPa");
    assert!(runs.iter().all(|run| run["status"] == "finished" && run["reused"] == false), "{told}");
    assert!(told["warnings"][0].as_str().unwrap().contains("checks not passed: inertial_number"), "{told}");

    // A run of the list is the run that one would have made alone.
    let alone: Vec<&str> = STUDY
        .iter()
        .map(|word| match *word {
            "lateral_stress=20 kPa,30 kPa" => "lateral_stress=30 kPa",
            "grains.material.friction=0.2,0.4" => "grains.material.friction=0.4",
            "--out=study" => "--out=alone",
            word => word,
        })
        .collect();
    done(here, &alone);
    assert_eq!(digest(here, "alone"), digest(here, &format!("study/{}", wanted[3])));

    // The same command uses all of it again, and one more value adds what is missing.
    let again = done_json(here, &STUDY);
    assert!(again["runs"].as_array().unwrap().iter().all(|run| run["reused"] == true), "{again}");
    assert!(done(here, &STUDY).contains("all were already finished; nothing was left to do"));
    let more: Vec<&str> =
        STUDY
            .iter()
            .map(|word| {
                if word.starts_with("lateral_stress") { "lateral_stress=20 kPa,30 kPa,40 kPa" } else { word }
            })
            .collect();
    let more = done_json(here, &more);
    let reused: Vec<bool> =
        more["runs"].as_array().unwrap().iter().map(|run| run["reused"].as_bool().unwrap()).collect();
    assert_eq!(reused, [true, true, true, true, false, false]);
    let status = done_json(here, &["status", "study"]);
    assert_eq!((&status["finished"], &status["command"]), (&true.into(), &"granum table study".into()));
    assert_eq!(status["runs"].as_array().unwrap().len(), 8);
    // So does a folder that was copied without its hidden file.
    std::fs::remove_file(here.join("study/.granum-lock")).unwrap();
    done(here, &["resume", "study"]);
    std::fs::remove_file(here.join("study/.granum-lock")).unwrap();
    assert!(done(here, &STUDY).contains("nothing was left to do"));

    table_of_the_study(here);
    curves_of_the_study(here);
    data_of_another_program(here);
    a_folder_of_several_runs_is_no_run(here);
    parameters_of_stages_are_inputs(here, [wanted[0], wanted[2]]);
}

/// Of runs that differ in the parameter of a stage, no difference is left if it is an input.
fn parameters_of_stages_are_inputs(here: &Path, runs: [&str; 2]) {
    let [one, two] = runs.map(|name| format!("study/{name}"));
    let note = |input: &str, out: &str| {
        let words =
            ["train", &one, &two, "--input", input, "--output", "stress_ratio", "--method", "ridge", out];
        let output = run(here, &words);
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    let told = note("axial_strain", "--out=without");
    assert!(told.contains("the runs differ in stage.1.lateral_stress, which is not an input"), "{told}");
    let told = note("axial_strain,stage.1.lateral_stress", "--out=with");
    assert!(!told.contains("is not an input"), "{told}");
}

/// The table of the six runs.
fn table_of_the_study(here: &Path) {
    let text = done(here, &["table", "study", "-o", "study.csv"]);
    assert!(text.contains("wrote 6 rows with"), "{text}");
    let csv = std::fs::read_to_string(here.join("study.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let cell = |row: usize, name: &str| {
        let at = rows[0].iter().position(|column| *column == name).unwrap_or_else(|| panic!("{name}: {csv}"));
        rows[row][at]
    };
    assert_eq!(rows.len(), 7);
    assert_eq!((cell(6, "stage.1.lateral_stress"), cell(6, "grains.material.friction")), ("40000", "0.4"));
    let record = granum_io::Run::at(here.join("study").join(cell(6, "name"))).unwrap().record().unwrap();
    assert_eq!(cell(6, "solid_fraction").parse::<f64>().unwrap(), record.measures["solid_fraction"]);
    for (name, value) in &record.measures {
        assert_eq!(cell(6, name).parse::<f64>().unwrap(), *value, "{name}");
    }
    assert_eq!(cell(6, "case_digest"), record.case_digest);
    assert_eq!(cell(1, "digest"), digest(here, cell(1, "folder")));
    assert!(cell(1, "failed_checks").starts_with("inertial_number"), "{csv}");
    assert!(!rows[0].contains(&"grains.count") && !rows[0].contains(&"stage.1.axial_strain"), "{csv}");
    // Parquet has the same numbers, and JSON the units.
    let asked = done_json(here, &["table", "study", "-o", "study.parquet"]);
    assert_eq!(asked["units"]["stage.1.lateral_stress"], "Pa");
    assert_eq!(asked["runs"][5]["stage.1.lateral_stress"], 40000);
    let table = granum_io::read_table(here.join("study.parquet")).unwrap();
    assert_eq!(table.column("stage.1.lateral_stress").unwrap()[4..], [4e4, 4e4]);
    // A selection of runs, and nothing that is not there.
    let two = format!("study/{}", cell(1, "name"));
    let text = done(here, &["table", &two, "alone"]);
    assert_eq!(
        text.lines().filter(|line| line.contains("0.2") || line.starts_with("alone")).count(),
        2,
        "{text}"
    );
    assert!(refused(here, 1, &["table", "nowhere"]).contains("nowhere: there is no such folder"));
    assert!(refused(here, 1, &["table", "study", "-o", "study.csv"]).contains("study.csv"));
    assert!(refused(here, 1, &["table", "study", "-o", "study.xls"]).contains(".csv or .parquet"));
}

/// The six runs over each other, in a report and in a figure.
fn curves_of_the_study(here: &Path) {
    let read = |name: &str| std::fs::read_to_string(here.join(name)).unwrap();
    let text = done(here, &["report", "study"]);
    assert!(text.contains("wrote study/report.html and 4 figures"), "{text}");
    // Two frictions are two materials, which have no critical state line in common.
    assert!(!read("study/report.html").contains("Critical state line"));
    let page = read("study/report.html");
    assert!(
        page.contains("differ in grains.material.friction and stage.1.lateral_stress, and in nothing else")
    );
    let figure = read("study/figures/figure-s1-stress.svg");
    for label in ["friction 0.2, lateral stress 20 kPa", "friction 0.4, lateral stress 40 kPa"] {
        assert!(figure.contains(label), "{label}");
    }
    // The report and its figures are not taken for runs.
    assert!(done(here, &["table", "study", "-o", "again.csv"]).contains("wrote 6 rows"));
    let text = done(here, &["report", "study", "alone", "--out", "all.html"]);
    assert!(text.contains("wrote all.html") && read("all.html").contains("7 runs"), "{text}");
    let sample = format!("study/samples/{}", files(&here.join("study/samples"))[0]);
    let message = refused(here, 1, &["report", &sample, "alone", "--out", "x.html"]);
    assert!(message.contains("is a sample"), "{message}");
    assert!(refused(here, 1, &["report", "nowhere"]).contains("nowhere: there is no such file or folder"));
    let message = refused(here, 1, &["report", "study", "--density", "1", "--out", "x.html"]);
    assert!(message.contains("belongs to files of another program"), "{message}");

    let compared = done_json(here, &["compare", "study", "-o", "compare.svg"]);
    let pairs = compared["comparisons"].as_array().unwrap();
    assert_eq!((pairs.len(), &pairs[0]["test"]), (5, &"friction 0.2, lateral stress 20 kPa".into()));
    assert!(pairs[4]["peak_deviator_stress_error"].as_f64().unwrap() > 0.5, "twice the stress: {compared}");
    assert!(read("compare.svg").contains("friction 0.4, lateral stress 40 kPa"));
    let message = refused(here, 1, &["compare", "alone", "-o", "y.svg"]);
    assert!(message.contains("give two runs or more"), "{message}");
    let message = refused(here, 1, &["compare", "study", "--test", "TMD22", "-o", "y.svg"]);
    assert!(message.contains("belong to a laboratory's file"), "{message}");
}

/// Grains and contacts in files have force chains and fabric.
fn data_of_another_program(here: &Path) {
    for table in ["grains", "contacts"] {
        done(here, &["export", "alone", "--table", table, "-o", &format!("{table}.csv")]);
    }
    let cell = granum_io::Run::at(here.join("alone")).unwrap().snapshot("end").unwrap().cell;
    let cell: Vec<String> = (0..3).map(|k| format!("{} m", cell[k][k])).collect();
    let cell = cell.join(", ");
    let ask = ["report", "grains.csv", "contacts.csv", "--cell", &cell, "--out", "data"];
    assert!(done(here, &ask).contains("wrote data/report.html and 4 figures"));
    let wanted = ["force-chains", "strong-network", "forces", "roses"];
    for (k, name) in wanted.iter().enumerate() {
        assert!(here.join(format!("data/figures/figure-s{}-{name}.svg", k + 1)).is_file(), "{name}");
    }
    let page = std::fs::read_to_string(here.join("data/report.html")).unwrap();
    let measured = done_json(here, &["measure", "grains.csv", "contacts.csv", "--cell", &cell]);
    assert!(
        page.contains("mechanical_coordination_number") && measured["values"]["deviator_fabric"].is_number()
    );
    // Without contacts the figures that need them are missing, and the page says why.
    done(here, &["report", "grains.csv", "--cell", &cell, "--out", "grains.html"]);
    let page = std::fs::read_to_string(here.join("grains.html")).unwrap();
    assert!(page.contains("There is no figure of force chains: the data have no"), "{page}");
    let message = refused(here, 1, &["report", "study", "grains.csv", "--out", "z.html"]);
    assert!(message.contains("not both"), "{message}");
}

fn a_folder_of_several_runs_is_no_run(here: &Path) {
    let message = refused(here, 1, &["shear", "case.toml", "--out", "study", "--force"]);
    assert!(message.contains("study already contains a finished list of 6 runs"), "{message}");
    let message = refused(here, 1, &["shear", "case.toml", "--seed", "1,2", "--out", "alone"]);
    assert!(message.contains("alone already contains a finished test"), "{message}");
    // A run of another case is not replaced without a word.
    let other =
        ["shear", "case.toml", "--set", "shear.deviator_strain=0.003", "--seed", "1,2", "--out", "seeds"];
    done(here, &other);
    let changed: Vec<&str> = other
        .iter()
        .map(|word| if word.contains("strain") { "shear.deviator_strain=0.004" } else { word })
        .collect();
    let message = refused(here, 1, &changed);
    assert!(
        message.contains("its run has another case or version") && message.contains("give --force"),
        "{message}"
    );
    let forced = done_json(here, &[&changed[..], &["--force"]].concat());
    assert!(forced["runs"].as_array().unwrap().iter().all(|run| run["reused"] == false), "{forced}");
}

#[test]
fn a_mistake_in_any_value_is_refused_before_anything_runs() {
    let base = folder_with_case();
    let here = base.path();
    for (flags, wanted) in [
        (
            &["--set", "grains.material.friction=0.2,-1"][..],
            "--set grains.material.friction = \"-1\" is out of bounds",
        ),
        (&["--set", "grains.diameter=1 mm,1 kg"], "--set grains.diameter = \"1 kg\" is a mass"),
        (&["--set", "grains.material.friction=0.2,,0.4"], "has an empty value between its commas"),
        (
            &["--set", "grains.material.friction=0,3"],
            "can be one number with a decimal comma or two values; write 0.3 or [0, 3]",
        ),
        (&["--set", "grains.material.friction=0.2,0.20"], "are the same case: give every value once"),
        (&["--seed", "1,x"], "--seed = \"x\" is not a whole number"),
        (&["--set", "recording.strains=[[0.01, 0.02], 0.03]"], "in which \"0.03\" is no list"),
        (
            &["--set", "contact.tangential=no-slip,peeling", "--set", "contact.normal=hertz"],
            "with --set contact.tangential=peeling --set contact.normal=hertz: contact.tangential = \"peeling\" needs",
        ),
        (
            &["--set", "recording.sensors=[[void_ratio], [no_such]]"],
            "recording.sensors: there is no sensor \"no_such\"",
        ),
        (&["--set", "grains.count=100,2000000000"], "out of bounds"),
    ] {
        let message = refused(here, 1, &[&["shear", "case.toml", "--out", "r"][..], flags].concat());
        assert!(message.contains(wanted), "{flags:?}: {message}");
    }
    let message = refused(here, 1, &["limits", "case.toml", "--seed", "1,2"]);
    assert!(
        message.contains("several values of a key make several runs, which this command does not take"),
        "{message}"
    );
    assert_eq!(files(here), ["case.toml"], "nothing may be left behind");
}

#[test]
fn a_list_is_one_value_of_a_key_that_takes_lists() {
    let base = folder_with_case();
    let here = base.path();
    let strains = |value: &str| format!("recording.strains={value}");
    done(here, &["shear", "case.toml", "--set", &strains("0.01,0.02"), "--out", "one"]);
    assert!(here.join("one/series.parquet").is_file(), "one run");
    let lists = strains("[[0.01, 0.02], [0.005, 0.01, 0.02]]");
    let told = done_json(here, &["shear", "case.toml", "--set", &lists, "--out", "two"]);
    let rows: Vec<usize> = (told["runs"].as_array().unwrap().iter())
        .map(|run| {
            granum_io::Run::at(here.join(run["folder"].as_str().unwrap())).unwrap().series().unwrap().rows()
        })
        .collect();
    assert_eq!(rows, [3, 4]);
}

#[test]
fn an_interrupted_list_continues_with_resume() {
    let base = folder_with_case();
    let here = base.path();
    let command =
        ["shear", "case.toml", "--seed", "1,2,3", "--set", "shear.deviator_strain=0.05", "--out", "seeds"];
    let child = std::process::Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(command)
        .current_dir(here)
        .stderr(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(60));
    assert!(
        std::process::Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status()
            .unwrap()
            .success()
    );
    let ended = child.wait_with_output().unwrap();
    // On a fast machine the runs may have ended before the signal.
    if !ended.status.success() {
        assert_eq!(ended.status.code(), Some(130), "{}", stderr(&ended));
        assert!(stderr(&ended).contains("continue with `granum resume seeds`"), "{}", stderr(&ended));
        assert_eq!(done_json(here, &["status", "seeds"])["command"], "granum resume seeds");
    }
    let resumed = run(here, &["resume", "seeds", "--json"]);
    assert!(resumed.status.success(), "{}", stderr(&resumed));
    let told = json(&stdout(&resumed));
    assert!(told["runs"].as_array().unwrap().iter().all(|run| run["status"] == "finished"), "{told}");
    let alone =
        ["shear", "case.toml", "--seed", "3", "--set", "shear.deviator_strain=0.05", "--out", "alone"];
    done(here, &alone);
    assert_eq!(digest(here, "alone"), digest(here, "seeds/seed=3"));
}
