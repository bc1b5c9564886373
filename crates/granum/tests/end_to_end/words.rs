//! Error messages name the key, both values and the remedy.

use crate::common::{run, stderr, stdout};
use crate::{SMALL, done, refused};

#[test]
fn a_sample_of_another_case_is_refused_by_the_keys_that_differ() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let other = SMALL.replace("friction = 0.1", "friction = 0.2").replace("count = 150", "count = 160");
    // Keys that do not determine the sample may differ.
    std::fs::write(here.join("other.toml"), other.replace("states = 8", "states = 9")).unwrap();
    let message = refused(here, 1, &["shear", "other.toml", "--sample", "sample", "--out", "one"]);
    for part in [
        "grains.count: 150 in the sample; 160 in the case",
        "preparation.friction: 0.1 in the sample; 0.2 in the case",
    ] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!message.contains("recording.states"), "{message}");

    // A finished test is refused as a sample, with a message that does not call it unfinished.
    done(here, &["shear", "case.toml", "--out", "test"]);
    let message = refused(here, 1, &["shear", "case.toml", "--sample", "test", "--out", "two"]);
    assert!(message.contains("the folder of a test, not of a sample"), "{message}");
    assert!(!message.contains("in progress"), "{message}");
}

#[test]
fn a_solid_fraction_that_was_not_reached_is_told_with_the_one_that_was() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let case = SMALL
        .replace("friction = 0.1", "friction = 0")
        .replace("solid_fraction = \"none\"", "solid_fraction = 0.72");
    std::fs::write(here.join("case.toml"), case).unwrap();
    let output = run(here, &["prepare", "case.toml", "--out", "sample"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stdout(&output);
    assert!(text.contains("warning: target 0.72 not reached: preparation.friction = 0 gives 0.6"), "{text}");
    assert!(!text.contains("solid_fraction_missed_by"), "{text}");
}
