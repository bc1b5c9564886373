//! A random gas of grains that do not overlap, from a seed: where a preparation starts.

use granum_simd::Row8;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::assembly::Vector;
use crate::cell::Cell;
use crate::config::Grains;
use crate::simulation::Site;

/// Tries for one grain before the gas is called too dense.
const TRIES: usize = 200_000;

/// The gas cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "no room for grain {placed} of {count} at an initial solid fraction of {solid_fraction}: random placement reaches about \
     0.38; choose preparation.initial_solid_fraction from 0.01 to 0.36"
)]
pub struct GasError {
    placed: usize,
    count: usize,
    solid_fraction: f64,
}

/// A number in [0, 1) with 53 random bits.
fn unit(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Places grains one after the other at random in a cubic cell of the given solid fraction (random sequential addition).
/// Radii are uniform in `d/2 (1 ± spread)`.
pub fn gas(grains: &Grains, solid_fraction: f64, seed: u64) -> Result<(Cell, Vec<Site>), GasError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut radii: Vec<f64> = (0..grains.count)
        .map(|_| 0.5 * grains.diameter * (1.0 + grains.spread * (2.0 * unit(&mut rng) - 1.0)))
        .collect();
    // Large ones first: small ones fit between them.
    radii.sort_unstable_by(|a, b| b.total_cmp(a));
    let solid: f64 = radii.iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
    let length = (solid / solid_fraction).cbrt();
    let mut boxes = Boxes::new(length, 2.0 * radii[0]);
    let mut sites = Vec::with_capacity(grains.count);
    for (k, &radius) in radii.iter().enumerate() {
        let found =
            (0..TRIES).map(|_| [(); 3].map(|()| length * unit(&mut rng))).find(|x| boxes.free(x, radius));
        let Some(position) = found else {
            return Err(GasError { placed: k, count: grains.count, solid_fraction });
        };
        boxes.insert(position, radius);
        sites.push(Site { id: k as u64 + 1, position, radius });
    }
    Ok((Cell::cuboid([length; 3]), sites))
}

/// Placed grains by box.
struct Boxes {
    length: f64,
    count: usize,
    content: Vec<Vec<Row8>>,
}

impl Boxes {
    fn new(length: f64, diameter: f64) -> Boxes {
        let count = ((length / diameter).floor() as usize).clamp(1, 400);
        Boxes { length, count, content: vec![Vec::new(); count.pow(3)] }
    }

    fn index(&self, x: &Vector) -> [usize; 3] {
        x.map(|v| ((v / self.length * self.count as f64) as usize).min(self.count - 1))
    }

    fn insert(&mut self, x: Vector, radius: f64) {
        let [a, b, c] = self.index(&x);
        self.content[(a * self.count + b) * self.count + c]
            .push(Row8([x[0], x[1], x[2], radius, 0.0, 0.0, 0.0, 0.0]));
    }

    fn free(&self, x: &Vector, radius: f64) -> bool {
        let here = self.index(x);
        let n = self.count as i64;
        (0..27).all(|step| {
            let offset = [step / 9 - 1, (step / 3) % 3 - 1, step % 3 - 1];
            let b: [usize; 3] =
                std::array::from_fn(|a| (here[a] as i64 + offset[a] as i64).rem_euclid(n) as usize);
            self.content[(b[0] * self.count + b[1]) * self.count + b[2]].iter().all(|other| {
                let square: f64 = (0..3)
                    .map(|a| {
                        let d = x[a] - other.0[a];
                        (d - self.length * (d / self.length).round()).powi(2)
                    })
                    .sum();
                square > (radius + other.0[3]).powi(2)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Material;

    fn grains(count: usize, spread: f64) -> Grains {
        Grains { count, diameter: 1e-4, spread, material: Material::default() }
    }

    #[test]
    fn no_two_grains_overlap_and_the_solid_fraction_is_met() {
        let (cell, sites) = gas(&grains(500, 0.2), 0.33, 7).unwrap();
        let length = cell.edges[0][0];
        for (k, a) in sites.iter().enumerate() {
            for b in &sites[..k] {
                let square: f64 = (0..3)
                    .map(|c| {
                        let d = a.position[c] - b.position[c];
                        (d - length * (d / length).round()).powi(2)
                    })
                    .sum();
                assert!(square.sqrt() > a.radius + b.radius);
            }
        }
        let solid: f64 = sites.iter().map(|s| 4.0 / 3.0 * std::f64::consts::PI * s.radius.powi(3)).sum();
        assert!((solid / cell.volume() - 0.33).abs() < 1e-12);
    }

    #[test]
    fn a_seed_decides_the_gas() {
        let g = grains(50, 0.0);
        assert_eq!(gas(&g, 0.2, 3).unwrap().1, gas(&g, 0.2, 3).unwrap().1);
        assert_ne!(gas(&g, 0.2, 3).unwrap().1, gas(&g, 0.2, 4).unwrap().1);
    }

    #[test]
    fn too_dense_a_gas_is_refused() {
        assert!(gas(&grains(300, 0.0), 0.6, 1).is_err());
    }
}
