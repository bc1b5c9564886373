//! Networks of one quantity, each for a range of the coordinate: the sub-models of a fit.
//!
//! ```text
//! FitSpec + Dataset --> NetworkMapping --> training rows --> networks, one per sub-model --> SubModelNetworks
//! ```
//!
//! A quantity is a column or a histogram. A histogram can enter the networks as a whole or point by point ([`Form`]), and a
//! histogram that is predicted is one network with the binned variable as an input. [`training_rows`] explains which states a
//! network learns from and how they are weighted, [`sensor_share`] how much weight an input has, and `ridge_share` why ridge
//! regression has a share in the predictions.

mod corrections;
mod fitted;
mod kept_networks;
mod mapping;
mod method;
mod onnx_form;
mod ridge_share;
pub mod sensor_share;
mod summary;
mod table;
mod training;
pub mod training_rows;
mod weighing;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod weighing_tests;

pub use crate::surrogate::checkpoints::{NetworkCheckpoints, NoCheckpoints};
pub use crate::surrogate::settings::{Form, NetworkSettings};
pub use crate::surrogate::sub_model::{SubModel, is_within, sub_model_at};
pub use fitted::{RowPrediction, StatePrediction, SubModelNetworks, networks_of};
pub use kept_networks::{KeptNetworks, TIMES_FILE};
pub use mapping::{MappingBins, MappingQuantity, NetworkMapping};
pub use method::NetworksBySubModel;
pub(crate) use ridge_share::{RidgeShare, StoredRidgeShare, supported_share};
pub use summary::NetworkScores;
pub use table::TablePrediction;
pub use training::{FEWEST_STATES, NetworkTask, network_seed};
