//! Reports of runs and studies: one self-contained HTML file, and its figures as SVG files.
//!
//! [`run_report`] writes the report of one run, [`study_report`] that of the whole paper. Quantities that a record does not
//! contain are omitted.

mod case_details;
pub mod comparison;
pub mod data;
mod deviatoric_plane;
mod energy;
pub mod figure;
mod forces;
mod further;
mod headline;
mod many_runs;
mod material;
mod networks;
mod numbers;
mod page;
mod path;
mod preparation;
mod run;
mod sample;
mod study;
mod symbols;
mod tables;
mod trust;

pub use data::{Role, RunReport, StudyReport};
pub use page::Document;
pub use preparation::report as sample_report;
pub use run::report as run_report;
pub use study::report as study_report;
