//! Names that become part of a path: what is written under them stays in the intended folder.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::windows_names;

/// Largest length of a name that may come from a file.
const LONGEST_NAME: usize = 100;
/// What is wrong with a link in the place of a folder.
pub(super) const LINK: &str =
    "is a symbolic link; output must stay in its folder, so replace it by a folder or remove it";

/// Rejects a name that was read from a file and is to become part of a path, unless it is a plain word of ASCII letters,
/// digits, `-` and `_`: what is written, renamed or removed under this name must be in the intended folder.
///
/// # Errors
/// [`Error::Value`].
pub fn check_name(what: &str, name: &str) -> Result<()> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    windows_names::check_path(Path::new(name))?;
    if !name.is_empty() && name.len() <= LONGEST_NAME && name.chars().all(plain) {
        return Ok(());
    }
    let message = format!("cannot be part of a file name; use up to {LONGEST_NAME} letters, digits, - and _");
    Err(Error::Value { name: what.into(), value: name.into(), message })
}

/// A folder inside an output folder, created if it does not exist. A link in its place could lead anywhere and is rejected.
///
/// # Errors
/// [`Error::Value`] if the name is not a plain word, [`Error::Content`] if there is a link or a file of that name,
/// [`Error::File`] if it cannot be created.
pub fn inner_folder(folder: &Path, name: &str) -> Result<PathBuf> {
    check_name("folder", name)?;
    let path = folder.join(name);
    match fs::symlink_metadata(&path) {
        Ok(kind) if kind.is_dir() => {}
        Ok(kind) if kind.is_symlink() => return Err(Error::content(&path, LINK)),
        Ok(_) => return Err(Error::content(&path, "is a file where a folder is needed; remove it")),
        Err(_) => fs::create_dir_all(&path).map_err(Error::file("create the folder", &path))?,
    }
    Ok(path)
}

/// Refuses to replace an output file unless `force` is set, and one whose folder does not exist, which would be found out only when all is computed.
///
/// # Errors
/// [`Error::Exists`], [`Error::Content`] if it is a folder or its name is none on Windows, [`Error::File`] if there is no folder for it.
pub fn check_output_file(path: impl AsRef<Path>, force: bool) -> Result<()> {
    let path = path.as_ref();
    check_new_file(path, force)?;
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            let why = format!("there is no folder {}; make it first", folder.display());
            Err(Error::file("write", path)(std::io::Error::new(std::io::ErrorKind::NotFound, why)))
        }
        _ => Ok(()),
    }
}

/// Refuses to replace an output file unless `force` is set; its folder is made later.
///
/// # Errors
/// [`Error::Exists`], or [`Error::Content`] if it is a folder or its name is none on Windows.
pub fn check_new_file(path: impl AsRef<Path>, force: bool) -> Result<()> {
    let path = path.as_ref();
    windows_names::check_path(path)?;
    if path.is_dir() {
        return Err(Error::content(path, "is a folder; the output must be a file"));
    }
    if !force && path.exists() {
        return Err(Error::Exists(path.to_path_buf()));
    }
    Ok(())
}
