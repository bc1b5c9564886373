//! Common types of granum: a periodic [`cell`], an [`assembly`] of grains and contacts at one moment, [`energy`] by mechanism, tables of
//! named columns, [`quantity`] with units, the nearest name to one that is not
//! known, why a registry refuses an addition, [`words`] in sentences, one [`digest`], [`input`] files, [`json`] that can be read, [`parallel`] work, and one [`observer`] of long work.
//!
//! Sign convention, stated once for the whole project: **compression is positive** for stress, strain, strain
//! rate and normal force. SI units throughout.

pub mod assembly;
pub mod cell;
pub mod clock;
pub mod digest;
pub mod energy;
pub mod geometry;
pub mod input;
pub mod json;
pub mod names;
mod observed_state;
pub mod observer;
pub mod parallel;
mod parts;
pub mod quantity;
mod registration;
pub mod rotation;
mod table;
pub mod words;

pub use assembly::Assembly;
pub use cell::Cell;
pub use observed_state::{MacroState, ObservedState};
pub use parts::{Part, Parts};
pub use registration::RegistrationError;
pub use table::{Column, ColumnKind, Table, TableError};
