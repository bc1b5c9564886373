//! Random grains of sand: ellipsoids with a rough surface.
//!
//! The surface is `r = r_e(u) (1 + f(u))` over the directions u, `r_e` that of an ellipsoid and `f = sum of c_nm Y_nm` over the degrees 3 to 15 of
//! real spherical harmonics. The coefficients are normally distributed with `sum over m of <c_nm^2> / 4 pi = D_n^2`,
//! `D_n = D_3 (n/3)^(-5/3)`: outlines of sands from a dozen places have a power that falls as `n^(-10/3)` (Barclay and Buckingham 2009), as sections of
//! such a surface do. That leaves three numbers: elongation, flatness and the roughness `D_3`.

use rayon::prelude::*;

use crate::cover::{CoverMethod, LargestGain, cover_mesh};
use crate::directions::directions;
use crate::entry::ShapeEntry;
use crate::families::ellipsoid::{ELONGATION, FLATNESS};
use crate::families::mesh::SPHERES;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, ShapeParameter, Spheres};
use crate::harmonics;
use crate::mesh::TriangleMesh;
use crate::random::Random;

/// Random grains of sand, several that differ from each other. They are covered by the spheres that fill most of them.
pub struct Sand;

const ANGULARITY: ShapeParameter = ShapeParameter {
    key: "angularity",
    default: 0.03,
    bounds: [0.0, 0.06],
    whole: false,
    meaning: "Roughness D_3 of a random grain: root mean square of the part of degree 3 of its radius over the radius. 0 is an ellipsoid.",
};

/// Number of different shapes, which several families have.
pub(crate) const SHAPES: ShapeParameter = ShapeParameter {
    key: "shapes",
    default: 10.0,
    bounds: [1.0, 50.0],
    whole: true,
    meaning: "Number of shapes that differ from each other; each grain has one of them.",
};

/// Seed of random shapes, which several families have.
pub(crate) const SHAPE_SEED: ShapeParameter = ShapeParameter {
    key: "shape_seed",
    default: 1.0,
    bounds: [0.0, 4294967295.0],
    whole: true,
    meaning: "Seed of the random numbers of shapes: another seed gives other shapes of the same kind.",
};

/// Least and largest degree of the roughness.
const DEGREES: [usize; 2] = [3, 15];
/// A grain is drawn again if its radius is somewhere below this share of that of the ellipsoid.
const LEAST_RADIUS: f64 = 0.3;
/// Number of times a grain is drawn.
const DRAWS: u64 = 100;
/// Level of the directions at which the surface is known: 2562 of them.
const LEVEL: usize = 4;

impl ShapeFamily for Sand {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "sand",
            help: "random grains, rough ellipsoids",
            parameters: &[ELONGATION, FLATNESS, ANGULARITY, SHAPES, SHAPE_SEED, SPHERES],
            takes_spheres: false,
            takes_file: false,
        }
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        let gain = LargestGain { pieces: given.value(&SPHERES) as usize, ..LargestGain::default() };
        let spheres = |shape: u64| {
            let cover = cover_mesh(&grain(given, shape)?, &CoverMethod::Gain(gain));
            Ok(cover.map_err(|why| ShapeError::new("pieces", why))?.spheres)
        };
        let all: Vec<_> = (0..given.value(&SHAPES) as u64).into_par_iter().map(spheres).collect();
        all.into_iter().collect()
    }
}

/// The surface of a grain.
pub(crate) fn grain(given: &ShapeEntry, shape: u64) -> Result<TriangleMesh, ShapeError> {
    let [roughness, seed] = [given.value(&ANGULARITY), given.value(&SHAPE_SEED)];
    let b = given.value(&ELONGATION);
    let c = b * given.value(&FLATNESS);
    let spread = directions(LEVEL);
    for draw in 0..DRAWS {
        let coefficients = coefficients(roughness, &mut Random::new(seed as u64, shape, draw));
        let factors: Vec<f64> =
            spread.units.iter().map(|u| 1.0 + harmonics::sum(&coefficients, DEGREES[0], u)).collect();
        if factors.iter().any(|factor| *factor < LEAST_RADIUS) {
            continue;
        }
        let place = |(u, factor): (&[f64; 3], &f64)| {
            let radius = factor / (u[0] * u[0] + u[1] * u[1] / (b * b) + u[2] * u[2] / (c * c)).sqrt();
            u.map(|x| radius * x)
        };
        let vertices = spread.units.iter().zip(&factors).map(place).collect();
        return Ok(TriangleMesh { vertices, triangles: spread.triangles.clone() });
    }
    let message =
        format!("is {roughness}: no grain of {DRAWS} is thick enough everywhere; take a smaller one");
    Err(ShapeError::new(ANGULARITY.key, message))
}

/// Random coefficients of the roughness, of each degree for m from -n to n.
fn coefficients(roughness: f64, random: &mut Random) -> Vec<Vec<f64>> {
    let of_degree = |n: usize| {
        let power = roughness * granum_simd::power(n as f64 / 3.0, -5.0 / 3.0);
        let deviation = power * (4.0 * std::f64::consts::PI / (2 * n + 1) as f64).sqrt();
        (0..2 * n + 1).map(|_| deviation * random.normal()).collect()
    };
    (DEGREES[0]..=DEGREES[1]).map(of_degree).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::descriptors::ShapeDescriptors;
    use crate::family::ShapeKind;
    use crate::mesh;

    fn entry(angularity: f64) -> ShapeEntry {
        ShapeEntry::new(ShapeKind::SAND).with("angularity", angularity).with("shapes", 4.0)
    }

    #[test]
    fn the_same_seed_is_the_same_bits_and_another_one_differs() {
        let few = entry(0.03).with("shapes", 2.0);
        let bits = |entry: &ShapeEntry| -> Vec<u64> {
            Sand.shapes(entry).unwrap().iter().flatten().map(|(c, r)| c[0].to_bits() ^ r.to_bits()).collect()
        };
        assert_eq!(bits(&few), bits(&few));
        assert_ne!(bits(&few), bits(&few.clone().with("shape_seed", 2.0)));
        let shapes = Sand.shapes(&few).unwrap();
        assert_ne!(shapes[0], shapes[1]);
    }

    /// Elongation and flatness are near those asked for, and sphericity falls with the roughness, of the surfaces and of their covers.
    #[test]
    fn grains_are_as_long_flat_and_rough_as_asked() {
        let mut last = [f64::INFINITY; 2];
        for angularity in [0.0, 0.02, 0.04, 0.06] {
            let entry = entry(angularity).with("elongation", 0.75).with("flatness", 0.7);
            let start = std::time::Instant::now();
            let shapes = entry.shapes().unwrap();
            let took = start.elapsed();
            let found: Vec<ShapeDescriptors> = shapes.iter().map(ShapeDescriptors::new).collect();
            let mean = |of: &dyn Fn(&ShapeDescriptors) -> f64| found.iter().map(of).sum::<f64>() / 4.0;
            let (elongation, flatness) = (mean(&|d| d.elongation), mean(&|d| d.flatness));
            let of_surface = |k: u64| {
                let moments = mesh::moments(&grain(&entry, k).unwrap());
                crate::union_of_spheres::sphericity(moments.volume, moments.surface) / 4.0
            };
            let sphericities = [(0..4).map(of_surface).sum(), mean(&|d| d.convexity)];
            println!(
                "{angularity}: EI {elongation:.3} FI {flatness:.3} sphericity {:.4} of spheres {:.4} convexity {:.4} roundness {:.3} in {took:?}",
                sphericities[0],
                mean(&|d| d.sphericity),
                sphericities[1],
                mean(&|d| d.roundness)
            );
            assert!(
                (elongation - 0.75).abs() < 0.05 && (flatness - 0.7).abs() < 0.05,
                "{elongation} {flatness}"
            );
            for k in 0..2 {
                assert!(sphericities[k] < last[k], "{angularity}: {sphericities:?} {last:?}");
            }
            last = sphericities;
        }
    }

    /// The mean square of the roughness over many grains is that of the sum over the degrees.
    #[test]
    fn the_roughness_has_the_power_asked_for() {
        let units = &directions(1).units;
        let (grains, roughness) = (200, 0.05);
        let mut square = 0.0;
        for k in 0..grains {
            let coefficients = coefficients(roughness, &mut Random::new(7, k, 0));
            let sum: f64 = units.iter().map(|u| harmonics::sum(&coefficients, 3, u)).map(|f| f * f).sum();
            square += sum / units.len() as f64 / grains as f64;
        }
        let golden: f64 =
            (3..=15).map(|n| (f64::from(n) / 3.0).powf(-10.0 / 3.0)).sum::<f64>() * roughness * roughness;
        assert!((square / golden - 1.0).abs() < 0.06, "{square} {golden}");
    }

    #[test]
    fn grains_too_thin_somewhere_are_refused() {
        let wild = entry(0.06);
        let spiky = ShapeEntry { values: [("angularity".to_string(), 1.0)].into(), ..wild };
        let message = grain(&spiky, 0).unwrap_err().message;
        assert!(message.starts_with("angularity is 1: no grain of 100"), "{message}");
    }
}
