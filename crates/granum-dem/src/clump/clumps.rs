//! The clumps of a simulation: what moves, which rows are its pieces, and where those are.

use granum_core::geometry::cross;
use granum_core::rotation::{Quaternion, matrix, to_space};
use granum_simd::{Row4, Row8};
use serde::{Deserialize, Serialize};

use super::rotor;
use crate::assembly::{Matrix, Vector};
use crate::cell::Cell;
use crate::particle_row::ParticleRow;

/// Stands for "no clump" in a list of the clumps of rows.
pub(crate) const NO_CLUMP: u32 = u32::MAX;

/// A rigid body of several pieces. Its first two rows of eight numbers are loaded at once by the stage of clumps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub(crate) struct Clump {
    /// Centre of mass X, m.
    pub(crate) centre: Vector,
    pub(crate) mass: f64,
    /// Fluctuating velocity v' of the centre, m/s.
    pub(crate) velocity: Vector,
    /// Volume of the union of the pieces, m3.
    pub(crate) volume: f64,
    /// Rotation from the axes of the body to those of space.
    pub(crate) orientation: Quaternion,
    /// Angular momentum about the centre in the axes of space, kg m2/s.
    pub(crate) momentum: Vector,
    /// Share of the time step of spheres of this mass that it allows.
    pub(crate) time_step_share: f64,
    /// Principal moments of inertia, kg m2.
    pub(crate) inertia: Vector,
    pub(crate) id: u64,
    /// Its pieces: the first, and one past the last.
    pub(crate) pieces: [u32; 2],
}

impl Clump {
    /// Centre, mass, velocity and volume; orientation, angular momentum and share of the time step.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[[f64; 8]; 2] {
        const { assert!(std::mem::offset_of!(Clump, inertia) == 128) };
        // SAFETY: the first sixteen numbers lie one after the other, as the offset of the next field shows.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }

    /// The same for writing.
    #[inline(always)]
    pub(crate) fn rows_mut(&mut self) -> &mut [[f64; 8]; 2] {
        // SAFETY: as above.
        unsafe { &mut *std::ptr::from_mut(self).cast() }
    }

    /// Its spin, rad/s.
    pub(crate) fn spin(&self) -> Vector {
        rotor::spin(&self.orientation, &self.momentum, &self.inertia)
    }
}

/// A piece of a clump.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ClumpPiece {
    /// Its centre in the axes of the body, m.
    pub(crate) centre: Vector,
    /// Its radius, m.
    pub(crate) radius: f64,
    /// Its row among the spheres.
    pub(crate) row: u32,
    /// Edges of the cell from the body's own image to that in which the row is: `x = X + R c + H s`.
    pub(crate) image: [i32; 3],
}

/// The clumps of a simulation, and their pieces in the order of the clumps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Clumps {
    pub(crate) bodies: Vec<Clump>,
    pub(crate) pieces: Vec<ClumpPiece>,
}

impl Clumps {
    pub(crate) fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// The pieces of a clump.
    pub(crate) fn pieces_of(&self, clump: &Clump) -> &[ClumpPiece] {
        &self.pieces[clump.pieces[0] as usize..clump.pieces[1] as usize]
    }

    /// The clump of each row, or [`NO_CLUMP`]; empty if there are no clumps.
    pub(crate) fn of_rows(&self, rows: usize) -> Vec<u32> {
        if self.is_empty() {
            return Vec::new();
        }
        let mut of_rows = vec![NO_CLUMP; rows];
        for (k, clump) in self.bodies.iter().enumerate() {
            for piece in self.pieces_of(clump) {
                of_rows[piece.row as usize] = k as u32;
            }
        }
        of_rows
    }

    /// The arm `R c_0` of each row from the centre of its body, zero for spheres; empty if there are no clumps.
    pub(crate) fn arms(&self, rows: usize) -> Vec<Row4> {
        if self.is_empty() {
            return Vec::new();
        }
        let mut arms = vec![Row4::default(); rows];
        for clump in &self.bodies {
            let rotation = matrix(&clump.orientation);
            for piece in self.pieces_of(clump) {
                let [x, y, z] = to_space(&rotation, &piece.centre);
                arms[piece.row as usize] = Row4([x, y, z, 0.0]);
            }
        }
        arms
    }

    /// Takes the new rows of all pieces after the rows were sorted.
    pub(crate) fn renumber(&mut self, new_place: &[u32]) {
        for piece in &mut self.pieces {
            piece.row = new_place[piece.row as usize];
        }
    }

    /// Puts the clumps into the order of their first rows, which is one in space.
    pub(crate) fn sort(&mut self) {
        let first_row = |clump: &Clump| self.pieces[clump.pieces[0] as usize].row;
        let mut bodies = std::mem::take(&mut self.bodies);
        bodies.sort_unstable_by_key(first_row);
        let mut pieces = Vec::with_capacity(self.pieces.len());
        for clump in &mut bodies {
            let first = pieces.len() as u32;
            pieces.extend_from_slice(&self.pieces[clump.pieces[0] as usize..clump.pieces[1] as usize]);
            clump.pieces = [first, pieces.len() as u32];
        }
        (self.bodies, self.pieces) = (bodies, pieces);
    }

    /// Moves the centres into the cell, after the rows were moved by these numbers of edges: rows and centres stay what they are to each
    /// other.
    pub(crate) fn wrap(&mut self, cell: &Cell, moved: &[[i32; 3]]) {
        for clump in &mut self.bodies {
            let [x, y, z] = clump.centre;
            let mut row = [Row8([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0])];
            let of_centre = crate::images::wrap(cell, &mut row)[0];
            clump.centre.copy_from_slice(&row[0].0[..3]);
            for piece in &mut self.pieces[clump.pieces[0] as usize..clump.pieces[1] as usize] {
                let of_row = moved[piece.row as usize];
                for a in 0..3 {
                    // Positions of a damaged checkpoint can be anywhere.
                    let moved = of_centre[a].saturating_sub(of_row[a]);
                    piece.image[a] = piece.image[a].saturating_add(moved);
                }
            }
        }
    }

    /// Gives the rows of all pieces the velocity and the spin that follow from those of their bodies.
    pub(crate) fn move_rows(&self, gradient: &Matrix, particles: &mut [Row8], spins: &mut [Row4]) {
        for clump in &self.bodies {
            let rotation = matrix(&clump.orientation);
            let spin = clump.spin();
            for piece in self.pieces_of(clump) {
                let arm = to_space(&rotation, &piece.centre);
                let velocity = velocity_of_row(&clump.velocity, &spin, &arm, &arm, gradient);
                particles[piece.row as usize].set_velocity(&velocity);
                spins[piece.row as usize].0[..3].copy_from_slice(&spin);
            }
        }
    }

    /// Scales all masses, and velocities and spins by another factor.
    pub(crate) fn scale(&mut self, masses: f64, velocities: f64) {
        for clump in &mut self.bodies {
            clump.mass *= masses;
            for k in 0..3 {
                clump.inertia[k] *= masses;
                clump.velocity[k] *= velocities;
                clump.momentum[k] *= masses * velocities;
            }
        }
    }

    /// Diameter of the largest ball about the centre of a clump that holds all of it, m; zero without clumps.
    pub(crate) fn longest(&self) -> f64 {
        let reach = |piece: &ClumpPiece| granum_core::geometry::length(&piece.centre) + piece.radius;
        2.0 * self.pieces.iter().map(reach).fold(0.0, f64::max)
    }

    /// Smallest share of the time step of spheres; one without clumps.
    pub(crate) fn time_step_share(&self) -> f64 {
        self.bodies.iter().fold(1.0, |least, clump| clump.time_step_share.min(least))
    }
}

/// The fluctuating velocity of the row of a piece, `v' + omega x c_mean - L c`, m/s: with the part `L x` of every row it is the velocity of
/// the piece.
pub(crate) fn velocity_of_row(
    velocity: &Vector,
    spin: &Vector,
    mean_arm: &Vector,
    arm: &Vector,
    gradient: &Matrix,
) -> Vector {
    let turning = cross(spin, mean_arm);
    let affine = to_space(gradient, arm);
    [
        velocity[0] + turning[0] - affine[0],
        velocity[1] + turning[1] - affine[1],
        velocity[2] + turning[2] - affine[2],
    ]
}
