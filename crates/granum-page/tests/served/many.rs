//! A folder of many runs: GRANUM_RUNS=10000 cargo test -p granum-page --test served many -- --nocapture

use std::path::Path;
use std::time::{Duration, Instant};

use crate::Served;
use crate::reading::small_run;

/// A copy of a folder whose files are those of the first one.
fn linked(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let there = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            linked(&entry.path(), &there);
        } else {
            std::fs::hard_link(entry.path(), there).unwrap();
        }
    }
}

#[test]
fn a_folder_of_many_runs_opens_in_less_than_two_seconds() {
    let count: usize = std::env::var("GRANUM_RUNS").map_or(300, |text| text.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let first = folder.path().join("runs/run-0");
    std::fs::create_dir_all(first.parent().unwrap()).unwrap();
    small_run(&first, 1);
    (1..count).for_each(|k| linked(&first, &folder.path().join(format!("runs/run-{k}"))));
    let served = Served::new(folder.path());
    let mut times = Vec::new();
    for target in ["order=newest", "order=name&from=200", "filter=run-7&kind=run"] {
        let begun = Instant::now();
        let (status, content) = served.get(&format!("/api/folder?{target}"));
        times.push(begun.elapsed());
        assert_eq!(status, 200, "{content}");
        assert!(content.contains(&format!("\"run\":{count}")), "{}", &content[..500]);
    }
    println!("{count} runs: {times:?}");
    assert!(times.iter().all(|time| *time < Duration::from_secs(2)), "{times:?}");
}
