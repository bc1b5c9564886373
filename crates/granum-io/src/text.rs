//! Reading small text files completely, with a limit on their size.

use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};

/// Reads a UTF-8 file of at most `largest` bytes.
///
/// # Errors
/// If it cannot be read, is larger, or is not UTF-8.
pub(crate) fn read_small(path: &Path, largest: u64) -> Result<String> {
    let file = granum_core::input::open(path).map_err(Error::file("read", path))?;
    let mut bytes = Vec::new();
    file.take(largest + 1).read_to_end(&mut bytes).map_err(Error::file("read", path))?;
    if bytes.len() as u64 > largest {
        return Err(Error::content(
            path,
            format!("is larger than {largest} bytes, which is too large for such a file"),
        ));
    }
    String::from_utf8(bytes).map_err(|error| {
        let line =
            error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
        Error::content(path, format!("line {line} is not UTF-8 text"))
    })
}
