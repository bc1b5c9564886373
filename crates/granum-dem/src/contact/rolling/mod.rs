//! Moment laws of a contact, one file each.

pub mod elastic_plastic;
pub mod elastic_plastic_twisting;
pub mod none;
mod slider;
pub mod spring_dashpot_slider;

pub use elastic_plastic::ElasticPlasticRolling;
pub use elastic_plastic_twisting::ElasticPlasticTwisting;
pub use none::NoMoments;
pub use spring_dashpot_slider::SpringDashpotSlider;
