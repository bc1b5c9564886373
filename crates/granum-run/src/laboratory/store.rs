//! Where a run is kept: in its folder, or in memory only.

use granum_core::Assembly;
use granum_io::RunFolder;

/// The folder of a run; nothing for a run that is kept in memory and leaves no files.
#[derive(Clone, Copy)]
pub(super) struct Store<'a>(pub(super) Option<&'a RunFolder>);

impl<'a> Store<'a> {
    /// Writes with the folder, if there is one.
    pub(super) fn write<E>(self, write: impl FnOnce(&'a RunFolder) -> Result<(), E>) -> Result<(), E> {
        self.0.map_or(Ok(()), write)
    }

    /// Writes a snapshot of all grains and contacts.
    pub(super) fn snapshot(self, name: &str, assembly: &Assembly) -> granum_io::Result<()> {
        self.write(|folder| folder.write_snapshot(name, assembly))
    }
}
