//! Definition of a contact law: a normal, a tangential, a moment or an adhesion law, with its description, the constants that it
//! prepares for a pair, its history, its energy channels and its stiffness.
//!
//! A law is written once over [`Real`](granum_simd::Real) and runs on one pair (`f64`), on eight side by side or on two times eight.

pub mod adhesion;
pub mod constants;
pub mod description;
pub mod elementary;
pub mod energy_channel;
pub mod limits;
pub mod moment;
pub mod normal;
pub mod pair_properties;
pub mod tangential;

pub use adhesion::{AdhesionLaw, Attraction};
pub use moment::{Moment, MomentLaw, RelativeSpin};
pub use normal::{AdhesionLosses, Normal, NormalLaw, NormalTraits};
pub use tangential::{Tangential, TangentialLaw};
