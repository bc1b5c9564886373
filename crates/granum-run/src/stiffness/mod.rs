//! Small-strain stiffness: the response of a state to small strains, measured on copies of it.
//!
//! A copy of the simulation comes to rest in a fixed cell under global damping. Each of the six components of strain is then
//! applied to two further copies, forward and backward, and these relax in lockstep until the difference of their stresses no
//! longer changes. Column j of the tensor is that difference over twice the strain, so that residual creep, which is common to both,
//! cancels, and so does the curvature of the contact law. The simulation itself is not changed: a run continues with the same bits.
//!
//! By default friction is raised on the copies to [`FROZEN`], so that no contact slides and the response is elastic; without
//! that, contacts at the limit of friction slide, and the result is a tangent stiffness that depends on the size of the strain.
//! Limits of rolling resistance are not changed, since the rolling stiffness depends on the same parameter.
//!
//! The affine tensor, from the stress after a single step in which every grain follows the strain of the cell, is the mean-field
//! estimate from the stiffness of every contact (Walton 1987 gives it for the mean contact); the difference between the two
//! tensors is due to the non-affine motion of the grains.

mod degradation;
mod probing;
mod series;
mod tensor;

pub use degradation::{Degradation, degradation, degradation_table};
pub use probing::{FROZEN, Probing, Stiffness, StiffnessError, measure};
pub use series::{Probed, Probes, table};
pub use tensor::Tensor;

#[cfg(test)]
mod tests;
