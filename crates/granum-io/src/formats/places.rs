//! Contacts that name their grains by places: the grain whose centre is at that place, or at an image of it.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use granum_core::assembly::{Assembly, Vector};
use granum_core::geometry::{apply, determinant, invert};

use super::result::FileContact;
use crate::error::{Error, Result};

/// How far a place may be from the centre of its grain, relative to the radius: files of single precision round it.
const TOLERANCE: f64 = 0.01;

/// The contacts with the ids of their grains in place of the numbers of their centres. Two contacts of the same grains are one:
/// those across a face of the cell may stand in a file from both sides. `corner` is that of the cell of the centres; the grains
/// are in a cell with a corner at the origin.
pub(super) fn identify(
    path: &Path,
    assembly: &Assembly,
    corner: Vector,
    centres: &[Vector],
    pairs: Vec<FileContact>,
) -> Result<Vec<FileContact>> {
    let grid = Grid::new(assembly);
    let mut ids: Vec<Option<u64>> = vec![None; centres.len()];
    let mut id = |number: u64| -> Result<u64> {
        let at = usize::try_from(number).ok().filter(|at| *at < centres.len());
        let Some(at) = at else {
            return Err(Error::content(
                path,
                format!("a contact names the centre {number}, which is not there"),
            ));
        };
        if let Some(known) = ids[at] {
            return Ok(known);
        }
        let place = std::array::from_fn(|a| centres[at][a] - corner[a]);
        let found = grid.grain(place).ok_or_else(|| {
            let message = format!(
                "a contact has its end at {:?}, where no grain is; is it of the same instant?",
                centres[at]
            );
            Error::content(path, message)
        })?;
        ids[at] = Some(assembly.bodies[found].id);
        Ok(assembly.bodies[found].id)
    };
    let mut seen = HashSet::new();
    let mut found = Vec::with_capacity(pairs.len());
    for pair in pairs {
        let (first, second) = (id(pair.first)?, id(pair.second)?);
        if seen.insert((first.min(second), first.max(second))) {
            found.push(FileContact { first, second, ..pair });
        }
    }
    Ok(found)
}

/// Volume of the cell, or of the cuboid around the centres if there is no cell, m3.
fn space(assembly: &Assembly, is_cell: bool) -> f64 {
    if is_cell {
        return determinant(&assembly.cell).abs();
    }
    let extent = |axis: usize| {
        let places = assembly.bodies.iter().map(|grain| grain.position[axis]);
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        (high - low).max(0.0)
    };
    extent(0) * extent(1) * extent(2)
}

/// The grains by bins of the cell, or of space if there is no cell.
struct Grid<'a> {
    assembly: &'a Assembly,
    inverse: [[f64; 3]; 3],
    bins: Vector,
    is_cell: bool,
    grains: HashMap<[i64; 3], Vec<usize>>,
}

impl<'a> Grid<'a> {
    fn new(assembly: &'a Assembly) -> Grid<'a> {
        let inverse = invert(&assembly.cell);
        let is_cell = inverse.iter().flatten().all(|x| x.is_finite());
        let largest = assembly.pieces.iter().map(|piece| piece.radius).fold(0.0, f64::max);
        // About one grain in a bin, however large the largest of them is; what is searched lies within the tolerance.
        let spacing = libm::cbrt(space(assembly, is_cell) / assembly.bodies.len().max(1) as f64);
        let width = spacing.max(TOLERANCE * largest);
        let width = if width > 0.0 { width } else { 1.0 };
        let bins = if is_cell {
            let heights = granum_core::Cell { edges: assembly.cell }.heights();
            heights.map(|height| (height / width).floor().clamp(1.0, 1e6))
        } else {
            [1.0 / width; 3]
        };
        let mut grid = Grid { assembly, inverse, bins, is_cell, grains: HashMap::new() };
        for (k, grain) in assembly.bodies.iter().enumerate() {
            grid.grains.entry(grid.bin(grid.place(grain.position))).or_default().push(k);
        }
        grid
    }

    /// A position in units of the edges, wrapped into the cell.
    fn place(&self, position: Vector) -> Vector {
        if self.is_cell { apply(&self.inverse, position).map(|s| s - s.floor()) } else { position }
    }

    fn bin(&self, place: Vector) -> [i64; 3] {
        std::array::from_fn(|a| (place[a] * self.bins[a]).floor() as i64)
    }

    fn grain(&self, position: Vector) -> Option<usize> {
        let place = self.place(position);
        let bin = self.bin(place);
        let mut best = (f64::INFINITY, None);
        for n in 0..27 {
            let shift = [n % 3, n / 3 % 3, n / 9].map(|k| k - 1);
            let near: [i64; 3] = std::array::from_fn(|a| match self.is_cell {
                true => (bin[a] + shift[a]).rem_euclid(self.bins[a] as i64),
                false => bin[a] + shift[a],
            });
            for k in self.grains.get(&near).into_iter().flatten() {
                let distance = self.distance(place, *k);
                if distance < best.0 {
                    best = (distance, Some(*k));
                }
            }
        }
        best.1.filter(|k| best.0 <= TOLERANCE * self.assembly.pieces[*k].radius)
    }

    fn distance(&self, place: Vector, k: usize) -> f64 {
        let other = self.place(self.assembly.bodies[k].position);
        let apart: Vector = std::array::from_fn(|a| other[a] - place[a]);
        let vector =
            if self.is_cell { apply(&self.assembly.cell, apart.map(|s| s - libm::round(s))) } else { apart };
        vector.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::assembly::Sphere;

    fn assembly() -> Assembly {
        let grain = |id, position| Sphere { id, position, radius: 0.5, ..Sphere::default() };
        Assembly { cell: [[4.0, 1.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]], ..Assembly::default() }
            .with_spheres(vec![
                grain(3, [0.01, 1.0, 1.0]),
                grain(8, [1.0, 1.0, 1.0]),
                grain(9, [4.2, 3.0, 1.0]),
            ])
    }

    #[test]
    fn grains_are_found_by_their_images_and_each_contact_once() {
        let centres =
            vec![[3.99 + 0.02, 1.0, 1.0], [1.001, 1.0, 1.0], [4.2 - 4.0, 3.0, 5.0], [0.011, 1.0, 1.0]];
        let pair = |first, second| FileContact { first, second, ..FileContact::default() };
        let found = identify(
            Path::new("c.vtp"),
            &assembly(),
            [0.0; 3],
            &centres,
            vec![pair(0, 1), pair(1, 3), pair(2, 1)],
        );
        let found: Vec<_> = found.unwrap().iter().map(|pair| (pair.first, pair.second)).collect();
        assert_eq!(found, [(3, 8), (9, 8)]);
    }

    #[test]
    fn a_place_without_a_grain_is_refused() {
        let pair = FileContact { first: 0, second: 1, ..FileContact::default() };
        let centres = [[1.0; 3], [2.0; 3]];
        let error = identify(Path::new("c.vtp"), &assembly(), [0.0; 3], &centres, vec![pair]).unwrap_err();
        assert!(error.to_string().starts_with("c.vtp: a contact has its end at [2.0, 2.0, 2.0]"), "{error}");
    }
}
