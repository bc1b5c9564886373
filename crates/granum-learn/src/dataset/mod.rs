//! Named columns over the states of runs, with the parameters of each run, for tests along arbitrary paths.
//!
//! A row is a state of a run. Its key consists of the run, the number of the stage of the test (`stage`) and the number of
//! the state in the stage (`state`). A row also contains the measurements (`stress_ratio`, `arc_length`, ...), one column
//! for each bin of every histogram (`probability_density_0.125` for the forces, `overlaps_probability_density_0.05`, ...), and
//! the parameters of its run, which are the same in all rows of the run: every key of its case, numbers
//! (`grains.material.friction`, `preparation.seed`) and words (`contact.normal`), and what was measured on its sample
//! (`sample.void_ratio`). Strain need not be monotonic: a column of strain may increase, decrease or change direction.

mod catalogue;
mod category;
mod column_group;
mod dataset_words;
mod keys;
mod named_columns;
mod run_columns;
mod run_states;
mod split;
mod variable;

pub use catalogue::{CatalogueEntry, CatalogueSection};
pub use category::Category;
pub use column_group::ColumnGroup;
pub use named_columns::Dataset;
pub use run_columns::record_error;
pub use run_states::{NamedRecord, RunStates};
pub use split::{Split, SplitParts, unseen_runs};
pub use variable::Variable;

#[cfg(test)]
mod tests;
