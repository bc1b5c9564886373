//! Products of matrices, their factorisation and inverse, and the minimum of a smooth function, with the same bits on every machine.

pub(crate) mod eigenvectors;
pub(crate) mod inverse;
pub(crate) mod kernels;
pub(crate) mod minimise;
pub(crate) mod symmetric;
