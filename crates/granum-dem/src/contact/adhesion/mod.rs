//! Adhesion laws in addition to the contact laws, which may act on separated grains, one file each.

pub mod capillary_bridge;
pub mod capillary_bridge_films;
pub mod none;
pub mod van_der_waals;

pub use capillary_bridge::CapillaryBridge;
pub use capillary_bridge_films::CapillaryBridgeFilms;
pub use none::NoAdhesion;
pub use van_der_waals::VanDerWaals;
