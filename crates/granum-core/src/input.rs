//! Files that are read: regular files, of a size that is known before their content is.
//!
//! A pipe may never end or never begin, and a device may have no end: a program that is handed one as its input would wait for ever or
//! fill the memory. All readers of all crates open their files here.

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;

/// Size in bytes above which no file is read into memory as a whole.
pub const LARGEST_INPUT: u64 = 1 << 34;

/// A page in a browser has no files. This is known when a module for one is compiled, which then has no readers of files either.
const IN_A_PAGE: bool = cfg!(all(target_arch = "wasm32", target_os = "unknown"));

fn no_files() -> io::Error {
    io::Error::new(io::ErrorKind::Unsupported, "a page in a browser has no files")
}

/// Opens a file for reading.
///
/// ```
/// let error = granum_core::input::open("/dev/zero".as_ref()).unwrap_err();
/// assert!(error.to_string().contains("regular file"));
/// ```
///
/// # Errors
/// If it cannot be opened, or is a pipe, a socket or a device.
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), inline(always))]
pub fn open(path: &Path) -> io::Result<File> {
    if IN_A_PAGE {
        return Err(no_files());
    }
    // Before it is opened, since the opening of a pipe waits for a writer, and afterwards, since it may have been replaced.
    check(&path.metadata()?)?;
    let file = File::open(path)?;
    check(&file.metadata()?)?;
    Ok(file)
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
    if IN_A_PAGE {
        return Err(no_files());
    }
    let file = open(path)?;
    let size = file.metadata()?.len();
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
    if IN_A_PAGE {
        return Err(no_files());
    }
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
