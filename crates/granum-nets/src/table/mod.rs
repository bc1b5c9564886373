//! Tables of rows for training, their division into sequences, and the scale of their columns.

pub(crate) mod data;
pub(crate) mod data_error;
pub(crate) mod members;
pub(crate) mod scaler;
pub(crate) mod sequences;
