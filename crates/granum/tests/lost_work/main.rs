//! No work is lost and no bit of a result changes, whatever ends the program: kills, signals, a full disk, a second process.

mod campaigns;
#[path = "../common/mod.rs"]
mod common;
mod disk;
mod faults;
mod followed;
mod kills;
mod same_bits;
mod slurm;
mod streams;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use common::{run, stderr};

/// A case that needs several trials of the preparation friction and then shears, all within one or two seconds.
pub const CASE: &str = r#"
[grains]
count = 120
spread = 0.1
[preparation]
initial_solid_fraction = 0.3
solid_fraction = 0.6
solid_fraction_tolerance = 1e-4
inertial_number = 1e-2
unbalanced_force = 2e-2
[shear]
deviator_strain = 0.05
inertial_number = 3e-3
[recording]
states = 8
observations_per_state = 3
"#;

/// Runs granum, which must succeed.
pub fn done(folder: &Path, arguments: &[&str]) {
    let output = run(folder, arguments);
    assert!(output.status.success(), "granum {}: {}", arguments.join(" "), stderr(&output));
}

/// All files under a folder by their names, except those that contain times or earlier states.
pub fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    const OTHER: [&str; 5] =
        [".granum-lock", "seconds.json", "speed.html", "checkpoint.previous", "checkpoint.refused"];
    files(folder)
        .into_iter()
        .filter(|file| !OTHER.iter().any(|name| file.file_name().is_some_and(|n| n == *name)))
        .map(|file| {
            let bytes = std::fs::read(&file).unwrap();
            (file.strip_prefix(folder).unwrap().to_path_buf(), bytes)
        })
        .collect()
}

/// Every file under a folder.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found
}

/// Asserts that two folders contain the same files with the same bytes; returns the number of files.
pub fn assert_same(a: &Path, b: &Path) -> usize {
    assert_same_but(&[], a, b)
}

/// As [`assert_same`], without files of the given names.
pub fn assert_same_but(but: &[&str], a: &Path, b: &Path) -> usize {
    let (mut one, mut two) = (contents(a), contents(b));
    for name in but {
        assert!(one.remove(Path::new(name)).is_some() && two.remove(Path::new(name)).is_some(), "{name}");
    }
    let names = |all: &BTreeMap<PathBuf, Vec<u8>>| all.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&one), names(&two), "{} {}", a.display(), b.display());
    for (name, bytes) in &one {
        assert!(bytes == &two[name], "{} of {} and {}", name.display(), a.display(), b.display());
    }
    one.len()
}
