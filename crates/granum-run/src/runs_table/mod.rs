//! Runs side by side: a table with one row for each run and the columns that a study needs: every key by which the cases differ,
//! the sample, the strength and other measures, the quality checks, and digests.
//!
//! ```
//! use granum_io::Case;
//! use granum_io::run::{Machine, RunRecord};
//! use granum_run::runs_table::{RunEntry, RunsTable};
//!
//! let entry = |name: &str, friction: &str| {
//!     let mut case = Case::default();
//!     case.set("grains.material.friction", friction)?;
//!     let record = RunRecord::new(granum_io::RunKind::Test, "0.1.0", &case, Machine::default());
//!     Ok::<_, granum_io::Error>(RunEntry::new(name, name, case, record))
//! };
//! let table = RunsTable::from_runs(&[entry("a", "0.2")?, entry("b", "0.4")?]);
//! assert_eq!(table.column("grains.material.friction").unwrap().numbers().unwrap(), [0.2, 0.4]);
//! # Ok::<(), granum_io::Error>(())
//! ```

mod columns;
mod entry;
mod find;
mod keys;
mod units;

pub use columns::{RunsTable, Selection};
pub use entry::RunEntry;
pub use find::find_runs;
pub use keys::{DifferingKey, KeyValue, RunGroup, differing_keys, groups, legend, repetitions};
pub use units::of_measure as unit_of_measure;

#[cfg(test)]
mod tests;
