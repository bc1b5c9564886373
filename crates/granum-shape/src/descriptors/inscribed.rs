//! The largest sphere inside a union of spheres.
//!
//! The distance of an inner point from the surface of the union is the least of its distances from the exposed ones of three kinds of
//! points: the point of a sphere straight outwards from its centre, the nearest point of a circle in which two spheres meet, and the points
//! where three meet. The largest such distance is sought from the deepest centres.

use granum_core::assembly::Vector;
use granum_core::geometry::{cross, dot, length};

use crate::directions::{steps, unit};
use crate::union_of_spheres::cuts::{Circle, is_covered, neighbours, seam, triple_points};

/// Number of centres from which the search goes on.
const STARTS: usize = 3;
/// First and last step of the search over the largest radius.
const STEP: [f64; 2] = [0.2, 1e-7];

/// What bounds a union of spheres.
struct Surface<'a> {
    spheres: &'a [(Vector, f64)],
    neighbours: Vec<Vec<(Vector, f64)>>,
    /// Circles in which two spheres meet, each with the number of the first of them.
    circles: Vec<(usize, Circle)>,
    /// Exposed points where three spheres meet.
    corners: Vec<Vector>,
}

/// Radius of the largest sphere inside a union of spheres, m. `exposed` is false for a sphere that has no part of the surface.
pub(crate) fn largest_inscribed(spheres: &[(Vector, f64)], exposed: &[bool]) -> f64 {
    let surface = Surface::new(spheres);
    let depth = |x: &Vector| surface.depth(x, exposed);
    let largest = spheres.iter().map(|(_, r)| *r).fold(0.0, f64::max);
    let count = spheres.len() as f64;
    let middle: Vector = std::array::from_fn(|a| spheres.iter().map(|(c, _)| c[a]).sum::<f64>() / count);
    let mut starts: Vec<(f64, Vector)> = (spheres.iter().map(|(c, _)| *c))
        .chain([middle])
        .filter(|x| is_covered(x, spheres, [usize::MAX; 2]))
        .map(|x| (depth(&x), x))
        .collect();
    starts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let deepest = |(mut best, mut x): (f64, Vector)| {
        let mut step = STEP[0] * largest;
        while step > STEP[1] * largest {
            let next = (steps().map(|s| std::array::from_fn(|a| x[a] + step * s[a])))
                .filter(|next| is_covered(next, spheres, [usize::MAX; 2]))
                .map(|next| (depth(&next), next))
                .max_by(|a, b| a.0.total_cmp(&b.0));
            match next {
                Some((deep, next)) if deep > best * (1.0 + 1e-12) => (best, x) = (deep, next),
                _ => step *= 0.5,
            }
        }
        best
    };
    starts.into_iter().take(STARTS).map(deepest).fold(largest, f64::max)
}

impl Surface<'_> {
    fn new(spheres: &[(Vector, f64)]) -> Surface<'_> {
        let around: Vec<Vec<(Vector, f64)>> = (0..spheres.len()).map(|k| neighbours(spheres, k)).collect();
        let (mut circles, mut corners) = (Vec::new(), Vec::new());
        for (k, (centre, radius)) in spheres.iter().enumerate() {
            let near = &around[k];
            // Each pair and each triple once.
            let before = neighbours(&spheres[..=k], k).len();
            for (j, (other, larger)) in near.iter().enumerate() {
                let Some(circle) = seam((centre, *radius), (other, *larger)) else { continue };
                let mut bare = across(&circle.1).iter().any(|u| !is_covered(&on(&circle, u), near, [j, j]));
                for (l, (third, third_radius)) in near.iter().enumerate().filter(|(l, _)| *l != j) {
                    let points = triple_points(&circle, third, *third_radius).into_iter().flatten();
                    for point in points.filter(|point| !is_covered(point, near, [j, l])) {
                        bare = true;
                        if l > j && j >= before {
                            corners.push(point);
                        }
                    }
                }
                // A circle without a bare point and without a corner is covered.
                if j >= before && bare {
                    circles.push((k, circle));
                }
            }
        }
        Surface { spheres, neighbours: around, circles, corners }
    }

    /// Distance of an inner point from the surface.
    fn depth(&self, x: &Vector, exposed: &[bool]) -> f64 {
        let distance = |p: &Vector| length(&std::array::from_fn(|a| x[a] - p[a]));
        let mut least = self.corners.iter().map(distance).fold(f64::INFINITY, f64::min);
        for (k, (centre, radius)) in self.spheres.iter().enumerate() {
            let away: Vector = std::array::from_fn(|a| x[a] - centre[a]);
            let from = length(&away);
            let short = (radius - from).abs();
            if short >= least || !exposed[k] {
                continue;
            }
            let point = std::array::from_fn(|a| centre[a] + radius * away[a] / from);
            if from == 0.0 || !is_covered(&point, &self.neighbours[k], [usize::MAX; 2]) {
                least = short;
            }
        }
        for (k, (middle, axis, radius)) in &self.circles {
            let away: Vector = std::array::from_fn(|a| x[a] - middle[a]);
            let along = dot(&away, axis);
            let flat: Vector = std::array::from_fn(|a| away[a] - along * axis[a]);
            let across = length(&flat);
            let short = (along * along + (across - radius) * (across - radius)).sqrt();
            if short >= least {
                continue;
            }
            // The second sphere of the circle does not cover it: points on a sphere are not inside.
            let circle = (*middle, *axis, *radius);
            let open = |u: &Vector| !is_covered(&on(&circle, u), &self.neighbours[*k], [usize::MAX; 2]);
            let bare =
                if across > 1e-9 * radius { open(&unit(&flat)) } else { self::across(axis).iter().any(open) };
            if bare {
                least = short;
            }
        }
        least
    }
}

/// The point of a circle in a direction across its axis.
fn on((middle, _, radius): &Circle, u: &Vector) -> Vector {
    std::array::from_fn(|a| middle[a] + radius * u[a])
}

/// Directions across an axis.
fn across(axis: &Vector) -> [Vector; 12] {
    let least = (0..3).min_by(|&a, &b| axis[a].abs().total_cmp(&axis[b].abs())).unwrap_or(0);
    let u = unit(&cross(axis, &std::array::from_fn(|a| if a == least { 1.0 } else { 0.0 })));
    let v = cross(axis, &u);
    std::array::from_fn(|k| {
        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * k as f64 / 12.0);
        std::array::from_fn(|a| cosine * u[a] + sine * v[a])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the middle of a tetrapod with the centres at the distance a, the nearest points are where three spheres meet or on the circles of
    /// two; a long dimer holds no sphere larger than its own.
    #[test]
    fn spheres_in_gaps_are_found() {
        let ball = |q: f64, r: f64| {
            [[q, q, q], [q, -q, -q], [-q, q, -q], [-q, -q, q]].map(|c: Vector| (c, r)).to_vec()
        };
        let found = |spheres: &[(Vector, f64)]| largest_inscribed(spheres, &vec![true; spheres.len()]);
        // The points where three spheres meet lie on the axes (-1,-1,-1) of the faces.
        let q = 0.1;
        // Distance x from the middle along (-1, -1, -1)/sqrt(3): the centres of the face are at q/sqrt(3) along it and q sqrt(8/3) across.
        let point = q / 3.0f64.sqrt() + (0.25 - 8.0 / 3.0 * q * q).sqrt();
        assert!((found(&ball(q, 0.5)) - point.max(0.5)).abs() < 1e-6, "{} {point}", found(&ball(q, 0.5)));
        let dimer = [([-0.25, 0.0, 0.0], 0.5), ([0.25, 0.0, 0.0], 0.5)];
        assert!((found(&dimer) - 0.5).abs() < 1e-9);
        let bead = [([0.0, 0.0, 0.0], 0.5), ([0.1, 0.0, 0.0], 0.5), ([0.05, 0.0, 0.0], 0.49999)];
        let middle = (0.25f64 - 0.0025).sqrt();
        assert!(found(&bead) >= middle, "{}", found(&bead));
    }
}
