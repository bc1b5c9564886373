//! Marks for data points.

use super::svg::{Point, number};
use std::fmt::Write;

/// Shape of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A circle.
    Circle,
    /// A square.
    Square,
    /// A triangle that points up.
    Triangle,
    /// A square on its corner.
    Diamond,
    /// A triangle that points down.
    Down,
    /// A plus sign.
    Plus,
    /// A diagonal cross.
    Cross,
    /// A vertical bar.
    Bar,
}

/// The shapes in the order in which figures use them.
pub const SHAPES: [Shape; 5] = [Shape::Circle, Shape::Square, Shape::Triangle, Shape::Diamond, Shape::Down];

impl Shape {
    /// True for shapes without an interior.
    pub fn is_open(self) -> bool {
        matches!(self, Shape::Plus | Shape::Cross | Shape::Bar)
    }

    /// Path data of a mark with a size of about `radius`; all shapes cover about the same area.
    pub fn path(self, centre: Point, radius: f64) -> String {
        let polygon = |scale: f64, corners: &[[f64; 2]]| {
            let mut data = String::new();
            for (k, corner) in corners.iter().enumerate() {
                let [x, y] = [0, 1].map(|c| number(centre[c] + scale * radius * corner[c]));
                let _ = write!(data, "{}{x} {y}", if k == 0 { 'M' } else { 'L' });
            }
            data + "Z"
        };
        let r = radius;
        match self {
            Shape::Circle => format!(
                "M{} {}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0Z",
                number(centre[0] - r),
                number(centre[1]),
                r = number(r),
                d = number(2.0 * r)
            ),
            Shape::Square => polygon(0.88, &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]),
            Shape::Triangle => polygon(1.3, &[[0.0, -1.0], [0.9, 0.56], [-0.9, 0.56]]),
            Shape::Down => polygon(1.3, &[[0.0, 1.0], [0.9, -0.56], [-0.9, -0.56]]),
            Shape::Diamond => polygon(1.25, &[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]),
            Shape::Bar => {
                let [x, top, bottom] = [centre[0], centre[1] - r, centre[1] + r].map(number);
                format!("M{x} {top}L{x} {bottom}")
            }
            Shape::Plus | Shape::Cross => {
                let arm =
                    if self == Shape::Plus { [[1.0, 0.0], [0.0, 1.0]] } else { [[0.8, 0.8], [0.8, -0.8]] };
                let mut data = String::new();
                for [x, y] in arm {
                    let [x0, x1] = [-1.0, 1.0].map(|s| number(centre[0] + s * r * x));
                    let [y0, y1] = [-1.0, 1.0].map(|s| number(centre[1] + s * r * y));
                    let _ = write!(data, "M{x0} {y0}L{x1} {y1}");
                }
                data
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_has_a_path() {
        for shape in SHAPES.into_iter().chain([Shape::Plus, Shape::Cross, Shape::Bar]) {
            let path = shape.path([10.0, 10.0], 3.0);
            assert!(path.starts_with('M') && !path.contains("NaN"), "{path}");
            assert_eq!(path.ends_with('Z'), !shape.is_open());
        }
    }
}
