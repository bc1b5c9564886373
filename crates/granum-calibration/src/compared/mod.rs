//! What is compared: curves of a quantity with their errors, and how samples of one material differ.

pub mod curve;
pub mod quantity;
pub mod sample_scatter;
