//! A bond as a file lists it.

/// A bond as a file has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FileBond {
    /// Id of the first sphere.
    pub first: u64,
    /// Id of the second sphere.
    pub second: u64,
    /// Type of the bond, from 1.
    pub kind: u32,
    /// Its line in the file, from 1; 0 in files without lines.
    pub line: usize,
}
