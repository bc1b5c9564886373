//! What acts on grains from outside, beside the periodic cell: a plane, a membrane, weight; each is a [`Boundary`], one file.
//!
//! A boundary sees one piece or one body at a time, after the contacts of a step, and answers with a load. The load goes to the body, its
//! power into the work of the boundary, and its stiffness into the choice of the time step. The periodic cell goes on to give the images of
//! grains: a wall stands in a cell that is wide enough for no image to reach it.
//!
//! Stress is that of the contacts between grains: the force between a grain and a boundary has no branch vector, and no part in it.

mod weight;

use std::fmt::Debug;

use crate::assembly::Vector;

pub use weight::Weight;

/// A piece of a grain as a boundary sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedPiece {
    /// Its centre, m.
    pub position: Vector,
    /// Its radius, m.
    pub radius: f64,
    /// Its fluctuating velocity v', m/s: in a cell that is not strained its velocity.
    pub velocity: Vector,
    /// Spin of its body, rad/s.
    pub spin: Vector,
    /// Mass of its body, kg.
    pub mass: f64,
}

/// A grain as a boundary sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedBody {
    /// Its centre of mass, m.
    pub position: Vector,
    /// Its fluctuating velocity v', m/s.
    pub velocity: Vector,
    /// Its mass, kg.
    pub mass: f64,
}

/// What a boundary does to a piece in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Force at the centre of the piece, N.
    pub force: Vector,
    /// Torque about the centre of the piece, N m.
    pub torque: Vector,
    /// Largest stiffness of the contact, N/m, for the time step; zero if there is none.
    pub stiffness: f64,
}

/// Something that acts on grains from outside.
///
/// It answers from what it is given alone, so that results do not depend on when and in what order it is asked. It is no part of a checkpoint:
/// who restores a simulation gives it its boundaries again.
///
/// ```
/// use granum_dem::boundary::{BoundedBody, Boundary};
///
/// /// A drag that grows with the velocity.
/// #[derive(Debug)]
/// struct Drag(f64);
///
/// impl Boundary for Drag {
///     fn name(&self) -> &'static str {
///         "drag"
///     }
///     fn force(&self, body: &BoundedBody) -> [f64; 3] {
///         body.velocity.map(|v| -self.0 * v)
///     }
/// }
/// ```
pub trait Boundary: Debug + Send + Sync {
    /// Its name, for messages.
    fn name(&self) -> &'static str;
    /// What it does to a piece that touches it; `None` if it does not reach it.
    fn load(&self, piece: &BoundedPiece) -> Option<Load> {
        let _ = piece;
        None
    }
    /// The force with which it acts on a body as a whole, at its centre of mass, N.
    fn force(&self, body: &BoundedBody) -> Vector {
        let _ = body;
        [0.0; 3]
    }
}
