//! What a format of packings provides.

use std::path::Path;

use crate::error::Result;
use crate::packing::Packing;

/// A format of packings: grains in a periodic cell.
pub trait PackingFormat: Send + Sync {
    /// Its name, e.g. "granum packing".
    fn name(&self) -> &'static str;
    /// The extensions of its files, in lower case and without the dot.
    fn extensions(&self) -> &'static [&'static str];
    /// True if a file with this beginning is of this format, whatever its name.
    fn recognises(&self, head: &[u8]) -> bool;
    /// Reads and checks a packing; [`Packing::checked`] contains the checks that all formats share.
    ///
    /// # Errors
    /// If the file cannot be read or does not contain a packing, with line and grain.
    fn read(&self, path: &Path) -> Result<Packing>;
    /// Writes a packing under a temporary name and renames it.
    ///
    /// # Errors
    /// If the file cannot be written.
    fn write(&self, path: &Path, packing: &Packing) -> Result<()>;
}
