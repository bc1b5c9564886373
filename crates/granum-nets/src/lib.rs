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

mod differentiable;
mod feed_forward;
pub mod gaussian_process;
mod linear_algebra;
mod model;
mod objective;
mod random;
mod recurrent;
mod sequence;
mod statistics;
mod table;
pub mod trainer;
mod training_error;

pub use differentiable::{Batch, Differentiable, GaussNewton};
pub use feed_forward::activation::Activation;
pub use feed_forward::network::{LARGEST_LAYER, MOST_LAYERS, MOST_WEIGHTS, Network, NetworkError};
pub use granum_simd::Isa;
pub use linear_algebra::eigenvectors::eigenvectors;
pub use linear_algebra::minimise::dot;
pub use model::ensemble::Ensemble;
pub use model::intervals::Intervals;
pub use model::model_definition::{ModelColumn, ModelDefinition};
pub use model::model_error::ModelError;
pub use model::prediction::{BatchPrediction, Deviation, NetworkPrediction};
pub use model::provenance::{Fit, Provenance};
pub use model::sequence_model::{SequenceDefinition, SequenceModel};
pub use model::sequence_steps::SequenceSteps;
pub use model::trained::Model;
pub use model::uncertainty::Uncertainty;
pub use objective::Objective;
pub use recurrent::gru::{Gru, GruWeights};
pub use recurrent::lstm::{Lstm, LstmWeights};
pub use recurrent::state_space::{StateSpace, StateSpaceWeights};
pub use recurrent::tensor_sizes::TensorSizes;
pub use recurrent::tensor_state_space::{TensorStateSpace, TensorWeights};
pub use sequence::stepper::{MOST_SEQUENCES, Stepper};
pub use statistics::normal;
pub use statistics::student_t::two_sided_quantile;
pub use table::data::Data;
pub use table::data_error::DataError;
pub use table::scaler::Scaler;
pub use table::sequences::Sequences;
