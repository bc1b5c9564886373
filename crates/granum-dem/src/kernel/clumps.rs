//! The stage of clumps: sums the forces on the pieces of every clump, advances it, and puts its pieces to their new places.

use std::ops::Range;

use granum_core::geometry::cross;
use granum_core::rotation::{matrix, to_space};
use granum_simd::{Kernel, Lanes, Row4};

use super::grains::larger;
use super::views::Views;
use crate::assembly::Vector;
use crate::clump::clumps::{Clump, ClumpPiece, velocity_of_row};
use crate::clump::rotor;
use crate::pairs::resultant;
use crate::particle_row::ParticleRow;

/// The stage of clumps for a range of blocks: each block moves a share of the clumps.
pub(crate) struct ClumpStage<'a> {
    pub(crate) views: &'a Views,
    pub(crate) blocks: Range<usize>,
}

impl Kernel for ClumpStage<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        let (blocks, clumps) = (v.blocks.len(), v.clumps.len());
        for k in self.blocks {
            let range = k * clumps / blocks..(k + 1) * clumps / blocks;
            let mut fastest = 0.0f64;
            // SAFETY: a clump belongs to one block, and a block to the thread that works on it.
            for clump in unsafe { v.clumps.write(range) } {
                // SAFETY: pieces are only read in this stage.
                let pieces =
                    unsafe { &v.clump_pieces.read()[clump.pieces[0] as usize..clump.pieces[1] as usize] };
                let [force, moment] = loads::<L>(v, pieces);
                fastest = larger(fastest, advance(v, clump, pieces, &force, &moment));
            }
            // SAFETY: only this thread works on this block.
            let of_block = unsafe { &mut v.fastest_grain.write(k..k + 1)[0] };
            *of_block = larger(*of_block, fastest);
        }
    }
}

/// Force on a clump and moment about its centre.
#[inline(always)]
fn loads<L: Lanes>(v: &Views, pieces: &[ClumpPiece]) -> [Vector; 2] {
    let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
    for piece in pieces {
        let row = piece.row as usize;
        // SAFETY: forces and lists are only read in this stage; the rows of a piece are written by the thread of its clump alone.
        let (total, arm, radius) = unsafe {
            (
                resultant::<L>(v.forces.read(), v.outer_offsets.read(), v.outer.read(), row),
                v.arms.write(row..row + 1)[0].0,
                v.particles.write(row..row + 1)[0].radius(),
            )
        };
        let lever = cross(&[arm[0], arm[1], arm[2]], &[total[0], total[1], total[2]]);
        for a in 0..3 {
            force[a] += total[a];
            moment[a] += radius * total[4 + a] + lever[a];
        }
    }
    [force, moment]
}

/// Kick and drift of a clump; returns the square of the largest fluctuating velocity of its pieces.
#[inline(always)]
fn advance(v: &Views, clump: &mut Clump, pieces: &[ClumpPiece], force: &Vector, moment: &Vector) -> f64 {
    let dt = v.dt;
    for a in 0..3 {
        clump.velocity[a] = clump.velocity[a] * v.retain + dt / clump.mass * force[a];
        clump.momentum[a] = clump.momentum[a] * v.retain + dt * moment[a];
    }
    let affine = to_space(&v.gradient, &clump.centre);
    for a in 0..3 {
        clump.centre[a] += dt * (clump.velocity[a] + affine[a]);
    }
    let before = clump.orientation;
    clump.orientation = rotor::turned(&before, &clump.momentum, &clump.inertia, dt);
    let spin = rotor::mean_spin(&before, &clump.orientation, dt);
    let rotation = matrix(&clump.orientation);
    let mut fastest = 0.0f64;
    for piece in pieces {
        let row = piece.row as usize;
        // SAFETY: the rows of a piece are written by the thread of its clump alone.
        let (particle, spins, old) = unsafe {
            (
                &mut v.particles.write(row..row + 1)[0],
                &mut v.spin.write(row..row + 1)[0],
                &mut v.arms.write(row..row + 1)[0],
            )
        };
        let arm = to_space(&rotation, &piece.centre);
        let middle = [0.5 * (old.0[0] + arm[0]), 0.5 * (old.0[1] + arm[1]), 0.5 * (old.0[2] + arm[2])];
        let velocity = velocity_of_row(&clump.velocity, &spin, &middle, &arm, &v.gradient);
        let [i, j, k] = piece.image;
        let image = to_space(&v.edges, &[f64::from(i), f64::from(j), f64::from(k)]);
        for a in 0..3 {
            particle.0[a] = clump.centre[a] + arm[a] + image[a];
            particle.0[4 + a] = velocity[a];
            spins.0[a] = spin[a];
        }
        *old = Row4([arm[0], arm[1], arm[2], 0.0]);
        let [x, y, z] = velocity;
        fastest = larger(fastest, x * x + y * y + z * z);
    }
    fastest
}
