//! Feed-forward networks for small tables: training, prediction with uncertainty, and model files.

// The parts that the second-order trainer uses stand here before it does.
#![allow(dead_code)]

mod activation;
mod backprop;
mod data;
mod forward;
mod hash;
mod initialisation;
mod kernels;
mod model;
mod model_file;
mod network;
mod scaler;
pub mod trainer;

pub use activation::Activation;
pub use data::{Data, DataError};
pub use model::{BatchPrediction, Column, Fit, Model, ModelError, Prediction, Provenance, Recipe};
pub use network::{LARGEST_LAYER, MOST_LAYERS, MOST_WEIGHTS, Network, NetworkError};
pub use scaler::Scaler;
