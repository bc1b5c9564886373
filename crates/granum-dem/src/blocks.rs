//! Rebuilding of the neighbour list: blocks of grains, batches of pairs, rows for forces, contact histories carried over.
//!
//! Order of the pairs: by blocks of grains, in their storage order; within a block, pairs inside the cell come first and
//! pairs across a face of the cell follow (only these look up an image vector); within both groups, touching pairs come
//! first, so that a batch is either full of contacts or has none; within those, pairs are ordered by the indices of their
//! grains.

use std::ops::Range;

use granum_simd::{LANES, Portable, Row8};

use crate::cell::Cell;
use crate::contact::evaluation::memory::Memory;
use crate::images::{NO_IMAGE, REACH, image_code, image_vector};
use crate::pairs::{Block, Marks, Pairs, resultant};
use crate::search::{Near, is_near};

/// A small sample should have at least this many blocks, so that several threads have work.
const WANTED_BLOCKS: usize = 24;
/// Number of grains of a block: enough that few pairs connect it with other blocks, few enough that its forces stay in the
/// fast cache of a core.
const BLOCK_GRAINS: Range<usize> = 128..1024;

/// What happened to the grains since the old list was built.
pub(crate) struct Change<'a> {
    /// Image vector that was subtracted from the position of each grain, by old index.
    pub(crate) moved: &'a [[i32; 3]],
    /// New index of each grain, if the grains were sorted again.
    pub(crate) new_place: Option<&'a [u32]>,
    /// Rewrites a contact history when i and j change roles.
    pub(crate) swap: &'a dyn Fn(&mut Memory<f64>),
    /// If present, pairs whose surfaces are farther apart than this, m, are listed only if they have a history.
    pub(crate) skin: Option<f64>,
}

/// Builds the new list from `near` (sorted). `particles` holds the grains in their new order, inside the cell, followed by
/// the two phantoms. Only the contact histories of the old list are held while the new one is built, because two lists of a
/// large sample would not fit into memory.
pub(crate) fn rebuild(
    old: Pairs,
    near: &[Near],
    cell: &Cell,
    particles: &[Row8],
    change: &Change,
    columns: [usize; 4],
) -> Pairs {
    let grains = particles.len();
    let mut kept = Kept::find(&old, near, change, grains);
    drop(old);
    let images: Vec<[f64; 3]> =
        (0..crate::images::IMAGES as u32).map(|code| cell.image(image_vector(code))).collect();
    let fewer: Vec<Near>;
    let near = match change.skin {
        None => near,
        Some(skin) => {
            let listed = |(pair, from): (&Near, u32)| {
                let (a, b) = (&particles[pair.i as usize], &particles[pair.j as usize]);
                let listed = from != 0 || is_near(a, b, &images[pair.image as usize], skin);
                listed.then_some((*pair, from))
            };
            (fewer, kept.from) = near.iter().zip(kept.from).filter_map(listed).unzip();
            &fewer
        }
    };
    let touches = |(pair, &from): (&Near, &u32)| {
        let (a, b) = (&particles[pair.i as usize], &particles[pair.j as usize]);
        from != 0 || is_near(a, b, &images[pair.image as usize], 0.0)
    };
    let touch: Vec<bool> = near.iter().zip(&kept.from).map(touches).collect();
    let mut list = List {
        pairs: Pairs { count: near.len(), columns, ..Pairs::default() },
        slots: vec![0; near.len()],
        halo: Vec::new(),
        near,
        grains,
    };
    let mut begin = 0;
    for range in partition(grains) {
        let end = begin + near[begin..].partition_point(|pair| (pair.i as usize) < range.end);
        list.append(range, begin..end, &touch);
        begin = end;
    }
    let List { mut pairs, slots, halo, .. } = list;
    list_outer(&mut pairs, &halo, grains);
    pairs.memory = vec![Row8::default(); pairs.batches() * pairs.columns_in_all()];
    pairs.marks = vec![Marks::default(); pairs.batches()];
    for (&slot, &from) in slots.iter().zip(&kept.from).filter(|(_, from)| **from != 0) {
        let (memory, marks) = &kept.memories[from as usize - 1];
        let (batch, lane) = (slot as usize / LANES, slot as usize % LANES);
        pairs.set_memory(slot as usize, memory);
        pairs.marks[batch].touched |= marks.touched << lane;
        pairs.marks[batch].sliding |= marks.sliding << lane;
        pairs.marks[batch].attracting |= marks.attracting << lane;
    }
    pairs.forces = kept.forces;
    pairs.forces.reserve_exact(halo.len());
    pairs.forces.resize(grains + halo.len(), Row8::default());
    pairs
}

/// Divides the grains into ranges of nearly equal length.
fn partition(grains: usize) -> impl Iterator<Item = Range<usize>> {
    let size = grains.div_ceil(WANTED_BLOCKS).clamp(BLOCK_GRAINS.start, BLOCK_GRAINS.end);
    let count = grains.div_ceil(size);
    (0..count).map(move |k| k * grains / count..(k + 1) * grains / count)
}

/// A list that is being built.
struct List<'a> {
    pairs: Pairs,
    /// Slot of each pair of `near`.
    slots: Vec<u32>,
    /// Grain of each force row after those of the grains.
    halo: Vec<u32>,
    near: &'a [Near],
    grains: usize,
}

impl List<'_> {
    /// Appends the block of the grains in `range`, whose pairs are `near[members]`.
    fn append(&mut self, range: Range<usize>, members: Range<usize>, touch: &[bool]) {
        let start = self.halo.len();
        let outside = self.near[members.clone()].iter().map(|pair| pair.j);
        self.halo.extend(outside.filter(|&j| j as usize >= range.end));
        self.halo[start..].sort_unstable();
        let mut kept = start;
        for k in start..self.halo.len() {
            if kept == start || self.halo[kept - 1] != self.halo[k] {
                self.halo[kept] = self.halo[k];
                kept += 1;
            }
        }
        self.halo.truncate(kept);
        let begin = self.pairs.first.len() as u32;
        self.group(&range, members.clone(), start, false, touch);
        let inner = self.pairs.first.len() as u32;
        self.group(&range, members, start, true, touch);
        let end = self.pairs.first.len() as u32;
        let row = |k: usize| (self.grains + k) as u32;
        self.pairs.blocks.push(Block {
            grains: [range.start as u32, range.end as u32],
            batches: [begin, inner, end],
            inner_ends: [inner, end],
            touching: 0,
            outer: [row(start), row(kept)],
        });
    }

    /// Appends the batches of the pairs across a face of the cell, or of the others; touching pairs come first.
    fn group(
        &mut self,
        range: &Range<usize>,
        members: Range<usize>,
        halo_start: usize,
        crossing: bool,
        touch: &[bool],
    ) {
        let chosen = |wanted: bool| {
            let near = self.near;
            members.clone().filter(move |&n| (near[n].image != NO_IMAGE) == crossing && touch[n] == wanted)
        };
        let mut order: Vec<usize> = chosen(true).collect();
        order.extend(chosen(false));
        let pairs = &mut self.pairs;
        for batch in order.chunks(LANES) {
            // Empty lanes pair a grain of the block with the distant phantom.
            let mut first = [range.start as u32; LANES];
            let mut second = [self.grains as u32 + 1; LANES];
            let mut target = first;
            let mut image = [NO_IMAGE; LANES];
            for (lane, &n) in batch.iter().enumerate() {
                let pair = &self.near[n];
                first[lane] = pair.i;
                second[lane] = pair.j;
                image[lane] = pair.image;
                target[lane] = if (pair.j as usize) < range.end {
                    pair.j
                } else {
                    let at = self.halo[halo_start..].partition_point(|&g| g < pair.j);
                    (self.grains + halo_start + at) as u32
                };
                self.slots[n] = (pairs.first.len() * LANES + lane) as u32;
            }
            pairs.first.push(first);
            pairs.second.push(second);
            pairs.target.push(target);
            pairs.image.push(image);
        }
    }
}

/// Lists for each grain the rows in which other blocks store forces on it.
fn list_outer(pairs: &mut Pairs, halo: &[u32], grains: usize) {
    let mut offsets = vec![0u32; grains + 1];
    for &g in halo {
        offsets[g as usize + 1] += 1;
    }
    for g in 0..grains {
        offsets[g + 1] += offsets[g];
    }
    let mut fill = offsets.clone();
    pairs.outer = vec![0; halo.len()];
    for (k, &g) in halo.iter().enumerate() {
        let at = &mut fill[g as usize];
        pairs.outer[*at as usize] = (grains + k) as u32;
        *at += 1;
    }
    pairs.outer_offsets = offsets;
}

/// What is carried over from the old list to the new one.
struct Kept {
    /// For each pair of `near`: 0 if it did not touch, otherwise the index of its history plus one.
    from: Vec<u32>,
    /// Memories, for the pairs as they stand in the new list, and the marks of each in the lowest bits.
    memories: Vec<(Memory<f64>, Marks)>,
    /// Resultant forces of the last step, by new index.
    forces: Vec<Row8>,
}

impl Kept {
    fn find(old: &Pairs, near: &[Near], change: &Change, grains: usize) -> Kept {
        let mut kept = Kept {
            from: vec![0; near.len()],
            memories: Vec::with_capacity(old.contacts()),
            forces: vec![Row8::default(); grains],
        };
        let starts = starts(near, grains);
        for slot in old.remembering() {
            let (key, flip) = carried_key(old, slot, change);
            let start = starts[key.i as usize] as usize;
            let of_grain = &near[start..starts[key.i as usize + 1] as usize];
            let Ok(n) = of_grain.binary_search(&key).map(|n| start + n) else { continue };
            let mut memory = old.memory(slot);
            if flip {
                (change.swap)(&mut memory);
            }
            let marks = Marks {
                touched: old.touched(slot).into(),
                sliding: old.sliding(slot).into(),
                attracting: old.attracting(slot).into(),
                changed: 0,
            };
            kept.memories.push((memory, marks));
            kept.from[n] = kept.memories.len() as u32;
        }
        if old.outer_offsets.len() == grains + 1 {
            for g in 0..grains {
                let new = change.new_place.map_or(g, |new| new[g] as usize);
                let total = resultant::<Portable>(&old.forces, &old.outer_offsets, &old.outer, g);
                kept.forces[new] = Row8(total);
            }
        }
        kept
    }
}

/// Index of the first pair of each grain in the sorted list, and the end of the list.
fn starts(near: &[Near], grains: usize) -> Vec<u32> {
    let mut starts = vec![0; grains + 1];
    for pair in near {
        starts[pair.i as usize + 1] += 1;
    }
    for g in 0..grains {
        starts[g + 1] += starts[g];
    }
    starts
}

/// The key of an old pair in the new order, and whether i and j change roles.
fn carried_key(pairs: &Pairs, slot: usize, change: &Change) -> (Near, bool) {
    let (b, l) = (slot / LANES, slot % LANES);
    let (mut i, mut j) = (pairs.first[b][l], pairs.second[b][l]);
    let old = image_vector(pairs.image[b][l]);
    // x_j + H s - x_i does not change when both positions jump by whole cells.
    let mut s: [i32; 3] = std::array::from_fn(|a| {
        let moved = |g: u32| change.moved.get(g as usize).map_or(0, |m| m[a]);
        old[a].saturating_add(moved(j)).saturating_sub(moved(i))
    });
    if let Some(new) = change.new_place {
        let place = |g: u32| new.get(g as usize).copied().unwrap_or(g);
        (i, j) = (place(i), place(j));
    }
    let flip = i > j || (i == j && s < [0; 3]);
    if flip {
        std::mem::swap(&mut i, &mut j);
        s = s.map(i32::saturating_neg);
    }
    let image = if s.iter().all(|x| (-REACH..=REACH).contains(x)) { image_code(s) } else { u32::MAX };
    (Near { i, j, image }, flip)
}

#[cfg(test)]
mod tests {
    use granum_simd::Isa;

    use super::*;
    use crate::images::wrap;
    use crate::pairs::spatial_order;
    use crate::pairs::tests::grains;
    use crate::search::find;

    const COUNT: usize = 700;

    fn negate(m: &mut Memory<f64>) {
        m.normal = m.normal.map(|x| -x);
        for c in 0..3 {
            m.history[c] = -m.history[c];
        }
    }

    fn branch(pairs: &Pairs, cell: &Cell, particles: &[Row8], slot: usize) -> ([f64; 3], f64) {
        let (b, l) = (slot / LANES, slot % LANES);
        let s = cell.image(image_vector(pairs.image[b][l]));
        let (i, j) = (pairs.first[b][l] as usize, pairs.second[b][l] as usize);
        let r: [f64; 3] = std::array::from_fn(|a| particles[j].0[a] + s[a] - particles[i].0[a]);
        (r, r.iter().map(|x| x * x).sum::<f64>().sqrt())
    }

    fn real(pairs: &Pairs) -> impl Iterator<Item = usize> + '_ {
        (0..pairs.batches() * LANES).filter(|s| (pairs.second[s / LANES][s % LANES] as usize) < COUNT)
    }

    #[test]
    fn memory_and_forces_survive_wrapping_and_reordering() {
        let cell = Cell::cuboid([14.0; 3]);
        let mut particles = grains(COUNT, &cell, 0.8);
        let near = find(Isa::detect(), &cell, &particles, 0.05);
        let none = vec![[0; 3]; COUNT];
        let change = Change { moved: &none, new_place: None, swap: &negate, skin: None };
        let mut pairs = rebuild(Pairs::default(), &near, &cell, &particles, &change, [7, 0, 0, 0]);
        assert!(pairs.blocks.len() > 3 && pairs.forces.len() > COUNT);
        // Store the direction and the branch vector itself as history, and let every pair pull with its branch vector.
        let slots: Vec<usize> = real(&pairs).collect();
        for slot in slots {
            let (r, d) = branch(&pairs, &cell, &particles, slot);
            let (b, l) = (slot / LANES, slot % LANES);
            for a in 0..3 {
                pairs.memory[b * 7 + a].0[l] = r[a] / d;
                pairs.memory[b * 7 + 3 + a].0[l] = r[a];
                let (i, j) = (pairs.first[b][l] as usize, pairs.target[b][l] as usize);
                pairs.forces[i].0[a] += r[a];
                pairs.forces[j].0[a] -= r[a];
            }
            pairs.memory[b * 7 + 6].0[l] = d;
            pairs.marks[b].touched |= 1 << l;
            pairs.marks[b].sliding |= ((slot % 3 == 0) as u8) << l;
        }
        let sum = |pairs: &Pairs, g: usize| {
            resultant::<Portable>(&pairs.forces, &pairs.outer_offsets, &pairs.outer, g)
        };
        let before: Vec<[f64; 8]> = (0..COUNT).map(|g| sum(&pairs, g)).collect();
        for row in &mut particles {
            row.0[0] += 4.0;
            row.0[2] -= 7.0;
        }
        let moved = wrap(&cell, &mut particles);
        let order = spatial_order(&cell, &particles, 1.7);
        let mut new_place = vec![0; COUNT];
        for (new, &old) in order.iter().enumerate() {
            new_place[old as usize] = new as u32;
        }
        let particles: Vec<Row8> = order.iter().map(|&o| particles[o as usize]).collect();
        let near = find(Isa::detect(), &cell, &particles, 0.05);
        let change = Change { moved: &moved, new_place: Some(&new_place), swap: &negate, skin: None };
        let again = rebuild(pairs.clone(), &near, &cell, &particles, &change, [7, 0, 0, 0]);
        assert_eq!((again.count, again.contacts()), (pairs.count, pairs.count));
        assert_eq!(real(&again).count(), again.count);
        let slid = |pairs: &Pairs| real(pairs).filter(|&s| pairs.sliding(s)).count();
        assert_eq!(slid(&again), slid(&pairs));
        for slot in real(&again) {
            let (r, d) = branch(&again, &cell, &particles, slot);
            for a in 0..3 {
                assert!((again.memory(slot).normal[a] - r[a] / d).abs() < 1e-12);
                assert!((again.memory(slot).history[a] - r[a]).abs() < 1e-12);
            }
            assert!((again.memory(slot).history[3] - d).abs() < 1e-12);
        }
        for g in 0..COUNT {
            assert_eq!(sum(&again, new_place[g] as usize), before[g]);
        }
    }

    #[test]
    fn blocks_share_no_row_and_touching_pairs_come_first() {
        let cell = Cell::cuboid([12.0; 3]);
        let particles = grains(COUNT, &cell, 0.8);
        let near = find(Isa::detect(), &cell, &particles, 0.3);
        let none = vec![[0; 3]; COUNT];
        let change = Change { moved: &none, new_place: None, swap: &negate, skin: None };
        let pairs = rebuild(Pairs::default(), &near, &cell, &particles, &change, [5, 0, 0, 0]);
        let mut owner = vec![usize::MAX; pairs.forces.len()];
        for (k, block) in pairs.blocks.iter().enumerate() {
            for [from, to] in [block.grains, block.outer] {
                for row in from..to {
                    assert_eq!(std::mem::replace(&mut owner[row as usize], k), usize::MAX);
                }
            }
        }
        assert!(owner.iter().all(|&k| k < pairs.blocks.len()));
        for (k, block) in pairs.blocks.iter().enumerate() {
            let [start, inner, end] = block.batches;
            for group in [start..inner, inner..end] {
                let mut over = false;
                for slot in group.flat_map(|b| (0..LANES).map(move |l| b as usize * LANES + l)) {
                    let (b, l) = (slot / LANES, slot % LANES);
                    let rows = [pairs.first[b][l], pairs.target[b][l]];
                    assert!(rows.iter().all(|&row| owner[row as usize] == k));
                    let phantom = pairs.second[b][l] as usize >= COUNT;
                    let apart = phantom || branch(&pairs, &cell, &particles, slot).1 > 1.6;
                    assert!(apart || !over, "a touching pair after one that is apart");
                    over |= apart;
                }
            }
        }
        // Every row beyond those of the grains belongs to the one grain that sums it.
        for g in 0..COUNT {
            for &row in &pairs.outer[pairs.outer_offsets[g] as usize..pairs.outer_offsets[g + 1] as usize] {
                let used = real(&pairs).any(|s| {
                    pairs.target[s / LANES][s % LANES] == row
                        && pairs.second[s / LANES][s % LANES] as usize == g
                });
                assert!(used);
            }
        }
    }
}
