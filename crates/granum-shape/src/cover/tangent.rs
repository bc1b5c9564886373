//! Spheres that touch the surface at random points from inside (Ferellec and McDowell 2010). They keep flat faces.
//!
//! A sphere that touches the surface at v with the inward normal n grows until it meets another point w of the surface, at the radius
//! `|w - v|^2 / (2 n.(w - v))`: the least of these is the limit of growing in small steps.

use granum_core::assembly::Vector;
use granum_core::geometry::{dot, length};

use super::samples::Sample;
use crate::random::Random;
use crate::union_of_spheres::Spheres;

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

impl Default for TangentSpheres {
    fn default() -> Self {
        TangentSpheres { pieces: 20, seed: 1, least_distance: 0.02, share: 0.99 }
    }
}

/// The spheres of a surface whose points are this far apart or closer.
pub(crate) fn tangent_spheres(surface: &[Sample], spacing: f64, given: &TangentSpheres) -> Spheres {
    let mut random = Random::new(given.seed, 0, 0);
    let mut open: Vec<usize> = (0..surface.len()).collect();
    let area = |open: &[usize]| open.iter().map(|k| surface[*k].area).sum::<f64>();
    let all = area(&open);
    let mut left = all;
    let widest = surface.iter().map(|s| s.area).fold(0.0, f64::max);
    let mut spheres: Spheres = Vec::new();
    let mut largest: f64 = 0.0;
    while spheres.len() < given.pieces && !open.is_empty() && left > (1.0 - given.share) * all {
        // Points are chosen in proportion to the areas for which they stand.
        let place = ((random.even() * open.len() as f64) as usize).min(open.len() - 1);
        if random.even() * widest > surface[open[place]].area {
            continue;
        }
        let chosen = open.swap_remove(place);
        let Some(radius) = grown(surface, spacing, chosen) else { continue };
        let Sample { place, normal, .. } = surface[chosen];
        let centre: Vector = std::array::from_fn(|a| place[a] - radius * normal[a]);
        spheres.push((centre, radius));
        largest = largest.max(radius);
        let from = |k: &usize| length(&std::array::from_fn(|a| surface[*k].place[a] - centre[a])) - radius;
        open.retain(|k| from(k) > given.least_distance * largest);
        left = area(&open);
    }
    spheres
}

/// The radius at which the sphere that touches a point meets another one. Points that are closer than the spacing do not stop it: the angles
/// between the facets of a smooth surface are no edges.
fn grown(surface: &[Sample], spacing: f64, chosen: usize) -> Option<f64> {
    let Sample { place, normal, .. } = surface[chosen];
    let radius = |other: &Sample| {
        let apart: Vector = std::array::from_fn(|a| other.place[a] - place[a]);
        let (square, inwards) = (dot(&apart, &apart), -dot(&apart, &normal));
        let stops = square > spacing * spacing && inwards > 0.0;
        if stops { square / (2.0 * inwards) } else { f64::INFINITY }
    };
    let least = surface.iter().map(radius).fold(f64::INFINITY, f64::min);
    (least.is_finite() && least > 0.0).then_some(least)
}
