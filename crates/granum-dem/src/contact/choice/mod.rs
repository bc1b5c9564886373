//! The choice of the laws of a simulation: laws as values, by their names, with the values of their parameters.

pub mod check;
pub mod contact_model;
pub mod kind;
pub mod law_error;
pub mod parameters;
pub mod registry;
