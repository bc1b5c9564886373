//! The Sobol sequence, Owen-scrambled: points that fill the space evenly, the first few as well as all.
//!
//! A campaign with more points of the same sequence keeps the points that it has. Source: Burley, Practical Hash-based Owen
//! Scrambling, Journal of Computer Graphics Techniques 9 (2020), by the crate `sobol_burley`.

use super::point_design::{Axis, Coordinate, DesignSize, Point, PointDesign};

/// The design.
pub(super) static SOBOL: PointDesign = PointDesign {
    name: "sobol",
    help: "a scrambled Sobol sequence",
    points_in_words: "points of a Sobol sequence",
    size: DesignSize::PointsThatFulfil,
    points: |_, seed, axes| Box::new((0..MOST_POINTS).map(move |point| sobol(point, seed, axes))),
};

/// Most points of a sequence.
pub(in crate::plan) const MOST_POINTS: usize = 1 << 16;
/// Most axes.
pub(in crate::plan) const MOST_AXES: usize = 256;

/// A point of the sequence with this seed of the scrambling; the number of the point is below [`MOST_POINTS`] and the number of axes at
/// most [`MOST_AXES`].
pub(in crate::plan) fn sobol(point: usize, seed: u32, axes: &[Axis]) -> Point {
    let on = |(k, axis): (usize, &Axis)| {
        Coordinate::drawn(f64::from(sobol_burley::sample(point as u32, k as u32, seed)), *axis)
    };
    axes.iter().enumerate().map(on).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(coordinate: Coordinate) -> f64 {
        match coordinate {
            Coordinate::Share(share) => share,
            Coordinate::Level(level) => level as f64,
        }
    }

    #[test]
    fn every_interval_of_a_power_of_two_has_its_points() {
        let axes = [Axis::Continuous; 5];
        for axis in 0..5 {
            let mut places: Vec<usize> =
                (0..64).map(|k| (share(sobol(k, 7, &axes)[axis]) * 64.0) as usize).collect();
            places.sort_unstable();
            assert_eq!(places, (0..64).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_points_stay_those_of_the_first_version() {
        let points: Vec<f64> = (0..3).map(|k| share(sobol(k, 1, &[Axis::Continuous; 2])[1])).collect();
        assert_eq!(points, [0.749_335_169_792_175_3, 0.080_497_622_489_929_2, 0.363_577_365_875_244_14]);
        assert_ne!(sobol(0, 1, &[Axis::Continuous]), sobol(0, 2, &[Axis::Continuous]));
        let levels: Vec<f64> = (0..30).map(|k| share(sobol(k, 1, &[Axis::Levels(3)])[0])).collect();
        assert!((0..3).all(|level| levels.iter().filter(|found| **found == level as f64).count() >= 8));
    }
}
