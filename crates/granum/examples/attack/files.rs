//! Copies and comparisons of folders.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Files that hold times, or earlier states, and so differ between two runs of one case.
const OTHER: [&str; 6] = [
    ".granum-lock",
    "run.json",
    "seconds.json",
    "checkpoint.previous",
    "checkpoint.refused",
    "reproduction.json",
];

/// Every file under a folder, relative to it, in the order of names. Links and devices are left out.
pub fn under(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    collect(folder, Path::new(""), &mut found);
    found.sort();
    found
}

fn collect(folder: &Path, inside: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder.join(inside)) else { return };
    for entry in entries.flatten() {
        let name = inside.join(entry.file_name());
        match entry.file_type() {
            Ok(kind) if kind.is_dir() => collect(folder, &name, found),
            Ok(kind) if kind.is_file() => found.push(name),
            _ => {}
        }
    }
}

/// Copies a file or a folder.
pub fn copy(from: &Path, to: &Path) -> io::Result<()> {
    if from.is_dir() {
        fs::create_dir_all(to)?;
        for entry in fs::read_dir(from)? {
            let entry = entry?;
            copy(&entry.path(), &to.join(entry.file_name()))?;
        }
        return Ok(());
    }
    if let Some(parent) = to.parent() {
        fs::create_dir_all(parent)?;
    }
    fs::copy(from, to).map(drop)
}

/// The bytes of every file under a folder, or of a single file, without those that hold times.
pub fn contents(path: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    if path.is_file() {
        return BTreeMap::from([(PathBuf::new(), fs::read(path).unwrap_or_default())]);
    }
    let differs = |file: &PathBuf| OTHER.iter().any(|name| file.file_name().is_some_and(|n| n == *name));
    let files = under(path).into_iter().filter(|file| !differs(file));
    files.map(|file| (file.clone(), bytes(&path.join(&file)))).collect()
}

/// The bytes of a file; of the plan of a training without the places of its runs and the sum of the text that holds them.
fn bytes(file: &Path) -> Vec<u8> {
    let bytes = fs::read(file).unwrap_or_default();
    if !file.ends_with("training.json") {
        return bytes;
    }
    let text = String::from_utf8_lossy(&bytes);
    let places =
        |line: &&str| line.trim_start().starts_with("\"/") || line.trim_start().starts_with("\"sha256\"");
    text.lines().filter(|line| !places(line)).collect::<Vec<_>>().join("\n").into_bytes()
}

/// The first difference between the contents of two folders.
pub fn difference(one: &Path, two: &Path) -> Option<String> {
    difference_of(&contents(one), &contents(two))
}

/// The first difference between contents.
pub fn difference_of(one: &BTreeMap<PathBuf, Vec<u8>>, two: &BTreeMap<PathBuf, Vec<u8>>) -> Option<String> {
    let only = |a: &BTreeMap<PathBuf, Vec<u8>>, b: &BTreeMap<PathBuf, Vec<u8>>| {
        a.keys().find(|name| !b.contains_key(*name)).map(|name| format!("only one has {}", name.display()))
    };
    only(one, two).or_else(|| only(two, one)).or_else(|| {
        let other = one.iter().find(|(name, bytes)| two.get(*name) != Some(bytes))?.0;
        Some(format!("{} has other bytes", other.display()))
    })
}
