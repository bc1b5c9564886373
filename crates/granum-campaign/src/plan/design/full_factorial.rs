//! The full factorial design: all combinations of the values of all variables, those of the last variable next to each other.

use super::point_design::{Axis, Coordinate, DesignSize, Point, PointDesign};

/// The design.
pub(super) static FULL_FACTORIAL: PointDesign = PointDesign {
    name: "full-factorial",
    help: "all combinations",
    points_in_words: "all combinations",
    size: DesignSize::Levels,
    points: |_, _, axes| {
        let levels = |axis: &Axis| match axis {
            Axis::Levels(count) => *count,
            Axis::Continuous => 1,
        };
        let levels: Vec<usize> = axes.iter().map(levels).collect();
        Box::new(full_factorial(&levels).into_iter())
    },
};

/// All combinations of so many values on each axis.
fn full_factorial(levels: &[usize]) -> Vec<Point> {
    let mut all: Vec<Point> = vec![Vec::new()];
    for count in levels {
        let with_each = |before: &Point| {
            let before = before.clone();
            (0..*count).map(move |level| [&before[..], &[Coordinate::Level(level)]].concat())
        };
        all = all.iter().flat_map(with_each).collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_combinations_come_once() {
        let points = full_factorial(&[2, 3]);
        let level = |level| Coordinate::Level(level);
        assert_eq!(points.len(), 6);
        assert_eq!(points[1], [level(0), level(1)]);
        assert_eq!(points[5], [level(1), level(2)]);
    }
}
