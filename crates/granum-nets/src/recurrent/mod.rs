//! Networks with a memory: cells, their batches, and models that are asked row by row.

pub(crate) mod cell_batch;
pub(crate) mod cell_network;
#[cfg(test)]
pub(crate) mod cell_tests;
pub(crate) mod gru;
pub(crate) mod lstm;
pub(crate) mod state_space;
pub(crate) mod symmetric_tensor;
pub(crate) mod tensor_cell;
pub(crate) mod tensor_sizes;
pub(crate) mod tensor_state_space;
