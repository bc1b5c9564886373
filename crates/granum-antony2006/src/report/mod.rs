//! The pages of the study's report, with the paper's figures and tables.

use granum_report::RunReport;
use serde::{Deserialize, Serialize};

use crate::figures::PaperFigure;
use crate::summary::PaperSummary;

mod headline;
mod many_runs;
mod networks;
mod speed;
mod study;
mod tables;

pub use networks::figure as mapping_figure;
pub use speed::page as speed_page;
pub use study::report as study_report;

/// The data of the report of a study.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StudyReport {
    /// The numerical results of the study.
    pub summary: PaperSummary,
    /// The curves of Figures 3-8.
    pub figures: Vec<PaperFigure>,
    /// The DEM runs, with the training runs first. The pictures show the first run.
    pub runs: Vec<RunReport>,
    /// The command with which the study can be repeated.
    pub command: String,
    /// Hash of the data set of the networks.
    pub dataset_hash: String,
    /// Seed of the study, from which the seeds of the networks are derived.
    pub network_seed: u64,
}
