//! The files of a page in a browser: what its reader has handed to it, in memory and under names that a case can have.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

static FILES: Mutex<BTreeMap<String, Arc<[u8]>>> = Mutex::new(BTreeMap::new());

fn files() -> MutexGuard<'static, BTreeMap<String, Arc<[u8]>>> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Puts these files in place of all that were handed over before.
pub fn replace(handed: BTreeMap<String, Arc<[u8]>>) {
    *files() = handed;
}

/// A file that was handed over.
#[derive(Clone, Debug)]
pub struct Handed(Cursor<Arc<[u8]>>);

/// What is known of a file that was handed over.
#[derive(Clone, Copy, Debug)]
pub struct Metadata(u64);

impl Metadata {
    /// The size in bytes.
    #[allow(clippy::len_without_is_empty)] // As that of the standard library.
    pub fn len(self) -> u64 {
        self.0
    }
}

impl Handed {
    /// What is known of it.
    ///
    /// # Errors
    /// None; the files of an operating system have some.
    pub fn metadata(&self) -> io::Result<Metadata> {
        Ok(Metadata(self.0.get_ref().len() as u64))
    }
}

impl Read for Handed {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer)
    }
}

impl Seek for Handed {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

/// The name of a path: its parts with a slash between them, without those that change nothing.
fn name(path: &Path) -> String {
    let parts = path.components().filter(|part| *part != Component::CurDir);
    parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

#[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
unsafe extern "C" {
    /// Whether this module of a page has calls by which files are handed to it. Each module defines it as a constant, so that one without such calls has
    /// none of the code that reads them.
    safe fn granum_takes_files() -> bool;
}

/// Tests have files.
#[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
fn granum_takes_files() -> bool {
    true
}

/// Whether files can be handed to this module.
#[inline(always)]
pub fn can_be() -> bool {
    granum_takes_files()
}

/// Opens a file.
///
/// # Errors
/// If none was handed over under this name.
#[inline(always)]
pub fn open(path: &Path) -> io::Result<Handed> {
    if !granum_takes_files() {
        return Err(io::Error::new(io::ErrorKind::Unsupported, "add it to the files of the case"));
    }
    find(path)
}

fn find(path: &Path) -> io::Result<Handed> {
    let name = name(path);
    let files = files();
    let Some(bytes) = files.get(&name) else {
        let known: Vec<&str> = files.keys().map(String::as_str).take(10).collect();
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        let message =
            format!("the page has no file {name:?}; add it to the files of the case (those it has: {known})");
        return Err(io::Error::new(io::ErrorKind::NotFound, message));
    };
    Ok(Handed(Cursor::new(Arc::clone(bytes))))
}

/// The files in a folder, which are those whose names begin with its name.
///
/// # Errors
/// If there is none.
#[inline(always)]
pub fn files_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    if !granum_takes_files() {
        return Err(io::Error::new(io::ErrorKind::Unsupported, "add its files to those of the case"));
    }
    list(folder)
}

fn list(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let name = name(folder);
    let files = files();
    let inside = |file: &&String| file.strip_prefix(&name).is_some_and(|rest| rest.starts_with('/'));
    let found: Vec<PathBuf> = files.keys().filter(inside).map(PathBuf::from).collect();
    if found.is_empty() {
        return Err(io::Error::new(io::ErrorKind::NotFound, format!("the page has no folder {name:?}")));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hand(names: &[(&str, &str)]) {
        replace(names.iter().map(|(name, text)| ((*name).into(), Arc::from(text.as_bytes()))).collect());
    }

    #[test]
    fn files_are_known_under_their_names() {
        hand(&[("grain.stl", "solid"), ("scan/1.tif", "a"), ("scan/2.tif", "b"), ("scanner.tif", "c")]);
        let mut text = String::new();
        let mut file = open(Path::new("./grain.stl")).unwrap();
        assert_eq!(file.metadata().unwrap().len(), 5);
        file.read_to_string(&mut text).unwrap();
        assert_eq!(text, "solid");
        file.seek(SeekFrom::Start(3)).unwrap();
        text.clear();
        file.read_to_string(&mut text).unwrap();
        assert_eq!(text, "id");
        assert_eq!(files_in(Path::new("scan")).unwrap(), ["scan/1.tif", "scan/2.tif"].map(PathBuf::from));
        assert!(files_in(Path::new("sc")).is_err());
        let error = open(Path::new("grain.obj")).unwrap_err().to_string();
        assert!(error.contains("no file \"grain.obj\"") && error.contains("grain.stl"), "{error}");
        hand(&[]);
        assert!(open(Path::new("grain.stl")).unwrap_err().to_string().contains("those it has: none"));
    }
}
