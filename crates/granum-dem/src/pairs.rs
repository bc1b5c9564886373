//! The list of near pairs, in batches of eight, with the memory of their contacts.
//!
//! Pairs within `R_i + R_j + skin` are listed. The list is valid while no pair outside it can have come to touch
//! ([`crate::simulation`] watches that), and is then made anew; memory travels with its pair. Order: pairs within
//! the cell first, pairs across a face after them (only these look up an image vector), each group sorted by the
//! grains' places in memory.

use granum_simd::{LANES, Row8};
use serde::{Deserialize, Serialize};

use crate::cell::{Cell, apply, invert};
use crate::checkpoint::rows;
use crate::contact::MAX_HISTORY;
use crate::contact::interaction::Memory;
use crate::kernel::NORMAL_COLUMNS;

/// Largest number of cells by which an image may be displaced along an edge.
const REACH: i32 = 2;
/// Number of different image vectors.
pub(crate) const IMAGES: usize = 125;
/// Code of the image vector (0, 0, 0).
pub(crate) const NO_IMAGE: u32 = 62;

/// Code of an image vector with entries from -2 to 2.
fn image_code(s: [i32; 3]) -> u32 {
    (((s[0] + REACH) * 5 + (s[1] + REACH)) * 5 + (s[2] + REACH)) as u32
}

/// Image vector of a code.
pub(crate) fn image_vector(code: u32) -> [i32; 3] {
    let c = code as i32;
    [c / 25 - REACH, (c / 5) % 5 - REACH, c % 5 - REACH]
}

/// Pairs in batches, their memory and what they last did to their grains.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pairs {
    /// Number of pairs (the rest of the last batch of a group is filled up with the two phantom grains).
    pub(crate) count: usize,
    /// Batches without images; the later ones have images.
    pub(crate) inner_batches: usize,
    /// Place of grain i, by batch and lane.
    pub(crate) first: Vec<[u32; LANES]>,
    /// Place of grain j.
    pub(crate) second: Vec<[u32; LANES]>,
    /// Code of the image of j.
    pub(crate) image: Vec<[u32; LANES]>,
    /// Columns of memory, by batch: the old normal (3), then the tangential law's history.
    #[serde(with = "rows::eight")]
    pub(crate) memory: Vec<Row8>,
    /// Number of columns of memory.
    pub(crate) columns: usize,
    /// Constants by batch, where grains differ; empty where all pairs are alike.
    #[serde(with = "rows::eight")]
    pub(crate) constants: Vec<Row8>,
    /// What each pair did in the last step: force on i and sliding flag, moment and normal force.
    #[serde(with = "rows::eight")]
    pub(crate) records: Vec<Row8>,
    /// For grain g: records where it is i are `incident[offsets[2g]..offsets[2g+1]]`, where it is j
    /// `incident[offsets[2g+1]..offsets[2g+2]]`.
    pub(crate) offsets: Vec<u32>,
    /// Slots of records.
    pub(crate) incident: Vec<u32>,
}

impl Pairs {
    /// Number of batches.
    pub(crate) fn batches(&self) -> usize {
        self.first.len()
    }

    /// Memory column `c` of batch `b`.
    pub(crate) fn column(&self, b: usize, c: usize) -> &[f64; LANES] {
        &self.memory[b * self.columns + c].0
    }

    /// The memory of a slot.
    pub(crate) fn memory(&self, slot: usize) -> Memory<f64> {
        let (b, l) = (slot / LANES, slot % LANES);
        let mut history = [0.0; MAX_HISTORY];
        for (c, value) in history.iter_mut().enumerate().take(self.columns - NORMAL_COLUMNS) {
            *value = self.column(b, NORMAL_COLUMNS + c)[l];
        }
        Memory { normal: [0, 1, 2].map(|c| self.column(b, c)[l]), history }
    }

    fn set_memory(&mut self, slot: usize, memory: &Memory<f64>) {
        let (b, l) = (slot / LANES, slot % LANES);
        for c in 0..NORMAL_COLUMNS {
            self.memory[b * self.columns + c].0[l] = memory.normal[c];
        }
        for c in 0..self.columns - NORMAL_COLUMNS {
            self.memory[b * self.columns + NORMAL_COLUMNS + c].0[l] = memory.history[c];
        }
    }

    /// True if the pair in this slot touched in the last step.
    pub(crate) fn touched(&self, slot: usize) -> bool {
        let (b, l) = (slot / LANES, slot % LANES);
        (0..3).map(|c| self.column(b, c)[l].powi(2)).sum::<f64>() > 0.5
    }
}

/// A near pair as the search finds it: places of i < j (i <= j for an image of itself) and image code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Near {
    pub(crate) i: u32,
    pub(crate) j: u32,
    pub(crate) image: u32,
}

/// Moves grains into the cell; returns for each the image vector that was subtracted from its position.
pub(crate) fn wrap(cell: &Cell, place: &mut [Row8]) -> Vec<[i32; 3]> {
    let inverse = invert(&cell.edges);
    place
        .iter_mut()
        .map(|row| {
            let fraction = apply(&inverse, [row.0[0], row.0[1], row.0[2]]);
            let moved: [i32; 3] = fraction.map(|x| x.floor() as i32);
            if moved != [0; 3] {
                let back = cell.image(moved);
                for a in 0..3 {
                    row.0[a] -= back[a];
                }
            }
            moved
        })
        .collect()
}

/// Grid of boxes over the cell, each at least `cutoff` wide.
struct Grid {
    counts: [usize; 3],
    start: Vec<u32>,
    member: Vec<u32>,
    of: Vec<[u32; 3]>,
}

impl Grid {
    fn new(cell: &Cell, place: &[Row8], cutoff: f64) -> Grid {
        let heights = cell.heights();
        let limit = (place.len() as f64).cbrt().ceil() as usize + 1;
        let counts: [usize; 3] = heights.map(|h| ((h / cutoff).floor() as usize).clamp(1, limit.max(1)));
        let inverse = invert(&cell.edges);
        let of: Vec<[u32; 3]> = place
            .iter()
            .map(|row| {
                let f = apply(&inverse, [row.0[0], row.0[1], row.0[2]]);
                std::array::from_fn(|a| {
                    ((f[a] * counts[a] as f64).max(0.0) as usize).min(counts[a] - 1) as u32
                })
            })
            .collect();
        let total = counts.iter().product::<usize>();
        let mut start = vec![0u32; total + 1];
        let index = |b: &[u32; 3]| (b[0] as usize * counts[1] + b[1] as usize) * counts[2] + b[2] as usize;
        for b in &of {
            start[index(b) + 1] += 1;
        }
        for k in 0..total {
            start[k + 1] += start[k];
        }
        let mut fill = start.clone();
        let mut member = vec![0u32; place.len()];
        for (g, b) in of.iter().enumerate() {
            let slot = &mut fill[index(b)];
            member[*slot as usize] = g as u32;
            *slot += 1;
        }
        Grid { counts, start, member, of }
    }

    fn members(&self, b: [usize; 3]) -> &[u32] {
        let k = (b[0] * self.counts[1] + b[1]) * self.counts[2] + b[2];
        &self.member[self.start[k] as usize..self.start[k + 1] as usize]
    }
}

/// All pairs of grains nearer than `R_i + R_j + skin`, sorted. `place` holds the grains only, inside the cell.
pub(crate) fn find(cell: &Cell, place: &[Row8], skin: f64) -> Vec<Near> {
    let largest = place.iter().fold(0.0f64, |m, row| m.max(row.0[3]));
    let grid = Grid::new(cell, place, 2.0 * largest + skin);
    let mut found = if grid.counts.iter().all(|&n| n >= 3) {
        find_in_grid(cell, place, skin, &grid)
    } else {
        find_all_images(cell, place, skin, 2.0 * largest + skin)
    };
    found.sort_unstable();
    found
}

fn is_near(a: &Row8, b: &Row8, image: &[f64; 3], skin: f64) -> bool {
    let reach = a.0[3] + b.0[3] + skin;
    let d: [f64; 3] = std::array::from_fn(|k| b.0[k] + image[k] - a.0[k]);
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < reach * reach
}

fn find_in_grid(cell: &Cell, place: &[Row8], skin: f64, grid: &Grid) -> Vec<Near> {
    let mut found = Vec::with_capacity(place.len() * 4);
    let images: Vec<[f64; 3]> = (0..IMAGES as u32).map(|c| cell.image(image_vector(c))).collect();
    for (i, row) in place.iter().enumerate() {
        let here = grid.of[i];
        for step in 0..27 {
            let offset = [step / 9 - 1, (step / 3) % 3 - 1, step % 3 - 1];
            let mut there = [0usize; 3];
            let mut image = [0i32; 3];
            for a in 0..3 {
                let n = grid.counts[a] as i32;
                let b = here[a] as i32 + offset[a];
                image[a] = b.div_euclid(n);
                there[a] = b.rem_euclid(n) as usize;
            }
            let code = image_code(image);
            for &j in grid.members(there) {
                if j as usize > i && is_near(row, &place[j as usize], &images[code as usize], skin) {
                    found.push(Near { i: i as u32, j, image: code });
                }
            }
        }
    }
    found
}

/// For cells only a few grains wide: every pair with every image within reach, images of itself included.
fn find_all_images(cell: &Cell, place: &[Row8], skin: f64, cutoff: f64) -> Vec<Near> {
    let heights = cell.heights();
    let reach: [i32; 3] = heights.map(|h| ((cutoff / h).ceil() as i32).clamp(1, REACH));
    let mut images = Vec::new();
    for a in -reach[0]..=reach[0] {
        for b in -reach[1]..=reach[1] {
            for c in -reach[2]..=reach[2] {
                images.push(([a, b, c], cell.image([a, b, c])));
            }
        }
    }
    let mut found = Vec::new();
    for (i, row) in place.iter().enumerate() {
        for (j, other) in place.iter().enumerate().skip(i) {
            for (s, image) in &images {
                if (j > i || *s > [0; 3]) && is_near(row, other, image, skin) {
                    found.push(Near { i: i as u32, j: j as u32, image: image_code(*s) });
                }
            }
        }
    }
    found
}

/// Order of grains along a space-filling (Morton) curve: `order[new place] = old place`.
pub(crate) fn spatial_order(cell: &Cell, place: &[Row8], spacing: f64) -> Vec<u32> {
    let inverse = invert(&cell.edges);
    let counts = cell.heights().map(|h| (h / spacing).floor().clamp(1.0, 1_000_000.0));
    let mut keys: Vec<(u64, u32)> = place
        .iter()
        .enumerate()
        .map(|(g, row)| {
            let f = apply(&inverse, [row.0[0], row.0[1], row.0[2]]);
            let key = (0..3).fold(0, |key, a| key | spread_bits((f[a].max(0.0) * counts[a]) as u64) << a);
            (key, g as u32)
        })
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, g)| g).collect()
}

/// Puts two zero bits between the lowest 21 bits.
fn spread_bits(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Where an old pair's memory goes: its key in the new order, and whether i and j changed sides.
fn carried_key(pairs: &Pairs, slot: usize, moved: &[[i32; 3]], new_place: Option<&[u32]>) -> (Near, bool) {
    let (b, l) = (slot / LANES, slot % LANES);
    let (i, j) = (pairs.first[b][l], pairs.second[b][l]);
    let old = image_vector(pairs.image[b][l]);
    // x_j + H s - x_i stays as it was when both positions jump by whole cells.
    let mut s: [i32; 3] = std::array::from_fn(|a| {
        old[a].saturating_add(moved[j as usize][a]).saturating_sub(moved[i as usize][a])
    });
    let (mut i, mut j) = match new_place {
        Some(new) => (new[i as usize], new[j as usize]),
        None => (i, j),
    };
    let flip = i > j || (i == j && s < [0; 3]);
    if flip {
        std::mem::swap(&mut i, &mut j);
        s = s.map(i32::saturating_neg);
    }
    let image = if s.iter().all(|x| (-REACH..=REACH).contains(x)) { image_code(s) } else { u32::MAX };
    (Near { i, j, image }, flip)
}

/// Makes the list anew from `near` (sorted), carrying over the memory and records of pairs that persist.
///
/// `moved` and `new_place` say how the grains were wrapped and reordered since the old list; `swap` rewrites
/// a memory when i and j change sides. `grains` counts the real grains; the
/// two phantoms follow them.
pub(crate) fn rebuild(
    old: &Pairs,
    near: &[Near],
    moved: &[[i32; 3]],
    new_place: Option<&[u32]>,
    columns: usize,
    swap: fn(&mut Memory<f64>),
    grains: usize,
) -> Pairs {
    let phantoms = (grains as u32, grains as u32 + 1);
    let mut pairs = Pairs { count: near.len(), columns, ..Pairs::default() };
    let mut slots: Vec<u32> = vec![0; near.len()];
    for crossing in [false, true] {
        let mut lane = LANES;
        for (n, pair) in near.iter().enumerate() {
            if (pair.image != NO_IMAGE) != crossing {
                continue;
            }
            if lane == LANES {
                pairs.first.push([phantoms.0; LANES]);
                pairs.second.push([phantoms.1; LANES]);
                pairs.image.push([NO_IMAGE; LANES]);
                lane = 0;
            }
            let b = pairs.first.len() - 1;
            pairs.first[b][lane] = pair.i;
            pairs.second[b][lane] = pair.j;
            pairs.image[b][lane] = pair.image;
            slots[n] = (b * LANES + lane) as u32;
            lane += 1;
        }
        if !crossing {
            pairs.inner_batches = pairs.first.len();
        }
    }
    pairs.memory = vec![Row8::default(); pairs.batches() * columns];
    pairs.records = vec![Row8::default(); pairs.batches() * LANES];
    list_incidents(&mut pairs, near, &slots, grains);
    carry_memory(&mut pairs, old, near, &slots, moved, new_place, swap);
    pairs
}

fn list_incidents(pairs: &mut Pairs, near: &[Near], slots: &[u32], grains: usize) {
    let mut offsets = vec![0u32; 2 * grains + 1];
    for pair in near {
        offsets[2 * pair.i as usize + 1] += 1;
        offsets[2 * pair.j as usize + 2] += 1;
    }
    for k in 0..2 * grains {
        offsets[k + 1] += offsets[k];
    }
    let mut fill = offsets.clone();
    let mut incident = vec![0u32; 2 * near.len()];
    for (pair, &slot) in near.iter().zip(slots) {
        for side in [2 * pair.i as usize, 2 * pair.j as usize + 1] {
            incident[fill[side] as usize] = slot;
            fill[side] += 1;
        }
    }
    pairs.offsets = offsets;
    pairs.incident = incident;
}

fn carry_memory(
    pairs: &mut Pairs,
    old: &Pairs,
    near: &[Near],
    slots: &[u32],
    moved: &[[i32; 3]],
    new_place: Option<&[u32]>,
    swap: fn(&mut Memory<f64>),
) {
    let real = moved.len() as u32;
    for slot in 0..old.batches() * LANES {
        if old.first[slot / LANES][slot % LANES] >= real || !old.touched(slot) {
            continue;
        }
        let (key, flip) = carried_key(old, slot, moved, new_place);
        let Ok(n) = near.binary_search(&key) else { continue };
        let target = slots[n] as usize;
        let mut memory = old.memory(slot);
        if flip {
            swap(&mut memory);
        }
        pairs.set_memory(target, &memory);
        let mut record = old.records[slot];
        if flip {
            // Force on the other grain; the moment serves both sides alike.
            for a in 0..3 {
                record.0[a] = -record.0[a];
            }
        }
        pairs.records[target] = record;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grains(n: usize, cell: &Cell, radius: f64) -> Vec<Row8> {
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

    #[test]
    fn grid_finds_what_all_images_find() {
        let cell = Cell { edges: [[10.0, 1.0, -0.5], [0.0, 9.0, 0.3], [0.0, 0.0, 11.0]] };
        let place = grains(300, &cell, 0.7);
        let mut slow = find_all_images(&cell, &place, 0.1, 1.5);
        slow.sort_unstable();
        assert_eq!(find(&cell, &place, 0.1), slow);
        assert!(slow.len() > 100);
    }

    #[test]
    fn small_cells_see_images_of_themselves() {
        let cell = Cell::cuboid([1.0; 3]);
        let place = [Row8([0.5, 0.5, 0.5, 0.5, 0.0, 0.0, 0.0, 1.0])];
        assert_eq!(find(&cell, &place, 1e-3).len(), 3);
    }

    #[test]
    fn memory_survives_wrapping_and_reordering() {
        let cell = Cell::cuboid([10.0; 3]);
        let mut place = grains(200, &cell, 0.8);
        let near = find(&cell, &place, 0.05);
        let none = vec![[0; 3]; 200];
        // A memory whose first three columns are a vector in space.
        let swap = |m: &mut Memory<f64>| {
            m.normal = m.normal.map(|x| -x);
            for c in 0..3 {
                m.history[c] = -m.history[c];
            }
        };
        let mut pairs = rebuild(&Pairs::default(), &near, &none, None, 7, swap, 200);
        let length = |pairs: &Pairs, place: &[Row8], slot: usize| {
            let (b, l) = (slot / LANES, slot % LANES);
            let s = cell.image(image_vector(pairs.image[b][l]));
            let (i, j) = (pairs.first[b][l] as usize, pairs.second[b][l] as usize);
            let r: [f64; 3] = std::array::from_fn(|a| place[j].0[a] + s[a] - place[i].0[a]);
            (r, r.iter().map(|x| x * x).sum::<f64>().sqrt())
        };
        // Remember the direction and the branch itself.
        for slot in 0..pairs.batches() * LANES {
            let (b, l) = (slot / LANES, slot % LANES);
            if pairs.first[b][l] < 200 {
                let (r, d) = length(&pairs, &place, slot);
                for a in 0..3 {
                    pairs.memory[b * 7 + a].0[l] = r[a] / d;
                    pairs.memory[b * 7 + 3 + a].0[l] = r[a];
                    pairs.records[slot].0[a] = r[a];
                }
                pairs.memory[b * 7 + 6].0[l] = d;
            }
        }
        for row in &mut place {
            row.0[0] += 4.0;
            row.0[2] -= 7.0;
        }
        let moved = wrap(&cell, &mut place);
        let order = spatial_order(&cell, &place, 1.7);
        let mut new_place = vec![0; 200];
        for (new, &old) in order.iter().enumerate() {
            new_place[old as usize] = new as u32;
        }
        let place: Vec<Row8> = order.iter().map(|&o| place[o as usize]).collect();
        let near = find(&cell, &place, 0.05);
        let again = rebuild(&pairs, &near, &moved, Some(&new_place), 7, swap, 200);
        assert_eq!(again.count, pairs.count);
        let mut checked = 0;
        for slot in 0..again.batches() * LANES {
            let (b, l) = (slot / LANES, slot % LANES);
            if again.first[b][l] >= 200 {
                continue;
            }
            let (r, d) = length(&again, &place, slot);
            for a in 0..3 {
                assert!((again.column(b, 3 + a)[l] - r[a]).abs() < 1e-12);
                assert!((again.records[slot].0[a] - r[a]).abs() < 1e-12);
            }
            assert!((again.column(b, 6)[l] - d).abs() < 1e-12);
            checked += 1;
        }
        assert_eq!(checked, again.count);
        for g in 0..200 {
            for side in 0..2 {
                let range = again.offsets[2 * g + side] as usize..again.offsets[2 * g + side + 1] as usize;
                for &slot in &again.incident[range] {
                    let list = if side == 0 { &again.first } else { &again.second };
                    assert_eq!(list[slot as usize / LANES][slot as usize % LANES], g as u32);
                }
            }
        }
    }
}
