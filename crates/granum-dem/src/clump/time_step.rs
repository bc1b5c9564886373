//! The share of the time step of spheres that a clump allows.
//!
//! A contact at the arm s of a body of mass m acts on the inverse mass `1/m 1 + [s] I^-1 [s]^T`. Its largest eigenvalue over all points of
//! the surface, times m, is kappa: 3.5 for a sphere, and more where inertia is small for the length of the arms. The step is that of
//! spheres of the body's mass, times `sqrt(3.5 / kappa)`.

use granum_core::geometry::length;

use crate::assembly::{Matrix, Vector};
use crate::invariants::eigenvalues;
use granum_shape::RigidShape;

/// The value of a sphere: `1 + 1/0.4`.
const OF_SPHERES: f64 = 3.5;
/// Number of points on each piece at which the inverse mass is evaluated.
const POINTS: usize = 200;

/// The share of the time step of spheres of the same mass that a shape allows; at most one: `sqrt(3.5/kappa)`, kappa being the largest
/// eigenvalue of the inverse mass over its surface, times its mass.
pub fn time_step_share(shape: &RigidShape) -> f64 {
    if shape.as_sphere().is_some() {
        return 1.0;
    }
    (OF_SPHERES / stiffest(shape)).sqrt().min(1.0)
}

/// Kappa: the largest inverse mass at a point of the surface, times the mass.
fn stiffest(shape: &RigidShape) -> f64 {
    let mut largest = 0.0f64;
    for piece in &shape.pieces {
        for direction in directions() {
            let arm: Vector = std::array::from_fn(|k| piece.centre[k] + piece.radius * direction[k]);
            let inside = shape.pieces.iter().any(|other| {
                let apart: Vector = std::array::from_fn(|k| arm[k] - other.centre[k]);
                length(&apart) < other.radius * (1.0 - 1e-9)
            });
            if !inside {
                largest = largest.max(eigenvalues(&inverse_mass(&arm, &shape.inertia_over_mass))[0]);
            }
        }
    }
    largest
}

/// `1 + [s] I^-1 [s]^T` for the arm s and the moments over the mass.
fn inverse_mass(s: &Vector, inertia: &Vector) -> Matrix {
    let cross = [[0.0, -s[2], s[1]], [s[2], 0.0, -s[0]], [-s[1], s[0], 0.0]];
    std::array::from_fn(|r| {
        std::array::from_fn(|c| {
            let turned: f64 = (0..3).map(|k| cross[r][k] * cross[c][k] / inertia[k]).sum();
            turned + if r == c { 1.0 } else { 0.0 }
        })
    })
}

/// Directions that cover a sphere evenly: a spiral whose turns are the golden angle, and the axes.
fn directions() -> impl Iterator<Item = Vector> {
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let spiral = (0..POINTS).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / POINTS as f64;
        let (sine, cosine) = libm::sincos(golden * k as f64);
        let radius = (1.0 - z * z).sqrt();
        [radius * cosine, radius * sine, z]
    });
    let axes = (0..6).map(|k| {
        let mut axis = [0.0; 3];
        axis[k / 2] = if k % 2 == 0 { 1.0 } else { -1.0 };
        axis
    });
    spiral.chain(axes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_shape::ShapePiece;

    /// The values of dimers: two spheres of diameter 1 at a distance.
    #[test]
    fn the_inverse_mass_of_dimers_is_that_of_theory() {
        assert!((stiffest(&RigidShape::sphere(0.3)) - OF_SPHERES).abs() < 1e-12);
        for (distance, inertia, golden) in [(0.5, [0.10625, 0.184375], 4.153), (1.0, [0.1, 0.35], 4.5)] {
            let piece = |x: f64| ShapePiece { centre: [x, 0.0, 0.0], radius: 0.5 };
            let shape = RigidShape {
                pieces: vec![piece(-0.5 * distance), piece(0.5 * distance)],
                volume: 1.0,
                inertia_over_mass: [inertia[0], inertia[1], inertia[1]],
            };
            let found = stiffest(&shape);
            assert!((found / golden - 1.0).abs() < 2e-3, "{distance}: {found} {golden}");
            assert!((time_step_share(&shape) - (3.5 / found).sqrt()).abs() < 1e-15);
        }
    }
}
