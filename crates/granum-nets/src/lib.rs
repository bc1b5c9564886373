//! Feed-forward networks for small tables and recurrent ones for sequences: training, prediction with uncertainty, and model files.
//!
//! ```
//! use granum_nets::trainer::{self, NoObserver, Options};
//! use granum_nets::{ModelColumn, Data, Model, ModelDefinition};
//!
//! // Forty rows of one input and one target.
//! let strain: Vec<f64> = (0..40).map(|k| 0.3 * k as f64 / 39.0).collect();
//! let ratio = strain.iter().map(|e| 0.6 * (1.0 - (-30.0 * e).exp())).collect();
//! let data = Data::new(strain, 1, ratio)?;
//!
//! let inputs = vec![ModelColumn::new("deviator_strain", "1")];
//! let definition = ModelDefinition::new(inputs, ModelColumn::new("stress_ratio", "1"), vec![10, 10]).with_seed(1);
//! let trainer = trainer::by_name("levenberg-marquardt", &Options::default())?;
//! let (model, report) = Model::fit(&definition, &data, trainer.as_ref(), &mut NoObserver)?;
//! println!("{} epochs: {}", report.epochs, report.termination);
//!
//! let inside = model.predict(&[0.1])?;
//! assert!((inside.value - 0.6 * (1.0 - (-3.0f64).exp())).abs() < 0.01);
//! assert!(inside.outside.is_empty());
//! assert_eq!(model.predict(&[0.5])?.outside, ["deviator_strain"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A network of the paper (280 rows, 3-60-60-1) fits into the second-level cache, so that the overhead of a general
//! framework would dominate. The kernels here use the lanes of `granum-simd`, sum in a fixed order, and give identical
//! bits with every instruction set.

mod activation;
mod backprop;
mod cell_batch;
#[cfg(test)]
mod cell_tests;
mod curvature;
mod data;
mod data_error;
mod differentiable;
mod eigenvectors;
mod ensemble;
mod forward;
pub mod gaussian_process;
mod gru;
mod gru_batch;
mod gru_shape;
mod initialisation;
mod intervals;
mod inverse;
mod kernels;
mod left_out;
mod lstm;
mod members;
mod minimise;
mod model;
mod model_definition;
mod model_error;
mod model_file;
mod network;
mod network_batch;
pub mod normal;
mod objective;
mod prediction;
mod provenance;
mod scaler;
mod sequence_group;
mod sequence_model;
mod sequence_steps;
mod sequences;
mod state_space;
mod stepper;
mod student_t;
mod symmetric;
mod symmetric_tensor;
mod tensor_cell;
mod tensor_sizes;
mod tensor_state_space;
pub mod trainer;
mod uncertainty;

pub use activation::Activation;
pub use data::Data;
pub use data_error::DataError;
pub use differentiable::{Batch, Differentiable, GaussNewton};
pub use eigenvectors::eigenvectors;
pub use ensemble::Ensemble;
pub use granum_simd::Isa;
pub use gru::{Gru, GruWeights};
pub use intervals::Intervals;
pub use lstm::Lstm;
pub use minimise::dot;
pub use model::Model;
pub use model_definition::{ModelColumn, ModelDefinition};
pub use model_error::ModelError;
pub use network::{LARGEST_LAYER, MOST_LAYERS, MOST_WEIGHTS, Network, NetworkError};
pub use objective::Objective;
pub use prediction::{BatchPrediction, Deviation, NetworkPrediction};
pub use provenance::{Fit, Provenance};
pub use scaler::Scaler;
pub use sequence_model::{SequenceDefinition, SequenceModel};
pub use sequence_steps::SequenceSteps;
pub use sequences::Sequences;
pub use state_space::StateSpace;
pub use stepper::Stepper;
pub use student_t::two_sided_quantile;
pub use tensor_sizes::TensorSizes;
pub use tensor_state_space::TensorStateSpace;
pub use uncertainty::Uncertainty;
