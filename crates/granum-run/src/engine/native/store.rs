//! Where a run is stored: in its folder, or only in memory.

use granum_core::Assembly;
use granum_io::RunFolder;

/// Name of the snapshot of a sample; in the folder of a test it holds the state in which the test begins.
pub const SAMPLE: &str = "start";
/// Name of the snapshot at the end of a test.
pub const END: &str = "end";

/// The folder of a run; `None` for a run that stays in memory and writes no files.
#[derive(Clone, Copy)]
pub(crate) struct Store<'a>(pub(crate) Option<&'a RunFolder>);

impl<'a> Store<'a> {
    /// Calls `write` with the folder, if there is one.
    pub(crate) fn write<E>(self, write: impl FnOnce(&'a RunFolder) -> Result<(), E>) -> Result<(), E> {
        self.0.map_or(Ok(()), write)
    }

    /// Writes a snapshot of all grains and contacts.
    pub(crate) fn snapshot(self, name: &str, assembly: &Assembly) -> granum_io::Result<()> {
        self.write(|folder| folder.write_snapshot(name, assembly))
    }
}
