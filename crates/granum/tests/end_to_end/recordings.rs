//! The output of a run: spacing of states, snapshots, history of the preparation, peak and late values.

use std::path::Path;

use granum_io::{Run, Table};

use crate::common::{run, stderr};
use crate::{SMALL, digest, done, done_json, refused};

fn shear(here: &Path, out: &str, more: &[&str]) -> serde_json::Value {
    done_json(here, &[&["shear", "case.toml", "--sample", "sample", "--out", out][..], more].concat())
}

fn table(here: &Path, name: &str) -> Table {
    granum_io::read_table(here.join(name)).unwrap()
}

#[test]
fn states_and_snapshots_stand_where_the_case_says() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let told = shear(here, "usual", &[]);

    // The initial elastic rise of q/p lies between the first two states of the default spacing.
    let slow = ["--set", "shear.inertial_number=3e-4", "--set", "recording.observations_per_state=1"];
    let spaced = ["--set", "recording.first_strain=1e-5"];
    shear(here, "geometric", &[&slow[..], &spaced].concat());
    let series = table(here, "geometric/series.parquet");
    let (strain, ratio) = (series.column("deviator_strain").unwrap(), series.column("stress_ratio").unwrap());
    assert_eq!(strain.len(), 9);
    for (k, strain) in strain.iter().enumerate().skip(1) {
        let wanted = 1e-5 * (0.02f64 / 1e-5).powf((k - 1) as f64 / 7.0);
        assert!((strain / wanted - 1.0).abs() < 0.25, "state {k}: {strain} for {wanted}");
    }
    assert!(ratio[1] < 0.3 && ratio.windows(2).take(4).all(|pair| pair[1] > pair[0]), "{ratio:?}");

    let list = ["--set", "recording.strains=[0.001, 0.005, 0.02]", "--set", "recording.snapshots=0.005,0.01"];
    shear(here, "listed", &list);
    let strain = table(here, "listed/series.parquet").column("deviator_strain").unwrap().to_vec();
    assert_eq!(strain.len(), 4);
    for (found, wanted) in strain.iter().zip([0.0, 0.001, 0.005, 0.02]) {
        assert!((found - wanted).abs() < 0.004, "{strain:?}");
    }
    let folder = Run::at(here.join("listed")).unwrap();
    assert_eq!(folder.snapshots().unwrap(), ["end", "start", "strain-0_005", "strain-0_01"]);
    for (name, wanted) in [("strain-0_005", 0.005), ("strain-0_01", 0.01)] {
        let strain = folder.snapshot(name).unwrap().strain;
        let deviator = strain[0][0] - 0.5 * (strain[1][1] + strain[2][2]);
        assert!((deviator - wanted).abs() < 2e-4, "{name}: {deviator}");
    }
    // Snapshots and the spacing of states do not change the test itself.
    let end = |name: &str| Run::at(here.join(name)).unwrap().snapshot("end").unwrap();
    assert_eq!(end("listed"), end("usual"));

    let grains = std::fs::read(here.join("listed/snapshots/end.grains.parquet")).unwrap();
    let table = granum_io::formats::parquet::read_bytes(grains, "end", Some(&["id"])).unwrap();
    assert_eq!(table.columns()[0].kind, granum_io::ColumnKind::Integer);
    let contacts = self::table(here, "listed/snapshots/end.contacts.parquet");
    let kind = |name: &str| contacts.columns().iter().find(|column| column.name == name).unwrap().kind;
    assert_eq!(kind("first"), granum_io::ColumnKind::Integer);
    assert_eq!(kind("sliding"), granum_io::ColumnKind::Boolean);

    peak_and_late(&told, &self::table(here, "usual/series.parquet"));
    let message =
        refused(here, 1, &["shear", "case.toml", "--out", "r", "--set", "recording.snapshots=0.05"]);
    assert!(message.contains("recording.snapshots goes up to 0.05, but the test ends at"), "{message}");
    done(here, &["report", "geometric"]);
    // Three states are too few for training, and the message names the sub-model that lacks states.
    let message = refused(here, 1, &["train", "listed", "--out", "study"]);
    assert!(message.contains("F1 sub-model 1") && message.contains("record more states"), "{message}");
}

/// Peak and late values in the output agree with the series.
fn peak_and_late(told: &serde_json::Value, series: &Table) {
    let measure = |name: &str| told["measures"][name].as_f64().unwrap_or_else(|| panic!("no {name}"));
    let column = |name: &str| series.column(name).unwrap();
    let largest = |name: &str| column(name).iter().copied().fold(f64::MIN, f64::max);
    assert_eq!(measure("peak_stress_ratio"), largest("stress_ratio"));
    assert_eq!(measure("peak_deviator_fabric"), largest("deviator_fabric"));
    // The last quarter of the strain comprises a little more than the last two of eight intervals, so that the mean is
    // close to that of the last three states.
    for (name, of) in [
        ("late_stress_ratio", "stress_ratio"),
        ("late_deviator_fabric", "deviator_fabric"),
        ("late_solid_fraction", "solid_fraction"),
    ] {
        let values = column(of);
        let last = &values[values.len() - 3..];
        let (low, high) = last.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
        assert!((low..=high).contains(&measure(name)), "{name}");
    }
}

#[test]
fn a_preparation_leaves_its_course() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    let told = done_json(here, &["prepare", "case.toml", "--out", "sample"]);
    let history = table(here, "sample/preparation.parquet");
    let column = |name: &str| history.column(name).unwrap();
    let last = |name: &str| *column(name).last().unwrap();
    assert!(history.rows() > 5);
    assert_eq!(last("step"), told["steps"]["prepare"].as_f64().unwrap());
    assert_eq!(last("solid_fraction"), told["measures"]["solid_fraction"].as_f64().unwrap());
    assert!((last("mean_stress") / told["measures"]["mean_stress"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    assert!(
        (last("coordination_number") - told["measures"]["coordination_number"].as_f64().unwrap()).abs()
            < 1e-9
    );
    assert!(column("solid_fraction")[0] < 0.36 && column("mean_stress")[0] == 0.0);
    assert!(column("step").windows(2).all(|pair| pair[1] >= pair[0]));
    assert!(column("time").windows(2).all(|pair| pair[1] >= pair[0]));
    assert_eq!((column("phase")[0], last("phase")), (0.0, 1.0));

    done(here, &["report", "sample"]);
    let page = std::fs::read_to_string(here.join("sample/report.html")).unwrap();
    assert!(page.contains("Compression curve") && page.contains("150 grains") && page.contains("<svg"));
    assert!(!page.contains("Strain rate"), "a sample has no rate");

    // The history does not depend on interruptions, and a test copies it from its sample.
    done(here, &["prepare", "case.toml", "--out", "often", "--checkpoint-every", "0.001"]);
    let bytes = |name: &str| std::fs::read(here.join(name).join("preparation.parquet")).unwrap();
    assert_eq!(bytes("often"), bytes("sample"));
    shear(here, "test", &[]);
    assert_eq!(bytes("test"), bytes("sample"));
}

#[test]
fn samples_that_could_not_be_taken_are_told() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let output = run(
        here,
        &[
            "shear",
            "case.toml",
            "--sample",
            "sample",
            "--out",
            "r",
            "--set",
            "recording.observations_per_state=100000",
        ],
    );
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("observations required by recording.observations_per_state were not made, at 8 states"),
        "{said}"
    );
    let record = std::fs::read_to_string(here.join("r/run.json")).unwrap();
    assert!(record.contains("were not made"), "{record}");
}

#[test]
fn another_mean_stress_is_reached_before_the_test_and_judged() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    for (stress, pascal) in [("200 kPa", 200e3), ("5 kPa", 5e3)] {
        let told = shear(here, "r", &["--force", "--set", &format!("shear.mean_stress={stress}")]);
        assert!(told["steps"]["consolidation"].as_f64().unwrap() > 0.0, "{told}");
        assert!((told["measures"]["mean_stress"].as_f64().unwrap() / pascal - 1.0).abs() < 0.01, "{told}");
        let p = table(here, "r/series.parquet").column("mean_stress").unwrap().to_vec();
        assert!(p.iter().all(|p| (p / pascal - 1.0).abs() < 0.05), "{p:?}");
        let names: Vec<_> =
            told["quality"].as_array().unwrap().iter().map(|flag| flag["name"].as_str().unwrap()).collect();
        for check in ["unbalanced_force", "mean_stress_missed_by", "largest_overlap", "time_step_fraction"] {
            assert!(names.contains(&format!("consolidation_{check}").as_str()), "{names:?}");
            assert!(names.contains(&format!("sample_{check}").as_str()), "{names:?}");
        }
        // The snapshot `start` is the sample at the beginning of the test.
        let start = Run::at(here.join("r")).unwrap().snapshot("start").unwrap();
        assert_eq!(start.target_mean_stress, Some(pascal));
    }
    // Interruptions do not change any bit of the result.
    shear(here, "often", &["--checkpoint-every", "0.001", "--set", "shear.mean_stress=5 kPa"]);
    assert_eq!(digest(here, "often"), digest(here, "r"));
    // No consolidation takes place if the mean stress of the sample is given explicitly.
    let same = shear(here, "same", &["--set", "shear.mean_stress=20 kPa"]);
    assert!(same["steps"].get("consolidation").is_none(), "{same}");
    // Excessive overlaps at a very high stress are reported for a sample as well.
    let crushed = done_json(
        here,
        &["prepare", "case.toml", "--out", "crushed", "--set", "preparation.mean_stress=300 MPa"],
    );
    let flags = crushed["quality"].as_array().unwrap();
    let overlap = flags.iter().find(|flag| flag["name"] == "sample_largest_overlap").unwrap();
    assert_eq!(overlap["passed"], false, "{overlap}");
}
