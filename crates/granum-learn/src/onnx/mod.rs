//! Surrogates as ONNX files, which other programs evaluate without granum: one file for each kind of graph.
//!
//! The list of methods with the form or the reason against it is in the book (`docs/src/onnx.md`).

mod gated_units;
mod graph;
mod interpolated;
pub(crate) mod messages;
mod network;
mod process;
mod refusal;
mod regression;
mod state_space_units;
mod trees;
mod unit;

pub use crate::onnx_export::{IR_VERSION, family_to_bytes, save, save_family, to_bytes};
pub use crate::surrogate::onnx_estimates::{OnnxAnswer, OnnxEstimate};
pub(crate) use crate::surrogate::onnx_estimates::{
    any, inputs, mean_and_variance, outputs, outputs_within, outside, spread, state_ranges,
};
pub(crate) use gated_units::step;
pub use graph::{OPSET, OnnxGraph, Value};
pub(crate) use interpolated::interpolated;
pub(crate) use network::{mean_of_points, network};
pub(crate) use process::{OnnxProcess, ProcessRows, process};
pub use refusal::refused;
pub(crate) use refusal::{MOST_BYTES, too_large};
pub(crate) use regression::{RidgeRow, along};
pub(crate) use trees::sum_of_trees;
pub(crate) use unit::{OnnxUnit, part};
