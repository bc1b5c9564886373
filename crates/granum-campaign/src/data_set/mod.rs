//! The data set of a campaign: a folder of Parquet files with a card in words, from which anybody can learn without granum.
//!
//! | file | content |
//! |---|---|
//! | `runs.parquet` | a row for each run: variables of the plan, resolved keys of the case, measures, checks, digests |
//! | `states.parquet` | a row for each recorded state: the series, and the histograms as columns of lists |
//! | `left_out.csv` | the runs that are not part of it, with the reason |
//! | `case.toml` | the base case, from which the settings of a run make its case |
//! | `README.md`, `metadata.json` | what it is, in words and as Croissant |
//! | `SHA256SUMS` | SHA-256 of the files above |
//! | `seconds.parquet` | what depends on the computer: wall times, machines |
//!
//! Its files have the same bytes on any number of workers, on any machine, in any order and after any kill, but for
//! `seconds.parquet`, which no sum covers. [`collect`] makes it from the folders of runs; [`DataSet::read`] reads it.

mod card;
mod collect;
mod contents;
mod croissant;
mod grainlearning;
mod known;
mod layout;
mod meaning;
mod read;
mod run_rows;
mod run_table;
mod state_rows;
mod write;
mod written;

pub use collect::{Collected, DataSetSummary, collect};
pub use contents::LeftOutRun;
pub use grainlearning::{GrainLearning, grainlearning};
pub use layout::{BIN_WIDTH, BINS, DATA_SET, FIRST_BIN, QUANTITY, RUN, VARIABLE};
pub use meaning::of_column as meaning_of_column;
pub use read::{DataSet, DataSetRun};
pub use run_rows::{read_finished, states_of};
