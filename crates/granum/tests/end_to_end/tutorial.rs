//! The commands of the tutorial work exactly as they are printed.

use crate::{done, refused};

const TUTORIAL: &str = include_str!("../../../../docs/src/tutorial.md");

/// The code blocks of a language, in order.
fn blocks(language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let after = |text: &str| text.split("```").next().unwrap_or_default().to_string();
    TUTORIAL.split(&fence).skip(1).map(after).collect()
}

#[test]
fn what_the_tutorial_says_works() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let case = &blocks("toml")[0];
    assert!(TUTORIAL.contains("into a new file, `my-sand.toml`"));
    granum_io::Case::parse(case, "my-sand.toml").unwrap();
    // The same keys with fewer grains and less strain, to save time.
    let small = case
        .replace("count = 1000", "count = 150")
        .replace("deviator_strain = 0.1", "deviator_strain = 0.01")
        .replace("inertial_number = 1e-3", "inertial_number = 5e-3")
        .replace("inertial_number = 2e-3", "inertial_number = 5e-3");
    assert_ne!(&small, case);
    std::fs::write(here.join("my-sand.toml"), small).unwrap();
    let mut commands = 0;
    for line in blocks("sh").iter().flat_map(|block| block.lines()) {
        let words: Vec<&str> = line.split_whitespace().take_while(|word| *word != "#").collect();
        // A reproduction takes an hour, and a quick one minutes; it has its own tests.
        if words.first() == Some(&"granum") && words[1] != "reproduce" {
            done(here, &words[1..]);
            commands += 1;
        }
    }
    assert!(commands >= 5, "{commands} commands");
    assert!(here.join("run-1/report.html").is_file() && here.join("run-2/run.json").is_file());

    // The statement of the block about complete case files holds: a key may occur only once.
    let both = std::fs::read_to_string(here.join("every-key.toml")).unwrap() + case;
    std::fs::write(here.join("both.toml"), both).unwrap();
    let message = refused(here, 1, &["shear", "both.toml", "--out", "no"]);
    assert!(message.contains("duplicate key"), "{message}");
}
