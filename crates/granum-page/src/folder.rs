//! What may be read: regular files in the folder that is served, and nothing beyond it.

use std::fs::{self, FileType};
use std::path::{Component, Path, PathBuf};

use crate::refused::Refused;
use crate::serve_error::ServeError;

/// Most entries of something that is opened.
const MOST_ENTRIES: usize = 2_000_000;

/// The folder that is served.
#[derive(Clone, Debug)]
pub struct Folder {
    /// Its place without links.
    root: PathBuf,
    /// As the user named it, for the command lines that are shown.
    named: PathBuf,
}

impl Folder {
    /// A folder.
    ///
    /// # Errors
    /// If it is none, or cannot be read.
    pub fn open(path: &Path) -> Result<Folder, ServeError> {
        let wrong = |source| ServeError::Folder { folder: path.to_path_buf(), source };
        let root = path.canonicalize().map_err(wrong)?;
        fs::read_dir(&root).map_err(wrong)?;
        Ok(Folder { root, named: path.to_path_buf() })
    }

    /// Its place without links.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// As the user named it.
    pub fn named(&self) -> &Path {
        &self.named
    }

    /// What the user would write for a place in it.
    pub fn as_named(&self, inside: &str) -> PathBuf {
        match (inside.is_empty(), self.named == Path::new(".")) {
            (true, _) => self.named.clone(),
            (_, true) => PathBuf::from(inside),
            _ => self.named.join(inside),
        }
    }

    /// The place of something in the folder by its path from there, whose parts stand between slashes; the empty path is the folder itself.
    /// Links are followed if they lead to somewhere in the folder.
    ///
    /// # Errors
    /// If the path leads out of the folder, is none of this system, or leads to nothing, or to a pipe, a socket or a device.
    pub fn place(&self, inside: &str) -> Result<PathBuf, Refused> {
        let nothing = || Refused::not_found(format!("there is no {inside:?} in the folder"));
        if inside.contains(['\0', '\\']) || Path::new(inside).is_absolute() {
            return Err(nothing());
        }
        let plain = |part: Component| matches!(part, Component::Normal(_));
        if !Path::new(inside).components().all(plain)
            || inside.split('/').any(|part| [".", ".."].contains(&part))
        {
            return Err(nothing());
        }
        // Drives and alternative streams of other systems.
        if cfg!(windows) && inside.contains(':') {
            return Err(nothing());
        }
        let place = self.root.join(inside).canonicalize().map_err(|_| nothing())?;
        let kind = place.symlink_metadata().map_err(|_| nothing())?.file_type();
        match place.starts_with(&self.root) && (kind.is_dir() || kind.is_file()) {
            true => Ok(place),
            false => Err(nothing()),
        }
    }

    /// The path of a place from the folder, with slashes; `None` if it is not in the folder or has no name as text.
    pub fn inside(&self, place: &Path) -> Option<String> {
        let parts = place.strip_prefix(&self.root).ok()?.components();
        let parts: Option<Vec<&str>> = parts.map(|part| part.as_os_str().to_str()).collect();
        Some(parts?.join("/"))
    }

    /// Looks at everything in a folder before a reader opens files in it.
    ///
    /// # Errors
    /// If there is a link that leads out of the folder that is served, or a pipe, a socket or a device.
    pub fn check_content(&self, place: &Path) -> Result<(), Refused> {
        let mut left = MOST_ENTRIES;
        self.check_within(place, &mut left)
    }

    fn check_within(&self, place: &Path, left: &mut usize) -> Result<(), Refused> {
        let Ok(entries) = fs::read_dir(place) else { return Ok(()) };
        for entry in entries.flatten() {
            *left =
                left.checked_sub(1).ok_or_else(|| Refused::unreadable("the folder has too many files"))?;
            let Ok(kind) = entry.file_type() else { continue };
            if kind.is_dir() {
                self.check_within(&entry.path(), left)?;
            } else if !self.is_readable(&entry.path(), kind) {
                let name = self.inside(&entry.path()).unwrap_or_default();
                let what =
                    if kind.is_symlink() { "a link that leads out of the folder" } else { "no regular file" };
                return Err(Refused::new(
                    axum::http::StatusCode::FORBIDDEN,
                    format!("{name} is {what}; nothing beside it is read"),
                ));
            }
        }
        Ok(())
    }

    fn is_readable(&self, path: &Path, kind: FileType) -> bool {
        if !kind.is_symlink() {
            return kind.is_file();
        }
        // A link that leads nowhere is left to its reader, who finds no file.
        match path.canonicalize() {
            Ok(place) => place.starts_with(&self.root) && (place.is_file() || place.is_dir()),
            Err(_) => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> (tempfile::TempDir, Folder) {
        let outer = tempfile::tempdir().unwrap();
        let inner = outer.path().join("served");
        fs::create_dir_all(inner.join("runs/a")).unwrap();
        fs::write(inner.join("runs/a/run.json"), "{}").unwrap();
        fs::write(outer.path().join("secret"), "secret").unwrap();
        let folder = Folder::open(&inner).unwrap();
        (outer, folder)
    }

    #[test]
    fn paths_stay_in_the_folder() {
        let (_outer, folder) = folder();
        assert!(
            folder.place("").is_ok()
                && folder.place("runs/a").is_ok()
                && folder.place("runs/a/run.json").is_ok()
        );
        let out = [
            "..",
            "../secret",
            "runs/../../secret",
            "runs/./a",
            "/etc/passwd",
            "//etc/passwd",
            "..\\secret",
            "runs\\a",
            "run\0",
            "nothing",
            "c:/x",
            "runs/a/",
        ];
        for path in out {
            let found = folder.place(path);
            assert!(found.is_err() || path == "runs/a/", "{path}: {found:?}");
        }
        assert_eq!(folder.inside(&folder.place("runs/a").unwrap()).unwrap(), "runs/a");
        assert!(folder.inside(Path::new("/etc")).is_none());
    }

    #[cfg(unix)]
    #[test]
    fn links_may_not_leave_it_and_pipes_are_not_opened() {
        use std::os::unix::fs::symlink;
        let (outer, folder) = folder();
        let root = folder.root().to_path_buf();
        symlink(root.join("runs"), root.join("here")).unwrap();
        symlink(outer.path(), root.join("out")).unwrap();
        assert!(folder.place("here/a").is_ok());
        assert!(folder.place("out").is_err() && folder.place("out/secret").is_err());
        assert!(folder.check_content(&root.join("runs")).is_ok());
        symlink(outer.path().join("secret"), root.join("runs/a/case.toml")).unwrap();
        let refused = folder.check_content(&root.join("runs")).unwrap_err();
        assert!(refused.reason.contains("runs/a/case.toml is a link"), "{refused:?}");
        fs::remove_file(root.join("runs/a/case.toml")).unwrap();
        let made = std::process::Command::new("mkfifo").arg(root.join("runs/a/series.parquet")).status();
        if made.is_ok_and(|status| status.success()) {
            assert!(folder.place("runs/a/series.parquet").is_err());
            assert!(folder.check_content(&root.join("runs")).is_err());
        }
    }
}
