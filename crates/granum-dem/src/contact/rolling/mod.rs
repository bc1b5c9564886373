//! Laws of the moments of a contact, one file each.

pub mod elastic_plastic;
pub mod none;

pub use elastic_plastic::ElasticPlasticRolling;
pub use none::NoMoments;
