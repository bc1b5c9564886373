//! Covers: spheres that stand for a mesh or an image of a grain.
//!
//! Spheres inside a body leave gaps between them. All radii therefore grow by one length until the union has the volume of the original, and what
//! rounding leaves is scaled away. [`CoverReport`] says how much was missing and how well the result stands for the original.

mod covered_body;
mod euclidean;
mod greedy;
pub(crate) mod grid;
mod image;
mod report;
pub(crate) mod samples;
mod tangent;

use granum_core::assembly::Vector;
use granum_core::rotation::to_body;

pub use covered_body::CoveredBody;
pub use euclidean::EuclideanMap;
pub use greedy::LargestGain;
pub use report::CoverReport;
pub use tangent::TangentSpheres;

pub(crate) use euclidean::euclidean_map;
pub(crate) use report::Original;

use crate::mesh::{Tree, TriangleMesh, moments};
use crate::principal_axes::principal;
use crate::union_of_spheres::Spheres;
use crate::union_of_spheres::connected::connected;
use samples::samples;

/// Voxels along the shortest side of the box around a mesh.
const ALONG_SHORTEST: usize = 51;

/// How to cover a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CoverMethod {
    /// The largest spheres that fit one after the other.
    Euclidean(EuclideanMap),
    /// The spheres that fill most, one after the other.
    Gain(LargestGain),
    /// Spheres that touch the surface at random points.
    Tangent(TangentSpheres),
}

/// Spheres that cover a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// The spheres, of the volume of the original, in the principal axes of the original about its centre.
    pub spheres: Spheres,
    /// How well they cover it.
    pub report: CoverReport,
}

/// Covers the body within a closed surface.
///
/// # Errors
/// With what is wrong about the spheres: there are none, for instance.
pub fn cover_mesh(mesh: &TriangleMesh, method: &CoverMethod) -> Result<Cover, String> {
    let own = in_own_axes(mesh);
    let (samples, spacing) = samples(&own);
    let original = Original { moments: moments(&own), samples };
    let spheres = match method {
        CoverMethod::Euclidean(given) => {
            let grid = grid::Grid::of_mesh(&own, ALONG_SHORTEST);
            euclidean_map(&grid, Some(&Tree::new(&own)), given)
        }
        CoverMethod::Gain(given) => {
            let grid = grid::Grid::of_mesh(&own, ALONG_SHORTEST);
            greedy::largest_gain(&grid, Some(&Tree::new(&own)), given)
        }
        CoverMethod::Tangent(given) => tangent::tangent_spheres(&original.samples, spacing, given),
    };
    finished(&original, spheres)
}

/// Covers a body of voxels.
///
/// # Errors
/// With what is wrong about the spheres.
pub(crate) fn cover_grid(grid: &grid::Grid, given: &LargestGain) -> Result<Cover, String> {
    finished(&Original::of_grid(grid), greedy::largest_gain(&image::divided(grid), None, given))
}

/// The spheres, grown to the volume of the original, and their report. Spheres that then do not hang together with the largest are left out.
fn finished(original: &Original, mut spheres: Spheres) -> Result<Cover, String> {
    spheres.sort_by(|a, b| b.1.total_cmp(&a.1));
    loop {
        let (grown, report) = original.compare(&spheres)?;
        let connected = connected(&grown);
        if connected.iter().all(|is| *is) {
            return Ok(Cover { spheres: grown, report });
        }
        let kept = spheres.into_iter().zip(connected).filter(|(_, is)| *is);
        spheres = kept.map(|(sphere, _)| sphere).collect();
    }
}

/// The same mesh in its principal axes about its centre, so that the cover does not depend on how it lies.
pub(crate) fn in_own_axes(mesh: &TriangleMesh) -> TriangleMesh {
    let found = moments(mesh);
    let (_, axes) = principal(&found.inertia_over_volume());
    let place = |p: &Vector| to_body(&axes, &std::array::from_fn(|a| p[a] - found.centre[a]));
    TriangleMesh { vertices: mesh.vertices.iter().map(place).collect(), triangles: mesh.triangles.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::directions;
    use crate::mesh::tests::ellipsoid;
    use crate::union_of_spheres::ShapeOfSpheres;

    /// A box whose edges and corners are rounded with a radius.
    pub(crate) fn rounded_box(half: Vector, radius: f64) -> TriangleMesh {
        let mut mesh = ellipsoid([radius; 3], 4);
        for (place, u) in mesh.vertices.iter_mut().zip(&directions(4).units) {
            for a in 0..3 {
                place[a] += (half[a] - radius) * if u[a] < 0.0 { -1.0 } else { 1.0 };
            }
        }
        mesh
    }

    /// The errors at which covers aim: 5 % of the moments of inertia with 10 to 30 spheres, at the volume of the original. What fills most is
    /// better than the Euclidean map.
    #[test]
    fn ten_to_thirty_spheres_have_the_inertia_of_a_body_within_five_percent() {
        let bodies = [
            ("ellipsoid", ellipsoid([1.0, 0.8, 0.6], 4)),
            ("box", rounded_box([1.0, 0.8, 0.6], 0.25)),
            ("flat box", rounded_box([1.0, 0.9, 0.5], 0.2)),
        ];
        for ((name, mesh), pieces) in bodies.iter().flat_map(|body| [10, 20, 30].map(|pieces| (body, pieces)))
        {
            let methods = [
                CoverMethod::Gain(LargestGain { pieces, ..LargestGain::default() }),
                CoverMethod::Euclidean(EuclideanMap { pieces, ..EuclideanMap::default() }),
                CoverMethod::Tangent(TangentSpheres { pieces, ..TangentSpheres::default() }),
            ];
            let reports = methods.map(|method| {
                let start = std::time::Instant::now();
                let Cover { spheres, report } = cover_mesh(mesh, &method).unwrap();
                println!("{name} {pieces} {:?} {report}", start.elapsed());
                let found = ShapeOfSpheres::new(&spheres).unwrap();
                assert!((found.shape.volume / moments(mesh).volume - 1.0).abs() < 1e-9, "{name}");
                report
            });
            // Errors of inertia, growth, mean distance.
            let limits = [[0.05, 0.05, 0.03], [0.06, 0.06, 0.035], [0.03, 0.04, 0.03]];
            // Few random spheres on a box cover it badly.
            let tested = if *name == "ellipsoid" { 3 } else { 2 };
            for (report, limits) in reports.iter().zip(limits).take(tested) {
                let inertia = report.inertia.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
                for (found, limit) in [inertia, report.growth, report.mean_distance].into_iter().zip(limits) {
                    assert!(found > 0.0 && found < limit, "{name} {pieces}: {report:?}");
                }
            }
            assert!(reports[0].mean_distance < reports[1].mean_distance, "{name}: {reports:?}");
        }
    }

    /// Sixty spheres fill an ellipsoid within 2 % before they grow, and have its inertia within half a percent.
    #[test]
    fn sixty_spheres_fill_an_ellipsoid_within_two_percent() {
        let method = CoverMethod::Gain(LargestGain { pieces: 60, ..LargestGain::default() });
        let CoverReport { pieces, volume, inertia, sphericity, .. } =
            cover_mesh(&ellipsoid([1.0, 0.8, 0.6], 4), &method).unwrap().report;
        assert!(pieces == 60 && volume > -0.02 && volume < 0.0, "{pieces} {volume}");
        assert!(
            inertia.iter().all(|error| error.abs() < 5e-3) && sphericity.abs() < 0.01,
            "{inertia:?} {sphericity}"
        );
    }

    /// A sphere is covered by one; the first sphere of a cube fills it, and no sphere stands out before growing.
    #[test]
    fn the_first_sphere_is_the_largest_inscribed_one() {
        let mesh = crate::mesh::tests::cube([7.0, -3.0, 2.0], 2.0);
        let own = in_own_axes(&mesh);
        let grid = grid::Grid::of_mesh(&own, 51);
        let found = euclidean_map(&grid, Some(&Tree::new(&own)), &EuclideanMap::default());
        assert!(
            (found[0].1 - 1.0).abs() < 1e-3 && found[0].0.iter().all(|x| x.abs() < 2e-3),
            "{:?}",
            found[0]
        );
        for (centre, radius) in &found {
            assert!(centre.iter().all(|x| x.abs() + radius < 1.0 + 1e-9), "{centre:?} {radius}");
        }
        // Eight corners are alike: the next spheres are of one size.
        assert!(found[1..9].iter().all(|s| (s.1 / found[1].1 - 1.0).abs() < 0.02), "{found:?}");
    }

    /// The same bits however the mesh lies, but for rounding, and always the same bits of the same mesh.
    #[test]
    fn a_cover_does_not_depend_on_where_the_mesh_lies() {
        let mesh = rounded_box([1.0, 0.8, 0.6], 0.25);
        let mut moved = mesh.clone();
        moved.vertices.iter_mut().for_each(|p| *p = [5.0 + p[1], 7.0 + p[2], 9.0 + p[0]]);
        let method = CoverMethod::Euclidean(EuclideanMap::default());
        let (first, again) = (cover_mesh(&mesh, &method).unwrap(), cover_mesh(&mesh, &method).unwrap());
        assert_eq!(first, again);
        let there = cover_mesh(&moved, &method).unwrap();
        for k in 0..3 {
            assert!((first.report.inertia[k] - there.report.inertia[k]).abs() < 0.02, "{:?}", there.report);
        }
    }
}
