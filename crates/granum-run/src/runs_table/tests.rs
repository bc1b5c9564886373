use granum_io::RunKind;
use granum_io::run::{Machine, QualityFlag};
use granum_io::{Case, RunRecord};

use super::*;

fn entry(name: &str, case: &str, measures: &[(&str, f64)]) -> RunEntry {
    let case = Case::parse(case, "case.toml").unwrap();
    let mut record = RunRecord::new(RunKind::Test, "0.1.0", &case, Machine::default());
    record.measures = measures.iter().map(|(name, value)| (name.to_string(), *value)).collect();
    record.quality = vec![QualityFlag::at_most("servo_error_rms", measures.len() as f64, 1.5, "slower")];
    RunEntry::new(name, name, case, record)
}

const PATH: &str = "[[stage]]\npath = 'drained-triaxial'\n";

#[test]
fn a_row_has_the_keys_that_differ_the_measures_and_the_checks() {
    let a = entry("a", &format!("{PATH}lateral_stress = '50 kPa'\n"), &[("solid_fraction", 0.6)]);
    let b = entry(
        "b",
        &format!("[contact]\nnormal = 'hertz'\n{PATH}lateral_stress = '100 kPa'\n"),
        &[("solid_fraction", 0.5), ("peak_friction_angle", 31.0)],
    );
    let table = RunsTable::from_runs(&[a, b]);
    let numbers =
        |name: &str| table.column(name).unwrap_or_else(|| panic!("{name}")).numbers().unwrap().to_vec();
    assert_eq!(numbers("stage.1.lateral_stress"), [5e4, 1e5]);
    assert_eq!(table.column("stage.1.lateral_stress").unwrap().unit, "Pa");
    assert_eq!(table.column("contact.normal").unwrap().text(1), "hertz");
    assert!((numbers("void_ratio")[0] - 2.0 / 3.0).abs() < 1e-15);
    let angle = table.column("peak_friction_angle").unwrap();
    assert_eq!((angle.unit.as_str(), angle.text(0).as_str(), angle.text(1).as_str()), ("deg", "", "31"));
    let failed = table.column("failed_checks").unwrap();
    assert_eq!([failed.text(0), failed.text(1)], ["", "servo_error_rms"]);
    assert!(table.column("shear.mean_stress").is_none() && table.column("grains.count").is_none());
    // The screen shows less.
    let main = table.select(Selection::Main);
    let names: Vec<&str> = main.columns().iter().map(|column| column.name.as_str()).collect();
    let wanted = [
        "name",
        "status",
        "contact.normal",
        "stage.1.lateral_stress",
        "void_ratio",
        "peak_friction_angle",
        "checks_failed",
    ];
    assert_eq!(names, wanted);
}

#[test]
fn the_legend_says_what_differs_in_few_words() {
    let of = |texts: &[&str]| {
        let runs: Vec<RunEntry> =
            (texts.iter().enumerate()).map(|(k, text)| entry(&format!("run-{k}"), text, &[])).collect();
        legend(&runs)
    };
    let friction =
        |friction: &str| format!("grains.material.friction = {friction}\npreparation.friction = 0.1\n");
    assert_eq!(of(&[&friction("0.2"), &friction("0.4")]), ["friction 0.2", "friction 0.4"]);
    let stress =
        |kpa: &str, seed: &str| format!("preparation.seed = {seed}\n{PATH}lateral_stress = '{kpa} kPa'\n");
    assert_eq!(
        of(&[&stress("50", "1"), &stress("100", "2")]),
        ["seed 1, lateral stress 50 kPa", "seed 2, lateral stress 100 kPa"]
    );
    // Repetitions of one case have their names.
    assert_eq!(of(&["", ""]), ["run-0", "run-1"]);
    let many = "grains.count = 100\npreparation.seed = 2\ngrains.material.friction = 0.1\nshear.deviator_strain = 0.1\n";
    assert_eq!(of(&["", many]), ["run-0", "run-1"]);
    let two = of(&["preparation.friction = 0.1", "grains.material.friction = 0.1"]);
    assert_eq!(
        two,
        [
            "material.friction 0.3, preparation.friction 0.1",
            "material.friction 0.1, preparation.friction auto"
        ]
    );
}

#[test]
fn stages_that_are_repeated_are_numbered() {
    let text = |amplitude: &str| {
        format!(
            "{PATH}[[stage]]\nrepeat = 2\n[[stage.stage]]\npath = 'hold'\n[[stage.stage]]\npath = 'cyclic'\nstrain_amplitude = {amplitude}\n"
        )
    };
    let found = differing_keys(&[entry("a", &text("0.01"), &[]), entry("b", &text("0.02"), &[])]);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].key, "stage.2.2.strain_amplitude");
    assert_eq!(found[0].values, [KeyValue::Number(0.01), KeyValue::Number(0.02)]);
}

#[test]
fn runs_are_found_in_the_folders_that_contain_them() {
    let base = tempfile::tempdir().unwrap();
    let make = |path: &str, kind: RunKind| {
        let folder = granum_io::RunFolder::create(base.path().join(path), false).unwrap();
        folder.write_record(&RunRecord::new(kind, "0.1.0", &Case::default(), Machine::default())).unwrap();
    };
    make("study/b", RunKind::Test);
    make("study/a", RunKind::Test);
    make("study/samples/s", RunKind::Sample);
    make("alone/samples/s", RunKind::Sample);
    let found = |folders: &[&str]| {
        let folders: Vec<_> = folders.iter().map(|folder| base.path().join(folder)).collect();
        find_runs(&folders).map(|found| {
            found
                .iter()
                .map(|path| path.strip_prefix(base.path()).unwrap().display().to_string())
                .collect::<Vec<_>>()
        })
    };
    assert_eq!(found(&["study"]).unwrap(), ["study/a", "study/b"]);
    assert_eq!(found(&["study/b", "study"]).unwrap(), ["study/b", "study/a"], "a run is a row once");
    assert_eq!(found(&["alone"]).unwrap(), ["alone/samples/s"]);
    std::fs::create_dir(base.path().join("empty")).unwrap();
    assert!(found(&["empty"]).unwrap_err().to_string().ends_with("empty: contains no run"));
    assert!(found(&["nowhere"]).unwrap_err().to_string().ends_with("there is no such folder"));
}

#[test]
fn repetitions_with_other_seeds_are_one_group() {
    let text = |friction: &str, seed: u32| {
        format!("grains.material.friction = {friction}\npreparation.seed = {seed}\n")
    };
    let runs: Vec<RunEntry> = [("0.2", 1), ("0.4", 1), ("0.2", 2)]
        .iter()
        .map(|(friction, seed)| entry(&format!("{friction}-{seed}"), &text(friction, *seed), &[]))
        .collect();
    let found: Vec<(String, Vec<usize>)> =
        groups(&runs).into_iter().map(|group| (group.label, group.runs)).collect();
    assert_eq!(
        found,
        [("friction 0.2 (2 seeds)".to_string(), vec![0, 2]), ("friction 0.4".to_string(), vec![1])]
    );
    let seeds: Vec<String> =
        groups(&[runs[0].clone(), runs[2].clone()]).into_iter().map(|group| group.label).collect();
    assert_eq!(seeds, ["seed 1", "seed 2"]);
}

/// A run of which the record was removed or replaced by something else is not left out of a table without a word.
#[test]
fn a_run_without_its_record_is_named() {
    let base = tempfile::tempdir().unwrap();
    for name in ["a", "b"] {
        let folder = base.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("run.json"), "{}").unwrap();
        std::fs::write(folder.join("series.parquet"), "").unwrap();
    }
    let find = || find_runs(&[base.path().to_path_buf()]);
    assert_eq!(find().unwrap().len(), 2);
    std::fs::remove_file(base.path().join("b/run.json")).unwrap();
    let error = find().unwrap_err().to_string();
    assert!(error.contains("b: holds the series of a run but no run.json"), "{error}");
    std::fs::create_dir(base.path().join("b/run.json")).unwrap();
    assert_eq!(find().unwrap().len(), 2);
}
