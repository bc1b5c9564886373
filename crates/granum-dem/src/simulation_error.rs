//! Reasons why a simulation cannot start or continue.

use crate::contact::choice::law_error::LawError;
use crate::mixture::MixtureError;

/// Reasons why a simulation cannot start or continue.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// There are no grains.
    #[error("a simulation needs at least one grain")]
    NoGrains,
    /// A grain is not usable.
    #[error("grain {id}: {what}")]
    Grain {
        /// Its id.
        id: u64,
        /// What is wrong and what would be right.
        what: String,
    },
    /// The cell has no volume.
    #[error("the cell's volume is {0} m3; it must be positive")]
    Cell(f64),
    /// The laws cannot be combined.
    #[error(transparent)]
    Law(#[from] LawError),
    /// The material is not possible.
    #[error("the material's {name} is {value}; it must be {right}")]
    Material {
        /// The property.
        name: &'static str,
        /// Its value, in SI units.
        value: f64,
        /// The permitted values.
        right: &'static str,
    },
    /// The materials are inconsistent.
    #[error(transparent)]
    Mixture(#[from] MixtureError),
    /// Materials are assigned to another number of grains, or do not exist.
    #[error("{what}")]
    Assignment {
        /// What is wrong and what would be right.
        what: String,
    },
    /// Adhesion beyond the theory of small contacts.
    #[error(
        "adhesion would hold grains of radius {radius:e} m together up to {reach:e} m apart, beyond half the radius, \
         where the theory of small contacts fails: lower interface_energy or raise youngs_modulus"
    )]
    Adhesion {
        /// Smallest radius, m.
        radius: f64,
        /// Distance at which a contact breaks, m.
        reach: f64,
    },
    /// A position, force or stress is no longer a number.
    #[error(
        "the simulation diverged at step {step} (a force or position is not finite): the time step {time_step:e} s is \
         probably too long; lower numerics.time_step_factor"
    )]
    Diverged {
        /// Step at which this was detected.
        step: u64,
        /// Time step, s.
        time_step: f64,
    },
    /// Bonds that cannot be made.
    #[error("bonds: {what}")]
    Bonds {
        /// What is wrong and what would be right.
        what: String,
    },
    /// Grains of several pieces with liquid that bridges share.
    #[error(
        "contact.adhesion = {law:?} keeps liquid in films on spheres, and some grains have several pieces: the film of such a grain belongs to \
         the whole of it; take another law of adhesion, or spheres"
    )]
    LiquidOfClumps {
        /// The law of adhesion.
        law: &'static str,
    },
    /// The cell is too thin for grains of several pieces.
    #[error(
        "the cell is only {height:e} m thick, and a grain of several pieces is {diameter:e} m long: it must be at least twice as thick, so \
         that two images of a grain never touch the same other grain"
    )]
    ThinForClumps {
        /// Smallest height of the cell, m.
        height: f64,
        /// Largest diameter of the sphere about the centre of a grain that holds all of it, m.
        diameter: f64,
    },
    /// The cell became thinner than a grain of several pieces is long.
    #[error(
        "the cell has become only {height:e} m thick, and a grain of several pieces is {diameter:e} m long: it would touch itself across the \
         cell, which is not computed; take more grains"
    )]
    NarrowForClumps {
        /// Smallest height of the cell, m.
        height: f64,
        /// Largest diameter of the sphere about the centre of a grain that holds all of it, m.
        diameter: f64,
    },
    /// The cell became too thin for the grains.
    #[error("the cell is only {height:e} m thick, less than half of the diameter {diameter:e} m of a grain")]
    Thin {
        /// Smallest height of the cell, m.
        height: f64,
        /// Largest diameter, m.
        diameter: f64,
    },
}
