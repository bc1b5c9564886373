//! The path of a state of a hybrid point: what its grains follow when they take over from the surrogate, and what a surrogate can learn from afterwards.

use std::sync::Arc;

use granum_core::geometry::Matrix;
use granum_core::{Column, Table};
use granum_dem::servo::{PLACES, component, strain_component};

use crate::increment::Pace;

/// The columns of strain by components xx, yy, zz, yz, zx, xy.
pub(crate) const STRAINS: [&str; 6] = [
    "axial_strain",
    "lateral_strain_2",
    "lateral_strain_3",
    "shear_strain_yz",
    "shear_strain_zx",
    "shear_strain_xy",
];
/// The columns of stress by the same components.
pub(crate) const STRESSES: [&str; 6] =
    ["stress_11", "stress_22", "stress_33", "stress_23", "stress_13", "stress_12"];

/// A part of a path, with those before it. States share the parts that they have in common.
#[derive(Clone, Debug)]
pub(crate) struct PathPart {
    pub(crate) before: Option<Arc<PathPart>>,
    /// Logarithmic strain of the part, in the axes of the cell.
    pub(crate) strain: Matrix,
    pub(crate) pace: Pace,
    /// Stress after it, Pa, in the axes of the cell.
    pub(crate) stress: Matrix,
}

impl Drop for PathPart {
    /// One after the other: a path of many parts would otherwise need as many nested calls.
    fn drop(&mut self) {
        let mut next = self.before.take();
        while let Some(part) = next {
            next = Arc::into_inner(part).and_then(|mut part| part.before.take());
        }
    }
}

/// The parts of a path, the first one first.
pub(crate) fn parts(last: Option<&Arc<PathPart>>) -> Vec<&PathPart> {
    let mut found = Vec::new();
    let mut next = last;
    while let Some(part) = next {
        found.push(part.as_ref());
        next = part.before.as_ref();
    }
    found.reverse();
    found
}

/// The strains since the start and the stresses along a path, a row for each part, after that of the start.
pub(crate) fn table(last: &Arc<PathPart>, start: &Matrix) -> Option<Table> {
    let mut strains: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0]);
    let mut stresses: [Vec<f64>; 6] = std::array::from_fn(|k| vec![component(start, k)]);
    for part in parts(Some(last)) {
        for k in 0..PLACES.len() {
            let before = strains[k].last().copied().unwrap_or(0.0);
            strains[k].push(before + strain_component(&part.strain, k));
            stresses[k].push(component(&part.stress, k));
        }
    }
    let column = |unit: &'static str| move |(name, values): (&str, Vec<f64>)| Column::new(name, unit, values);
    let strains = STRAINS.into_iter().zip(strains).map(column("1"));
    let stresses = STRESSES.into_iter().zip(stresses).map(column("Pa"));
    Table::new(strains.chain(stresses).collect()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_path_is_dropped_and_told_in_order() {
        let mut last: Option<Arc<PathPart>> = None;
        for k in 0..200_000 {
            let strain = [[1e-6, 0.0, 0.0], [0.0; 3], [0.0; 3]];
            let stress = [[f64::from(k), 0.0, 0.0], [0.0; 3], [0.0; 3]];
            last = Some(Arc::new(PathPart { before: last, strain, pace: Pace::OfControls, stress }));
        }
        let last = last.unwrap();
        // Another state that has the path in common keeps it.
        let other = Arc::clone(&last);
        drop(last);
        let table = table(&other, &[[7.0, 0.0, 0.0], [0.0; 3], [0.0; 3]]).unwrap();
        let stress = table.values("stress_11").unwrap();
        assert_eq!((stress.len(), stress[0], stress[1], stress[200_000]), (200_001, 7.0, 0.0, 199_999.0));
        assert!((table.values("axial_strain").unwrap()[200_000] - 0.2).abs() < 1e-9);
    }
}
