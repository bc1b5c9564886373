//! The rows of runs: what a campaign keeps of a run when it throws its folder away, and from which its data set is made.
//!
//! They are in files `rows/NNNN.rows` of the folder of the campaign. Every process that takes in runs begins a file of its own and only
//! ever appends to it, so that no locks are needed, and what a killed process left unfinished at the end of its file does no harm to
//! others. A run counts as taken in once its bytes are on the disk.

mod folders;
mod row_files;
mod row_writer;
mod stored_run;

pub use folders::{forget_leftovers, read_run, remove_folder};
pub use row_files::{RowFiles, StoredHead};
pub use row_writer::RowWriter;
pub use stored_run::StoredRun;

#[cfg(test)]
pub(crate) use stored_run::tests::some_run;
