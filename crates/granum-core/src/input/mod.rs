//! Files that are read: regular files, of a size that is known before their content is.
//!
//! A pipe may never end or never begin, and a device may have no end: a program that is handed one as its input would wait for ever or
//! fill the memory. All readers of all crates open their files here. A page in a browser has no files but those that its reader hands to it,
//! which are known under their names (`handed.rs`).

#[cfg(any(test, all(target_arch = "wasm32", target_os = "unknown")))]
pub mod handed;

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// A file that is open for reading.
#[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
pub type Input = File;
/// A file that is open for reading.
#[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
pub type Input = handed::Handed;

/// Size in bytes above which no file is read into memory as a whole.
pub const LARGEST_INPUT: u64 = 1 << 34;

/// Opens a file for reading.
///
/// ```
/// let error = granum_core::input::open("/dev/zero".as_ref()).unwrap_err();
/// assert!(error.to_string().contains("regular file"));
/// ```
///
/// # Errors
/// If it cannot be opened, or is a pipe, a socket or a device.
#[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
pub fn open(path: &Path) -> io::Result<Input> {
    open_on_disk(path)
}

/// Opens a file that was handed to the page.
///
/// # Errors
/// If none was under this name.
#[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn open(path: &Path) -> io::Result<Input> {
    handed::open(path)
}

/// Whether files can be read at all; false in a module of a page to which none can be handed, which then has nothing of a reader that asks this first.
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn are_there() -> bool {
    #[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
    return handed::can_be();
    #[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
    return true;
}

/// Opens a file for a reader that needs one of the operating system.
///
/// # Errors
/// As for [`open`]; in a page there is none.
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn open_on_disk(path: &Path) -> io::Result<File> {
    // This is known when a module for a page is compiled, which then has none of what comes after it.
    if cfg!(all(target_arch = "wasm32", target_os = "unknown")) {
        return Err(io::Error::new(io::ErrorKind::Unsupported, "a page in a browser cannot read such files"));
    }
    // Before it is opened, since the opening of a pipe waits for a writer, and afterwards, since it may have been replaced.
    check(&path.metadata()?)?;
    let file = File::open(path)?;
    check(&file.metadata()?)?;
    Ok(file)
}

/// The size of a file that is open, bytes.
///
/// # Errors
/// If the system does not tell it.
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn size(file: &Input) -> io::Result<u64> {
    Ok(file.metadata()?.len())
}

/// The size of a file, bytes.
///
/// # Errors
/// As for [`open`].
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn size_of(path: &Path) -> io::Result<u64> {
    size(&open(path)?)
}

/// True if there is a folder of this name.
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn is_folder(path: &Path) -> bool {
    #[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
    return handed::files_in(path).is_ok();
    #[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
    return path.is_dir();
}

/// The files and folders in a folder, in no particular order.
///
/// # Errors
/// If it cannot be read.
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn files_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    #[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
    return handed::files_in(folder);
    #[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
    return std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect();
}

/// Folders are left to the system, whose message says what they are.
fn check(metadata: &Metadata) -> io::Result<()> {
    if metadata.is_file() || metadata.is_dir() {
        return Ok(());
    }
    let message =
        "it is a pipe, a socket or a device; an input must be a regular file, so save the data to one";
    Err(io::Error::new(io::ErrorKind::InvalidInput, message))
}

/// Reads a file of at most `largest` bytes as a whole.
///
/// # Errors
/// As for [`open`]; [`io::ErrorKind::FileTooLarge`] if it has more bytes.
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn read(path: &Path, largest: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let size = size(&file)?;
    let too_large = |size: u64| {
        let message = format!("it has {size} bytes or more; at most {largest} are read");
        io::Error::new(io::ErrorKind::FileTooLarge, message)
    };
    if size > largest {
        return Err(too_large(size));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or(0));
    // It may have grown since.
    file.take(largest.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > largest {
        return Err(too_large(bytes.len() as u64));
    }
    Ok(bytes)
}

/// Reads a file of UTF-8 text of at most `largest` bytes.
///
/// # Errors
/// As for [`read`]; [`io::ErrorKind::InvalidData`] if it is not UTF-8.
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn read_text(path: &Path, largest: u64) -> io::Result<String> {
    let bytes = read(path, largest)?;
    String::from_utf8(bytes).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8 text"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_read() {
        for device in ["/dev/zero", "/dev/null"] {
            let error = read(Path::new(device), 10).unwrap_err();
            assert!(error.to_string().contains("an input must be a regular file"), "{error}");
        }
        assert_eq!(open(Path::new("/nothing/here")).unwrap_err().kind(), io::ErrorKind::NotFound);
        assert!(read(Path::new("/"), 10).is_err());
    }

    #[test]
    fn sizes_are_bounded() {
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let size = std::fs::metadata(&here).unwrap().len();
        assert_eq!(read(&here, size).unwrap().len() as u64, size);
        assert_eq!(read(&here, size - 1).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert!(read_text(&here, LARGEST_INPUT).unwrap().contains("granum-core"));
    }
}
