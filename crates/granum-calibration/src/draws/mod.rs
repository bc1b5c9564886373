//! Draws from a distribution that is known but for a factor: chains, importance sampling, and whether the draws are enough.

pub mod chains;
pub mod chi_square;
pub mod diagnostics;
pub(crate) mod random;
pub mod sequential;
