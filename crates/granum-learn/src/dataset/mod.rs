//! Named columns over the states of runs, with the parameters of each run, for tests along arbitrary paths.
//!
//! A row is a state of a run. Its key consists of the run, the number of the stage of the test (`stage`) and the number of
//! the state in the stage (`state`). A row also contains the measurements (`stress_ratio`, `arc_length`, ...), one column
//! for each bin of a histogram (`probability_density_0.125`, ...), and the parameters of its run
//! (`grains.material.friction`, `preparation.seed`, ...), which are the same in all rows of the run. Strain need not be
//! monotonic: a column of strain may increase, decrease or change direction.

mod named_columns;
pub(crate) mod run_states;
mod split;
mod variable;

pub use named_columns::Dataset;
pub use run_states::{ColumnGroup, NamedRecord, RunStates, record_error};
pub use split::{Split, SplitParts};
pub use variable::Variable;

#[cfg(test)]
mod tests;
