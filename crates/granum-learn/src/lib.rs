//! The hybrid method of Antony, Zhou and Wang (2006): networks that learn from soft sensors of DEM runs, judged
//! against runs that none of them saw.
//!
//! ```text
//! Record --> Dataset --> Study --> Evaluation --> Summary, Figures, reading
//! ```
//!
//! [`Dataset`] draws states from records and splits them, [`Study`] trains the six [`mapping`]s with their three
//! sub-models, each beside a network of the same size that sees strain only, and [`Evaluation`] scores both on held-out
//! states and on unseen runs, next to [`baseline`]s without networks and the scatter between runs of different seeds, and
//! tells whether the networks use their sensors ([`sensor_use`]). [`SizeStudy`] and [`antony2006::speed`] measure the paper's
//! claims on size and speed.

pub mod antony2006;
pub mod baseline;
pub mod contents;
pub mod dataset;
mod error;
pub mod files;
pub mod layout;
pub mod mapping;
pub mod runs;
pub mod score;
mod sensor_share;
pub mod sensor_use;
pub mod student_t;
pub mod study;
mod surrogate;
pub mod training_checkpoints;
mod training_rows;

#[cfg(test)]
mod synthetic;
#[cfg(test)]
mod tests;

pub use antony2006::size_study::{SizeStudy, SizeStudyOptions};
pub use antony2006::summary::Summary;
pub use dataset::{Dataset, DatasetOptions, NamedRecord, Run, State};
pub use error::{LearnError, Result};
pub use mapping::{Form, Mapping, Quantity, SubModel, paper_mappings};
pub use score::Score;
pub use sensor_use::{SensorUse, Verdict};
pub use study::{Evaluation, Study, StudyObserver, StudyOptions, StudyProgress};
pub use surrogate::{Answer, Outside, RowAnswer, Surrogate};
