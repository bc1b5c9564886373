//! `granum view`: the page of grains, forces, bonds and cracks.

use crate::{SMALL, done, refused};

#[test]
fn a_run_and_results_of_other_programs_are_shown_and_mistakes_are_named() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["run", "case.toml", "--out", "run"]);
    let said = done(here, &["view", "run", "-o", "grains.html"]);
    assert!(said.contains("150 grains") && said.contains("open grains.html in a browser"), "{said}");
    let page = std::fs::read_to_string(here.join("grains.html")).unwrap();
    assert!(page.contains("<title>run</title>") && page.contains("export function show(root, data)"));
    assert!(
        page.contains("\"count\":150") && !page.contains("https:"),
        "the page lacks grains or asks for something"
    );
    // A file is not lost, and what is shown is asked for by its name.
    assert!(refused(here, 1, &["view", "run", "-o", "grains.html"]).contains("grains.html"));
    done(here, &["view", "run", "--snapshot", "start", "--colour", "spin", "--chains", "-o", "start.html"]);
    let told = refused(here, 1, &["view", "run", "--snapshot", "strat", "-o", "other.html"]);
    assert!(told.contains("no snapshot strat") && told.contains("did you mean start?"), "{told}");
    let told = refused(here, 1, &["view", "run", "--colour", "spinn", "-o", "other.html"]);
    assert!(told.contains("--colour spinn") && told.contains("did you mean spin?"), "{told}");
    assert!(
        refused(here, 1, &["view", "run", "--opacity", "2", "-o", "other.html"]).contains("between 0 and 1")
    );
    assert!(!here.join("other.html").exists());
    done(here, &["export", "run", "--snapshot", "all", "-o", "run.dump"]);
    done(here, &["view", "run.dump", "--snapshot", "1", "-o", "first.html"]);
    let told = refused(here, 1, &["view", "run.dump", "--snapshot", "7", "-o", "other.html"]);
    assert!(told.contains("--snapshot 7: it must be the number of an instant"), "{told}");
}
