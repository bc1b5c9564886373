//! Invalid input ends with an error status and with a message that names the file and the line.

use crate::common::{json, run, stderr};
use crate::{SMALL, done, refused};

#[test]
fn bad_cases_are_refused_with_the_place() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    for (text, place, what) in [
        ("[grains]\ncount = 1000\ndiameter = \"70 kg\"\n", "case.toml:3:", "diameter"),
        ("[grains]\n[contact]\ndampling = 0.1\n", "case.toml:3:", "did you mean damping?"),
        ("[grains]\ncount = -5\n", "case.toml:2:", "count"),
        ("[grains]\ncount = \"many\"\n", "case.toml:2:", "count"),
        ("[grains\ncount = 5\n", "case.toml:1:", ""),
    ] {
        std::fs::write(here.join("case.toml"), text).unwrap();
        let message = refused(here, 1, &["shear", "case.toml", "--out", "run"]);
        assert!(message.contains(place) && message.contains(what), "{text}: {message}");
        let output = run(here, &["--json", "prepare", "case.toml"]);
        let error = json(&stderr(&output));
        assert_eq!(error["error"]["places"][0]["file"], "case.toml", "{error}");
    }
    let message = refused(here, 1, &["shear", "nothing.toml"]);
    assert!(message.contains("nothing.toml"), "{message}");
    assert_eq!(std::fs::read_dir(here).unwrap().count(), 1, "nothing may be left behind");
}

#[test]
fn bad_packings_are_refused_with_the_place() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let head = "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=1e-3 yhi=1e-3 zhi=1e-3\nid,x,y,z,radius\n";
    let good = "1,1e-4,1e-4,1e-4,5e-5\n2,2e-4,1e-4,1e-4,5e-5\n";
    let ask = ["forces", "packing.csv", "--normal", "hertz"];
    let write = |text: String| std::fs::write(here.join("packing.csv"), text).unwrap();
    write(format!("{head}{good}"));
    done(here, &ask);
    for (rows, place, what) in [
        ("3,1.1e-4,1e-4,1e-4,5e-5\n", "packing.csv", "overlap"),
        ("3,NaN,1e-4,5e-4,5e-5\n", "packing.csv:5:", "NaN"),
        ("2,5e-4,5e-4,5e-4,5e-5\n", "packing.csv:5:", "2"),
        ("3,5e-4,5e-4,5e-4,-5e-5\n", "packing.csv:5:", "radius"),
        ("3,5e-4,5e-4\n", "packing.csv:5:", ""),
    ] {
        write(format!("{head}{good}{rows}"));
        let message = refused(here, 1, &ask);
        assert!(message.contains(place) && message.contains(what), "{rows}: {message}");
    }
    let message = refused(here, 1, &["forces", "nothing.csv"]);
    assert!(message.contains("nothing.csv"), "{message}");
}

#[test]
fn folders_that_are_not_of_granum_stay_as_they_are() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    std::fs::create_dir(here.join("thesis")).unwrap();
    std::fs::write(here.join("thesis/chapter.tex"), "mine").unwrap();
    let message = refused(here, 1, &["shear", "case.toml", "--out", "thesis", "--force"]);
    assert!(message.contains("contains files that granum did not write"), "{message}");
    for command in ["resume", "status", "digest", "report"] {
        let message = refused(here, 1, &[command, "thesis"]);
        assert!(message.contains("thesis"), "{command}: {message}");
    }
    assert_eq!(std::fs::read_dir(here.join("thesis")).unwrap().count(), 1);
}

#[test]
fn every_command_shows_an_example() {
    let base = tempfile::tempdir().unwrap();
    let help = done(base.path(), &["--help"]);
    let commands = help.split("Commands:").nth(1).unwrap().split("\n\n").next().unwrap();
    let names: Vec<&str> = commands
        .lines()
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    assert!(names.len() >= 12, "{names:?}");
    for name in names {
        let help = done(base.path(), &[name, "--help"]);
        assert!(help.contains("Example") && help.contains(&format!("granum {name}")), "{help}");
    }
    assert_eq!(run(base.path(), &["shear"]).status.code(), Some(2));
}
