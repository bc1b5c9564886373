//! A run that was saved to a file, as the laboratory page does it, goes on in a folder.

use granum_io::{Case, RunKind};
use granum_run::laboratory::RunInPieces;
use granum_run::{Flow, Laboratory, NoObserver, Observer, Progress, Source};

use crate::{SMALL, done, refused};

/// Stops at the next opportunity.
struct AtOnce;

impl Observer for AtOnce {
    fn progress(&mut self, _: &Progress) -> Flow {
        Flow::Stop
    }
}

#[test]
fn a_saved_run_goes_on_in_a_folder_with_the_same_digest() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let text = SMALL.replace("count = 150", "count = 60");
    std::fs::write(here.join("case.toml"), &text).unwrap();
    done(here, &["run", "case.toml", "--out", "whole"]);
    let case = Case::parse(&text, "case.toml").unwrap();
    let laboratory = Laboratory::here();
    let mut run: RunInPieces =
        laboratory.in_pieces(RunKind::Test, &case, &Source::Case, &mut NoObserver).unwrap();
    while run.states().len() < 2 {
        run.go_on(&mut AtOnce).unwrap();
    }
    let saved = run.saved().unwrap().unwrap().to_json().unwrap();
    std::fs::write(here.join("saved-run.json"), &saved).unwrap();
    done(here, &["resume", "saved-run.json", "--out", "went-on"]);
    let digest = |folder: &str| {
        let line = done(here, &["digest", folder]);
        line.split_whitespace().next().unwrap_or_default().to_string()
    };
    assert_eq!(digest("went-on"), digest("whole"));
    assert_eq!(digest("whole").len(), 64);
    done(here, &["resume", "saved-run.json", "--out", "went-on", "--force"]);
    assert_eq!(digest("went-on"), digest("whole"));
    // The folder is not replaced unasked, and nothing is made of what is no saved run.
    let told = refused(here, 1, &["resume", "saved-run.json", "--out", "whole"]);
    assert!(told.contains("whole") && told.contains("--force"), "{told}");
    assert!(std::fs::exists(here.join("whole/series.parquet")).unwrap());
    let told = refused(here, 1, &["resume", "case.toml", "--out", "none"]);
    assert!(told.contains("case.toml: this is no saved run"), "{told}");
    std::fs::write(here.join("cut.json"), &saved[..saved.len() / 2]).unwrap();
    let told = refused(here, 1, &["resume", "cut.json", "--out", "none"]);
    assert!(told.contains("cut.json: this is no saved run"), "{told}");
    let other = saved.replace("granum run 1", "granum run 7");
    std::fs::write(here.join("later.json"), other).unwrap();
    let told = refused(here, 1, &["resume", "later.json", "--out", "none"]);
    assert!(told.contains("its format is \"granum run 7\""), "{told}");
    assert!(!here.join("none").exists());
    let told = refused(here, 1, &["resume", "whole", "--out", "none"]);
    assert!(told.contains("--out none is for the file of a saved run"), "{told}");
}
