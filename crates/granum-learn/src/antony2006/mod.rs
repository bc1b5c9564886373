//! The study of Antony, Zhou and Wang (2006): six mappings between strain, stress ratio, fabric and the distribution of contact
//! forces, their networks, what stands beside these, what is measured of the claims, and its files.
//!
//! ```text
//! Dataset --> StudyData --> Study --> Evaluation --> Summary, Figures, reading
//! ```
//!
//! [`StudyData`] asks a [`crate::Dataset`] for the columns of the paper by name, and for a test of one stage in which the
//! deviator strain rises. [`Study`] trains the [`mapping`]s with their three sub-models, each beside a network of the same
//! size that sees strain only, and [`study::Evaluation`] scores both on held-out states and on unseen runs, next to
//! [`baseline`]s without networks and the scatter between runs of different seeds, and tells whether the networks use their
//! sensors ([`sensor_use`]). [`size_study`] and [`speed`] measure the paper's claims on size and speed.
//! [`MappingNetworks`] is a [`crate::Surrogate`] like any other.

pub mod baseline;
mod batch;
pub mod figures;
pub mod files;
pub mod interpretation;
pub mod layout;
pub mod learning_curve;
pub mod mapping;
mod mapping_networks;
mod mapping_surrogate;
pub mod reproduction;
pub mod scatter;
mod sensor_share;
pub mod sensor_use;
pub mod size_study;
pub mod speed;
pub mod study;
pub mod study_data;
pub mod sufficiency;
pub mod summary;
pub mod training_checkpoints;
mod training_rows;

#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
mod tests;

pub use batch::Batch;
pub use mapping_networks::{Answer, MappingNetworks, RowAnswer};
pub use mapping_surrogate::MappingMethod;
pub use study::Study;
pub use study_data::{Run, State, StudyData, StudyDataOptions};
