//! Surrogates as ONNX files, which other programs evaluate without granum: one file for each kind of graph.
//!
//! The list of methods with the form or the reason against it is in the book (`docs/src/onnx.md`).

mod estimates;
mod export;
mod graph;
mod messages;
mod network;
mod recurrent_unit;
mod refusal;
mod regression;

pub(crate) use estimates::{OnnxEstimate, any, inputs, outputs, outside, spread, state_ranges};
pub use export::{IR_VERSION, save, to_bytes};
pub use graph::{OPSET, OnnxGraph, Value};
pub(crate) use network::{mean_of_points, network};
pub(crate) use recurrent_unit::step;
pub use refusal::refused;
pub(crate) use regression::{RidgeRow, along};
