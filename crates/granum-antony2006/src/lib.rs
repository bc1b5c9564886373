//! The study of Antony, Zhou and Wang (2006): six mappings between strain, stress ratio, fabric and the distribution of
//! contact forces, their networks, the baselines, the tests of the claims of the paper, and the files of the study.
//!
//! ```text
//! Dataset --> StudyData --> Study --> Evaluation --> Summary, Figures, reading
//! ```
//!
//! [`StudyData`] takes the columns of the paper from a [`granum_learn::Dataset`] by name; the test must have a single stage in
//! which the deviator strain increases. [`Study`] trains the [`mapping`]s with their three sub-models, and for each
//! sub-model a strain-only network of the same size. [`study::Evaluation`] scores both on held-out states and on unseen
//! runs, compares them with [`baseline`]s without networks and with the scatter between runs of different seeds, and tests
//! whether the networks use their sensors ([`sensor_use`]). [`size_study`] and [`speed`] test the claims of the paper on
//! size and speed. [`MappingNetworks`] can be used as any other [`granum_learn::Surrogate`].

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
pub mod report;
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
pub mod times;
pub mod training_checkpoints;
mod training_rows;

#[cfg(test)]
mod mapping_surrogate_tests;
#[cfg(test)]
#[path = "../../granum-learn/src/synthetic.rs"]
mod synthetic;
#[cfg(test)]
mod tests;

pub use batch::Batch;
pub use mapping::{Form, Mapping, Quantity, SubModel, paper_mappings};
pub use mapping_networks::{Answer, MappingNetworks, RowAnswer};
pub use mapping_surrogate::MappingMethod;
pub use report::{StudyReport, speed_page, study_report};
pub use sensor_use::{SensorUse, Verdict};
pub use size_study::{SizeStudy, SizeStudyOptions};
pub use study::{Evaluation, Study, StudyObserver, StudyOptions, StudyProgress};
pub use study_data::{Run, State, StudyData, StudyDataOptions};
pub use summary::Summary;
