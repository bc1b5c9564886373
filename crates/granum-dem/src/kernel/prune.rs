//! Dynamic pruning of the neighbour list: of the listed pairs, only those of an inner list are evaluated in every step.
//!
//! A neighbour list that lasts hundreds of steps contains many pairs that do not touch, and as contacts form and break, batches
//! that were full of contacts become sparse. The slots of each block are therefore sorted every few dozen steps: touching
//! pairs first, then pairs closer than the inner skin, then the rest, which need no evaluation until a grain may have moved
//! by half the inner skin (Páll et al. 2020 prune their lists in the same way). Only slots in the wrong group are
//! exchanged, and these are few.

use std::ops::Range;

use granum_simd::{Kernel, LANES, Lanes, Mask};

use super::views::Views;
use crate::inner_list::Nearness;
use crate::team::RawSlice;
use granum_simd::vectors::dot;

/// Sorts the pairs of a range of blocks.
pub(crate) struct PruneStage<'a> {
    pub(crate) views: &'a Views,
    pub(crate) blocks: Range<usize>,
}

impl Kernel for PruneStage<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        for k in self.blocks {
            // SAFETY: in this stage a block and all data of its pairs belong to the thread that works on it.
            let block = unsafe { &mut v.blocks.write(k..k + 1)[0] };
            let [start, inner, end] = block.batches.map(|b| b as usize);
            for (zone, batches) in [start..inner, inner..end].into_iter().enumerate() {
                // SAFETY: as above.
                let nearness = unsafe { v.nearness.write(batches.clone()) };
                for (b, n) in batches.clone().zip(nearness.iter_mut()) {
                    *n = measure::<L>(v, b);
                }
                let begin = batches.start as u32;
                let [touching, near] = sort(v, batches, nearness);
                block.inner_ends[zone] = begin + near.div_ceil(LANES) as u32;
                if zone == 0 {
                    block.touching = (touching / LANES) as u32;
                }
            }
        }
    }
}

/// Measures the gaps of the pairs of a batch.
#[inline(always)]
fn measure<L: Lanes>(v: &Views, b: usize) -> Nearness {
    // SAFETY: grains are only read in this stage; lists and marks belong to the thread that works on the block.
    let (particles, i, j, image, marks) = unsafe {
        (
            &v.particles.read()[..v.grains + 2],
            v.first.write(b..b + 1)[0],
            v.second.write(b..b + 1)[0],
            v.image.write(b..b + 1)[0],
            v.marks.write(b..b + 1)[0],
        )
    };
    let (a, c, image) = (L::gather8(particles, &i), L::gather8(particles, &j), L::gather4(&v.images, &image));
    let branch = [c[0] - a[0] + image[0], c[1] - a[1] + image[1], c[2] - a[2] + image[2]];
    let square = dot(branch, branch);
    let sum = a[3] + c[3];
    // Zero without an adhesion law.
    let reach = sum + L::splat(v.onset + v.inner_skin);
    let touching = square.lt(sum * sum).bits() as u8 | marks.touched | marks.attracting;
    Nearness { touching, near: square.lt(reach * reach).bits() as u8 }
}

/// Sorts the slots of some batches; returns how many pairs touch and how many belong to the inner list.
fn sort(v: &Views, batches: Range<usize>, nearness: &mut [Nearness]) -> [usize; 2] {
    let kinds: [fn(&mut Nearness) -> &mut u8; 2] = [|n| &mut n.touching, |n| &mut n.near];
    let first = batches.start * LANES;
    // SAFETY: marks belong to the thread that works on the block.
    let marks = unsafe { v.marks.write(batches) };
    let mut from = 0;
    let mut ends = [0; 2];
    for (kind, end) in kinds.into_iter().zip(&mut ends) {
        let mut to = nearness.len() * LANES;
        loop {
            let mut is = |slot: usize| *kind(&mut nearness[slot / LANES]) >> (slot % LANES) & 1 != 0;
            while from < to && is(from) {
                from += 1;
            }
            while from < to && !is(to - 1) {
                to -= 1;
            }
            if from == to {
                break;
            }
            for bits in kinds {
                exchange_bits(nearness, bits, from, to - 1);
            }
            exchange_bits(marks, |m| &mut m.touched, from, to - 1);
            exchange_bits(marks, |m| &mut m.sliding, from, to - 1);
            exchange_bits(marks, |m| &mut m.attracting, from, to - 1);
            trade(v, first + from, first + to - 1);
        }
        *end = from;
    }
    ends
}

/// Exchanges the slots of two pairs of a block, except for their marks.
fn trade(v: &Views, a: usize, b: usize) {
    let constants = if v.constants.len() == 0 { 0 } else { v.constants_kept };
    // SAFETY: all of this belongs to the thread that works on the block.
    unsafe {
        for list in [&v.first, &v.second, &v.target, &v.image] {
            exchange(list, 1, |row| row, a, b);
        }
        exchange(&v.memory, v.columns, |row| &mut row.0, a, b);
        exchange(&v.constants, constants, |row| &mut row.0, a, b);
    }
}

/// Exchanges two slots in each of the columns of a table.
///
/// # Safety
/// As for [`RawSlice::write`].
unsafe fn exchange<R, T: Copy>(
    table: &RawSlice<R>,
    columns: usize,
    lanes: fn(&mut R) -> &mut [T; LANES],
    a: usize,
    b: usize,
) {
    for c in 0..columns {
        let lane = |slot: usize| {
            let row = slot / LANES * columns + c;
            // SAFETY: guaranteed by the caller; each reference ends before the next is made.
            unsafe { &mut lanes(&mut table.write(row..row + 1)[0])[slot % LANES] }
        };
        let x = *lane(a);
        *lane(a) = *lane(b);
        *lane(b) = x;
    }
}

/// Exchanges the bits of two slots.
fn exchange_bits<B>(batches: &mut [B], bits: fn(&mut B) -> &mut u8, a: usize, b: usize) {
    let mut is = |slot: usize| *bits(&mut batches[slot / LANES]) >> (slot % LANES) & 1;
    if is(a) != is(b) {
        for slot in [a, b] {
            *bits(&mut batches[slot / LANES]) ^= 1 << (slot % LANES);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::checkpoint::tests::running;
    use crate::images::image_vector;
    use crate::simulation::Simulation;
    use granum_simd::LANES;

    /// Branch vector and sum of the radii of the pair in a slot.
    fn branch(s: &Simulation, slot: usize) -> ([f64; 3], f64) {
        let (state, pairs) = (s.state(), &s.state().pairs);
        let (b, l) = (slot / LANES, slot % LANES);
        let [i, j] = [&pairs.first, &pairs.second].map(|list| state.particles[list[b][l] as usize].0);
        let image = state.cell.image(image_vector(pairs.image[b][l]));
        (std::array::from_fn(|a| j[a] + image[a] - i[a]), i[3] + j[3])
    }

    fn length(a: [f64; 3]) -> f64 {
        a.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// All listed pairs, regardless of their slots.
    fn listed(s: &Simulation) -> Vec<[u32; 4]> {
        let p = &s.state().pairs;
        let slot =
            |k: usize| [&p.first, &p.second, &p.target, &p.image].map(|list| list[k / LANES][k % LANES]);
        let mut all: Vec<_> = (0..p.batches() * LANES).map(slot).collect();
        all.sort_unstable();
        all
    }

    #[test]
    fn no_contact_is_missed_and_memory_stays_with_its_pair() {
        for spread in [0.0, 0.3] {
            let mut s = running(300, spread);
            let (mut left_out, mut sorted, mut moved, mut lists) = (0, 0, 0, 0);
            let mut before = (s.rebuilds(), listed(&s), s.state().pairs.first.clone());
            for _ in 0..600 {
                s.advance(1).unwrap();
                sorted += usize::from(s.state().inner_list.steps == 1);
                let pairs = &s.state().pairs;
                for block in &pairs.blocks {
                    let [_, inner, end] = block.batches;
                    for b in (block.inner_ends[0]..inner).chain(block.inner_ends[1]..end) {
                        for slot in b as usize * LANES..(b as usize + 1) * LANES {
                            let (r, sum) = branch(&s, slot);
                            assert!(!pairs.touched(slot) && length(r) > sum);
                            left_out += 1;
                        }
                    }
                }
                for slot in pairs.touching() {
                    let (r, normal) = (branch(&s, slot).0, pairs.memory(slot).normal);
                    let cosine = (0..3).map(|a| r[a] * normal[a]).sum::<f64>() / length(r);
                    assert!((cosine - 1.0).abs() < 1e-9, "{cosine}");
                }
                if s.rebuilds() == before.0 {
                    assert!(listed(&s) == before.1);
                    moved += usize::from(pairs.first != before.2);
                } else {
                    lists += 1;
                }
                before = (s.rebuilds(), listed(&s), pairs.first.clone());
            }
            assert!(left_out > 10_000 && sorted > 5 && moved > 3, "{left_out} {sorted} {moved} {lists}");
        }
    }

    /// Exchanging the slots of pairs changes the forces only by rounding errors.
    #[test]
    fn sorting_changes_no_force() {
        let mut s = running(300, 0.3);
        s.advance(17).unwrap();
        let mut again = s.clone();
        again.integrator.state.inner_list.travel = f64::NEG_INFINITY;
        s.advance(1).unwrap();
        again.advance(1).unwrap();
        assert!(again.state().inner_list.steps == 1 && s.state().inner_list.steps > 1);
        let scale = s.state().sums.virial[0].abs();
        for (a, b) in s.state().sums.virial.iter().zip(again.state().sums.virial) {
            assert!((a - b).abs() < 1e-12 * scale, "{a} {b}");
        }
        assert_eq!(s.state().contacts(), again.state().contacts());
    }
}
