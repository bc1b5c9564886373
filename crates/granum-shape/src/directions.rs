//! Directions that are spread evenly over the sphere, and the triangles between them.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use granum_core::assembly::Vector;
use granum_core::geometry::{cross, dot, length};

/// Directions and the triangles between them: an icosahedron whose triangles are divided into four again and again.
pub(crate) struct Directions {
    /// Unit vectors.
    pub units: Vec<Vector>,
    /// The triangles, anticlockwise seen from outside.
    pub triangles: Vec<[usize; 3]>,
}

/// Largest level.
const LEVELS: usize = 6;

/// The directions of a level, `10 * 4^level + 2` of them; at most level 5.
pub(crate) fn directions(level: usize) -> &'static Directions {
    static MADE: [OnceLock<Directions>; LEVELS] = [const { OnceLock::new() }; LEVELS];
    let level = level.min(LEVELS - 1);
    MADE[level].get_or_init(|| (0..level).fold(icosahedron(), |coarse, _| divided(&coarse)))
}

fn icosahedron() -> Directions {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let corners = [[1.0, golden], [-1.0, golden], [1.0, -golden], [-1.0, -golden]];
    let mut units = Vec::new();
    units.extend(corners.map(|[s, g]| unit(&[s, g, 0.0])));
    units.extend(corners.map(|[s, g]| unit(&[0.0, s, g])));
    units.extend(corners.map(|[s, g]| unit(&[g, 0.0, s])));
    Directions { triangles: faces(&units), units }
}

/// The triangles of three neighbours, turned outwards.
fn faces(units: &[Vector]) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    let near = |a: usize, b: usize| dot(&units[a], &units[b]) > 0.4;
    for a in 0..units.len() {
        for b in a + 1..units.len() {
            for c in b + 1..units.len() {
                if near(a, b) && near(b, c) && near(a, c) {
                    let outwards = dot(&units[a], &cross(&units[b], &units[c])) > 0.0;
                    triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    triangles
}

fn divided(coarse: &Directions) -> Directions {
    let mut units = coarse.units.clone();
    let mut middles: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let mut middle = |a: usize, b: usize| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let sum = std::array::from_fn(|k| units[a][k] + units[b][k]);
            units.push(unit(&sum));
            units.len() - 1
        })
    };
    let mut triangles = Vec::with_capacity(4 * coarse.triangles.len());
    for &[a, b, c] in &coarse.triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    Directions { units, triangles }
}

/// A vector of length one.
pub(crate) fn unit(v: &Vector) -> Vector {
    let length = length(v);
    v.map(|x| x / length)
}

/// The 26 directions to the neighbours of a cube in a grid of cubes.
pub(crate) fn steps() -> impl Iterator<Item = Vector> {
    let step = |k: i32| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1].map(f64::from);
    (0..27).map(step).filter(|step| *step != [0.0; 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_triangles_close_around_the_sphere() {
        for level in 0..4 {
            let found = directions(level);
            let count = 10 * 4usize.pow(level as u32) + 2;
            assert_eq!((found.units.len(), found.triangles.len()), (count, 2 * count - 4));
            let volume: f64 = (found.triangles.iter())
                .map(|&[a, b, c]| dot(&found.units[a], &cross(&found.units[b], &found.units[c])) / 6.0)
                .sum();
            let whole = 4.0 / 3.0 * std::f64::consts::PI;
            let share = [0.606, 0.87, 0.966, 0.991][level];
            assert!(volume > share * whole * 0.99 && volume < whole, "{level}: {}", volume / whole);
        }
    }
}
