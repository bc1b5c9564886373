//! Reports of runs and studies: one self-contained HTML file, and its figures as SVG files.
//!
//! [`run_report`] writes the report of one run, [`overlay_report`] that of several over each other, and [`data_report`] that of
//! another program's data. Quantities that a record does not contain are omitted. Pages of other crates are
//! made of the same parts: [`page`], [`figure`], and the sections of [`run`], [`sample`] and [`trust`].

pub mod calibration;
pub mod campaign;
pub mod case_details;
pub mod comparison;
pub mod data;
mod deviatoric_plane;
mod energy;
pub mod family;
pub mod figure;
mod forces;
mod further;
pub mod headline;
pub mod laboratory_summary;
mod learning_curve;
pub mod lines_of_tests;
mod material;
pub mod numbers;
pub mod other_data;
pub mod overlay;
pub mod page;
mod path;
mod preparation;
pub mod presented;
pub mod run;
pub mod sample;
pub mod shapes;
mod state_map;
pub mod strength;
mod study;
pub mod symbols;
pub mod trust;
pub mod viewer;
pub mod worth;

pub use campaign::report as campaign_report;
pub use data::{RoleInStudy, RunReport};
pub use other_data::report as data_report;
pub use overlay::report as overlay_report;
pub use page::Document;
pub use preparation::report as sample_report;
pub use presented::Presented;
pub use run::report as run_report;
pub use state_map::state_map;
pub use study::report as surrogate_study_report;
pub use worth::report as worth_report;
