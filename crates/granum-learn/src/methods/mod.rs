//! The methods by which surrogates are fitted, one file or folder each, and their registry.

pub(crate) mod boosted_trees;
pub(crate) mod cascade;
pub(crate) mod cascade_onnx;
pub(crate) mod curve_process;
pub(crate) mod feed_forward;
pub(crate) mod left_out_errors;
pub(crate) mod mean_curve;
#[cfg(test)]
mod memory_tests;
pub(crate) mod method_words;
pub(crate) mod nearest_run;
pub(crate) mod neighbours;
pub mod networks;
pub(crate) mod networks_of_parts;
pub(crate) mod onnx_memory;
pub(crate) mod path;
pub(crate) mod recurrent;
pub(crate) mod recurrent_onnx;
pub(crate) mod recurrent_steps;
pub(crate) mod registry;
pub(crate) mod ridge;
pub(crate) mod scatter_of_networks;
#[cfg(test)]
mod tests;

pub use boosted_trees::BoostedTrees;
pub use cascade::{Cascade, FittedCascade};
pub(crate) use curve_process::onnx_curves;
pub use curve_process::{
    CorrelatedCurve, EndedEarly, ErrorCorrelation, FittedCurves, FurtherRun, GaussianProcessOfCurves,
    LeftOutCurves, NextRuns,
};
pub use feed_forward::FeedForward;
pub use mean_curve::MeanCurve;
pub use method_words::method_of_words;
pub use nearest_run::NearestRun;
pub(crate) use path::{COMPONENTS, STRAINS, SUFFIXES, deviator};
pub use path::{PathCell, PathNetworks};
pub use recurrent::Recurrent;
pub use registry::SurrogateMethods;
pub(crate) use ridge::FittedRidge;
pub use ridge::RidgeRegression;
