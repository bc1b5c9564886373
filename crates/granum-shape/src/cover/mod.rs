//! Covers: spheres that stand for a mesh or an image of a grain.

mod euclidean;
pub(crate) mod grid;
mod report;
pub(crate) mod samples;
mod tangent;

use granum_core::assembly::Vector;
use granum_core::rotation::to_body;

pub use euclidean::EuclideanMap;
pub use report::CoverReport;
pub use tangent::TangentSpheres;

pub(crate) use euclidean::euclidean_map;
pub(crate) use report::Original;

use crate::family::Spheres;
use crate::mesh::{Tree, TriangleMesh, moments};
use crate::principal_axes::principal;
use samples::samples;

/// Voxels along the shortest side of the box around a mesh.
const ALONG_SHORTEST: usize = 50;

/// How to cover a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CoverMethod {
    /// The largest spheres that fit one after the other.
    Euclidean(EuclideanMap),
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
    let original = Original { moments: moments(&own), samples: samples(&own) };
    let spheres = match method {
        CoverMethod::Euclidean(given) => {
            let grid = grid::Grid::of_mesh(&own, ALONG_SHORTEST);
            euclidean_map(&grid, Some(&Tree::new(&own)), given)
        }
        CoverMethod::Tangent(given) => tangent::tangent_spheres(&original.samples, given),
    };
    let (spheres, report) = original.compare(&spheres)?;
    Ok(Cover { spheres, report })
}

/// The same mesh in its principal axes about its centre, so that the cover does not depend on how it lies.
fn in_own_axes(mesh: &TriangleMesh) -> TriangleMesh {
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

    /// A box whose edges and corners are rounded with a radius.
    pub(crate) fn rounded_box(half: Vector, radius: f64) -> TriangleMesh {
        let mut mesh = ellipsoid([radius; 3], 5);
        for (place, u) in mesh.vertices.iter_mut().zip(&directions(5).units) {
            for a in 0..3 {
                place[a] += (half[a] - radius) * if u[a] < 0.0 { -1.0 } else { 1.0 };
            }
        }
        mesh
    }

    #[test]
    fn covers_scan() {
        let bodies =
            [("ellipsoid", ellipsoid([1.0, 0.8, 0.6], 5)), ("box", rounded_box([1.0, 0.8, 0.6], 0.25))];
        for (name, mesh) in &bodies {
            for pieces in [10, 20, 30] {
                for overlap in [0.3, 0.5, 0.6, 0.7, 0.8, 0.9] {
                    let start = std::time::Instant::now();
                    let method = CoverMethod::Euclidean(EuclideanMap { pieces, overlap, least_radius: 0.05 });
                    let cover = cover_mesh(mesh, &method).unwrap();
                    let r = cover.report;
                    println!(
                        "{name} {pieces} {overlap}: {} V {:.4} I {:.4} {:.4} {:.4} S {:.3} psi {:.3} d {:.4} {:.4} {:?}",
                        r.pieces,
                        r.volume,
                        r.inertia[0],
                        r.inertia[1],
                        r.inertia[2],
                        r.surface,
                        r.sphericity,
                        r.mean_distance,
                        r.largest_distance,
                        start.elapsed()
                    );
                }
                let method = CoverMethod::Tangent(TangentSpheres {
                    pieces,
                    seed: 1,
                    least_distance: 0.02,
                    share: 0.99,
                });
                let r = cover_mesh(mesh, &method).unwrap().report;
                println!("{name} {pieces} tangent {r:?}");
            }
        }
    }
}
