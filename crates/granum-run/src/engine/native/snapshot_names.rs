//! Names of the snapshots of a run.

/// Name of the snapshot of a sample; in the folder of a test it holds the state in which the test begins.
pub const SAMPLE: &str = "start";
/// Name of the snapshot at the end of a test.
pub const END: &str = "end";
