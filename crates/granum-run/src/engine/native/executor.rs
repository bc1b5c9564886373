//! What the parts of a run need besides its case.

use granum_io::Formats;
use granum_io::case::Vocabulary;

use crate::engine::resources::Resources;
use crate::engine::task::Task;

/// Executes the parts of a run: the threads, the interval of checkpoints, and what is known by name.
#[derive(Clone, Debug)]
pub(crate) struct Executor {
    pub(super) resources: Resources,
    pub(super) vocabulary: Vocabulary,
    pub(super) formats: Formats,
}

impl Executor {
    /// That of a task.
    pub(super) fn of(task: &Task) -> Executor {
        let Task { resources, vocabulary, formats, .. } = task.clone();
        Executor { resources, vocabulary, formats }
    }
}
