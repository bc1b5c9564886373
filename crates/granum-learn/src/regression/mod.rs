//! Penalised linear regression with the same bits on every machine.

pub(crate) mod cholesky;
pub(crate) mod deviations;
pub(crate) mod spline;
