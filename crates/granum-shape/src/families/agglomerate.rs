//! Agglomerates: equal spheres of the densest lattice inside of a ball, which touch without overlap, so that bonds can hold them together and
//! break (`[[bond]]` with `places = "inside"`).
//!
//! The lattice is the face-centred cubic one; the spheres nearest to the centre are taken, as many as asked for. Some of them can be taken out
//! at random, as flaws (Cheng, Nakata and Bolton 2003). Several agglomerates that differ by their flaws make a sample with the scatter of
//! strength that flaws give.

use crate::entry::ShapeEntry;
use crate::families::sand::{SHAPE_SEED, SHAPES};
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, ShapeParameter, Spheres};
use crate::random::Random;

/// Agglomerates of equal spheres.
pub struct Agglomerate;

const SPHERES: ShapeParameter = ShapeParameter {
    key: "agglomerate_spheres",
    default: 43.0,
    bounds: [4.0, 1000.0],
    whole: true,
    meaning: "Number of spheres of an agglomerate before any are taken out.",
};
const FLAWS: ShapeParameter = ShapeParameter {
    key: "flaws",
    default: 0.0,
    bounds: [0.0, 0.4],
    whole: false,
    meaning: "Share of the spheres of an agglomerate that are taken out at random.",
};

impl ShapeFamily for Agglomerate {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "agglomerate",
            help: "equal spheres of the densest lattice inside of a ball, which touch: with bonds inside they can come apart",
            parameters: &[SPHERES, FLAWS, SHAPES, SHAPE_SEED],
            takes_spheres: false,
            takes_file: false,
        }
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        let count = given.value(&SPHERES) as usize;
        let whole = ball(count);
        let out = (given.value(&FLAWS) * count as f64).round() as usize;
        let mut random = Random::new(given.value(&SHAPE_SEED) as u64, 0, 0);
        Ok((0..given.value(&SHAPES) as usize).map(|_| with_flaws(&whole, out, &mut random)).collect())
    }
}

/// The spheres of diameter one of the lattice that are nearest to its octahedral hole for few spheres, or to one of them: the ball whose last
/// shell is the fullest. Equal distances are taken in the order of the coordinates.
fn ball(count: usize) -> Spheres {
    let spacing = 2.0f64.sqrt();
    // Far enough for a thousand spheres.
    let reach = 9i32;
    let mut places: Vec<[f64; 3]> = Vec::new();
    for x in -reach..=reach {
        for y in -reach..=reach {
            for z in -reach..=reach {
                if (x + y + z) % 2 == 0 {
                    places.push([x, y, z].map(|k| 0.5 * spacing * f64::from(k)));
                }
            }
        }
    }
    let square = |p: &[f64; 3]| p.iter().map(|x| x * x).sum::<f64>();
    places.sort_by(|a, b| {
        square(a)
            .total_cmp(&square(b))
            .then_with(|| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2])))
    });
    places.truncate(count);
    places.into_iter().map(|place| (place, 0.5)).collect()
}

/// The spheres without some of them, drawn one after another; what is not connected to the largest rest is taken out as well.
fn with_flaws(whole: &Spheres, out: usize, random: &mut Random) -> Spheres {
    let mut left = whole.clone();
    for _ in 0..out.min(whole.len().saturating_sub(2)) {
        left.remove((random.even() * left.len() as f64) as usize);
    }
    largest_connected(&left)
}

/// The spheres of the largest set in which each touches another.
fn largest_connected(spheres: &Spheres) -> Spheres {
    let touches = |a: &[f64; 3], b: &[f64; 3]| {
        let square: f64 = (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum();
        square < 1.01
    };
    let mut set = vec![usize::MAX; spheres.len()];
    let mut sizes = Vec::new();
    for start in 0..spheres.len() {
        if set[start] != usize::MAX {
            continue;
        }
        let (mut waiting, mut size) = (vec![start], 0);
        set[start] = sizes.len();
        while let Some(at) = waiting.pop() {
            size += 1;
            for next in 0..spheres.len() {
                if set[next] == usize::MAX && touches(&spheres[at].0, &spheres[next].0) {
                    set[next] = sizes.len();
                    waiting.push(next);
                }
            }
        }
        sizes.push(size);
    }
    let largest = (0..sizes.len()).rev().max_by_key(|k| sizes[*k]).unwrap_or(0);
    spheres.iter().zip(&set).filter(|(_, of)| **of == largest).map(|(sphere, _)| *sphere).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_touch_without_overlap_and_shells_are_whole() {
        // Shells of 1, 12, 6 and 24: 12 + 24 contacts of the first two, 24 + 48 + 24 + 24 of the others.
        for (count, contacts) in [(13, 36), (43, 156)] {
            let spheres = ball(count);
            let mut touching = 0;
            for (k, (a, _)) in spheres.iter().enumerate() {
                for (b, _) in &spheres[k + 1..] {
                    let distance = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
                    assert!(distance > 1.0 - 1e-12, "{distance}");
                    touching += usize::from(distance < 1.0 + 1e-9);
                }
            }
            assert_eq!((spheres.len(), touching), (count, contacts));
        }
    }

    #[test]
    fn flaws_make_agglomerates_that_differ_and_hold_together() {
        let mut entry = ShapeEntry { kind: crate::family::ShapeKind::AGGLOMERATE, ..ShapeEntry::default() };
        for (key, value) in [("flaws", 0.2), ("shapes", 5.0)] {
            entry.values.insert(key.into(), value);
        }
        let shapes = Agglomerate.shapes(&entry).unwrap();
        assert_eq!(shapes.len(), 5);
        assert!(
            shapes.iter().all(|spheres| spheres.len() <= 34 && spheres.len() >= 30),
            "{:?}",
            shapes.iter().map(Vec::len).collect::<Vec<_>>()
        );
        assert_ne!(shapes[0], shapes[1]);
        assert_eq!(shapes, Agglomerate.shapes(&entry).unwrap());
    }
}
