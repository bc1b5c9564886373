//! Penalised linear regression with bit-identical results on every computer.

pub(crate) mod cholesky;
pub(crate) mod deviations;
pub(crate) mod spline;
