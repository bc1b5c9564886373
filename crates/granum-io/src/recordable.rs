//! The paths by which the files of a folder name other files: relative to the folder, so that folders that are moved or copied together
//! find each other again.

use std::path::{Component, Path, PathBuf};

use crate::error::{Error, Result};

/// How many folders above, and how many last parts of a path, are tried for what an earlier version named by an absolute path.
const NEAR: usize = 3;

/// The absolute path of a file or folder that a record is to name.
///
/// # Errors
/// [`Error::Content`] if it is not UTF-8 text, which a record in JSON needs; [`Error::File`] if the working directory no longer exists.
pub fn recordable(path: &Path) -> Result<PathBuf> {
    let absolute = std::path::absolute(path).map_err(Error::file("resolve the path", path))?;
    if absolute.to_str().is_some() {
        return Ok(absolute);
    }
    let message = "has a name with bytes that are not UTF-8 text, which the record of a run cannot hold: rename it, or give a link to it \
                   with another name";
    Err(Error::content(&absolute, message))
}

/// The path of a file or folder as a file in `folder` is to name it: relative to `folder`. The absolute path remains only where there is no
/// other, on another drive of Windows.
///
/// # Errors
/// As [`recordable`].
pub fn path_from(folder: &Path, path: &Path) -> Result<PathBuf> {
    let (whole, folder) = (recordable(path)?, absolute(folder));
    let (whole, folder) = (without_parents(&whole), without_parents(&folder));
    let alike = whole.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    if alike == 0 {
        return Ok(whole);
    }
    let up = folder.components().skip(alike).map(|_| Component::ParentDir);
    let relative: PathBuf = up.chain(whole.components().skip(alike)).collect();
    Ok(if relative.as_os_str().is_empty() { PathBuf::from(".") } else { relative })
}

/// The file or folder that a file in `folder` names. An absolute path, which earlier versions wrote, is returned as it is.
pub fn path_in(folder: &Path, path: &Path) -> PathBuf {
    if path.is_absolute() {
        return path.to_path_buf();
    }
    let by_name = joined(&without_parents(&absolute(folder)), path);
    if by_name.symlink_metadata().is_ok() {
        return by_name;
    }
    // A folder that is reached through a link has other folders above it.
    let behind_links = folder.canonicalize().map(|folder| joined(&folder, path));
    behind_links.ok().filter(|path| path.symlink_metadata().is_ok()).unwrap_or(by_name)
}

/// The place near `folder` where something lies now that a file in it names by an absolute path: folders of earlier versions did, and a
/// folder that was moved since keeps what belongs together near each other. `is_it` tells whether a place has it.
pub fn moved_with(folder: &Path, path: &Path, is_it: &dyn Fn(&Path) -> bool) -> Option<PathBuf> {
    let folder = without_parents(&absolute(folder));
    let names: Vec<Component> =
        path.components().filter(|part| matches!(part, Component::Normal(_))).collect();
    for above in folder.ancestors().skip(1).take(NEAR) {
        for count in (1..=NEAR.min(names.len())).rev() {
            let place =
                names[names.len() - count..].iter().fold(above.to_path_buf(), |place, name| place.join(name));
            if place != folder && is_it(&place) {
                return Some(place);
            }
        }
    }
    None
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

/// A relative path from a folder by their names alone, as it was written: links are not followed.
fn joined(folder: &Path, path: &Path) -> PathBuf {
    let mut whole = folder.to_path_buf();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(whole.pop()),
            Component::CurDir => {}
            part => whole.push(part),
        }
    }
    whole
}

/// An absolute path without `..`. What is above a link is where the link leads, so that links before a `..` are followed.
fn without_parents(path: &Path) -> PathBuf {
    let mut whole = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                if whole.symlink_metadata().is_ok_and(|kind| kind.is_symlink())
                    && let Ok(target) = whole.canonicalize()
                {
                    whole = target;
                }
                whole.pop();
            }
            Component::CurDir => {}
            part => whole.push(part),
        }
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_path_leads_from_its_folder_to_the_file_and_back() {
        let base = tempfile::tempdir().unwrap();
        let at = |name: &str| base.path().join(name);
        fs::create_dir_all(at("study/tests/a")).unwrap();
        fs::create_dir_all(at("study/samples/b")).unwrap();
        for (path, expected) in
            [("study/samples/b", "../../samples/b"), ("study/tests/a", "."), ("study/tests/a/c", "c")]
        {
            let path = at(path);
            let relative = path_from(&at("study/tests/a"), &path).unwrap();
            assert_eq!(relative, Path::new(expected));
            assert_eq!(path_in(&at("study/tests/a"), &relative), path);
        }
        assert_eq!(
            path_from(&at("x/../study"), &at("study/./samples/../p.csv")).unwrap(),
            Path::new("p.csv")
        );
        assert_eq!(path_in(&at("study"), &at("elsewhere")), at("elsewhere"));
    }

    #[test]
    fn what_was_moved_with_a_folder_is_near_it() {
        let base = tempfile::tempdir().unwrap();
        let sample = base.path().join("moved/samples/b");
        fs::create_dir_all(&sample).unwrap();
        fs::create_dir_all(base.path().join("moved/tests/a")).unwrap();
        let place = |path: &str| {
            moved_with(&base.path().join("moved/tests/a"), Path::new(path), &|place| place.is_dir())
        };
        assert_eq!(place("/old/study/samples/b"), Some(sample));
        assert_eq!(place("/old/study/samples/c"), None);
        assert_eq!(place("/old/a"), None, "the folder itself");
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_behind_a_link_finds_what_is_beside_it_and_beside_the_link() {
        let base = tempfile::tempdir().unwrap();
        let at = |name: &str| base.path().join(name);
        fs::create_dir_all(at("disk/run")).unwrap();
        fs::create_dir_all(at("disk/near")).unwrap();
        fs::create_dir_all(at("home/sample")).unwrap();
        std::os::unix::fs::symlink(at("disk/run"), at("home/run")).unwrap();
        assert_eq!(path_from(&at("home/run"), &at("home/sample")).unwrap(), Path::new("../sample"));
        assert_eq!(path_in(&at("home/run"), Path::new("../sample")), at("home/sample"));
        let near = path_in(&at("home/run"), Path::new("../near"));
        assert_eq!(near, at("disk/near").canonicalize().unwrap());
    }
}
