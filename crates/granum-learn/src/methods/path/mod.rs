//! Surrogates with a state for any path of strain: they learn the change for an increment, and are rolled out freely along whole paths.
//!
//! The path are the columns of strain (`axial_strain`, `lateral_strain_2`, `lateral_strain_3`, `shear_strain_yz`, `_zx`, `_xy`), of which the increments
//! between the rows of a run count, or any other inputs that vary along a run. If `volumetric_strain` is an output, only the deviator of the increment is an
//! input. Inputs that are constant in a run describe the sample: `sample.X` is the value of the output `X` before the first row. Six outputs `X_11`, `X_22`,
//! `X_33`, `X_23`, `X_13`, `X_12` are one tensor, if there are strains.
//!
//! All methods predict from the predicted state, never from a measured one; runs have any lengths and are not padded, and the first row is
//! predicted as all others. One network is trained for each part of the runs, as by [`super::Recurrent`]; their errors on
//! the runs that they were not trained on give intervals that grow along the path (`errors.rs`).
//!
//! **Objectivity.** A sample without a direction of its own answers a turned path by a turned stress. `path-tensor` does so by construction, whatever its
//! weights are. The other networks see each run in [`PathNetworks::rotations`] further random rotations, and predict the mean over the 24 rotations that
//! permute and mirror the axes, so that at least these change nothing.

mod cell;
mod channels;
mod errors;
mod fitted;
mod growth;
mod method;
mod onnx_form;
mod onnx_rotations;
mod onnx_terms;
mod path_surrogate;
mod rotation;
mod runs;
mod sample_places;
mod steps;
mod tensor_channel;
#[cfg(test)]
mod tests;

pub use cell::PathCell;
pub(crate) use channels::{STRAINS, SUFFIXES};
pub use method::PathNetworks;
pub(crate) use rotation::{COMPONENTS, parts as deviator};
