//! How well spheres cover a body.

use granum_core::assembly::Vector;
use granum_core::geometry::length;

use super::samples::Sample;
use crate::family::Spheres;
use crate::principal_axes::principal;
use crate::rigid_shape::equivalent_radius;
use crate::union_of_spheres::{Moments, ShapeOfSpheres, sphericity};

/// Errors of a cover, each over what it is of the original. That of the volume is before, all others are after the scaling to the volume of
/// the original.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CoverReport {
    /// Number of spheres.
    pub pieces: usize,
    /// Error of the volume before scaling.
    pub volume: f64,
    /// Errors of the principal moments of inertia, in rising order.
    pub inertia: Vector,
    /// Error of the surface, that of the union of the spheres with its seams; not a number where the surface of the original is not known.
    pub surface: f64,
    /// Error of the sphericity, likewise.
    pub sphericity: f64,
    /// Mean distance of the surface of the original from that of the spheres, over the diameter of the sphere of equal volume.
    pub mean_distance: f64,
    /// Largest such distance.
    pub largest_distance: f64,
}

/// A body that is covered.
pub(crate) struct Original {
    pub moments: Moments,
    pub samples: Vec<Sample>,
}

impl Original {
    /// Scales spheres about their centre of mass to the volume of the original, and reports how well they then cover it.
    ///
    /// # Errors
    /// With what is wrong about the spheres.
    pub(crate) fn compare(&self, spheres: &Spheres) -> Result<(Spheres, CoverReport), String> {
        let found = ShapeOfSpheres::new(spheres)?;
        let factor = equivalent_radius(self.moments.volume) / equivalent_radius(found.shape.volume);
        let centre = found.centre;
        let place = |c: &Vector| std::array::from_fn(|a| centre[a] + factor * (c[a] - centre[a]));
        let scaled: Spheres = spheres.iter().map(|(c, r)| (place(c), factor * r)).collect();
        let (inertia, _) = principal(&self.moments.inertia_over_volume());
        let square = factor * factor;
        let surface = self.moments.surface;
        let of_spheres = sphericity(self.moments.volume, found.surface * square);
        let [mean_distance, largest_distance] = self.distances(&scaled);
        let report = CoverReport {
            pieces: spheres.len(),
            volume: found.shape.volume / self.moments.volume - 1.0,
            inertia: std::array::from_fn(|k| found.shape.inertia_over_mass[k] * square / inertia[k] - 1.0),
            surface: found.surface * square / surface - 1.0,
            sphericity: of_spheres / sphericity(self.moments.volume, surface) - 1.0,
            mean_distance,
            largest_distance,
        };
        Ok((scaled, report))
    }

    /// Mean and largest distance of the surface from spheres, over the diameter of the sphere of equal volume. For a point inside several
    /// spheres it is that from the sphere in which it is deepest.
    fn distances(&self, spheres: &Spheres) -> [f64; 2] {
        let diameter = 2.0 * equivalent_radius(self.moments.volume);
        let [mut sum, mut area, mut largest] = [0.0; 3];
        for sample in &self.samples {
            let from = |(c, r): &(Vector, f64)| length(&std::array::from_fn(|a| sample.place[a] - c[a])) - r;
            let distance = spheres.iter().map(from).fold(f64::INFINITY, f64::min).abs();
            sum += sample.area * distance;
            area += sample.area;
            largest = f64::max(largest, distance);
        }
        [sum / area / diameter, largest / diameter]
    }
}
