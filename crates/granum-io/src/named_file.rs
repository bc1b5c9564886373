//! Files that are named within other files.

use std::path::{Component, Path, PathBuf};

/// The file that another file in `folder` names.
///
/// What a file names must lie in its own folder or below it, so that a file from elsewhere cannot make the program read, and print
/// parts of, any file of the machine: names that lead out by `..`, as absolute paths or through symbolic links are refused unless
/// `outside` is true.
///
/// # Errors
/// A sentence that continues the name of the file.
pub fn named_file(folder: &Path, name: &str, outside: bool) -> Result<PathBuf, String> {
    let path = folder.join(name);
    if outside || !leads_out(folder, &path, name) {
        return Ok(path);
    }
    Err(format!(
        "leads out of the folder of the file that names it; only what is in that folder or below it is read, unless \
         --allow-outside is given (name = {name:?})"
    ))
}

fn leads_out(folder: &Path, path: &Path, name: &str) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match (folder.canonicalize(), path.canonicalize()) {
        (Ok(folder), Ok(path)) => !path.starts_with(folder),
        // What does not exist is judged by its name, and is then missed by whoever reads it.
        _ => climbs(name),
    }
}

/// True if a name is absolute, or at any part of it above where it began.
fn climbs(name: &str) -> bool {
    let mut depth = 0;
    for part in Path::new(name).components() {
        depth += match part {
            Component::Normal(_) => 1,
            Component::CurDir => 0,
            Component::ParentDir => -1,
            Component::RootDir | Component::Prefix(_) => return true,
        };
        if depth < 0 {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn only_what_is_below_is_read() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path().join("here");
        fs::create_dir_all(folder.join("deep")).unwrap();
        for name in ["secret.txt", "here/a.txt", "here/deep/b.txt"] {
            fs::write(base.path().join(name), "x").unwrap();
        }
        let whole = folder.join("a.txt").display().to_string();
        for name in ["a.txt", "deep/b.txt", "deep/../a.txt", "./a.txt", "missing.txt", whole.as_str()] {
            assert!(named_file(&folder, name, false).is_ok(), "{name}");
        }
        let secret = base.path().join("secret.txt").display().to_string();
        for name in
            ["../secret.txt", "deep/../../secret.txt", "../missing.txt", "/missing.txt", secret.as_str()]
        {
            let error = named_file(&folder, name, false).unwrap_err();
            assert!(error.contains("--allow-outside"), "{error}");
            assert!(named_file(&folder, name, true).is_ok(), "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_out_are_refused() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path().join("here");
        fs::create_dir(&folder).unwrap();
        fs::write(base.path().join("secret.txt"), "x").unwrap();
        fs::write(folder.join("mine.txt"), "x").unwrap();
        std::os::unix::fs::symlink("../secret.txt", folder.join("link.txt")).unwrap();
        std::os::unix::fs::symlink("mine.txt", folder.join("inner.txt")).unwrap();
        std::os::unix::fs::symlink(base.path(), folder.join("up")).unwrap();
        for name in ["link.txt", "up/secret.txt"] {
            assert!(named_file(&folder, name, false).is_err(), "{name}");
        }
        assert!(named_file(&folder, "inner.txt", false).is_ok());
        // A folder that is itself reached through a link is where the link leads.
        std::os::unix::fs::symlink(&folder, base.path().join("alias")).unwrap();
        assert!(named_file(&base.path().join("alias"), "mine.txt", false).is_ok());
    }
}
