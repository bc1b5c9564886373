//! The posterior: its values, what it predicts, whether it explains the tests, and whether its intervals hold.

pub mod band;
pub mod confirmation;
pub mod coverage;
pub mod fit;
pub mod outcome;
pub mod prediction;
