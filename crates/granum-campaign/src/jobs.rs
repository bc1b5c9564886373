//! Where the runs of a campaign are that a scheduler has.

use std::collections::BTreeMap;

/// Where the runs of a campaign are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Jobs {
    /// The place of each run that was given to the scheduler and of which it has not been taken up that its job is over.
    pub places: BTreeMap<String, Place>,
    /// The jobs.
    pub jobs: Vec<JobState>,
}

/// Where a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Its job is over.
    Over,
    /// Its job waits to begin.
    Queued,
    /// Its job goes on.
    Running,
}

/// The state of a job.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobState {
    /// The name that the scheduler gave to it.
    pub job: String,
    /// Number of elements that wait.
    pub queued: usize,
    /// Number of elements that go on.
    pub running: usize,
    /// Number of elements that are over.
    pub over: usize,
    /// Why elements wait, as the scheduler says.
    pub reasons: Vec<String>,
    /// What was last said of elements that ended before their runs.
    pub said: Vec<String>,
}
