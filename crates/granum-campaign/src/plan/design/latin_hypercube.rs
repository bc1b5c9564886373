//! The Latin hypercube: every axis is divided into as many intervals as there are points, and each interval has one point.
//!
//! Of several hypercubes that are drawn the one is taken whose closest points are furthest apart (maximin). Source: McKay, Beckman
//! and Conover, Technometrics 21 (1979) 239; Johnson, Moore and Ylvisaker, Journal of Statistical Planning and Inference 26 (1990) 131.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::point_design::{Axis, Coordinate, DesignSize, Point, PointDesign};

/// The design.
pub(super) static LATIN_HYPERCUBE: PointDesign = PointDesign {
    name: "latin-hypercube",
    help: "each of as many intervals of a variable as there are points has one",
    points_in_words: "points of a Latin hypercube",
    size: DesignSize::Points,
    points: |points, seed, axes| Box::new(latin_hypercube(points, seed, axes).into_iter()),
};

/// Number of hypercubes of which the best is taken.
const DRAWN: usize = 20;
/// With more points than this the distances of all pairs would take longer than they are worth.
const MOST_COMPARED: usize = 500;

/// The points of a Latin hypercube with this seed.
fn latin_hypercube(points: usize, seed: u32, axes: &[Axis]) -> Vec<Point> {
    let mut random = ChaCha8Rng::seed_from_u64(u64::from(seed));
    let count = if points > MOST_COMPARED { 1 } else { DRAWN };
    let mut best: Option<(f64, Vec<Vec<f64>>)> = None;
    for _ in 0..count {
        let drawn = draw(points, axes.len(), &mut random);
        let distance = if count > 1 { closest(&drawn) } else { 0.0 };
        if best.as_ref().is_none_or(|(known, _)| distance > *known) {
            best = Some((distance, drawn));
        }
    }
    let shares = best.map_or_else(Vec::new, |(_, drawn)| drawn);
    let point = |shares: Vec<f64>| {
        shares.into_iter().zip(axes).map(|(share, axis)| Coordinate::drawn(share, *axis)).collect()
    };
    shares.into_iter().map(point).collect()
}

/// Points whose places on each axis are one in each interval, in a random order, anywhere within it.
fn draw(points: usize, axes: usize, random: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::with_capacity(axes); points];
    for _ in 0..axes {
        let mut order: Vec<usize> = (0..points).collect();
        for last in (1..points).rev() {
            order.swap(last, (random.next_u64() % (last as u64 + 1)) as usize);
        }
        for (point, place) in all.iter_mut().zip(order) {
            let within = (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            point.push((place as f64 + within) / points as f64);
        }
    }
    all
}

/// The square of the smallest distance between two points.
fn closest(points: &[Vec<f64>]) -> f64 {
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    let from = |(k, point): (usize, &Vec<f64>)| {
        points[k + 1..].iter().map(|other| distance(point, other)).fold(f64::INFINITY, f64::min)
    };
    points.iter().enumerate().map(from).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_interval_of_each_axis_has_one_point() {
        let axes = [Axis::Continuous; 3];
        let points = latin_hypercube(40, 3, &axes);
        for axis in 0..3 {
            let place = |point: &Point| match point[axis] {
                Coordinate::Share(share) => (share * 40.0) as usize,
                Coordinate::Level(level) => level,
            };
            let mut places: Vec<usize> = points.iter().map(place).collect();
            places.sort_unstable();
            assert_eq!(places, (0..40).collect::<Vec<_>>());
        }
        assert_eq!(points, latin_hypercube(40, 3, &axes));
        assert_ne!(points, latin_hypercube(40, 4, &axes));
        assert!(latin_hypercube(0, 1, &axes).is_empty());
    }
}
