//! The study of Antony, Zhou and Wang (2006) as a configuration of a general study ([`granum_learn::study`]): six mappings between
//! strain, stress ratio, fabric and the distribution of contact forces, the shapes of their eighteen networks, and the tests of the
//! claims of the paper, with its tables and report pages.
//!
//! ```text
//! Dataset --> PaperData --> PaperOptions::definition --> granum_learn::Study --> Evaluation --> PaperSummary, figures, interpretation
//! ```
//!
//! [`PaperData`] checks that the runs are tests with a single stage in which the deviator strain increases, and chooses the bins
//! of forces. [`PaperOptions`] makes a [`granum_learn::study::StudyDefinition`] of the [`mapping`]s with their sub-models; training,
//! baselines, scores, files and the test of the use of the sensors are those of any study. [`Evaluation`] gives the scores in
//! the terms of the paper. [`size_study`] and [`speed`] test the claims of the paper on size and speed.
//!
//! ```
//! use granum_antony2006::{Evaluation, PaperData, PaperDataOptions, PaperOptions, paper_mappings};
//! use granum_core::{Column, Table};
//! use granum_learn::dataset::{ColumnGroup, RunStates};
//! use granum_learn::study::NoStudyObserver;
//!
//! // Runs as tables: strain increases, the stress ratio is proportional to the fabric, and P(f) has two bins.
//! let run = |name: &str, shift: f64| -> Result<RunStates, Box<dyn std::error::Error>> {
//!     let strain: Vec<f64> = (0..=60).map(|k| 0.005 * f64::from(k)).collect();
//!     let fabric: Vec<f64> = strain.iter().map(|e| 0.1 * (1.0 - (-40.0 * e).exp()) + shift).collect();
//!     let ratio = fabric.iter().map(|f| 6.0 * f).collect();
//!     let table = Table::new(vec![
//!         Column::new("deviator_strain", "1", strain.clone()),
//!         Column::new("stress_ratio", "1", ratio),
//!         Column::new("deviator_fabric", "1", fabric),
//!         Column::new("probability_density_0.5", "1", strain.iter().map(|e| 0.6 - 0.1 * e).collect()),
//!         Column::new("probability_density_1.5", "1", strain.iter().map(|e| 0.3 + 0.1 * e).collect()),
//!     ])?;
//!     let (name_of, binned) = ("probability_density".to_string(), "force".to_string());
//!     let bins = ColumnGroup { name: name_of, binned, bin_width: 1.0, centres: vec![0.5, 1.5] };
//!     Ok(RunStates::new(name, table)?.with_group(bins)?)
//! };
//! let training = vec![run("a", 0.0)?, run("b", 0.004)?];
//! let data = PaperData::new(training, vec![run("c", 0.002)?], &PaperDataOptions::default())?;
//!
//! // The third mapping, q/p = F3(eps_d, phi_d, P(f)), with small networks.
//! let options = PaperOptions { mappings: vec![paper_mappings()[2].with_neurons(3)], ..PaperOptions::default() };
//! let study = options.train(&data, &NoStudyObserver)?;
//! let evaluation = &Evaluation::of_study(&study, &data)?[0];
//! assert!(evaluation.network.unseen.relative_rmse < 0.05, "{:?}", evaluation.network.unseen);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod data;
pub mod evaluation;
pub mod figures;
pub mod interpretation;
pub mod learning_curve;
pub mod mapping;
mod method;
mod options;
pub mod report;
pub mod reproduction;
pub mod size_study;
pub mod speed;
pub mod summary;
pub mod times;

#[cfg(test)]
mod method_tests;
#[cfg(test)]
mod outcome_tests;
#[cfg(test)]
#[path = "../../granum-learn/src/synthetic.rs"]
mod synthetic;
#[cfg(test)]
mod tests;

pub use data::{PaperData, PaperDataOptions, check_run};
pub use evaluation::{Evaluation, RunScore, ScoreParts};
pub use mapping::{Mapping, PaperQuantity, paper_mapping, paper_mappings};
pub use method::{MappingMethod, PAPER_TRAINER};
pub use options::{PaperOptions, files_of_earlier_versions, is_of_paper};
pub use report::{StudyReport, speed_page, study_report};
pub use size_study::{SizeStudy, SizeStudyOptions};
pub use summary::PaperSummary;
