//! Where the results of a run are.

use std::sync::Arc;

use granum_run::RunResult;
use tempfile::TempDir;

/// Where the results of a run are.
pub enum Place {
    /// In a folder; of a sample without a name it is removed when nothing refers to it.
    Folder { run: granum_io::Run, kept: Option<Arc<TempDir>> },
    /// In memory.
    Memory { case: Box<granum_io::Case>, result: Box<RunResult> },
}
