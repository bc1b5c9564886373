//! What is inferred from: priors, the likelihood of the readings, and what the priors reach.

pub mod likelihood;
pub mod prior;
pub mod reach;
