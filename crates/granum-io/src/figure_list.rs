//! The list of the figures that granum wrote into a folder of figures, so that a figure that a user put there is told apart.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

use crate::atomic::write_atomically;
use crate::error::Result;
use crate::text::read_small;

/// Name of the list, a name a line.
const LIST: &str = ".granum-figures";
const LARGEST: u64 = 1 << 20;

/// Adds names to the list of a folder of figures, before they are written.
///
/// # Errors
/// [`crate::Error::File`] if the list cannot be written.
pub fn add<'a>(figures: &Path, names: impl IntoIterator<Item = &'a str>) -> Result<()> {
    let mut all: BTreeSet<String> = listed(figures).unwrap_or_default();
    all.extend(names.into_iter().map(String::from));
    let text: String = all.iter().map(|name| format!("{name}\n")).collect();
    write_atomically(&figures.join(LIST), |file| file.write_all(text.as_bytes()))
}

/// The files that granum wrote into a folder of figures, with the list itself. Earlier versions left no list: their figures
/// are told by their names (`figure-3.svg`, `figure-s1-stress.svg`).
pub fn names(figures: &Path) -> Vec<String> {
    let mut all: Vec<String> = match listed(figures) {
        Some(names) => names.into_iter().collect(),
        None => {
            let entries = std::fs::read_dir(figures).into_iter().flatten().flatten();
            entries
                .filter_map(|entry| entry.file_name().into_string().ok())
                .filter(|name| is_usual(name))
                .collect()
        }
    };
    all.push(LIST.to_string());
    all
}

fn listed(figures: &Path) -> Option<BTreeSet<String>> {
    let path = figures.join(LIST);
    if !std::fs::symlink_metadata(&path).is_ok_and(|kind| kind.is_file()) {
        return None;
    }
    let text = read_small(&path, LARGEST).ok()?;
    Some(text.lines().filter(|name| is_plain(name)).map(String::from).collect())
}

/// True for a name that stays in its folder.
fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    !name.is_empty() && !name.starts_with('.') && name.chars().all(plain)
}

fn is_usual(name: &str) -> bool {
    let Some(rest) = name.strip_prefix("figure-").and_then(|rest| rest.strip_suffix(".svg")) else {
        return false;
    };
    let number = rest.split('-').next().unwrap_or("");
    let digits = number.strip_prefix('s').unwrap_or(number);
    !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit()) && is_plain(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_a_user_are_told_apart() {
        let base = tempfile::tempdir().unwrap();
        for name in ["figure-3.svg", "figure-s1-stress.svg", "mine.svg", "figure-mine.svg"] {
            std::fs::write(base.path().join(name), "x").unwrap();
        }
        let mut old = names(base.path());
        old.sort();
        assert_eq!(old, [".granum-figures", "figure-3.svg", "figure-s1-stress.svg"]);
        add(base.path(), ["figure-s1-stress.svg"]).unwrap();
        add(base.path(), ["figure-s2-forces.svg"]).unwrap();
        assert_eq!(names(base.path()), ["figure-s1-stress.svg", "figure-s2-forces.svg", ".granum-figures"]);
        std::fs::write(base.path().join(LIST), "../x\nfigure-1.svg\n").unwrap();
        assert_eq!(names(base.path()), ["figure-1.svg", ".granum-figures"]);
    }
}
