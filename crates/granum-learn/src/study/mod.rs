//! Studies: surrogates of several methods that are fitted to a data set, scored on runs that they have not seen, compared with
//! baselines, and tested for the use of their inputs.
//!
//! ```text
//! Dataset + StudyDefinition --> Study (fitted, saved) --> StudyScores, predictions, report
//! ```
//!
//! For each fit (inputs, outputs, coordinate) a study has the methods that were asked for, each a second time with the
//! coordinate as its only input, ridge regression in both forms, and the mean curve of the runs.
//!
//! ```
//! use granum_core::{Column, Table};
//! use granum_learn::study::{NoStudyObserver, Study, StudyDefinition};
//! use granum_learn::{Dataset, FitSpec, RunStates, Split, SurrogateMethods};
//!
//! // Six runs in which y follows x and a sensor s.
//! let run = |k: u32| {
//!     let x: Vec<f64> = (0..40).map(|i| f64::from(i) / 39.0).collect();
//!     let s: Vec<f64> = x.iter().map(|x| (9.0 * x + f64::from(k)).sin()).collect();
//!     let y = x.iter().zip(&s).map(|(x, s)| x + 0.3 * s).collect();
//!     let columns = vec![Column::new("x", "", x), Column::new("s", "", s), Column::new("y", "", y)];
//!     RunStates::new(&format!("run-{k}"), Table::new(columns)?)
//! };
//! let dataset = Dataset::new((1..=6).map(run).collect::<granum_learn::Result<_>>()?)?;
//! let fit = FitSpec::new(["x", "s"], ["y"]).with_coordinate("x");
//! let split = Split::default().unseen(["run-4", "run-5", "run-6"]);
//! let definition = StudyDefinition::new([fit], ["ridge"], split);
//! let study = Study::train(&dataset, &definition, &SurrogateMethods::standard(), &NoStudyObserver)?;
//! let scores = study.evaluate(&dataset)?;
//! let ridge = scores.member("y-ridge").unwrap();
//! assert!(ridge.unseen.score.relative_rmse < 0.1);
//! assert_eq!(scores.fits[0].uses["y-ridge"].verdict().words("inputs"), "uses its inputs and gains by it");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod definition;
mod files;
mod input_test;
mod kept_study;
mod learning;
mod member;
mod names;
mod observer;
mod plan;
mod predictions;
mod scores;
mod thinning;
mod timed;
mod training;

pub use definition::StudyDefinition;
pub use files::{StoredStudy, faults, is_study, load, save};
pub use kept_study::KeptStudy;
pub use member::{Member, MemberRole, StudyFit};
pub use names::{SCORED_FILE, STUDY_FILE};
pub use observer::{NoStudyObserver, StudyObserver};
pub use plan::{PLAN_FILE, StudyPlan};
pub use predictions::predictions;
pub use scores::{FitScores, MemberScores, OutputScore, PartScore, StudyScores};
pub use thinning::thinned;
pub use training::Study;

#[cfg(test)]
mod tests;
