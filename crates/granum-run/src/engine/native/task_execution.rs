//! What the parts of a run need besides its case.

use granum_io::Formats;
use granum_io::case::Vocabulary;

use crate::task::definition::Task;
use crate::task::resources::Resources;

/// Executes the parts of a run: the threads, the interval of checkpoints, and what is known by name.
#[derive(Clone, Debug)]
pub(crate) struct TaskExecution {
    pub(super) resources: Resources,
    pub(super) vocabulary: Vocabulary,
    pub(super) formats: Formats,
}

impl TaskExecution {
    /// That of a task.
    pub(super) fn new(task: &Task) -> TaskExecution {
        let Task { resources, vocabulary, formats, .. } = task.clone();
        TaskExecution { resources, vocabulary, formats }
    }
}
