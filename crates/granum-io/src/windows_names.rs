//! Names that Windows gives another meaning: what is written under them would be lost, or be found under another name.

use std::path::{Component, Path};

use crate::error::{Error, Result};

/// Refuses a path to be written on Windows if a name in it stands for a device, ends with what Windows removes, or has characters that
/// are no part of a name. Elsewhere every path is accepted.
///
/// # Errors
/// [`Error::Content`].
pub(crate) fn check_path(path: &Path) -> Result<()> {
    if !cfg!(windows) {
        return Ok(());
    }
    let is_absolute = path.has_root();
    let wrong = path.components().find_map(|component| match component {
        Component::Normal(name) => refusal(&name.to_string_lossy()),
        // `a:b` is b in the present folder of the drive a.
        Component::Prefix(drive) if !is_absolute => {
            Some(relative_to_drive(&drive.as_os_str().to_string_lossy()))
        }
        _ => None,
    });
    wrong.map_or(Ok(()), |message| Err(Error::content(path, message)))
}

/// What is wrong with a path that begins with a drive and no root.
fn relative_to_drive(drive: &str) -> String {
    format!(
        "cannot be written: {drive:?} at its beginning stands for a drive on Windows; choose another name, or write \"{drive}\\\" before the \
         folders of the drive"
    )
}

/// What is wrong with a name on Windows.
fn refusal(name: &str) -> Option<String> {
    // Up to Windows 10 also with any ending.
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let port = ["COM", "LPT"].iter().any(|device| {
        stem.strip_prefix(device)
            .is_some_and(|digit| digit.len() == 1 && digit.as_bytes()[0].is_ascii_digit())
    });
    if port || ["CON", "PRN", "AUX", "NUL"].contains(&stem.as_str()) {
        return Some(format!(
            "cannot be written: {name:?} stands for a device on Windows; choose another name"
        ));
    }
    if name.ends_with(['.', ' ']) {
        return Some(format!(
            "cannot be written: Windows removes the end of the name {name:?}; choose one without a dot or blank there"
        ));
    }
    let strange = name.chars().find(|c| matches!(c, '<' | '>' | ':' | '"' | '|' | '?' | '*') || *c < ' ')?;
    Some(format!("cannot be written: {strange:?} is no part of a name on Windows; choose another name"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_lost_ends_and_characters_are_named() {
        for name in ["CON", "nul", "Aux.txt", "prn.tar.gz", "com1", "LPT9.csv", "con .txt"] {
            assert!(refusal(name).is_some_and(|message| message.contains("device")), "{name}");
        }
        for name in ["ends.", "ends ", "..."] {
            assert!(refusal(name).is_some_and(|message| message.contains("removes the end")), "{name}");
        }
        for name in ["a:b", "what?", "<x>", "tab\t", "a|b"] {
            assert!(refusal(name).is_some_and(|message| message.contains("no part of a name")), "{name:?}");
        }
        for name in [
            "run",
            "CONE",
            "nullity.csv",
            "com",
            "com10",
            "lpt",
            ".hidden",
            "a.b.c",
            "Größe",
            "a b",
            "series.parquet",
        ] {
            assert_eq!(refusal(name), None, "{name}");
        }
    }

    #[test]
    fn only_windows_refuses_a_path() {
        let refused = check_path(Path::new("deep/CON/run.json"));
        assert_eq!(refused.is_err(), cfg!(windows));
        check_path(Path::new("../runs/./dense")).unwrap();
        let drive = check_path(Path::new("a:b/run"));
        assert_eq!(drive.is_err(), cfg!(windows));
        assert!(drive.err().is_none_or(|error| error.to_string().contains("stands for a drive")));
        check_path(Path::new("c:\\work\\run")).unwrap();
    }
}
