//! Search for grossly overlapping grains, in any cell and for any mixture of sizes.
//!
//! Grains are sorted into levels by octave of radius, and each level into bins no narrower than its largest diameter. For
//! each grain, its own level and those of smaller grains are searched, so that one large grain among many small ones costs
//! little.

use granum_core::Cell;
use granum_core::geometry::{Matrix, Vector, apply, invert};

use super::packed_grain::PackedGrain;
use crate::error::{Result, in_file};

/// Overlap as a fraction of the smaller diameter above which a packing is rejected.
pub const GROSS_OVERLAP: f64 = 0.05;

/// Largest number of bins along an edge.
const MOST_BINS: i64 = 1 << 20;

/// Rejects a packing with the first grain that overlaps another grossly; `grains` contains the grains with their line
/// numbers.
pub(super) fn check(file: &str, edges: &Matrix, grains: &[(PackedGrain, usize)]) -> Result<()> {
    let search = Search::new(edges, grains);
    for at in 0..grains.len() {
        let Some((other, overlap)) = search.overlapping(at) else { continue };
        let ((grain, line), (second, second_line)) = (&grains[at], &grains[other]);
        let other_line = if *second_line == 0 { String::new() } else { format!(" (line {second_line})") };
        let message = format!(
            "grain {} overlaps grain {}{other_line} by {overlap:.3e} m, {:.1} % of the smaller diameter",
            grain.id,
            second.id,
            50.0 * overlap / grain.radius.min(second.radius)
        );
        let help =
            format!("at most {} % is accepted in a packing; are the radii right?", 100.0 * GROSS_OVERLAP);
        return Err(in_file(file, *line, message, &help));
    }
    Ok(())
}

/// Grains of one octave of radii.
struct Level {
    largest_radius: f64,
    bins: [i64; 3],
    /// Bin and grain, sorted.
    entries: Vec<(u64, u32)>,
}

struct Search<'a> {
    edges: &'a Matrix,
    heights: Vector,
    grains: &'a [(PackedGrain, usize)],
    /// Positions in units of the edges, in [0, 1).
    places: Vec<Vector>,
    level_of: Vec<u32>,
    levels: Vec<Level>,
}

impl<'a> Search<'a> {
    fn new(edges: &'a Matrix, grains: &'a [(PackedGrain, usize)]) -> Self {
        let inverse = invert(edges);
        // The corner of the cell does not matter: differences and wrapped positions are the same.
        let places: Vec<Vector> =
            grains.iter().map(|(grain, _)| apply(&inverse, grain.position).map(|s| s - s.floor())).collect();
        let largest = grains.iter().map(|(grain, _)| grain.radius).fold(0.0, f64::max);
        let octaves: Vec<u32> =
            grains.iter().map(|(grain, _)| libm::log2(largest / grain.radius) as u32).collect();
        let mut present = octaves.clone();
        present.sort_unstable();
        present.dedup();
        let level_of: Vec<u32> =
            octaves.iter().map(|octave| present.partition_point(|known| known < octave) as u32).collect();
        let mut search = Search {
            edges,
            heights: Cell { edges: *edges }.heights(),
            grains,
            places,
            level_of,
            levels: vec![],
        };
        search.levels = (0..present.len() as u32).map(|level| search.fill(level)).collect();
        search
    }

    fn fill(&self, level: u32) -> Level {
        let members: Vec<usize> = (0..self.grains.len()).filter(|at| self.level_of[*at] == level).collect();
        let largest_radius = members.iter().map(|at| self.grains[*at].0.radius).fold(0.0, f64::max);
        let bins = self.heights.map(|height| ((height / (2.0 * largest_radius)) as i64).clamp(1, MOST_BINS));
        let mut entries: Vec<(u64, u32)> = members
            .iter()
            .map(|at| {
                let bin =
                    std::array::from_fn(|k| ((self.places[*at][k] * bins[k] as f64) as i64).min(bins[k] - 1));
                (key(bin), *at as u32)
            })
            .collect();
        entries.sort_unstable();
        Level { largest_radius, bins, entries }
    }

    /// A grain that overlaps grain `at` grossly, with the overlap.
    fn overlapping(&self, at: usize) -> Option<(usize, f64)> {
        let own = self.level_of[at] as usize;
        self.levels[own..].iter().find_map(|level| {
            let reach = self.grains[at].0.radius + level.largest_radius;
            let range: [(i64, i64); 3] = std::array::from_fn(|k| {
                let (place, half, bins) = (self.places[at][k], reach / self.heights[k], level.bins[k] as f64);
                (((place - half) * bins).floor() as i64, ((place + half) * bins).floor() as i64)
            });
            let boxes: i64 = range.iter().map(|(low, high)| high - low + 1).product();
            if boxes as usize > 27 + level.entries.len() {
                self.among_all(at, level)
            } else {
                self.among_bins(at, level, range)
            }
        })
    }

    fn among_bins(&self, at: usize, level: &Level, range: [(i64, i64); 3]) -> Option<(usize, f64)> {
        let [x, y, z] = range;
        for i in x.0..=x.1 {
            for j in y.0..=y.1 {
                for k in z.0..=z.1 {
                    let bin = [i, j, k];
                    let image = std::array::from_fn(|a| bin[a].div_euclid(level.bins[a]) as f64);
                    let wrapped = key(std::array::from_fn(|a| bin[a].rem_euclid(level.bins[a])));
                    let first = level.entries.partition_point(|entry| entry.0 < wrapped);
                    let members = level.entries[first..].iter().take_while(|entry| entry.0 == wrapped);
                    if let Some(found) =
                        members.into_iter().find_map(|e| self.overlap(at, e.1 as usize, image))
                    {
                        return Some(found);
                    }
                }
            }
        }
        None
    }

    /// Searches all grains of the level and their nearest images, for the case that the bins within range outnumber the
    /// grains.
    fn among_all(&self, at: usize, level: &Level) -> Option<(usize, f64)> {
        level.entries.iter().find_map(|(_, other)| {
            (0..27).find_map(|n| {
                let image = [n % 3, n / 3 % 3, n / 9].map(|a| f64::from(a) - 1.0);
                self.overlap(at, *other as usize, image)
            })
        })
    }

    /// The overlap of two different grains, the second in an image of the cell, if it is gross.
    fn overlap(&self, at: usize, other: usize, image: Vector) -> Option<(usize, f64)> {
        if at == other {
            return None;
        }
        let (one, two) = (&self.grains[at].0, &self.grains[other].0);
        let apart: Vector = std::array::from_fn(|a| self.places[other][a] + image[a] - self.places[at][a]);
        let distance = apply(self.edges, apart).iter().map(|x| x * x).sum::<f64>().sqrt();
        let overlap = one.radius + two.radius - distance;
        (overlap > GROSS_OVERLAP * 2.0 * one.radius.min(two.radius)).then_some((other, overlap))
    }
}

/// A single number for a bin, with 21 bits for each axis.
fn key(bin: [i64; 3]) -> u64 {
    bin.iter().fold(0, |key, index| key << 21 | *index as u64)
}
