//! Names of the files and columns of a data set.

/// Folder of the data set in that of its campaign.
pub const DATA_SET: &str = "dataset";
/// The runs.
pub(super) const RUNS_FILE: &str = "runs.parquet";
/// The states.
pub(super) const STATES_FILE: &str = "states.parquet";
/// The runs that are not part of it.
pub(super) const LEFT_OUT_FILE: &str = "left_out.csv";
/// The base case.
pub(super) const CASE_FILE: &str = "case.toml";
/// What it is, in words.
pub(super) const CARD: &str = "README.md";
/// What it is, as Croissant.
pub(super) const METADATA: &str = "metadata.json";
/// The sums, which are written last: without them the data set is not whole.
pub(super) const SUMS: &str = "SHA256SUMS";
/// What depends on the computer.
pub(super) const SECONDS_FILE: &str = "seconds.parquet";

/// The column of the name of the run, in every table.
pub const RUN: &str = "run";
/// Beginning of the columns of the variables of the plan.
pub const VARIABLE: &str = "variable.";
/// Beginning of the columns of the measures of the sample and the test.
pub(super) const MEASURE: &str = "measure.";
/// Beginning of the columns of the checks, with the value that was found.
pub(super) const CHECK: &str = "check.";
/// End of the columns of the limits of checks.
pub(super) const LIMIT: &str = ".limit";
/// End of the columns of the width of the bins of a histogram.
pub const BIN_WIDTH: &str = ".bin_width";
/// End of the columns of the number of the first bin of a histogram.
pub const FIRST_BIN: &str = ".first_bin";
/// End of the columns of the number of bins of a histogram.
pub const BINS: &str = ".bins";
/// End of the columns of what a histogram counts.
pub const QUANTITY: &str = ".quantity";
/// End of the columns with the number of values that a histogram has counted.
pub(super) const COUNTED: &str = "_counted";
/// Column of the keys that a run sets over the base case.
pub(super) const SETTINGS: &str = "settings";
