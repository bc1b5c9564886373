//! A test is a sequence of stages, in whichever way its case writes it.

use super::{SMALL, digest, done, done_json};

#[test]
fn shear_is_run_of_a_case_and_a_test_has_one_name() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    let start = SMALL.find("[shear]").unwrap();
    let path =
        "[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.01\ninertial_number = 3e-3\nstates = 5\n";
    std::fs::write(here.join("path.toml"), format!("{}{path}", &SMALL[..start])).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    for case in ["case.toml", "path.toml"] {
        let [one, two] = ["run", "shear"].map(|command| {
            let out = format!("{command}-{case}");
            done(here, &[command, case, "--sample", "sample", "--out", &out]);
            digest(here, &out)
        });
        assert_eq!(one, two, "{case}");
        let name = format!("run-{case}");
        let record: serde_json::Value =
            serde_json::from_slice(&std::fs::read(here.join(&name).join("run.json")).unwrap()).unwrap();
        assert_eq!(record["kind"], "test");
        assert!(record["steps"]["test"].as_u64() > Some(100), "{record}");
        let limit =
            record["quality"].as_array().unwrap().iter().find(|flag| flag["name"] == "servo_error_rms");
        let (limit, key) = match case {
            "case.toml" => (limit.unwrap()["limit"].as_f64() == Some(0.01), "shear.inertial_number"),
            _ => (limit.unwrap()["limit"].as_f64() == Some(0.005), "the inertial_number of the stage"),
        };
        assert!(limit && record["quality"].to_string().contains(&format!("lower {key}")), "{record}");
        assert_eq!(done_json(here, &["status", &name])["kind"], "test");
    }
}
