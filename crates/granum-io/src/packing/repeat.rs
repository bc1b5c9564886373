//! Larger packings from copies of a periodic cell.

use super::{PackedBody, PackedGrain, PackedMaterials, Packing};
use crate::error::{Error, Result};
use std::path::Path;

impl Packing {
    /// One cell made of `counts` copies of the cell along its edges. Contacts and stress are those of the original; ids are
    /// numbered on from copy to copy.
    ///
    /// # Errors
    /// [`Error::Content`] if a count is zero or there would be more than 4e9 grains, or if the packing lists bonds, whose images are not known.
    pub fn repeated(&self, counts: [usize; 3]) -> Result<Packing> {
        if !self.bonds.is_empty() {
            let what = format!(
                "copies of a packing with {} bonds are not made: take its spheres without them",
                self.bonds.len()
            );
            return Err(Error::content(Path::new("packing"), what));
        }
        let copies = counts.iter().try_fold(1usize, |n, &c| n.checked_mul(c));
        let total = copies.and_then(|n| n.checked_mul(self.grains.len()));
        if !total.is_some_and(|n| n > 0 && n < 4_000_000_000) {
            let what = format!("{} x {} x {} copies are not possible", counts[0], counts[1], counts[2]);
            return Err(Error::content(Path::new("packing"), what));
        }
        let mut grains = Vec::with_capacity(total.unwrap_or(0));
        for a in 0..counts[0] {
            for b in 0..counts[1] {
                for c in 0..counts[2] {
                    let at = [a as f64, b as f64, c as f64];
                    let first = grains.len() as u64;
                    grains.extend(self.grains.iter().map(|g| PackedGrain {
                        id: first + g.id,
                        position: std::array::from_fn(|k| {
                            let shift: f64 = (0..3).map(|e| self.cell[k][e] * at[e]).sum();
                            g.position[k] + shift
                        }),
                        radius: g.radius,
                    }));
                }
            }
        }
        let cell = self.cell.map(|row| std::array::from_fn(|k| row[k] * counts[k] as f64));
        let copies = total.unwrap_or(0) / self.grains.len().max(1);
        let of = if self.materials.of.is_empty() { Vec::new() } else { self.materials.of.repeat(copies) };
        let materials = PackedMaterials { names: self.materials.names.clone(), of };
        let remarks = self.remarks.clone();
        let copy = |copy: usize| {
            let first = copy * self.grains.len();
            self.bodies.iter().map(move |body| PackedBody { grain: first + body.grain, ..body.clone() })
        };
        let bodies = (0..copies).flat_map(copy).collect();
        Ok(Packing { bodies, materials, remarks, ..Packing::new(self.origin, cell, grains) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_fill_the_larger_cell_and_overlap_as_the_original() {
        let cell = [[3.0, 0.5, 0.0], [0.0, 3.0, 0.2], [0.0, 0.0, 3.0]];
        let grain = |id, position| PackedGrain { id, position, radius: 0.5 };
        let one = Packing {
            origin: [0.1, 0.0, -0.2],
            cell,
            grains: vec![grain(1, [0.2, 0.1, 0.0]), grain(2, [1.2, 0.1, 0.0])],
            bodies: Vec::new(),
            bonds: Vec::new(),
            materials: PackedMaterials { names: vec!["a".into(), "b".into()], of: vec![0, 1] },
            remarks: Vec::new(),
        };
        let many = one.repeated([2, 1, 3]).unwrap();
        assert_eq!(many.grains.len(), 12);
        assert!(many.grains.iter().enumerate().all(|(k, g)| g.id == k as u64 + 1));
        assert!((many.solid_fraction() / one.solid_fraction() - 1.0).abs() < 1e-14);
        assert_eq!(many.cell, [[6.0, 0.5, 0.0], [0.0, 3.0, 3.0 * 0.2], [0.0, 0.0, 9.0]]);
        // Every copy of grain 1 is displaced from it by a lattice vector.
        let last = &many.grains[10];
        let away: Vec<f64> = (0..3).map(|k| last.position[k] - one.grains[0].position[k]).collect();
        assert!((away[0] - 3.0).abs() < 1e-14 && (away[1] - 0.4).abs() < 1e-14);
        assert!((away[2] - 6.0).abs() < 1e-14);
        // The packing can be written and read back.
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("many.csv");
        crate::write_packing(&file, &many).unwrap();
        assert_eq!(crate::read_packing(&file).unwrap(), many);
    }

    #[test]
    fn no_copies_are_refused() {
        let one = Packing::new([0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], vec![]);
        assert!(one.repeated([1, 1, 1]).is_err());
        assert!(one.repeated([0, 1, 1]).unwrap_err().to_string().contains("0 x 1 x 1"));
    }
}
