//! Spheres that touch the surface at random points from inside (Ferellec and McDowell 2010). They keep flat faces.
//!
//! A sphere that touches the surface at v with the inward normal n grows until it meets another point w of the surface, at the radius
//! `|w - v|^2 / (2 n.(w - v))`: the least of these is the limit of growing in small steps.

use granum_core::assembly::Vector;
use granum_core::geometry::{dot, length};

use super::samples::Sample;
use crate::family::Spheres;
use crate::random::Random;

/// When to stop, and where spheres begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentSpheres {
    /// Largest number of spheres.
    pub pieces: usize,
    /// Seed of the random points.
    pub seed: u64,
    /// Least distance of a point from all spheres at which another one may begin, over the largest radius.
    pub least_distance: f64,
    /// Share of the points at which to stop that are closer to a sphere than that.
    pub share: f64,
}

/// The spheres of a surface.
pub(crate) fn tangent_spheres(surface: &[Sample], given: &TangentSpheres) -> Spheres {
    let mut random = Random::new(given.seed, 0, 0);
    let mut open: Vec<usize> = (0..surface.len()).collect();
    let mut spheres: Spheres = Vec::new();
    let mut largest: f64 = 0.0;
    while spheres.len() < given.pieces && open.len() as f64 > (1.0 - given.share) * surface.len() as f64 {
        let chosen = open.swap_remove(((random.even() * open.len() as f64) as usize).min(open.len() - 1));
        let Some(radius) = grown(surface, chosen) else { continue };
        let Sample { place, normal, .. } = surface[chosen];
        let centre: Vector = std::array::from_fn(|a| place[a] - radius * normal[a]);
        spheres.push((centre, radius));
        largest = largest.max(radius);
        let from = |k: &usize| length(&std::array::from_fn(|a| surface[*k].place[a] - centre[a])) - radius;
        open.retain(|k| from(k) > given.least_distance * largest);
    }
    spheres
}

/// The radius at which the sphere that touches a point meets another one.
fn grown(surface: &[Sample], chosen: usize) -> Option<f64> {
    let Sample { place, normal, .. } = surface[chosen];
    let radius = |other: &Sample| {
        let apart: Vector = std::array::from_fn(|a| other.place[a] - place[a]);
        let inwards = -dot(&apart, &normal);
        // Points of the same plane do not stop it.
        if inwards > 1e-9 * length(&apart) { dot(&apart, &apart) / (2.0 * inwards) } else { f64::INFINITY }
    };
    let least = surface.iter().map(radius).fold(f64::INFINITY, f64::min);
    (least.is_finite() && least > 0.0).then_some(least)
}
