//! Grains within a given distance of each other, in a periodic cell of any shape and size. If the cell is smaller than the
//! distance, a grain has several images of another grain, and of itself, as neighbours.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::{apply, determinant, invert};

/// Most work, in steps of some nanoseconds, that a sensor does in searches for neighbours: this number for each grain, and for few grains
/// [`LEAST_WORK`]. Equal grains in a dense packing take some hundreds of steps a grain within two diameters and some thousands within five;
/// more is taken where grains differ in size by a factor above ten, or are clustered in a cell that is otherwise empty.
pub(crate) const WORK_OF_A_GRAIN: f64 = 20_000.0;
/// Work that is done for any number of grains.
pub(crate) const LEAST_WORK: f64 = 2e8;

/// The most work for a number of grains.
pub(crate) fn most_work(grains: usize) -> f64 {
    LEAST_WORK.max(WORK_OF_A_GRAIN * grains as f64)
}

/// Why a sensor is left out that would do more.
pub(crate) const TOO_MUCH_WORK: &str = "the grains differ so much in size, or leave so much of the cell empty, that the search for \
                                        neighbours would take more than 20000 steps for each of them, and more than 2e8 in all";

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

    /// Steps that [`Neighbours::each_of`] takes for some grains: one for each bin and for each grain in it. The count ends as soon as it is
    /// above the most.
    pub(crate) fn work(&self, grains: impl Iterator<Item = usize>, most: f64) -> f64 {
        let bins: f64 = self.spans.iter().map(|span| 2.0 * *span as f64 + 1.0).product();
        let mut known: Vec<Option<f64>> = vec![None; self.starts.len().saturating_sub(1)];
        let mut sum = 0.0;
        for i in grains {
            // Bins alone may be too many to be visited.
            if sum + bins > most {
                return sum + bins;
            }
            let number = self.number(self.bins[i]);
            let counted =
                || bins + self.around(i).map(|(_, number)| self.members_of(number).len() as f64).sum::<f64>();
            sum += *known[number].get_or_insert_with(counted);
        }
        sum
    }

    /// The bins that the reach can touch from a grain, images included: the image of the cell, and the number of the bin.
    fn around(&self, i: usize) -> impl Iterator<Item = (Vector, usize)> {
        let [x, y, z] = self.spans;
        let steps = (-x..=x).flat_map(move |a| (-y..=y).flat_map(move |b| (-z..=z).map(move |c| [a, b, c])));
        steps.map(move |step| {
            let bin: [i64; 3] = std::array::from_fn(|k| self.bins[i][k] + step[k]);
            let image = std::array::from_fn(|k| bin[k].div_euclid(self.counts[k]) as f64);
            (image, self.number(std::array::from_fn(|k| bin[k].rem_euclid(self.counts[k]))))
        })
    }

    fn members_of(&self, number: usize) -> &[usize] {
        &self.members[self.starts[number]..self.starts[number + 1]]
    }

    /// Calls `each` with every image of a grain whose centre lies nearer than the reach to that of grain `i`: its index, the
    /// branch to it and its length. The order is fixed. Of the grain itself only other images are neighbours.
    pub(crate) fn each_of(&self, i: usize, mut each: impl FnMut(usize, Vector, f64)) {
        for (image, number) in self.around(i) {
            let shift = apply(self.cell, image);
            for &j in self.members_of(number) {
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
            let positions: Vec<Vector> = lattice.bodies.iter().map(|grain| grain.position).collect();
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
            .bodies
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
    fn the_work_is_known_before_it_is_done() {
        let lattice = lattice::simple_cubic(6, 1.0, 0.0, 0.0);
        let positions: Vec<Vector> = lattice.bodies.iter().map(|grain| grain.position).collect();
        // Five bins along each edge, of which the reach spans two on both sides: each grain visits every bin and every grain once.
        let neighbours = Neighbours::new(&lattice.cell, &positions, 2.1).unwrap();
        let all = |most| neighbours.work(0..positions.len(), most);
        assert_eq!(all(f64::INFINITY), 216.0 * (125.0 + 216.0));
        assert!(all(1000.0) > 1000.0 && all(1000.0) < 2000.0);
        // All grains in one place of a wide cell, where an even distribution would have next to no neighbours.
        let cell = [[1e3, 0.0, 0.0], [0.0, 1e3, 0.0], [0.0, 0.0, 1e3]];
        let neighbours = Neighbours::new(&cell, &positions, 20.0).unwrap();
        assert!(neighbours.work(0..216, f64::INFINITY) > 216.0 * 216.0);
        // A reach of many cells.
        let neighbours =
            Neighbours::new(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], &positions, 1e4).unwrap();
        assert!(neighbours.work(0..216, 1e9) > 1e9);
    }

    #[test]
    fn a_cell_without_a_volume_has_none() {
        assert!(Neighbours::new(&[[0.0; 3]; 3], &[[0.0; 3]], 1.0).is_none());
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(Neighbours::new(&unit, &[[0.0; 3]], 0.0).is_none());
    }
}
