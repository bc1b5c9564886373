//! Feed-forward networks: evaluation, gradients and curvature.

pub(crate) mod activation;
pub(crate) mod backprop;
pub(crate) mod curvature;
pub(crate) mod forward;
pub(crate) mod initialisation;
pub(crate) mod network;
pub(crate) mod network_batch;
