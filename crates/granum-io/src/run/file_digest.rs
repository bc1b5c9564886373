//! SHA-256 of files, and the name of the record that holds those of a run.

use std::io;
use std::path::Path;

use granum_core::digest::Digest;

use crate::error::{Error, Result};

/// The record of a run.
pub(crate) const RECORD: &str = "run.json";

/// SHA-256 of a file, in hexadecimal digits.
///
/// # Errors
/// [`Error::File`] if it cannot be read.
pub fn file_digest(path: &Path) -> Result<String> {
    let mut file = granum_core::input::open(path).map_err(Error::file("read", path))?;
    let mut hash = Digest::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match io::Read::read(&mut file, &mut buffer).map_err(Error::file("read", path))? {
            0 => return Ok(hash.finish()),
            count => hash.bytes(&buffer[..count]),
        }
    }
}
