//! Descriptors of shapes: proportions, sphericity, convexity, roundness and sizes.

mod bounding_box;
mod hull;
mod inscribed;
mod seams;

use granum_core::assembly::Vector;

pub use hull::hull_volume;
pub use seams::widest_seam;

use crate::directions::directions;
use crate::entry::SizeMeasure;
use crate::union_of_spheres::cuts::{is_covered, neighbours};
use crate::union_of_spheres::{ShapeOfSpheres, sphericity};

/// Level of the directions along which the exposed areas of spheres are sampled: 642 of them.
const AREA_LEVEL: usize = 3;

/// Descriptors of a shape. Lengths are in the unit of the shape, the others are pure numbers.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ShapeDescriptors {
    /// Semi-lengths `a >= b >= c` of the ellipsoid of equal mass and inertia, m: `a_k^2 = 5/2 (I_i + I_j - I_k)/m`.
    pub semi_lengths: Vector,
    /// Elongation by inertia `b/a`: 1 for a shape as wide as long.
    pub elongation: f64,
    /// Flatness by inertia `c/b`: 1 for a shape as thick as wide.
    pub flatness: f64,
    /// Lengths of the bounding box of least volume in falling order, m.
    pub box_lengths: Vector,
    /// Elongation by the bounding box: intermediate over largest length.
    pub box_elongation: f64,
    /// Flatness by the bounding box: least over intermediate length.
    pub box_flatness: f64,
    /// Sphericity: surface of the sphere of equal volume over the surface.
    pub sphericity: f64,
    /// Convexity: volume over the volume of the convex hull (within 0.5 %).
    pub convexity: f64,
    /// Roundness: mean radius of the spheres that have a part on the convex hull, weighted with the areas that they expose, over the radius
    /// of the largest sphere inside the shape.
    pub roundness: f64,
    /// Radius of the largest sphere inside the shape, m.
    pub inscribed_radius: f64,
    /// Diameter of the sphere of equal volume, m: `(6 V/pi)^(1/3)`.
    pub volume_diameter: f64,
}

impl ShapeDescriptors {
    /// The descriptors of a shape.
    pub fn new(of: &ShapeOfSpheres) -> ShapeDescriptors {
        let pieces = &of.shape.pieces;
        let semi_lengths = semi_lengths(&of.shape.inertia_over_mass);
        let box_lengths = bounding_box::least_box(pieces);
        let hull = hull::hull(pieces);
        let spheres: Vec<(Vector, f64)> = pieces.iter().map(|p| (p.centre, p.radius)).collect();
        let areas = exposed_areas(&spheres);
        let exposed: Vec<bool> = areas.iter().map(|area| *area > 0.0).collect();
        let inscribed_radius = inscribed::largest_inscribed(&spheres, &exposed);
        let on_hull = |k: &usize| hull.touches[*k];
        let sum = |of: &dyn Fn(usize) -> f64| (0..pieces.len()).filter(on_hull).map(of).sum::<f64>();
        let mean_radius = sum(&|k| areas[k] * pieces[k].radius) / sum(&|k| areas[k]);
        ShapeDescriptors {
            semi_lengths,
            elongation: semi_lengths[1] / semi_lengths[0],
            flatness: semi_lengths[2] / semi_lengths[1],
            box_lengths,
            box_elongation: box_lengths[1] / box_lengths[0],
            box_flatness: box_lengths[2] / box_lengths[1],
            sphericity: sphericity(of.shape.volume, of.surface),
            convexity: (of.shape.volume / hull.volume).min(1.0),
            roundness: mean_radius / inscribed_radius,
            inscribed_radius,
            volume_diameter: 2.0 * of.shape.equivalent_radius(),
        }
    }

    /// Sieve diameter, m: the edge of the smallest square hole through which the shape passes, taken as the intermediate length of its
    /// bounding box.
    pub fn sieve_diameter(&self) -> f64 {
        self.box_lengths[1]
    }

    /// The diameter that a measure of size means, m.
    pub fn diameter(&self, measure: SizeMeasure) -> f64 {
        match measure {
            SizeMeasure::Volume => self.volume_diameter,
            SizeMeasure::Sieve => self.sieve_diameter(),
        }
    }
}

/// Semi-lengths in falling order of the ellipsoid with these principal moments over the mass, in rising order.
pub(crate) fn semi_lengths(inertia_over_mass: &Vector) -> Vector {
    let [i, j, k] = *inertia_over_mass;
    let mut lengths = [j + k - i, k + i - j, i + j - k].map(|twice| (2.5 * twice).max(0.0).sqrt());
    lengths.sort_by(|a, b| b.total_cmp(a));
    lengths
}

/// Area of each sphere that no other one covers, m2, from evenly spread points.
fn exposed_areas(spheres: &[(Vector, f64)]) -> Vec<f64> {
    let units = &directions(AREA_LEVEL).units;
    let area = |k: usize| {
        let (centre, radius) = &spheres[k];
        let near = neighbours(spheres, k);
        let bare = |u: &&Vector| {
            let point = std::array::from_fn(|a| centre[a] + radius * u[a]);
            !is_covered(&point, &near, [usize::MAX; 2])
        };
        let share = units.iter().filter(bare).count() as f64 / units.len() as f64;
        share * 4.0 * std::f64::consts::PI * radius * radius
    };
    (0..spheres.len()).map(area).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::union_of_spheres::tests::spiral;

    fn near(found: f64, golden: f64, tolerance: f64) {
        assert!((found - golden).abs() <= tolerance, "{found} {golden}");
    }

    fn row(xs: &[f64]) -> ShapeDescriptors {
        let spheres: Vec<(Vector, f64)> = xs.iter().map(|x| ([*x, 0.0, 0.0], 0.5)).collect();
        ShapeDescriptors::new(&ShapeOfSpheres::new(&spheres).unwrap())
    }

    #[test]
    fn descriptors_of_a_sphere_are_one() {
        let found = row(&[0.0]);
        for one in [found.elongation, found.flatness, found.box_elongation, found.sphericity, found.roundness]
        {
            near(one, 1.0, 1e-12);
        }
        near(found.convexity, 1.0, 1e-9);
        near(found.sieve_diameter(), 1.0, 1e-12);
        near(found.semi_lengths[0], 0.5, 1e-12);
    }

    /// Golden numbers of two spheres at the distances 1 and 0.5; their hulls are capsules.
    #[test]
    fn descriptors_of_dimers_are_met() {
        let touching = row(&[0.0, 1.0]);
        near(touching.volume_diameter, 1.2599210499, 1e-9);
        near(touching.elongation, 0.4082482905, 1e-9);
        near(touching.flatness, 1.0, 1e-9);
        near(touching.box_elongation, 0.5, 1e-6);
        near(touching.box_flatness, 1.0, 1e-6);
        near(touching.diameter(SizeMeasure::Sieve), 1.0, 1e-6);
        near(touching.convexity, 0.8, 0.008);
        near(touching.roundness, 1.0, 1e-9);
        let merged = row(&[-0.25, 0.25]);
        near(merged.diameter(SizeMeasure::Volume), 1.1905507890, 1e-9);
        near(merged.convexity, 0.8835729338221 / (std::f64::consts::PI * (1.0 / 6.0 + 0.125)), 0.009);
        near(merged.sphericity, 0.9449407874, 1e-9);
    }

    /// A large sphere with a small one half outside: the mean radius is weighted with the exposed areas, by the caps in closed form.
    #[test]
    fn roundness_falls_with_small_pieces_on_the_hull() {
        let (large, small) = (1.0f64, 0.2f64);
        let shape = ShapeOfSpheres::new(&[([0.0; 3], large), ([1.0, 0.0, 0.0], small)]).unwrap();
        let along = 0.5 * (1.0 + (large * large - small * small));
        let exposed = [2.0 * large * (large + along), 2.0 * small * (small + 1.0 - along)];
        let mean = (exposed[0] * large + exposed[1] * small) / (exposed[0] + exposed[1]);
        near(ShapeDescriptors::new(&shape).roundness, mean, 2e-3);
    }

    #[test]
    fn thirty_spheres_take_little_time() {
        let shape = ShapeOfSpheres::new(&spiral(30)).unwrap();
        directions(4);
        let start = std::time::Instant::now();
        let found = ShapeDescriptors::new(&shape);
        let took = start.elapsed();
        println!("descriptors of 30 spheres: {took:?}, {found:?}");
        assert!(took.as_secs_f64() < 0.5, "{took:?}");
        assert!(found.inscribed_radius >= 0.49 && found.convexity < 1.0 && found.roundness < 1.0);
    }
}
