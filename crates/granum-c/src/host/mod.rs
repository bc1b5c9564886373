//! What finite-element programs agree upon, and what they do not: signs, the order of components, how a material is named.

mod component_order;
mod components;
mod configuration;
mod session;
mod session_functions;

pub use component_order::{ComponentOrder, HostIncrement};
pub use components::{components_of, tensor_from};
pub use configuration::{Configuration, InitialStress, MaterialConfiguration, TangentKind};
pub use session::{PointAnswer, PointQuestion, Session};
pub use session_functions::{
    current, granum_points_load, granum_points_message, granum_points_open, granum_points_save, refused,
};
