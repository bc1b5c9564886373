//! Feed-forward networks for small tables: training, prediction with uncertainty, and model files.

mod activation;
mod backprop;
mod curvature;
mod data;
mod ensemble;
mod forward;
mod hash;
mod initialisation;
mod kernels;
mod model;
mod model_file;
mod network;
mod scaler;
mod symmetric;
pub mod trainer;
mod uncertainty;

pub use activation::Activation;
pub use data::{Data, DataError};
pub use ensemble::Ensemble;
pub use model::{BatchPrediction, Column, Fit, Model, ModelError, Prediction, Provenance, Recipe};
pub use network::{LARGEST_LAYER, MOST_LAYERS, MOST_WEIGHTS, Network, NetworkError};
pub use scaler::Scaler;
