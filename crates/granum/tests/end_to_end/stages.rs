//! Tests along paths and stages, as in the book.

use super::{SMALL, done, done_json, refused};

/// The small case without the sections that stages replace.
fn case() -> String {
    let start = SMALL.find("[shear]").unwrap();
    format!("{}[recording]\nobservations_per_state = 3\n", &SMALL[..start])
}

#[test]
fn a_drained_and_an_undrained_test_of_one_sample() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    std::fs::write(place.join("case.toml"), SMALL).unwrap();
    done(place, &["prepare", "case.toml", "--out", "sample"]);
    for (path, column) in [("drained-triaxial", "stress_33"), ("undrained-triaxial", "volumetric_strain")] {
        let with = ["--with", "axial_strain=0.01", "--with", "inertial_number=3e-3", "--with", "states=10"];
        let mut all = vec!["run", "case.toml", "--sample", "sample", "--path", path, "--out", path];
        all.extend(with);
        let found = done_json(place, &all);
        assert_eq!(found["status"], "finished");
        let notes = found["notes"].to_string();
        assert!(
            notes.contains("stage 1 (shear) ended after") && notes.contains("xx_strain reached 0.01"),
            "{notes}"
        );
        let table = granum_io::Run::at(place.join(path)).unwrap().series().unwrap();
        let values = table.column(column).unwrap();
        let spread = values.iter().fold(0.0f64, |m, v| m.max((v - values[0]).abs()));
        assert!(
            values.len() >= 10 && spread < if column == "stress_33" { 500.0 } else { 1e-6 },
            "{values:?}"
        );
        assert_eq!(table.column("stage").unwrap()[3], 1.0);
        // The case in the folder contains the path and can be run unchanged.
        let text = std::fs::read_to_string(place.join(path).join("case.toml")).unwrap();
        assert!(text.contains(&format!("path = \"{path}\"")) && !text.contains("[shear]"), "{text}");
        assert!(done(place, &["status", path]).contains("finished"));
        done(place, &["report", path]);
    }
}

/// A stage that ends at a stress tells that stress at its end, in print, in JSON and in its folder, beside the mean over its last interval.
#[test]
fn the_stress_at_the_end_of_a_stage_is_that_which_was_reached() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let stages = "[[stage]]\nname = \"up\"\ninertial_number = 3e-3\nxx = { rate = 1 }\nyy = { rate = -0.5 }\nzz = { rate = -0.5 }\n\
                  until = { axial_deviator_stress = \"30 kPa\" }\nrecord = { every = 1e-4 }\n\
                  [[stage]]\nname = \"back\"\ninertial_number = 3e-3\nxx = { rate = -1 }\nyy = { rate = 0.5 }\n\
                  zz = { rate = 0.5 }\nuntil = { axial_deviator_stress = \"10 kPa\" }\nrecord = { every = 1e-4 }\n";
    std::fs::write(place.join("case.toml"), case() + stages).unwrap();
    let text = done(place, &["run", "case.toml", "--out", "run"]);
    assert!(text.contains("at its end") && text.contains("as the mean over its last interval"), "{text}");
    let resumed = done_json(place, &["resume", "run"]);
    let record = granum_io::Run::at(place.join("run")).unwrap().record().unwrap();
    assert_eq!(record.stage_ends.len(), 2);
    for (k, (reached, snapshot)) in [(30e3, "stage-1"), (10e3, "end")].into_iter().enumerate() {
        let end = &record.stage_ends[k];
        // The engine ends at the stress with the dashpots, which are not part of the stress of the contacts.
        assert!((end.axial_deviator_stress - reached).abs() < 500.0, "{end:?}");
        assert_eq!(resumed["stresses"][k]["end"]["axial_deviator_stress"], end.axial_deviator_stress);
        let assembly = granum_io::Run::at(place.join("run")).unwrap().snapshot(snapshot).unwrap();
        let stress = granum_dem::loading::MacroState::from_assembly(&assembly).stress;
        let measured = stress[0][0] - 0.5 * (stress[1][1] + stress[2][2]);
        assert!((measured / end.axial_deviator_stress - 1.0).abs() < 1e-9, "{measured} {end:?}");
        let last = &resumed["stresses"][k]["last_interval"];
        // The second stage is shorter than an interval of the record.
        if k == 0 {
            let of_interval = last["stress_11"].as_f64().unwrap() - last["stress_22"].as_f64().unwrap();
            assert!((of_interval - measured).abs() > 10.0, "the mean over the interval is another: {last}");
        }
    }
}

#[test]
fn shear_runs_the_stages_of_a_case_and_flags_set_them() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let stages = "[[stage]]\npath = \"undrained-triaxial\"\naxial_strain = 0.02\ninertial_number = 3e-3\nstates = 4\n\
                  [[stage]]\nname = \"back\"\ninertial_number = 3e-3\nxx = { rate = -1 }\nyy = { rate = 0.5 }\n\
                  zz = { rate = 0.5 }\nuntil = { xx_strain = 0 }\nrecord = { every = 1e-3 }\n";
    std::fs::write(place.join("case.toml"), case() + stages).unwrap();
    let set = ["--set", "stage.1.axial_strain=0.004"];
    done(place, &["shear", "case.toml", "--out", "one", set[0], set[1]]);
    done(place, &["run", "case.toml", "--out", "two", set[0], set[1], "--threads", "2"]);
    assert_eq!(super::digest(place, "one"), super::digest(place, "two"));
    let table = granum_io::Run::at(place.join("one")).unwrap().series().unwrap();
    let (stage, state) = (table.column("stage").unwrap(), table.column("state").unwrap());
    assert_eq!((stage[0], state[0]), (1.0, 0.0));
    assert_eq!(stage.last(), Some(&2.0));
    assert!(state.iter().zip(stage).any(|pair| pair == (&0.0, &2.0)));
    // Networks can only be trained on tests of a single stage so far.
    let text = refused(place, 1, &["train", "one", "--out", "study"]);
    assert!(text.contains("it is a test of several stages"), "{text}");
    let text =
        refused(place, 1, &["shear", "case.toml", "--out", "three", "--set", "shear.deviator_strain=0.1"]);
    assert!(text.contains("has no effect in a case with stages"), "{text}");
}

#[test]
fn paths_and_the_schema_are_printed_for_people_and_machines() {
    let folder = tempfile::tempdir().unwrap();
    let text = done(folder.path(), &["run", "--list"]);
    assert!(text.contains("drained-triaxial\n") && text.contains("lateral_stress: "), "{text}");
    let paths = done_json(folder.path(), &["run", "--list"]);
    assert!(paths["paths"].as_array().is_some_and(|paths| paths.len() >= 8));
    let schema = done_json(folder.path(), &["schema"]);
    assert!(schema["$defs"]["stage"]["anyOf"].is_array());
    let plain: serde_json::Value = serde_json::from_str(&done(folder.path(), &["schema"])).unwrap();
    assert_eq!(plain, schema);
}

#[test]
fn mistakes_in_paths_are_refused_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    std::fs::write(place.join("case.toml"), case()).unwrap();
    let text = refused(place, 1, &["run", "case.toml", "--path", "drained"]);
    assert!(text.contains("did you mean drained-triaxial?"), "{text}");
    let text =
        refused(place, 1, &["run", "case.toml", "--path", "isotropic", "--with", "mean_stress=1e14 Pa"]);
    assert!(text.contains("out of bounds"), "{text}");
    let text = refused(place, 1, &["run", "case.toml", "--path", "isotropic", "--with", "mean_stress=-1"]);
    assert!(text.contains("is understood as -1 Pa"), "{text}");
    let text = refused(place, 2, &["run", "case.toml", "--with", "mean_stress=1"]);
    assert!(text.contains("--path"), "{text}");
    std::fs::write(place.join("bad.toml"), case() + "[[stage]]\npath = \"oedometer\"\naxial_stres = 1\n")
        .unwrap();
    let text = refused(place, 1, &["run", "bad.toml"]);
    assert!(text.contains("bad.toml:") && text.contains("axial_stress"), "{text}");
    assert!(!place.join("run").exists());
}
