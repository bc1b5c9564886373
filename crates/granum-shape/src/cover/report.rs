//! How well spheres cover a body.

use granum_core::assembly::Vector;
use granum_core::geometry::length;

use super::samples::Sample;
use crate::principal_axes::principal;
use crate::rigid_shape::equivalent_radius;
use crate::union_of_spheres::{Moments, ShapeOfSpheres, Spheres, sphericity};

/// Largest number of steps in which the radii grow, and the error of the volume at which they stop.
const GROWTHS: usize = 8;
const NEAR: f64 = 1e-6;

/// Errors of a cover, each over what it is of the original. That of the volume is of the spheres as they were found; the others are after
/// the radii have grown and all was scaled to the volume of the original.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CoverReport {
    /// Number of spheres.
    pub pieces: usize,
    /// Error of the volume of the spheres as they were found: gaps remain between spheres inside a body.
    pub volume: f64,
    /// What was then added to all radii, so that the volume is that of the original, over the diameter of the sphere of equal volume: the
    /// spheres stand out by as much.
    pub growth: f64,
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

impl std::fmt::Display for CoverReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let percent = |x: f64| format!("{:+.1} %", 100.0 * x);
        write!(
            f,
            "{} spheres, found with an error of the volume of {}, grown by {:.3} of the diameter to its volume; errors of the moments of inertia \
             {}, {}, {}, of the sphericity {}; distance of the surfaces {:.3} of the diameter, at most {:.3}",
            self.pieces,
            percent(self.volume),
            self.growth,
            percent(self.inertia[0]),
            percent(self.inertia[1]),
            percent(self.inertia[2]),
            percent(self.sphericity),
            self.mean_distance,
            self.largest_distance
        )
    }
}

/// A body that is covered.
pub(crate) struct Original {
    pub moments: Moments,
    pub samples: Vec<Sample>,
}

impl Original {
    /// Lets the radii grow until the volume is that of the original, and reports how well the spheres then cover it.
    ///
    /// # Errors
    /// With what is wrong about the spheres.
    pub(crate) fn compare(&self, spheres: &Spheres) -> Result<(Spheres, CoverReport), String> {
        let (grown, volume, growth) = self.grown(spheres)?;
        let found = ShapeOfSpheres::new(&grown)?;
        let factor = equivalent_radius(self.moments.volume) / equivalent_radius(found.shape.volume);
        let centre = found.centre;
        let place = |c: &Vector| std::array::from_fn(|a| centre[a] + factor * (c[a] - centre[a]));
        let scaled: Spheres = grown.iter().map(|(c, r)| (place(c), factor * r)).collect();
        let (inertia, _) = principal(&self.moments.inertia_over_volume());
        let square = factor * factor;
        let surface = self.moments.surface;
        let of_spheres = sphericity(self.moments.volume, found.surface * square);
        let [mean_distance, largest_distance] = self.distances(&scaled);
        let report = CoverReport {
            pieces: spheres.len(),
            volume: volume / self.moments.volume - 1.0,
            growth: growth / (2.0 * equivalent_radius(self.moments.volume)),
            inertia: std::array::from_fn(|k| found.shape.inertia_over_mass[k] * square / inertia[k] - 1.0),
            surface: found.surface * square / surface - 1.0,
            sphericity: of_spheres / sphericity(self.moments.volume, surface) - 1.0,
            mean_distance,
            largest_distance,
        };
        Ok((scaled, report))
    }

    /// The spheres with one length added to all radii, so that their union has the volume of the original; their volume before, and the length. The
    /// volume grows with the radii by the surface (Newton's method).
    fn grown(&self, spheres: &Spheres) -> Result<(Spheres, f64, f64), String> {
        let least = spheres.iter().map(|(_, r)| *r).fold(f64::INFINITY, f64::min);
        let with = |growth: f64| -> Spheres { spheres.iter().map(|(c, r)| (*c, r + growth)).collect() };
        let (mut growth, mut volume) = (0.0, None);
        for _ in 0..GROWTHS {
            let found = ShapeOfSpheres::new(&with(growth))?;
            let lacks = self.moments.volume - found.shape.volume;
            volume = volume.or(Some(found.shape.volume));
            if lacks.abs() < NEAR * self.moments.volume {
                break;
            }
            growth = f64::max(growth + lacks / found.surface, -0.5 * least);
        }
        Ok((with(growth), volume.unwrap_or(f64::NAN), growth))
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
