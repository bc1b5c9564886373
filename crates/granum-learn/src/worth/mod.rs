//! What each soft sensor is worth: how well the stress ratio and the volumetric strain of unseen runs are known from different
//! knowledge of a test, and how well soft sensors are known from what a laboratory measures.
//!
//! ```text
//! strain alone                       an unknown material on a bench
//! strain + a soft sensor             the same with a sensor that measures fabric, P(f), coordination, sliding
//! strain + properties                a known material and packing (direct)
//! strain + properties --> sensors    the cascade
//! strain + properties + sensors      both
//! ```
//!
//! Each line is an [`Answer`] with its error on unseen runs, which have other parameters and other seeds than the training runs, its standard
//! error over these runs, and the share of their states within the intervals. For each line the method is chosen among several on training runs
//! alone: the one with the least error on every fifth of them when it is fitted to the others. Sensors of another run at the same
//! coordinate, and sensors permuted over the states of their run, show whether it is the value of the sensor that counts.

mod answers;
mod knowledge;
mod measurement;
mod plan;
#[cfg(test)]
mod tests;

pub use answers::{Answer, AnswerRow, Worth};
pub use knowledge::{Knowledge, Source};
pub use measurement::measure;
pub use plan::{WorthPlan, properties};
