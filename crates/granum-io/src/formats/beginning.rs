//! By what the format of a file is recognised: its beginning, or the end of its name.

use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};

/// Number of leading bytes of a file by which a format may be recognised.
const HEAD: u64 = 4096;

/// The beginning of a file, by which its format may be recognised.
pub(super) fn head(path: &Path) -> Result<Vec<u8>> {
    let mut head = Vec::new();
    let file = granum_core::input::open(path).map_err(Error::file("read", path))?;
    file.take(HEAD).read_to_end(&mut head).map_err(Error::file("read", path))?;
    Ok(head)
}

/// The extension of a file in lower case, without the dot; empty if it has none.
pub(super) fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}
