//! The trainers, which share one trait and have one file each.
//!
//! All functions that train accept a `&dyn Trainer`, so that user-defined trainers can be used like those of this crate; the
//! registry of names ([`by_name`]) is built on top. [`crate::Objective`] provides the error of a model and its gradient, over
//! rows or over sequences:
//!
//! ```
//! use granum_nets::trainer::{
//!     Flow, NoObserver, Observer, TerminationReason, Trainer, TrainerState, TrainingError, TrainingReport,
//!     training_progress,
//! };
//! use granum_nets::{ModelColumn, Data, Differentiable, Model, ModelDefinition, Objective};
//!
//! /// Resilient propagation (Riedmiller and Braun 1993): the sign of the gradient decides, each weight has its own step.
//! struct Rprop {
//!     epochs: u64,
//! }
//!
//! impl Trainer for Rprop {
//!     fn name(&self) -> &str {
//!         "rprop"
//!     }
//!
//!     fn resume(
//!         &self,
//!         model: &mut dyn Differentiable,
//!         data: &Data,
//!         state: Option<TrainerState>,
//!         observer: &mut dyn Observer,
//!     ) -> Result<TrainingReport, TrainingError> {
//!         let mut objective = Objective::new(model, data)?;
//!         let count = model.weights().len();
//!         let mut state = state.unwrap_or_else(|| {
//!             let state = TrainerState::new("rprop", model.weights().to_vec());
//!             state.with("steps", &vec![0.05; count]).with("signs", &vec![0.0; count])
//!         });
//!         state.check("rprop", model)?;
//!         let mut termination = TerminationReason::EpochLimit;
//!         while state.epoch() < self.epochs {
//!             let (_, gradient) = objective.error_and_gradient(state.weights())?;
//!             let mut weights = state.weights().to_vec();
//!             let (mut steps, mut signs) = (state.vector("steps", count)?.to_vec(), state.vector("signs", count)?.to_vec());
//!             for k in 0..count {
//!                 let agrees = signs[k] * gradient[k];
//!                 steps[k] = (steps[k] * if agrees < 0.0 { 0.5 } else { 1.2 }).clamp(1e-6, 1.0);
//!                 signs[k] = if agrees < 0.0 { 0.0 } else { gradient[k].signum() };
//!                 weights[k] -= steps[k] * signs[k];
//!             }
//!             let error = objective.error(&weights)?;
//!             state.set("steps", &steps);
//!             state.set("signs", &signs);
//!             state.note_epoch(&weights, error);
//!             if observer.progress(&training_progress(state.epoch(), self.epochs, error, None)) == Flow::Stop {
//!                 termination = TerminationReason::Stopped;
//!                 break;
//!             }
//!         }
//!         let error = objective.error(state.weights())?;
//!         model.weights_mut().copy_from_slice(state.weights());
//!         Ok(TrainingReport::new(state, error, termination))
//!     }
//! }
//!
//! let x: Vec<f64> = (0..30).map(|k| k as f64 / 29.0).collect();
//! let y = x.iter().map(|x| 2.0 * x * x).collect();
//! let definition = ModelDefinition::new(vec![ModelColumn::new("x", "1")], ModelColumn::new("y", "1"), vec![6]);
//! let (model, report) = Model::fit(&definition, &Data::new(x, 1, y)?, &Rprop { epochs: 300 }, &mut NoObserver)?;
//! assert!((model.value(&[0.5])? - 0.5).abs() < 0.02 && report.trainer == "rprop");
//! assert_eq!(model.provenance().trainer, "rprop");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adam;
mod kind;
mod lbfgs;
pub(crate) mod left_out;
mod levenberg_marquardt;
mod options;
mod registry;
pub(crate) mod report;
pub(crate) mod state;
pub(crate) mod trainer_trait;
mod traingdx;

pub use crate::training_error::{TerminationReason, TrainingError};
pub use adam::Adam;
pub use granum_core::observer::{Flow, NoObserver, Observer, Progress};
pub use kind::TrainerKind;
pub use lbfgs::Lbfgs;
pub use levenberg_marquardt::{LevenbergMarquardt, Regularisation};
pub use options::Options;
pub use registry::{ALL, NAMES, by_name};
pub use report::{Evidence, TrainingReport};
pub use state::{HistoryPoint, TrainerState};
pub use trainer_trait::{SharedTrainer, Trainer, training_progress};
pub use traingdx::Traingdx;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod traingdx_tests;
