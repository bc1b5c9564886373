//! Moment laws of a contact, one file each.

pub mod elastic_plastic;
pub mod elastic_plastic_twisting;
pub mod none;
mod slider;

pub use elastic_plastic::ElasticPlasticRolling;
pub use elastic_plastic_twisting::ElasticPlasticTwisting;
pub use none::NoMoments;
