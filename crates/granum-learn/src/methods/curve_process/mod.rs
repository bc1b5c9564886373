//! Gaussian processes of whole curves: each output of a test is a curve over the coordinate, a weighted sum of a few principal
//! components, and each weight is a smooth function of what is constant in a run: the properties of the grains, the sample, the stress.
//!
//! ```text
//! y(x, s) = y_0 + m(s) + sum_j t_j(x) v_j(s) + noise
//! ```
//!
//! with the coordinate `s`, the other inputs `x`, the mean `m` of the training curves, their principal components `v_j`, and a Gaussian
//! process ([`granum_nets::gaussian_process`]) for each weight `t_j`. If the value of an output on the sample is an input
//! (`sample.NAME`), it is `y_0`, and the curve starts there.
//!
//! If all bins of a histogram are outputs, such as those of the distribution of contact forces, it is predicted as a whole: normalised, nowhere
//! negative, and with the mean one (`densities`).
//!
//! The variance of a new run about the mean has two parts: that of the processes, which more runs would reduce (`parameters`), and
//! that of a single run, which they would not (`noise`): the noise of the processes, and the part of the training curves that the
//! components do not contain. Intervals are these standard deviations times a factor, which is chosen on whole training runs, each
//! predicted by what was fitted to others (conformal calibration): for intervals of single states, and for bands that contain a whole curve. It is
//! larger where training runs were missed by more, and outside of the combinations of inputs that they have (`local_calibration`).

mod calibration;
mod components;
mod corners;
mod curve_surrogate;
mod densities;
mod error_size;
mod failure;
mod fitted;
mod fitting;
mod further_run;
mod groups;
mod joint;
mod kept_curve;
mod left_out;
mod left_out_curves;
mod local_calibration;
mod method;
mod next_runs;
mod onnx_densities;
mod onnx_form;
mod orthogonal_hull;
mod predicted_curve;
mod prepared;
mod reach;
mod root;
mod run_curves;
mod start_memory;
#[cfg(test)]
mod tests;

pub(super) use calibration::Calibration;
pub(super) use error_size::ErrorSize;
pub use fitted::{CorrelatedCurve, FittedCurves};
pub use further_run::FurtherRun;
pub(super) use groups::{Group, groups_of};
pub use joint::ErrorCorrelation;
pub use left_out_curves::LeftOutCurves;
pub use method::GaussianProcessOfCurves;
pub use next_runs::NextRuns;
pub(crate) use onnx_form::onnx_curves;
pub use reach::EndedEarly;
pub(super) use run_curves::{RunCurve, common_points};
