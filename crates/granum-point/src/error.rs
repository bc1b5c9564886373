//! Reasons why a material point gives no answer.

use granum_dem::checkpoint::CheckpointError;
use granum_dem::loading::ControlError;
use granum_dem::simulation::SimulationError;
use granum_learn::LearnError;
use granum_run::LaboratoryError;
use granum_run::stiffness::StiffnessError;

/// Reasons why a material point gives no answer. After each of them the state that was asked is as it was.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PointError {
    /// A control is not possible.
    #[error("the {name} of a material point is {value:e}; it must be {wanted}")]
    Control {
        /// The control.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The permitted values.
        wanted: &'static str,
    },
    /// A number of an increment or of a stress is infinite or not a number.
    #[error("{what} has a component that is not a finite number")]
    NotFinite {
        /// What has it.
        what: &'static str,
    },
    /// A matrix is no deformation of a body.
    #[error("the deformation gradient has the determinant {determinant:e}; it must be positive")]
    Deformation {
        /// The determinant.
        determinant: f64,
    },
    /// A matrix is no rotation.
    #[error(
        "the rotation of an increment differs from an orthogonal matrix without reflection by {difference:e}; at most 1e-6 is \
         permitted"
    )]
    Rotation {
        /// Largest entry of the difference.
        difference: f64,
    },
    /// An increment is larger than the point permits.
    #[error(
        "the increment has a strain of {size:.3e}, and this point permits {limit:.3e} at once: take a smaller step"
    )]
    TooLarge {
        /// Its size, `sqrt(2/3 e:e)` of all of the strain.
        size: f64,
        /// The largest one.
        limit: f64,
    },
    /// An increment needs more steps than the point permits.
    #[error(
        "the increment needs about {needed:.3e} steps, and this point permits {limit}: take a smaller increment, a larger \
         inertial number, or allow more steps"
    )]
    TooLong {
        /// Estimated number of steps.
        needed: f64,
        /// The largest number.
        limit: u64,
    },
    /// The cell has become too thin for its grains.
    #[error(
        "after this increment the cell is only {heights:.2} mean diameters thick, and at least {limit} are needed: a periodic \
         cell cannot be sheared or flattened without end"
    )]
    Thin {
        /// Smallest distance of two opposite faces over the mean diameter.
        heights: f64,
        /// The smallest permitted value.
        limit: f64,
    },
    /// Grains overlap too far.
    #[error(
        "after this increment grains overlap by {overlap:.3} of the sum of their radii, more than the {limit} up to which the \
         theory of small contacts is used"
    )]
    TooDeep {
        /// Largest overlap over the sum of the radii.
        overlap: f64,
        /// The largest permitted one.
        limit: f64,
    },
    /// An imposed stress was not reached.
    #[error(
        "the sample cannot be brought to the stress that is imposed on it: the largest difference is {difference:.3e} Pa with a \
         mean stress of {mean_stress:.3e} Pa; a stress ratio beyond the strength of the sample, or tension, cannot be carried"
    )]
    StressNotReached {
        /// Largest difference of a component, Pa.
        difference: f64,
        /// Mean stress that is imposed, Pa.
        mean_stress: f64,
    },
    /// A surrogate is not that of a material point.
    #[error(
        "a surrogate of the method {method} cannot stand for a material point: {reason}; it must have a memory, the six strains (axial_strain, \
         lateral_strain_2, lateral_strain_3, shear_strain_yz, shear_strain_zx, shear_strain_xy) among its inputs and the six stresses (stress_11, \
         stress_22, stress_33, stress_23, stress_13, stress_12) among its outputs"
    )]
    NoMaterial {
        /// Its method.
        method: String,
        /// The reason.
        reason: String,
    },
    /// A surrogate is asked for what only grains can do.
    #[error("{what} needs grains, and the stress of this point is predicted by a surrogate: {instead}")]
    NoGrains {
        /// What was asked.
        what: &'static str,
        /// What can be asked instead.
        instead: &'static str,
    },
    /// A state is of the other kind than the point.
    #[error("the state is of a point of {state}, and this is a point of {point}")]
    OtherKind {
        /// What the state consists of.
        state: &'static str,
        /// What the point consists of.
        point: &'static str,
    },
    /// The surrogate has no answer.
    #[error(transparent)]
    Surrogate(#[from] LearnError),
    /// The caller stopped it.
    #[error("the increment was stopped by its caller; no state was made of it")]
    Stopped,
    /// The engine failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The stress cannot be controlled.
    #[error(transparent)]
    Loading(#[from] ControlError),
    /// The stiffness cannot be measured.
    #[error(transparent)]
    Stiffness(#[from] StiffnessError),
    /// The sample cannot be made.
    #[error(transparent)]
    Sample(#[from] Box<LaboratoryError>),
    /// The state cannot be written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
}
