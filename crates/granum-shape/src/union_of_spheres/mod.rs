//! Volume, surface, centre and inertia of a union of spheres, exactly but for rounding: what several spheres share counts once.
//!
//! By the divergence theorem all moments are integrals over the exposed patches of the spheres: `V = 1/3 int x.n`, `int x = 1/2 int x^2 n_x`,
//! `int x^2 = 1/3 int x^3 n_x`, `int xy = 1/2 int x^2 y n_x`. On the sphere i with `h = z - z_i` and `rho^2 = R_i^2 - h^2` the element is
//! `n dA = (rho cos, rho sin, h) dz dphi`. At one height z another sphere covers one arc of the circle, so that what is exposed are arcs, over
//! which powers of sine and cosine are integrated in closed form. The heights are cut at the poles of the spheres, at the extremes of the
//! circles in which two of them meet and at the points where three meet; between two cuts a Gauss-Legendre rule in the angle
//! `z = z_m - delta/2 cos(theta)` takes away the roots at the ends. The spheres are sliced along an oblique axis, along which shapes that people make have
//! no symmetry. Of the cuts only those are needed that are exposed.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::{dot, length};
use granum_core::rotation::{normalized, to_body, to_space};

use crate::principal_axes::principal;
use crate::rigid_shape::{RigidShape, ShapePiece};

pub(crate) mod connected;
pub(crate) mod cuts;

use cuts::{cuts, neighbours};

/// Number of nodes between two cuts.
const NODES: usize = 48;
/// The rotation into the axes in which spheres are sliced.
const OBLIQUE: [f64; 4] = [0.81, 0.37, -0.29, 0.35];

/// The spheres of a shape: centres and radii in any unit of length and in any axes.
pub type Spheres = Vec<(Vector, f64)>;

/// Moments of a body of density one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Volume, m3.
    pub volume: f64,
    /// Surface, m2.
    pub surface: f64,
    /// Centre, m.
    pub centre: Vector,
    /// `int (x - c)(x - c)^T`, m5.
    pub second: Matrix,
}

impl Moments {
    /// The inertia over the volume, m2: `tr(S) 1 - S` with the second moments S over the volume.
    pub fn inertia_over_volume(&self) -> Matrix {
        let s = self.second.map(|row| row.map(|x| x / self.volume));
        let trace = s[0][0] + s[1][1] + s[2][2];
        std::array::from_fn(|r| std::array::from_fn(|c| if r == c { trace - s[r][c] } else { -s[r][c] }))
    }
}

/// A shape of spheres, and where its principal axes are.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeOfSpheres {
    /// The shape, in its principal axes, in the order of rising moments.
    pub shape: RigidShape,
    /// Centre of mass in the axes of the given spheres, m.
    pub centre: Vector,
    /// The principal axes there: its columns.
    pub axes: Matrix,
    /// Surface of the union, m2.
    pub surface: f64,
}

impl ShapeOfSpheres {
    /// The shape of spheres with these centres and radii, m. Spheres inside another one are left out.
    ///
    /// # Errors
    /// With what is wrong and what would be right: without spheres, for a radius that is not positive or a place that is not finite, and for two equal spheres.
    pub fn new(spheres: &[(Vector, f64)]) -> Result<ShapeOfSpheres, String> {
        check(spheres)?;
        let outer = outermost(spheres);
        let moments = moments(&outer);
        let (values, axes) = principal(&moments.inertia_over_volume());
        let piece = |(centre, radius): &(Vector, f64)| {
            let apart = std::array::from_fn(|a| centre[a] - moments.centre[a]);
            ShapePiece { centre: to_body(&axes, &apart), radius: *radius }
        };
        let pieces = match outer[..] {
            // The only piece is the centre, without rounding.
            [(_, radius)] => vec![ShapePiece { centre: [0.0; 3], radius }],
            _ => outer.iter().map(piece).collect(),
        };
        let shape = RigidShape { pieces, volume: moments.volume, inertia_over_mass: values };
        Ok(ShapeOfSpheres { shape, centre: moments.centre, axes, surface: moments.surface })
    }

    /// The same shape with all lengths multiplied by a factor.
    pub fn scaled(&self, factor: f64) -> ShapeOfSpheres {
        ShapeOfSpheres {
            shape: self.shape.scaled(factor),
            centre: self.centre.map(|x| factor * x),
            axes: self.axes,
            surface: self.surface * factor * factor,
        }
    }

    /// Sphericity: surface of the sphere of equal volume over the surface, `pi^(1/3) (6 V)^(2/3) / S`.
    pub fn sphericity(&self) -> f64 {
        sphericity(self.shape.volume, self.surface)
    }
}

/// Sphericity of a body of this volume and surface.
pub(crate) fn sphericity(volume: f64, surface: f64) -> f64 {
    let edge = granum_simd::cbrt(6.0 * volume);
    granum_simd::cbrt(std::f64::consts::PI) * edge * edge / surface
}

fn check(spheres: &[(Vector, f64)]) -> Result<(), String> {
    if spheres.is_empty() {
        return Err("a shape needs at least one sphere".into());
    }
    for (k, (centre, radius)) in spheres.iter().enumerate() {
        if !(*radius > 0.0 && radius.is_finite()) {
            return Err(format!("the radius of sphere {k} is {radius} m; it must be positive"));
        }
        if centre.iter().any(|x| !x.is_finite()) {
            return Err(format!("the centre {centre:?} of sphere {k} is not finite"));
        }
        if let Some(other) = spheres[..k].iter().position(|other| *other == (*centre, *radius)) {
            return Err(format!("the spheres {other} and {k} are equal; leave one of them out"));
        }
    }
    Ok(())
}

/// The spheres that are not inside another one.
fn outermost(spheres: &[(Vector, f64)]) -> Vec<(Vector, f64)> {
    let inside = |(centre, radius): &(Vector, f64), (other, larger): &(Vector, f64)| {
        let apart: Vector = std::array::from_fn(|a| centre[a] - other[a]);
        larger > radius && length(&apart) + radius <= *larger
    };
    spheres.iter().filter(|one| !spheres.iter().any(|other| inside(one, other))).copied().collect()
}

/// The moments of a union of spheres, none of which is inside another.
pub(crate) fn moments(spheres: &[(Vector, f64)]) -> Moments {
    let rotation = granum_core::rotation::matrix(&normalized(&OBLIQUE));
    // About the middle of the centres, so that large coordinates cost no digits.
    let count = spheres.len() as f64;
    let middle: Vector = std::array::from_fn(|a| spheres.iter().map(|(c, _)| c[a]).sum::<f64>() / count);
    let turned: Vec<(Vector, f64)> = (spheres.iter())
        .map(|(c, r)| (to_body(&rotation, &std::array::from_fn(|a| c[a] - middle[a])), *r))
        .collect();
    let sums = integrals(&turned);
    let volume = sums.volume;
    let centre = sums.first.map(|x| x / volume);
    let second: Matrix =
        std::array::from_fn(|r| std::array::from_fn(|c| sums.second[r][c] - volume * centre[r] * centre[c]));
    let of_space = to_space(&rotation, &centre);
    Moments {
        volume,
        surface: sums.surface,
        centre: std::array::from_fn(|a| middle[a] + of_space[a]),
        second: rotated(&rotation, &second),
    }
}

/// `R S R^T`.
fn rotated(rotation: &Matrix, second: &Matrix) -> Matrix {
    let half: Matrix = std::array::from_fn(|r| to_space(&transposed(second), &rotation[r]));
    std::array::from_fn(|r| std::array::from_fn(|c| dot(&half[r], &rotation[c])))
}

fn transposed(m: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| m[c][r]))
}

/// Integrals over a body.
#[derive(Clone, Copy, Default)]
struct Sums {
    volume: f64,
    surface: f64,
    first: Vector,
    second: Matrix,
}

fn integrals(spheres: &[(Vector, f64)]) -> Sums {
    let rule = gauss_legendre();
    let mut sums = Sums::default();
    for (k, (centre, radius)) in spheres.iter().enumerate() {
        let neighbours = neighbours(spheres, k);
        let arcs: Vec<Cap> = neighbours.iter().map(|other| Cap::new((centre, *radius), other)).collect();
        for ends in cuts((centre, *radius), &neighbours).windows(2) {
            let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
            for (node, weight) in &rule {
                // theta from 0 to pi.
                let theta = 0.5 * std::f64::consts::PI * (1.0 + node);
                let (sine, cosine) = libm::sincos(theta);
                let dz = weight * 0.5 * std::f64::consts::PI * half * sine;
                add_slice(&mut sums, &arcs, (centre, *radius), middle - half * cosine, dz);
            }
        }
    }
    for (r, c) in [(1, 0), (2, 0), (2, 1)] {
        sums.second[r][c] = sums.second[c][r];
    }
    sums
}

/// Adds what is exposed of a sphere at a height.
fn add_slice(sums: &mut Sums, caps: &[Cap], (centre, radius): (&Vector, f64), z: f64, dz: f64) {
    let h = z - centre[2];
    let rho = (radius * radius - h * h).max(0.0).sqrt();
    let Some(arcs) = exposed(caps, h, rho) else { return };
    let [x, y] = [centre[0], centre[1]];
    for [from, to] in arcs {
        let p = Powers::between(from, to);
        sums.surface += radius * dz * p.one;
        sums.volume += dz / 3.0 * (rho * (x * p.c + rho * p.cc + y * p.s + rho * p.ss) + z * h * p.one);
        // Powers of x = x_i + rho cos times cos, and of y times sin.
        let x2c = x * x * p.c + 2.0 * x * rho * p.cc + rho * rho * p.ccc;
        let y2s = y * y * p.s + 2.0 * y * rho * p.ss + rho * rho * p.sss;
        sums.first[0] += 0.5 * dz * rho * x2c;
        sums.first[1] += 0.5 * dz * rho * y2s;
        sums.first[2] += 0.5 * dz * z * z * h * p.one;
        let x3c = x * x * x * p.c
            + 3.0 * x * x * rho * p.cc
            + 3.0 * x * rho * rho * p.ccc
            + rho * rho * rho * p.cccc;
        let y3s = y * y * y * p.s
            + 3.0 * y * y * rho * p.ss
            + 3.0 * y * rho * rho * p.sss
            + rho * rho * rho * p.ssss;
        sums.second[0][0] += dz / 3.0 * rho * x3c;
        sums.second[1][1] += dz / 3.0 * rho * y3s;
        sums.second[2][2] += dz / 3.0 * z * z * z * h * p.one;
        let x2cs = x * x * p.cs + 2.0 * x * rho * p.ccs + rho * rho * p.cccs;
        sums.second[0][1] += 0.5 * dz * rho * (y * x2c + rho * x2cs);
        sums.second[0][2] += 0.5 * dz * z * z * h * (x * p.one + rho * p.c);
        sums.second[1][2] += 0.5 * dz * z * z * h * (y * p.one + rho * p.s);
    }
}

/// What another sphere covers of a sphere, at every height.
struct Cap {
    /// Distance of the centres across the axis of slicing, m.
    across: f64,
    /// Angle of the other centre about that axis.
    angle: f64,
    /// `R_i^2 + |d|^2 - R_j^2`, m2.
    limit: f64,
    /// Distance of the centres along the axis, m.
    along: f64,
}

impl Cap {
    fn new((centre, radius): (&Vector, f64), (other, larger): &(Vector, f64)) -> Cap {
        let d: Vector = std::array::from_fn(|a| other[a] - centre[a]);
        Cap {
            across: (d[0] * d[0] + d[1] * d[1]).sqrt(),
            angle: libm::atan2(d[1], d[0]),
            limit: radius * radius + dot(&d, &d) - larger * larger,
            along: d[2],
        }
    }
}

/// The arcs of a circle on a sphere that no other sphere covers; `None` if one covers all of it.
fn exposed(caps: &[Cap], h: f64, rho: f64) -> Option<Vec<[f64; 2]>> {
    let whole = std::f64::consts::TAU;
    let mut covered: Vec<[f64; 2]> = Vec::new();
    for cap in caps {
        let limit = cap.limit - 2.0 * cap.along * h;
        let reach = 2.0 * rho * cap.across;
        if limit >= reach {
            continue;
        }
        if limit <= -reach {
            return None;
        }
        let half = libm::acos(limit / reach);
        let mut from = cap.angle - half;
        if from < 0.0 {
            from += whole;
        }
        let to = from + 2.0 * half;
        if to > whole {
            covered.push([from, whole]);
            covered.push([0.0, to - whole]);
        } else {
            covered.push([from, to]);
        }
    }
    covered.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut arcs, mut end) = (Vec::new(), 0.0);
    for [from, to] in covered {
        if from > end {
            arcs.push([end, from]);
        }
        end = f64::max(end, to);
    }
    if end < whole {
        arcs.push([end, whole]);
    }
    Some(arcs)
}

/// Integrals of powers of cosine (c) and sine (s) over an arc.
struct Powers {
    one: f64,
    c: f64,
    s: f64,
    cc: f64,
    ss: f64,
    cs: f64,
    ccc: f64,
    sss: f64,
    ccs: f64,
    cccc: f64,
    ssss: f64,
    cccs: f64,
}

impl Powers {
    fn between(from: f64, to: f64) -> Powers {
        let (s0, c0) = libm::sincos(from);
        let (s1, c1) = libm::sincos(to);
        let change = |of: &dyn Fn(f64, f64) -> f64| of(s1, c1) - of(s0, c0);
        let angle = to - from;
        let double = change(&|s, c| 2.0 * s * c);
        let four = change(&|s, c| 4.0 * s * c * (c * c - s * s));
        Powers {
            one: angle,
            c: change(&|s, _| s),
            s: change(&|_, c| -c),
            cc: 0.5 * angle + 0.25 * double,
            ss: 0.5 * angle - 0.25 * double,
            cs: change(&|s, _| 0.5 * s * s),
            ccc: change(&|s, _| s - s * s * s / 3.0),
            sss: change(&|_, c| c * c * c / 3.0 - c),
            ccs: change(&|_, c| -c * c * c / 3.0),
            cccc: 0.375 * angle + 0.25 * double + four / 32.0,
            ssss: 0.375 * angle - 0.25 * double + four / 32.0,
            cccs: change(&|_, c| -0.25 * c * c * c * c),
        }
    }
}

/// Nodes and weights of the Gauss-Legendre rule between -1 and 1.
fn gauss_legendre() -> Vec<(f64, f64)> {
    let n = NODES as f64;
    let node = |k: usize| {
        let mut x = libm::cos(std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5));
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut before, mut now) = (1.0, x);
            for m in 2..=NODES {
                let m = m as f64;
                (before, now) = (now, ((2.0 * m - 1.0) * x * now - (m - 1.0) * before) / m);
            }
            slope = n * (x * now - before) / (x * x - 1.0);
            x -= now / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..NODES).map(node).collect()
}

#[cfg(test)]
pub(crate) mod tests;
