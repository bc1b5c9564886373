//! A case has one result, independently of threads, instruction set, source of the sample, recording and interval of
//! checkpoints.

use std::fs;

use granum_dem::Isa;

use crate::{CASE, assert_same, assert_same_but, done};

#[test]
fn any_threads_instruction_set_and_interval_leave_the_same_bytes() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    // There are enough grains to divide the work of a step among threads.
    let case = CASE
        .replace("count = 120", "count = 200")
        .replace("solid_fraction = 0.6", "friction = 0.1\nsolid_fraction = \"none\"")
        .replace("deviator_strain = 0.05", "deviator_strain = 0.002");
    fs::write(here.join("case.toml"), &case).unwrap();
    // Only the test itself goes with the portable instructions, which are slow.
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let portable = ["--isa", "portable", "--threads", "1", "--sample", "sample"];
    done(here, &[&["shear", "case.toml", "--out", "reference"], &portable[..]].concat());
    let shear = |name: &str, more: &[&str]| {
        done(here, &[&["shear", "case.toml", "--sample", "sample", "--out", name][..], more].concat());
        assert!(assert_same(&here.join("reference"), &here.join(name)) >= 10);
    };
    for isa in Isa::ALL.into_iter().filter(|isa| isa.available() && *isa != Isa::Portable) {
        shear(isa.name(), &["--isa", isa.name()]);
    }
    shear("often", &["--checkpoint-every", "0"]);
    shear("two-threads", &["--threads", "2"]);
    shear("four-threads", &["--threads", "4"]);
    // The record says that this sample was prepared by the run itself.
    done(here, &["shear", "case.toml", "--out", "prepared"]);
    assert!(assert_same_but(&["run.json"], &here.join("reference"), &here.join("prepared")) >= 9);

    // Another recording gives another series of exactly the same simulation.
    let more = case.replace("states = 8", "states = 50").replace("per_state = 3", "per_state = 10");
    fs::write(here.join("case.toml"), more).unwrap();
    done(here, &["shear", "case.toml", "--out", "recorded"]);
    let bytes = |run: &str, name: &str| fs::read(here.join(run).join(name)).unwrap();
    assert!(bytes("reference", "series.parquet") != bytes("recorded", "series.parquet"));
    for name in ["end.json", "end.grains.parquet", "end.contacts.parquet", "start.contacts.parquet"] {
        let name = format!("snapshots/{name}");
        assert!(bytes("reference", &name) == bytes("recorded", &name), "{name}");
    }
}
