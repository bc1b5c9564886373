//! The study of Antony, Zhou and Wang (2006): its runs, what is measured of its claims, its summary and figures.

pub mod figures;
pub mod interpretation;
pub mod learning_curve;
pub mod reproduction;
pub mod size_study;
pub mod speed;
pub mod sufficiency;
pub mod summary;
