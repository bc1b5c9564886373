//! The loads of boundaries, which are added to the forces of the contacts.

use granum_core::geometry::{cross, dot};

use crate::assembly::Vector;
use crate::boundary::{BoundedBody, BoundedPiece, Load};
use crate::clump::clumps::NO_CLUMP;
use crate::integrator::Integrator;
use crate::particle_row::ParticleRow;
use crate::state::State;

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
