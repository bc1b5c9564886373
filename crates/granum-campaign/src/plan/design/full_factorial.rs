//! The full factorial design: all combinations of the values of all variables, those of the last variable next to each other.

use super::{Coordinate, Point};

/// All combinations of so many values on each axis.
pub(in crate::plan) fn full_factorial(levels: &[usize]) -> Vec<Point> {
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
