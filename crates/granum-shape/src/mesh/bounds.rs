//! Boxes around points.

use granum_core::assembly::Vector;

/// The least and the largest coordinates of points.
pub(crate) fn bounds(points: &[Vector]) -> [Vector; 2] {
    let none = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    points.iter().fold(none, |[low, high], p| {
        [std::array::from_fn(|a| low[a].min(p[a])), std::array::from_fn(|a| high[a].max(p[a]))]
    })
}
