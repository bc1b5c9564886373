//! Grains within a given distance of each other, in a periodic cell of any shape and size. If the cell is smaller than the
//! distance, a grain has several images of another grain, and of itself, as neighbours.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::{apply, determinant, invert};

/// Largest number of neighbours, in the mean over the grains, that a search looks at: its cost is at most this multiple of the number of
/// grains. Equal grains have some hundreds within five diameters; only grains that differ in size by a factor above ten have more.
pub(crate) const MOST_NEIGHBOURS: f64 = 50_000.0;

/// Mean number of neighbours, their images included, within a reach in a cell that they fill evenly; zero without a volume.
pub(crate) fn expected(cell: &Matrix, grains: usize, reach: f64) -> f64 {
    let volume = determinant(cell).abs();
    let sphere = 4.0 / 3.0 * std::f64::consts::PI * reach * reach * reach;
    if volume > 0.0 { grains as f64 * sphere / volume } else { 0.0 }
}

/// The grains of an assembly, sorted into bins.
pub(crate) struct Neighbours<'a> {
    cell: &'a Matrix,
    reach: f64,
    /// Centres, brought back into the cell.
    centres: Vec<Vector>,
    /// Bin of each grain along each edge.
    bins: Vec<[i64; 3]>,
    /// Number of bins along each edge, and how many of them the reach spans.
    counts: [i64; 3],
    spans: [i64; 3],
    /// The grains bin by bin, and where each bin starts.
    members: Vec<usize>,
    starts: Vec<usize>,
}

impl<'a> Neighbours<'a> {
    /// Sorts the centres into bins for a reach; `None` for a cell without a volume or a reach that is not positive.
    pub(crate) fn new(cell: &'a Matrix, positions: &[Vector], reach: f64) -> Option<Neighbours<'a>> {
        let is_usable = determinant(cell) != 0.0 && reach > 0.0 && reach.is_finite();
        if !is_usable {
            return None;
        }
        let inverse = invert(cell);
        let heights: Vector =
            std::array::from_fn(|k| 1.0 / inverse[k].iter().map(|x| x * x).sum::<f64>().sqrt());
        // More bins than grains would be empty.
        let most = libm::cbrt(positions.len() as f64).ceil().max(1.0);
        let counts: [i64; 3] =
            std::array::from_fn(|k| (2.0 * heights[k] / reach).floor().clamp(1.0, most) as i64);
        let spans = std::array::from_fn(|k| (reach * counts[k] as f64 / heights[k]).ceil() as i64);
        let places: Vec<Vector> =
            positions.iter().map(|x| apply(&inverse, *x).map(|s| s - s.floor())).collect();
        let bin = |s: f64, k: usize| ((s * counts[k] as f64) as i64).min(counts[k] - 1);
        let bins: Vec<[i64; 3]> = places.iter().map(|s| std::array::from_fn(|k| bin(s[k], k))).collect();
        let mut found = Neighbours {
            cell,
            reach,
            centres: places.into_iter().map(|s| apply(cell, s)).collect(),
            bins,
            counts,
            spans,
            members: (0..positions.len()).collect(),
            starts: Vec::new(),
        };
        let numbers: Vec<usize> = found.bins.iter().map(|bin| found.number(*bin)).collect();
        found.members.sort_by_key(|&grain| (numbers[grain], grain));
        let total = counts.iter().product::<i64>() as usize;
        found.starts = vec![0; total + 1];
        numbers.iter().for_each(|&number| found.starts[number + 1] += 1);
        (0..total).for_each(|number| found.starts[number + 1] += found.starts[number]);
        Some(found)
    }

    fn number(&self, [a, b, c]: [i64; 3]) -> usize {
        ((a * self.counts[1] + b) * self.counts[2] + c) as usize
    }

    /// Calls `each` with every image of a grain whose centre lies nearer than the reach to that of grain `i`: its index, the
    /// branch to it and its length. The order is fixed. Of the grain itself only other images are neighbours.
    pub(crate) fn each_of(&self, i: usize, mut each: impl FnMut(usize, Vector, f64)) {
        let [x, y, z] = self.spans;
        let around = (-x..=x).flat_map(|a| (-y..=y).flat_map(move |b| (-z..=z).map(move |c| [a, b, c])));
        for step in around {
            let bin: [i64; 3] = std::array::from_fn(|k| self.bins[i][k] + step[k]);
            let image: Vector = std::array::from_fn(|k| bin[k].div_euclid(self.counts[k]) as f64);
            let number = self.number(std::array::from_fn(|k| bin[k].rem_euclid(self.counts[k])));
            let shift = apply(self.cell, image);
            for &j in &self.members[self.starts[number]..self.starts[number + 1]] {
                let branch: Vector =
                    std::array::from_fn(|a| self.centres[j][a] + shift[a] - self.centres[i][a]);
                let distance = branch.iter().map(|x| x * x).sum::<f64>().sqrt();
                let is_itself = j == i && image == [0.0; 3];
                if distance < self.reach && !is_itself {
                    each(j, branch, distance);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    #[test]
    fn shells_of_a_lattice_are_found_in_a_large_and_in_a_tiny_cell() {
        for n in [1, 2, 5] {
            let lattice = lattice::simple_cubic(n, 1.0, 0.0, 0.0);
            let positions: Vec<Vector> = lattice.grains.iter().map(|grain| grain.position).collect();
            // Up to a distance of 2.1 there are shells of 6, 12, 8 and 6.
            let neighbours = Neighbours::new(&lattice.cell, &positions, 2.1).unwrap();
            for i in 0..positions.len() {
                let mut shells = [0; 5];
                neighbours.each_of(i, |_, _, distance| shells[(distance * distance).round() as usize] += 1);
                assert_eq!(shells, [0, 6, 12, 8, 6], "{n}");
            }
        }
    }

    /// Against plain loops over all images, in a skew cell, with centres outside it.
    #[test]
    fn a_skew_cell_has_the_neighbours_of_plain_loops() {
        let mut assembly = lattice::random_contacts(40, 9);
        assembly.cell = [[1.0, 0.6, -0.3], [0.0, 0.8, 0.5], [0.0, 0.0, 1.1]];
        let positions: Vec<Vector> = assembly
            .grains
            .iter()
            .map(|grain| apply(&assembly.cell, grain.position).map(|x| x + 3.0))
            .collect();
        let reach = 0.9;
        let neighbours = Neighbours::new(&assembly.cell, &positions, reach).unwrap();
        for i in 0..positions.len() {
            let mut found: Vec<(usize, i64)> = Vec::new();
            neighbours.each_of(i, |j, _, distance| found.push((j, (1e9 * distance).round() as i64)));
            let mut plain = Vec::new();
            for (j, other) in positions.iter().enumerate() {
                for image in 0..11 * 11 * 11 {
                    let image = [image % 11 - 5, image / 11 % 11 - 5, image / 121 - 5].map(f64::from);
                    let shift = apply(&assembly.cell, image);
                    let square: f64 = (0..3).map(|a| (other[a] + shift[a] - positions[i][a]).powi(2)).sum();
                    if square.sqrt() < reach && !(i == j && image == [0.0; 3]) {
                        plain.push((j, (1e9 * square.sqrt()).round() as i64));
                    }
                }
            }
            found.sort_unstable();
            plain.sort_unstable();
            assert_eq!(found, plain);
        }
    }

    #[test]
    fn the_number_of_neighbours_is_known_before_they_are_searched() {
        let lattice = lattice::simple_cubic(6, 1.0, 0.0, 0.0);
        // Up to a distance of 2.1 there are 32 and the grain itself; a sphere of this radius has a volume of 38.8.
        assert!((expected(&lattice.cell, lattice.grains.len(), 2.1) - 38.8).abs() < 0.1);
        assert_eq!(expected(&[[0.0; 3]; 3], 10, 1.0), 0.0);
    }

    #[test]
    fn a_cell_without_a_volume_has_none() {
        assert!(Neighbours::new(&[[0.0; 3]; 3], &[[0.0; 3]], 1.0).is_none());
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(Neighbours::new(&unit, &[[0.0; 3]], 0.0).is_none());
    }
}
