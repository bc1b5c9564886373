//! The stages of a step: every contact adds to the force rows of its grains; every grain sums its rows and moves; and before
//! some steps the neighbour list is pruned again to the pairs that need to be evaluated.
//!
//! All stages work on the blocks of the neighbour list, so that their sums do not depend on which thread computed them.
//! [`Views`] gives all threads access to the state during a stage; its `unsafe` code follows the rules of
//! [`crate::team::RawSlice`].

mod choice;
mod contacts;
mod fetch;
mod grains;
mod laws;
mod prune;
mod push;
mod source;

use serde::{Deserialize, Serialize};

use granum_simd::{Isa, LANES, Row4, Row8};

use crate::assembly::Matrix;
use crate::config::Contact;
use crate::contact::PairConstants;
use crate::pairs::{Block, IMAGES, Marks};
use crate::team::RawSlice;

pub(crate) use choice::{Stage, Stages};
pub(crate) use contacts::ContactStage;
pub(crate) use grains::{GrainStage, larger, resultant};
pub(crate) use laws::{AnyLaws, StageLaws, WithMoments};
pub(crate) use prune::{InnerList, Nearness, PruneStage};
pub(crate) use source::{Alike, AlikeOrByBatch, ByBatch, ConstantSource};

/// Number of history columns before those of the laws: the old normal.
pub(crate) const NORMAL_COLUMNS: usize = crate::contact::slots::DIRECTION;

/// Sums over the contacts of a block (or of all blocks).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(64))]
pub struct ContactSums {
    /// `- sum of (elastic force on i)_a (branch)_b`, J: the stress times the volume.
    pub virial: [f64; 9],
    /// Work of the elastic tangential forces in this step, positive where energy is absorbed, J.
    pub tangential_work: f64,
    /// Energy lost to sliding in this step, J.
    pub friction_loss: f64,
    /// Energy lost without sliding in this step, J.
    pub micro_slip_loss: f64,
    /// Energy lost in dashpots in this step, J.
    pub damping_loss: f64,
    /// Energy lost by the formation of contacts in this step, J.
    pub adhesion_made: f64,
    /// Energy lost by the breaking of contacts in this step, J.
    pub adhesion_broken: f64,
    /// Work of the elastic couples in this step, positive where energy is absorbed, J.
    pub moment_work: f64,
    /// The part of it that was dissipated, J.
    pub moment_loss: f64,
    /// Lost in this step where attractions beyond touch begin or end, J.
    pub attraction_loss: f64,
    /// Lost in this step by plastic deformation, J.
    pub plastic_loss: f64,
    /// Power that the deformation of the cell supplies to the contacts, W.
    pub boundary_power: f64,
    /// `sum of k_n D^2`, J.
    pub stiffness: f64,
    /// `sum of |N|` of the elastic normal forces, N.
    pub normal_force: f64,
    /// Largest `k_t / m` of a contact, with the smaller mass of the two, 1/s2.
    pub fastest: f64,
}

impl ContactSums {
    /// Total of the sums of blocks, added in the order of the blocks.
    pub(crate) fn total(blocks: &[ContactSums]) -> ContactSums {
        let mut t = ContactSums::default();
        for c in blocks {
            for a in 0..9 {
                t.virial[a] += c.virial[a];
            }
            t.tangential_work += c.tangential_work;
            t.friction_loss += c.friction_loss;
            t.damping_loss += c.damping_loss;
            t.micro_slip_loss += c.micro_slip_loss;
            t.adhesion_made += c.adhesion_made;
            t.adhesion_broken += c.adhesion_broken;
            t.moment_work += c.moment_work;
            t.moment_loss += c.moment_loss;
            t.attraction_loss += c.attraction_loss;
            t.plastic_loss += c.plastic_loss;
            t.boundary_power += c.boundary_power;
            t.stiffness += c.stiffness;
            t.normal_force += c.normal_force;
            t.fastest = t.fastest.max(c.fastest);
        }
        t
    }
}

/// The arrays of the state that the threads share during the stages of a step.
#[derive(Clone, Copy)]
pub(crate) struct Views {
    pub(crate) grains: usize,
    pub(crate) particles: RawSlice<Row8>,
    pub(crate) spin: RawSlice<Row4>,
    pub(crate) blocks: RawSlice<Block>,
    pub(crate) first: RawSlice<[u32; LANES]>,
    pub(crate) second: RawSlice<[u32; LANES]>,
    pub(crate) target: RawSlice<[u32; LANES]>,
    pub(crate) image: RawSlice<[u32; LANES]>,
    pub(crate) memory: RawSlice<Row8>,
    pub(crate) marks: RawSlice<Marks>,
    /// Working memory of the pruning stage.
    pub(crate) nearness: RawSlice<Nearness>,
    /// Number of columns of a contact history.
    pub(crate) columns: usize,
    pub(crate) constants: RawSlice<Row8>,
    pub(crate) forces: RawSlice<Row8>,
    pub(crate) outer_offsets: RawSlice<u32>,
    pub(crate) outer: RawSlice<u32>,
    pub(crate) contact_sums: RawSlice<ContactSums>,
    pub(crate) fastest_grain: RawSlice<f64>,
    /// True where all grains have the same mass and radius.
    pub(crate) equal: bool,
    /// True where the contact data do not fit into the caches.
    pub(crate) far: bool,
    pub(crate) alike: PairConstants<f64>,
    /// Number of rows of constants of a batch.
    pub(crate) constants_kept: usize,
    pub(crate) laws: Contact,
    pub(crate) isa: Isa,
    pub(crate) images: [Row4; IMAGES],
    pub(crate) gradient: Matrix,
    pub(crate) dt: f64,
    /// Pairs with a gap below this belong to the inner list, m.
    pub(crate) inner_skin: f64,
    /// Largest distance of the surfaces at which grains that do not touch act on each other, m.
    pub(crate) range: f64,
    /// Weight of the energy of discarded histories in this step; zero where it is not evaluated.
    pub(crate) sampling_weight: f64,
    /// Factor on velocities and spins in a step: 1 without global damping.
    pub(crate) retain: f64,
}
