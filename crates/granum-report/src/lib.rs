//! Reports of runs and studies: one HTML file that needs nothing beside it, and its figures as SVG files.
//!
//! [`run_report`] draws one run, [`study_report`] the whole paper. What a record does not hold is left out; nothing is made up.

pub mod data;
mod deviatoric_plane;
mod energy;
pub mod figure;
mod forces;
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

pub use data::{Role, RunReport};
pub use page::Document;
pub use preparation::report as sample_report;
pub use run::report as run_report;
pub use study::{StudyReport, report as study_report};
