//! What a user types and names: numbers without units, files in files, names of columns, and paths of any bytes.

use std::fs;
use std::path::Path;

use crate::common::{run, stderr};
use crate::{done, refused};

/// A small sample at 100 kPa and a short test.
const CASE: &str = r#"
[grains]
count = 60
[preparation]
mean_stress = "100 kPa"
solid_fraction = "none"
inertial_number = 5e-3
unbalanced_force = 0.05
[[stage]]
path = "drained-triaxial"
lateral_stress = "100 kPa"
axial_strain = 0.01
inertial_number = 5e-3
states = 3
"#;

/// A folder with that case.
fn with_case() -> tempfile::TempDir {
    let base = tempfile::tempdir().unwrap();
    fs::write(base.path().join("case.toml"), CASE).unwrap();
    base
}

#[test]
fn a_bare_stress_far_from_the_sample_needs_its_unit() {
    let base = with_case();
    let here = base.path();
    let path = ["run", "case.toml", "--path", "drained-triaxial", "--out", "r", "--with"];
    let ask = |with: &str| refused(here, 1, &[&path[..], &[with]].concat());
    let message = ask("lateral_stress=50");
    for part in [
        "--with lateral_stress = \"50\" is understood as 50 Pa",
        "of 100 kPa; probably 50 kPa",
        "or \"50 Pa\"",
    ] {
        assert!(message.contains(part), "{message}");
    }
    assert!(ask("axial_strain=2").contains("a strain of 200 %; probably 2 % was meant"));
    assert!(
        ask("axial_strain=5")
            .contains("out of bounds; it must be from -3 to 3; if 5 % is meant, write \"5 %\"")
    );
    let message =
        refused(here, 1, &["run", "case.toml", "--set", "stage.1.lateral_stress=150", "--out", "r"]);
    assert!(message.contains("--set stage.1.lateral_stress = \"150\" is understood as 150 Pa"), "{message}");
    fs::write(here.join("typed.toml"), CASE.replace("\"100 kPa\"\naxial", "100\naxial")).unwrap();
    let message = refused(here, 1, &["run", "typed.toml", "--out", "r"]);
    assert!(
        message.contains("typed.toml:11:18: stage.1.lateral_stress = 100 is understood as 100 Pa"),
        "{message}"
    );
    assert_eq!(fs::read_dir(here).unwrap().count(), 2, "nothing may be left behind");
}

/// A stress with its unit is taken; the case of the run can be run again from any place, and the summary tells the stresses.
#[test]
fn a_stress_with_its_unit_is_taken_and_told() {
    let base = with_case();
    let here = base.path();
    let text = done(
        here,
        &[
            "run",
            "case.toml",
            "--set",
            "stage.1.lateral_stress=8 kPa",
            "--set",
            "stage.1.axial_strain=0.002",
            "--out",
            "r",
        ],
    );
    assert!(text.contains("stresses of stage 1 (consolidation): p 100.0 kPa"), "{text}");
    assert!(text.contains("stresses of stage 2 (shear): p 8."), "{text}");
    let written = fs::read_to_string(here.join("r/case.toml")).unwrap();
    assert!(written.contains("lateral_stress = \"8000 Pa\""), "{written}");
    fs::copy(here.join("r/case.toml"), here.join("copy.toml")).unwrap();
    let message = refused(here, 1, &["run", "copy.toml", "--set", "stage.1.lateral_stress=7", "--out", "s"]);
    assert!(message.contains("is understood as 7 Pa"), "{message}");
    assert_eq!(crate::digest(here, "r"), {
        done(here, &["run", "copy.toml", "--out", "again"]);
        crate::digest(here, "again")
    });
    // A laboratory's strains in per cent without a unit, and what is beyond the run.
    let lab = "axial_strain,deviator_stress (kPa)\n0,0\n1,5\n20,9\n";
    fs::write(here.join("lab.csv"), lab).unwrap();
    let message = refused(here, 1, &["compare", "r", "lab.csv"]);
    assert!(
        message.contains("lab.csv:1:1: axial_strain goes to 20 and is understood as a strain of 2000 %"),
        "{message}"
    );
    fs::write(here.join("lab.csv"), lab.replace("axial_strain", "axial_strain (%)")).unwrap();
    let message = refused(here, 1, &["compare", "r", "lab.csv"]);
    assert!(
        message.contains("there is nothing to compare") && message.contains("its first beyond zero is 1 %"),
        "{message}"
    );
    assert!(!here.join("compare.svg").exists());
    // What readings show to be otherwise is told with how to state it, and believed once it is stated.
    let rows: String = (0..12).map(|k| format!("0.{k:02},{},{}\n", k, 100 + k)).collect();
    let text = format!("axial_strain (%),deviator_stress (kPa),mean_stress (kPa)\n{rows}");
    fs::write(here.join("lab.csv"), text).unwrap();
    let told = stderr(&run(here, &["compare", "r", "lab.csv", "--force"]));
    assert!(
        told.contains("the axial strain ends at 0.11 %") && told.contains("--map axial_strain="),
        "{told}"
    );
    let refusal = refused(here, 1, &["compare", "r", "lab.csv", "--as", "strain=real", "--force"]);
    assert!(refusal.contains("engineering or logarithmic"), "{refusal}");
    done(here, &["compare", "r", "lab.csv", "--as", "deviator_stress=half", "--force"]);
}

#[test]
fn files_in_files_lie_below_them_unless_allowed() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::create_dir(here.join("cases")).unwrap();
    fs::write(here.join("element.csv"), "xx_strain\n0\n0.001\n").unwrap();
    let case = CASE.split("[[stage]]").next().unwrap();
    let case =
        format!("{case}[[stage]]\npath = \"history\"\ninertial_number = 5e-3\nfile = \"../element.csv\"\n");
    fs::write(here.join("cases/case.toml"), case).unwrap();
    let message = refused(here, 1, &["run", "cases/case.toml", "--out", "r"]);
    assert!(message.contains("stage.1.file") && message.contains("--allow-outside"), "{message}");
    done(here, &["run", "cases/case.toml", "--out", "r", "--allow-outside"]);
    fs::write(
        here.join("cases/run-1.vtm"),
        "<VTKFile type=\"vtkMultiBlockDataSet\"><DataSet file=\"../x.vtu\"/></VTKFile>",
    )
    .unwrap();
    let message = refused(here, 1, &["measure", "cases/run-1.vtm"]);
    assert!(message.contains("leads out of the folder"), "{message}");
    let message = refused(here, 1, &["measure", "cases/run-1.vtm", "--allow-outside"]);
    assert!(message.contains("cannot read") && message.contains("x.vtu"), "{message}");
}

#[test]
fn messages_say_what_would_be_right() {
    let base = with_case();
    let here = base.path();
    done(here, &["run", "case.toml", "--out", "r"]);
    let message = refused(here, 1, &["run", "case.toml", "--set", "lateral_stress=1e5", "--out", "s"]);
    assert!(message.contains("did you mean stage.1.lateral_stress?"), "{message}");
    let message = refused(here, 1, &["export", "r", "-o", "series.xls"]);
    assert!(message.contains(".xls") && message.contains(".csv or .parquet"), "{message}");
    let message = refused(here, 1, &["export", "r", "-o", "all.vtp", "--snapshot", "all"]);
    assert!(message.contains("choose one with --snapshot (there are end, "), "{message}");
    done(here, &["export", "r", "-o", "all.xyz", "--snapshot", "all"]);
    let message = refused(here, 1, &["export", "all.xyz", "-o", "one.vtp"]);
    assert!(message.contains("choose one with --snapshot (1 to 3, or last)"), "{message}");
    done(here, &["export", "all.xyz", "-o", "one.vtp", "--snapshot", "2"]);
    assert!(
        refused(here, 1, &["export", "all.xyz", "-o", "two.vtp", "--snapshot", "9"])
            .contains("from 1 to 3, last or all")
    );
    for command in [["predict", "r"], ["evaluate", "r"]] {
        let arguments = if command[0] == "evaluate" { vec!["evaluate", "r", "r"] } else { command.to_vec() };
        let message = refused(here, 1, &arguments);
        assert!(
            message.contains("r: a study is needed here, and this folder holds a finished test"),
            "{message}"
        );
        assert!(message.contains("granum train r --out study"), "{message}");
    }
    // The sample of another folder was not made in this run.
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let text = done(here, &["run", "case.toml", "--sample", "sample", "--out", "tested"]);
    let steps = |name: &str| {
        let record: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(here.join(name)).unwrap()).unwrap();
        record["steps"]["test"].as_f64().unwrap() * 60.0
    };
    assert!(text.contains(&format!("{:.2e} grain-steps in ", steps("tested/run.json"))), "{text}");
}

/// Names of files can have any bytes.
#[cfg(unix)]
#[test]
fn paths_that_are_not_text_work_or_are_refused_before_anything_is_written() {
    use std::ffi::{OsStr, OsString};
    use std::os::unix::ffi::OsStrExt;

    let base = with_case();
    let here = base.path();
    let name = |text: &[u8]| OsStr::from_bytes(text).to_os_string();
    let granum = |arguments: &[OsString]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_granum"))
            .current_dir(here)
            .args(arguments)
            .output()
            .unwrap();
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said).into_owned();
        assert!(!said.contains("panicked"), "{arguments:?}: {said}");
        (output.status.code(), said)
    };
    let words = |text: &str| -> Vec<OsString> {
        text.split(' ')
            .map(|word| name(&word.bytes().map(|b| if b == b'@' { 0xff } else { b }).collect::<Vec<_>>()))
            .collect()
    };
    let works = |line: &str| {
        let (status, said) = granum(&words(line));
        assert_eq!(status, Some(0), "{line}: {said}");
        said
    };
    assert!(works("init c@.toml").contains("granum run $'c\\xff.toml'"));
    fs::write(here.join(name(b"c\xff.toml")), CASE).unwrap();
    works("run c@.toml --out r@");
    for json in ["", "--json "] {
        for command in [
            "status r@",
            "digest r@",
            "export r@ -o s@.csv --force",
            "resume r@",
            "report r@ --force",
            "measure r@",
        ] {
            let said = works(&format!("{json}{command}"));
            assert!(command.starts_with("measure") || json.is_empty() || said.contains("\\\\xff"), "{said}");
        }
    }
    assert!(works("status r@").contains("granum report $'r\\xff'"), "the command can be pasted into a shell");
    works("prepare c@.toml --out p@");
    works("export r@ -o g@.csv --snapshot start --table grains");
    // The record of a run must name its sample or its packing.
    works("export r@ -o packing@.vtp --snapshot start");
    for source in ["--sample p@", "--packing packing@.vtp"] {
        let (status, said) = granum(&words(&format!("run c@.toml {source} --out n")));
        assert_eq!(status, Some(1), "{said}");
        assert!(said.contains("not UTF-8 text") && said.contains("rename it"), "{said}");
        assert!(!Path::new(here).join("n").exists(), "no folder may be left behind an error");
    }
}
