//! What acts on grains from outside, beside the periodic cell: a plane, a membrane, weight; each is a [`Boundary`], one file.
//!
//! A boundary sees one piece or one body at a time, after the contacts of a step, and answers with a load. The load goes to the body, its
//! power into the work of the boundary, and its stiffness into the choice of the time step. The periodic cell goes on to give the images of
//! grains: a wall stands in a cell that is wide enough for no image to reach it.
//!
//! Stress is that of the contacts between grains: the force between a grain and a boundary has no branch vector, and no part in it.

mod weight;

use std::fmt::Debug;

use granum_core::geometry::{cross, dot};

use crate::assembly::Vector;
use crate::clump::clumps::NO_CLUMP;
use crate::integrator::Integrator;
use crate::particle_row::ParticleRow;
use crate::state::State;

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

impl Integrator {
    /// Adds the loads of the boundaries to the forces of the contacts: those on pieces in the order of the rows, then those on bodies.
    pub(crate) fn add_loads(&mut self) {
        for boundary in &self.boundaries {
            for row in 0..self.state.pieces() {
                let (particle, w) = (&self.state.particles[row], &self.state.spin[row].0);
                let piece = BoundedPiece {
                    position: particle.position(),
                    radius: particle.radius(),
                    velocity: particle.velocity(),
                    spin: [w[0], w[1], w[2]],
                    mass: particle.mass(),
                };
                if let Some(load) = boundary.load(&piece) {
                    add(&mut self.state, row, &load, &piece);
                }
            }
            for row in 0..self.state.pieces() {
                if self.clump_of.get(row).is_none_or(|clump| *clump == NO_CLUMP) {
                    let particle = &self.state.particles[row];
                    let (position, velocity) = (particle.position(), particle.velocity());
                    let body = BoundedBody { position, velocity, mass: particle.mass() };
                    let force = boundary.force(&body);
                    add_at_centre(&mut self.state, row, &force, &velocity, &[0.0; 3]);
                }
            }
            for k in 0..self.state.clumps.bodies.len() {
                let clump = self.state.clumps.bodies[k];
                let row = self.state.clumps.pieces_of(&clump)[0].row as usize;
                let arm = &self.arms[row].0;
                let (position, velocity) = (clump.centre, clump.velocity);
                let force = boundary.force(&BoundedBody { position, velocity, mass: clump.mass });
                add_at_centre(&mut self.state, row, &force, &velocity, &[arm[0], arm[1], arm[2]]);
            }
        }
    }
}

/// Adds a load on a piece.
fn add(state: &mut State, row: usize, load: &Load, piece: &BoundedPiece) {
    let forces = &mut state.pairs.forces[row].0;
    for a in 0..3 {
        forces[a] += load.force[a];
        // Rows hold torques over the radius.
        forces[4 + a] += load.torque[a] / piece.radius;
    }
    state.sums.boundary_power += dot(&load.force, &piece.velocity) + dot(&load.torque, &piece.spin);
    state.sums.fastest = state.sums.fastest.max(load.stiffness / piece.mass);
}

/// Adds a force at the centre of a body, one of whose pieces is in a row at this arm from it: the torque of the force at the piece is taken
/// back.
fn add_at_centre(state: &mut State, row: usize, force: &Vector, velocity: &Vector, arm: &Vector) {
    let radius = state.particles[row].radius();
    let lever = cross(arm, force);
    let forces = &mut state.pairs.forces[row].0;
    for a in 0..3 {
        forces[a] += force[a];
        forces[4 + a] -= lever[a] / radius;
    }
    state.sums.boundary_power += dot(force, velocity);
}

/// Velocity of the point of a piece at an arm from its centre, m/s.
pub fn velocity_at(piece: &BoundedPiece, arm: &Vector) -> Vector {
    let turning = cross(&piece.spin, arm);
    std::array::from_fn(|a| piece.velocity[a] + turning[a])
}
