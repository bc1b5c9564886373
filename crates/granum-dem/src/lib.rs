//! The discrete element engine of granum: grains in a periodic cell, contact laws, servo control, preparation
//! and loading paths.
//!
//! Sign convention, stated once for the whole project: **compression is positive** for stress, strain, strain
//! rate and normal force. SI units throughout.

pub mod body_insertion;
pub mod bond;
pub mod boundary;
pub mod checkpoint;
mod clump;
pub mod config;
pub mod contact;
pub mod contact_history;
pub mod invariants;
pub mod loading;
pub mod material;
pub mod mixture;
pub mod observer;
pub mod preparation;
mod random;
pub mod random_insertion;
pub mod servo;
pub mod simulation;
pub mod sizes;
pub mod state;

mod assembly_of_state;
mod blocks;
mod boundary_loads;
mod contact_sums;
mod discarded;
mod grain_shapes;
mod hardware;
mod images;
mod initial_body;
mod initial_sphere;
mod inner_list;
mod integrator;
mod kernel;
mod known_constants;
mod ledger;
mod liquid;
mod observed_pairs;
mod pair_table;
mod pairs;
mod particle_row;
mod properties;
mod rows;
mod saved_properties;
mod search;
mod simulation_error;
mod slices;
mod stepping;
mod team;

pub use clump::time_step::time_step_share;
pub use granum_core::{assembly, cell};
pub use granum_shape as shape;
pub use granum_simd::Isa;
