//! Trained models: columns, file, predictions and their uncertainty.

pub(crate) mod ensemble;
pub(crate) mod intervals;
pub(crate) mod left_out;
pub(crate) mod model_definition;
pub(crate) mod model_error;
pub(crate) mod model_file;
pub(crate) mod prediction;
pub(crate) mod provenance;
pub(crate) mod sequence_model;
pub(crate) mod sequence_steps;
pub(crate) mod trained;
pub(crate) mod uncertainty;
