//! The discrete element engine of granum: grains in a periodic cell, contact laws, servo control, preparation
//! and loading paths.
//!
//! Sign convention, stated once for the whole project: **compression is positive** for stress, strain, strain
//! rate and normal force. SI units throughout.

pub mod assembly;
pub mod config;
pub mod contact;

mod pairs;
mod team;
pub mod cell;
