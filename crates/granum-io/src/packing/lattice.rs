//! Lattices of periodic cells: many cells of different shape repeat the same grains, and the least skewed of them is the one to judge and to
//! search in.

use granum_core::Cell;
use granum_core::geometry::{Matrix, Vector, apply, determinant, dot, invert};

/// Largest number of edges that are replaced. Each replacement at least halves what is left of a skewness, which a number of 64 bits can
/// hold some thousand times.
const MOST_REPLACEMENTS: usize = 10_000;
/// An edge is replaced by one whose square is smaller by more than this fraction: less is rounding.
const GAIN: f64 = 1e-9;

/// Edges of the least skewed cell with the lattice of these edges (column k is edge k): none of them can be made shorter by adding or
/// subtracting the others (Minkowski reduction). Edges that are reduced are returned as they are.
///
/// The orientation, which is the sign of the determinant, stays as it is.
pub(crate) fn reduced(edges: &Matrix) -> Matrix {
    let mut vectors: [Vector; 3] = std::array::from_fn(|k| std::array::from_fn(|a| edges[a][k]));
    for _ in 0..MOST_REPLACEMENTS {
        if !shorten_by_one(&mut vectors) && !shorten_by_two(&mut vectors) {
            break;
        }
    }
    std::array::from_fn(|a| std::array::from_fn(|k| vectors[k][a]))
}

/// Largest ratio of the product of the lengths of a cell's edges to its volume with which a sample keeps its cell: 1 for a box, about 6
/// after a simple shear of 6. Images of a grain within a given distance are searched among many others where it is larger.
const MOST_SKEWED: f64 = 10.0;

/// The least skewed cell of the lattice, if the edges are so nearly parallel that searches for neighbours suffer, or if a grain of this
/// radius, m, fits only into that cell; otherwise none.
pub(crate) fn less_skewed(edges: &Matrix, largest_radius: f64) -> Option<Matrix> {
    let narrow = Cell { edges: *edges }.heights().into_iter().fold(f64::INFINITY, f64::min);
    let length = |column: usize| edges.iter().map(|row| row[column] * row[column]).sum::<f64>().sqrt();
    let skewness = (0..3).map(length).product::<f64>() / determinant(edges).abs();
    (skewness > MOST_SKEWED || narrow < 2.0 * largest_radius).then(|| reduced(edges))
}

/// The images of what is in a cell.
pub(crate) struct Images {
    /// Edges and their inverse: of the cell and, if it is skewed, of the least skewed cell of its lattice, next to whose images the nearest
    /// one always lies. None for a cell of zero volume, in which nothing has an image.
    cells: Vec<(Matrix, Matrix)>,
}

impl Images {
    /// The images of a cell with these edges.
    pub(crate) fn new(edges: &Matrix) -> Images {
        let inverse = invert(edges);
        if inverse.iter().flatten().any(|x| !x.is_finite()) {
            return Images { cells: Vec::new() };
        }
        let reduced = less_skewed(edges, 0.0).map(|edges| (edges, invert(&edges)));
        Images { cells: std::iter::once((*edges, inverse)).chain(reduced).collect() }
    }

    /// The shortest of the images of a vector between two places.
    pub(crate) fn nearest(&self, apart: Vector) -> Vector {
        self.cells.iter().fold(apart, |apart, (edges, inverse)| nearest_in(edges, inverse, apart))
    }
}

/// The shortest vector among the images next to the one that is nearest by fractions of the edges.
fn nearest_in(edges: &Matrix, inverse: &Matrix, apart: Vector) -> Vector {
    let middle = apply(inverse, apart).map(f64::round);
    let mut best = (f64::INFINITY, apart);
    for n in 0..27 {
        let shift =
            std::array::from_fn(|a| middle[a] + [n % 3, n / 3 % 3, n / 9].map(|k| f64::from(k) - 1.0)[a]);
        let moved = apply(edges, shift);
        let vector: Vector = std::array::from_fn(|a| apart[a] - moved[a]);
        let square = dot(&vector, &vector);
        if square < best.0 {
            best = (square, vector);
        }
    }
    best.1
}

/// Edges of the same lattice whose determinant is positive: of left-handed ones each is turned round.
pub(crate) fn right_handed(edges: &Matrix) -> Matrix {
    if determinant(edges) < 0.0 { edges.map(|row| row.map(|x| -x)) } else { *edges }
}

/// Subtracts multiples of one edge from another; false if nothing becomes shorter by it.
fn shorten_by_one(vectors: &mut [Vector; 3]) -> bool {
    let mut shorter = false;
    for k in 0..3 {
        for by in (0..3).filter(|by| *by != k) {
            let times = libm::round(dot(&vectors[k], &vectors[by]) / dot(&vectors[by], &vectors[by]));
            if times.is_finite() && times != 0.0 {
                let candidate = std::array::from_fn(|a| vectors[k][a] - times * vectors[by][a]);
                shorter |= replace(&mut vectors[k], candidate);
            }
        }
    }
    shorter
}

/// Adds both other edges, with either sign, to one; false if nothing becomes shorter by it.
fn shorten_by_two(vectors: &mut [Vector; 3]) -> bool {
    for k in 0..3 {
        let [one, two] = [vectors[(k + 1) % 3], vectors[(k + 2) % 3]];
        for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let candidate = std::array::from_fn(|a| vectors[k][a] + s * one[a] + t * two[a]);
            if replace(&mut vectors[k], candidate) {
                return true;
            }
        }
    }
    false
}

fn replace(vector: &mut Vector, candidate: Vector) -> bool {
    let shorter = dot(&candidate, &candidate) < (1.0 - GAIN) * dot(vector, vector);
    if shorter {
        *vector = candidate;
    }
    shorter
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::geometry::{invert, multiply};

    /// Product of the lengths of the edges over the volume of the cell.
    fn skewness(edges: &Matrix) -> f64 {
        let length = |k: usize| edges.iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
        length(0) * length(1) * length(2) / determinant(edges).abs()
    }

    #[test]
    fn a_skewed_cell_becomes_the_box_of_its_lattice() {
        let cube = [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]];
        let change = [[1.0, 7.0, -3.0], [0.0, 1.0, 12.0], [0.0, 0.0, 1.0]];
        let found = reduced(&multiply(&cube, &change));
        assert!((skewness(&found) - 1.0).abs() < 1e-12, "{found:?}");
        assert_eq!(determinant(&found), 8.0);
        assert_eq!(reduced(&cube), cube);
    }

    /// Whole numbers lead from one basis to the other, so that both span one lattice.
    #[test]
    fn the_lattice_and_its_orientation_stay() {
        let edges = [[1.0, 5.3, -2.1], [0.0, 1.2, 8.4], [0.0, 0.1, -0.9]];
        let found = reduced(&edges);
        let change = multiply(&invert(&edges), &found);
        let whole = |x: &f64| (x - x.round()).abs() < 1e-9;
        assert!(change.iter().flatten().all(whole), "{change:?}");
        assert!((determinant(&change) - 1.0).abs() < 1e-9);
        assert!(skewness(&found) < 2.0 && skewness(&edges) > 10.0);
    }

    /// By four edges in each direction the images next to the nearest fractions do not hold the shortest vector.
    #[test]
    fn the_nearest_image_is_the_shortest_in_a_skewed_cell_too() {
        let skewed = [[1.0, 40.3, 0.0], [0.0, 1.0, 17.6], [0.0, 0.0, 1.0]];
        let cube = Images::new(&reduced(&skewed));
        let images = Images::new(&skewed);
        for apart in [[0.4, 0.1, 0.3], [7.3, -2.2, 0.9], [-0.6, 11.5, 3.4]] {
            let [one, two] = [images.nearest(apart), cube.nearest(apart)].map(|v| dot(&v, &v));
            assert!((one - two).abs() < 1e-9, "{apart:?}: {one} {two}");
        }
        assert_eq!(Images::new(&[[0.0; 3]; 3]).nearest([5.0, 0.0, 0.0]), [5.0, 0.0, 0.0]);
    }

    #[test]
    fn a_left_handed_cell_is_turned_round() {
        let left = [[0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 3.0]];
        assert_eq!(determinant(&right_handed(&left)), 6.0);
        assert_eq!(right_handed(&right_handed(&left)), right_handed(&left));
    }

    #[test]
    fn edges_that_span_no_volume_end() {
        for edges in [[[0.0; 3]; 3], [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0; 3]], [[f64::NAN; 3]; 3]] {
            let _ = reduced(&edges);
        }
    }
}
