//! Grains that are labelled in a stack of images, as of a computed tomography.

use rayon::prelude::*;

use crate::cover::grid::Grid;
use crate::cover::{Cover, CoveredBody, LargestGain, cover_grid};
use crate::entry::ShapeEntry;
use crate::families::mesh::SPHERES;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, ShapeParameter, Spheres};
use crate::{mesh, voxels};

/// The grains of a labelled stack of images, each of them a shape, covered by the spheres that fill most of it.
pub struct Voxels;

const SPACING_Y: ShapeParameter = ShapeParameter {
    key: "spacing_y",
    default: 1.0,
    bounds: [0.01, 100.0],
    whole: false,
    meaning: "Distance of the rows of an image over that of its columns.",
};

const SPACING_Z: ShapeParameter = ShapeParameter {
    key: "spacing_z",
    default: 1.0,
    bounds: [0.01, 100.0],
    whole: false,
    meaning: "Distance of the images of a stack over that of the columns of an image.",
};

impl ShapeFamily for Voxels {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "voxels",
            help: "the grains of a labelled stack of images, a TIFF file or a folder of them",
            parameters: &[SPACING_Y, SPACING_Z, SPHERES],
            takes_spheres: false,
            takes_file: true,
        }
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        self.shapes_with_notices(given, &mut Vec::new())
    }

    fn covered_bodies(
        &self,
        given: &ShapeEntry,
        notices: &mut Vec<String>,
    ) -> Result<Vec<CoveredBody>, ShapeError> {
        let covers = covers(given, notices)?.into_iter();
        Ok(covers.map(|(label, grid, cover)| CoveredBody::of_grid(label, &grid, cover)).collect())
    }
}

/// The grains of the file with their labels, and their covers. Notices say how well these are.
fn covers(given: &ShapeEntry, notices: &mut Vec<String>) -> Result<Vec<(u32, Grid, Cover)>, ShapeError> {
    let Some(path) = &given.file else {
        let message = "is missing: kind = \"voxels\" needs one, e.g. file = \"grains.tif\"";
        return Err(ShapeError::new("file", message));
    };
    let step = [1.0, given.value(&SPACING_Y), given.value(&SPACING_Z)];
    let grains = voxels::grains(&voxels::read(path)?, step, path, notices)?;
    let gain = LargestGain { pieces: given.value(&SPHERES) as usize, ..LargestGain::default() };
    let covered: Vec<Result<Cover, String>> =
        grains.par_iter().map(|(_, grid)| cover_grid(grid, &gain)).collect();
    let mut covers = Vec::new();
    for ((label, grid), cover) in grains.into_iter().zip(covered) {
        let refused =
            |why: String| mesh::fault(path, format!("has the label {label} that cannot be covered: {why}"));
        covers.push((label, grid, cover.map_err(refused)?));
    }
    notices.push(summary(&path.display().to_string(), &covers));
    Ok(covers)
}

/// How well the grains are covered.
fn summary(name: &str, covers: &[(u32, Grid, Cover)]) -> String {
    let inertia = |cover: &Cover| cover.report.inertia.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let largest = covers.iter().map(|(_, _, cover)| inertia(cover)).fold(0.0, f64::max);
    let mean = covers.iter().map(|(_, _, c)| c.report.mean_distance).sum::<f64>() / covers.len() as f64;
    format!(
        "{name:?}: {} grains are covered; errors of their moments of inertia are up to {:.1} %, the mean distance of the surfaces is {mean:.3} of the \
         diameter",
        covers.len(),
        100.0 * largest
    )
}
