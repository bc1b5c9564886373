//! Penalised linear regression with bit-identical results on every computer.

pub mod boosting;
pub mod cholesky;
pub mod deviations;
pub mod independent;
pub mod spline;
