//! The commands of the chapter of campaigns work exactly as they are printed, with a smaller sample and fewer points.

use crate::chapter::change;
use crate::done;

const CHAPTER: &str = include_str!("../../../../docs/src/campaigns.md");

/// The commands of the study with which the chapter begins, in order.
fn commands() -> Vec<Vec<&'static str>> {
    let study = CHAPTER.split("## The plan").next().unwrap_or_default();
    let blocks = study.split("```sh\n").skip(1).map(|text| text.split("```").next().unwrap_or_default());
    let words =
        |line: &'static str| line.split_whitespace().take_while(|word| *word != "#").collect::<Vec<_>>();
    blocks.flat_map(str::lines).map(words).filter(|words| words.first() == Some(&"granum")).collect()
}

#[test]
fn the_study_of_the_chapter_works() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let commands = commands();
    assert!(commands.len() >= 6, "{commands:?}");
    for (k, words) in commands.iter().enumerate() {
        done(here, &words[1..]);
        if k == 0 {
            let smaller = [("grains.count = 1000", "grains.count = 60"), ("points = 100", "points = 3")];
            change(&here.join("friction-pressure-density.toml"), &smaller);
            let faster = [
                ("axial_strain = 0.3", "axial_strain = 0.01"),
                ("states = 120", "states = 4"),
                ("inertial_number = 1e-3", "inertial_number = 1e-2"),
                ("inertial_number = 2e-3", "inertial_number = 1e-2"),
                ("unbalanced_force = 2e-3", "unbalanced_force = 5e-2"),
            ];
            change(&here.join("drained-dense.toml"), &faster);
        }
    }
    assert!(here.join("study/report.html").is_file());
    let table = std::fs::read_to_string(here.join("study.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 6, "{table}");
}
