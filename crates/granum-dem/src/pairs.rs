//! The neighbour list, in batches of eight pairs, with the histories of their contacts.
//!
//! Pairs within `R_i + R_j + skin` are listed. The list is valid while no pair outside it can have come to touch
//! ([`crate::simulation`] checks this), and is then rebuilt by [`crate::blocks`]; each history is carried over with its
//! pair.

use granum_simd::{LANES, Lanes, Row8};
use serde::{Deserialize, Serialize};

use crate::cell::Cell;
use crate::contact::evaluation::memory::Memory;
use crate::particle_row::ParticleRow;
use crate::rows;
use granum_core::geometry::{apply, invert};

/// Number of history columns before those of the laws: the old normal.
pub(crate) const NORMAL_COLUMNS: usize = crate::contact::slot::slots::DIRECTION;

/// A range of grains and the pairs whose first grain is in it: the unit of work of a thread.
///
/// A pair adds its force directly to the rows of its two grains. For grains of other blocks a block has rows of its own, and
/// those grains sum the rows of the blocks in the order of the blocks: no two threads write the same row, and no sum depends
/// on the thread that computed it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    /// First grain, and one past the last.
    pub(crate) grains: [u32; 2],
    /// First batch, one past the last within the cell, one past the last (the later ones have images).
    pub(crate) batches: [u32; 3],
    /// One past the last batch of the inner list, within the cell and among those with images.
    pub(crate) inner_ends: [u32; 2],
    /// Number of batches, from the first, that had a contact in every lane when the pairs were sorted.
    pub(crate) touching: u32,
    /// First row of forces on grains of other blocks, and one past the last.
    pub(crate) outer: [u32; 2],
}

/// State of the pairs of a batch in its last step, one bit for each lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Marks {
    /// Pairs that touched.
    pub(crate) touched: u8,
    /// Pairs that slid.
    pub(crate) sliding: u8,
    /// On which pairs a law of adhesion acted, touching or not.
    pub(crate) attracting: u8,
    /// Pairs whose bridge ruptured in this step, or that began to touch without one, so that liquid is exchanged after it; none
    /// between two steps.
    #[serde(skip)]
    pub(crate) changed: u8,
}

/// Pairs in batches, their histories and their forces on the grains in the last step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pairs {
    /// Number of pairs. The remaining lanes of the last batch of a group pair a grain of the block with the distant phantom.
    pub(crate) count: usize,
    /// Blocks, in the order of the grains.
    pub(crate) blocks: Vec<Block>,
    /// Index of grain i, by batch and lane; its force row has the same index.
    pub(crate) first: Vec<[u32; LANES]>,
    /// Index of grain j.
    pub(crate) second: Vec<[u32; LANES]>,
    /// Force row of grain j.
    pub(crate) target: Vec<[u32; LANES]>,
    /// Code of the image of j.
    pub(crate) image: Vec<[u32; LANES]>,
    /// Columns of memory, by batch: the old normal (3), the tangential law's history, that of the law of moments, that of the
    /// law of adhesion, that of the normal law.
    #[serde(with = "rows::eight")]
    pub(crate) memory: Vec<Row8>,
    /// Number of columns of memory: of the old normal and the tangential law, of the law of moments, of the law of adhesion, of the
    /// normal law.
    pub(crate) columns: [usize; 4],
    /// State of the lanes of a batch in the last step.
    pub(crate) marks: Vec<Marks>,
    /// Constants by batch, where grains differ; empty where all pairs are equal.
    #[serde(with = "rows::eight")]
    pub(crate) constants: Vec<Row8>,
    /// Force (entries 0..3) and torque over radius (4..7) of the last step: one row for every grain with the contribution of
    /// its own block, then the rows of the blocks for grains of other blocks.
    #[serde(with = "rows::eight")]
    pub(crate) forces: Vec<Row8>,
    /// The rows of other blocks for grain g are `outer[outer_offsets[g]..outer_offsets[g + 1]]`.
    pub(crate) outer_offsets: Vec<u32>,
    /// Indices of rows of forces.
    pub(crate) outer: Vec<u32>,
}

impl Pairs {
    /// Number of batches.
    pub(crate) fn batches(&self) -> usize {
        self.first.len()
    }

    /// Number of history columns of a batch.
    pub(crate) fn columns_in_all(&self) -> usize {
        self.columns.iter().sum()
    }

    /// History column `c` of batch `b`.
    pub(crate) fn column(&self, b: usize, c: usize) -> &[f64; LANES] {
        &self.memory[b * self.columns_in_all() + c].0
    }

    /// The contact history in a slot.
    pub(crate) fn memory(&self, slot: usize) -> Memory<f64> {
        let mut memory = Memory::new();
        self.read_memory(slot, &mut memory);
        memory
    }

    /// Reads the contact history in a slot. The columns that no law uses are left as they are.
    #[inline(always)]
    pub(crate) fn read_memory(&self, slot: usize, memory: &mut Memory<f64>) {
        let (b, l) = (slot / LANES, slot % LANES);
        let all = self.columns_in_all();
        let mut rows = self.memory[b * all..(b + 1) * all].iter();
        let [of_contact, moments, adhesion, loading] = self.columns;
        let mut fill = |values: &mut [f64], count: usize| {
            for (value, row) in values.iter_mut().zip(rows.by_ref().take(count)) {
                *value = row.0[l];
            }
        };
        fill(&mut memory.normal, NORMAL_COLUMNS);
        fill(&mut memory.history, of_contact - NORMAL_COLUMNS);
        fill(&mut memory.moments, moments);
        fill(&mut memory.adhesion, adhesion);
        fill(&mut memory.loading, loading);
    }

    /// Reads the histories of a batch. The columns that no law uses are left as they are.
    #[inline(always)]
    pub(crate) fn read_batch(&self, b: usize, memory: &mut Memory<Row8>) {
        let all = self.columns_in_all();
        let mut rows = &self.memory[b * all..(b + 1) * all];
        let [of_contact, moments, adhesion, loading] = self.columns;
        for (to, count) in [
            (&mut memory.normal[..], NORMAL_COLUMNS),
            (&mut memory.history[..], of_contact - NORMAL_COLUMNS),
            (&mut memory.moments[..], moments),
            (&mut memory.adhesion[..], adhesion),
            (&mut memory.loading[..], loading),
        ] {
            let (part, rest) = rows.split_at(count);
            to[..count].copy_from_slice(part);
            rows = rest;
        }
    }

    pub(crate) fn set_memory(&mut self, slot: usize, memory: &Memory<f64>) {
        let (b, l) = (slot / LANES, slot % LANES);
        let history = self.columns[0] - NORMAL_COLUMNS;
        let of_contact = memory.normal.iter().chain(&memory.history[..history]);
        let others = memory.moments[..self.columns[1]].iter().chain(&memory.adhesion[..self.columns[2]]);
        let values = of_contact.chain(others).chain(&memory.loading[..self.columns[3]]);
        let first = b * self.columns_in_all();
        for (row, value) in self.memory[first..].iter_mut().zip(values) {
            row.0[l] = *value;
        }
    }

    /// True if the pair in this slot touched in the last step.
    pub(crate) fn touched(&self, slot: usize) -> bool {
        self.marks[slot / LANES].touched >> (slot % LANES) & 1 != 0
    }

    /// True if it slid.
    pub(crate) fn sliding(&self, slot: usize) -> bool {
        self.marks[slot / LANES].sliding >> (slot % LANES) & 1 != 0
    }

    /// Number of contacts in the last step.
    pub(crate) fn contacts(&self) -> usize {
        self.marks.iter().map(|m| m.touched.count_ones() as usize).sum()
    }

    /// True if a law of adhesion acted on the pair in this slot in the last step.
    pub(crate) fn attracting(&self, slot: usize) -> bool {
        self.marks[slot / LANES].attracting >> (slot % LANES) & 1 != 0
    }

    /// Slots of the pairs that do not touch, but act on each other at a distance.
    pub(crate) fn apart(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.batches() * LANES).filter(|&slot| self.attracting(slot) && !self.touched(slot))
    }

    /// Slots of the pairs that remember something: they touched, or acted on each other at a distance.
    pub(crate) fn remembering(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.batches() * LANES).filter(|&slot| self.touched(slot) || self.attracting(slot))
    }

    /// Slots of the pairs that touched in the last step.
    pub(crate) fn touching(&self) -> impl Iterator<Item = usize> + '_ {
        let batches = self.marks.iter().enumerate().filter(|(_, marks)| marks.touched != 0);
        batches.flat_map(|(b, marks)| {
            (0..LANES).filter(|l| marks.touched >> l & 1 != 0).map(move |l| b * LANES + l)
        })
    }
}

/// Sum of the force rows of a grain: force (entries 0..3) and torque over radius (4..7).
#[inline(always)]
pub(crate) fn resultant<L: Lanes>(forces: &[Row8], offsets: &[u32], outer: &[u32], g: usize) -> [f64; 8] {
    let mut total = [0.0; 8];
    resultant_lanes::<L>(forces, offsets, outer, g).store(&mut total);
    total
}

/// The same in a register.
#[inline(always)]
pub(crate) fn resultant_lanes<L: Lanes>(forces: &[Row8], offsets: &[u32], outer: &[u32], g: usize) -> L {
    let mut sum = L::load(&forces[g].0);
    for &row in &outer[offsets[g] as usize..offsets[g + 1] as usize] {
        sum = sum + L::load(&forces[row as usize].0);
    }
    sum
}

/// Order of grains along a space-filling (Morton) curve: `order[new index] = old index`.
pub(crate) fn spatial_order(cell: &Cell, particles: &[Row8], spacing: f64) -> Vec<u32> {
    let inverse = invert(&cell.edges);
    let counts = cell.heights().map(|h| (h / spacing).floor().clamp(1.0, 1_000_000.0));
    let mut keys: Vec<(u64, u32)> = particles
        .iter()
        .enumerate()
        .map(|(g, row)| {
            let f = apply(&inverse, row.position());
            let key = (0..3).fold(0, |key, a| key | spread_bits((f[a].max(0.0) * counts[a]) as u64) << a);
            (key, g as u32)
        })
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, g)| g).collect()
}

/// Inserts two zero bits after each of the lowest 21 bits.
fn spread_bits(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn grains(n: usize, cell: &Cell, radius: f64) -> Vec<Row8> {
        let mut x = 0.123_456_789f64;
        let mut next = || {
            x = (x * 997.0 + 0.618).fract();
            x
        };
        (0..n)
            .map(|_| {
                let p = apply(&cell.edges, [next(), next(), next()]);
                Row8([p[0], p[1], p[2], radius, 0.0, 0.0, 0.0, 1.0])
            })
            .collect()
    }
}
