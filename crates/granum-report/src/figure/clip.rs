//! Clipping of lines and areas at a rectangle, without SVG clip paths, whose names would have to be unique on a page.

use super::svg::Point;

/// A rectangle on the page: left, top, right, bottom, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Right edge.
    pub right: f64,
    /// Lower edge.
    pub bottom: f64,
}

impl Rect {
    /// A rectangle from its edges.
    pub fn new(left: f64, top: f64, right: f64, bottom: f64) -> Self {
        Rect { left, top, right, bottom }
    }

    /// Width, px.
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    /// Height, px.
    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// True for a point inside the rectangle enlarged by a margin, including its edges.
    pub fn contains(&self, p: Point, margin: f64) -> bool {
        p[0] >= self.left - margin
            && p[0] <= self.right + margin
            && p[1] >= self.top - margin
            && p[1] <= self.bottom + margin
    }
}

/// The part of a segment inside a box in any number of dimensions, as the two parameters in 0..1 at which it enters and
/// leaves the box (Liang and Barsky 1984); `None` if it is outside.
pub fn segment<const D: usize>(
    a: [f64; D],
    b: [f64; D],
    low: [f64; D],
    high: [f64; D],
) -> Option<(f64, f64)> {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for k in 0..D {
        let step = b[k] - a[k];
        if step == 0.0 {
            if a[k] < low[k] || a[k] > high[k] {
                return None;
            }
            continue;
        }
        let (t0, t1) = ((low[k] - a[k]) / step, (high[k] - a[k]) / step);
        enter = enter.max(t0.min(t1));
        leave = leave.min(t0.max(t1));
    }
    (enter < leave).then_some((enter, leave))
}

/// The parts of a line through points inside a rectangle.
pub fn polyline(points: &[Point], rect: &Rect) -> Vec<Vec<Point>> {
    let (low, high) = ([rect.left, rect.top], [rect.right, rect.bottom]);
    let mut parts: Vec<Vec<Point>> = Vec::new();
    let mut open = false;
    for pair in points.windows(2) {
        let Some((enter, leave)) = segment(pair[0], pair[1], low, high) else {
            open = false;
            continue;
        };
        let at = |t: f64| -> Point { std::array::from_fn(|k| pair[0][k] + t * (pair[1][k] - pair[0][k])) };
        if !open || enter > 0.0 {
            parts.push(vec![at(enter)]);
        }
        if let Some(part) = parts.last_mut() {
            part.push(at(leave));
        }
        open = leave >= 1.0;
    }
    parts
}

/// The part of an area inside a rectangle (Sutherland and Hodgman 1974).
pub fn polygon(points: &[Point], rect: &Rect) -> Vec<Point> {
    let mut points = points.to_vec();
    for (axis, limit, sign) in
        [(0, rect.left, 1.0), (0, rect.right, -1.0), (1, rect.top, 1.0), (1, rect.bottom, -1.0)]
    {
        let inside = |p: &Point| sign * (p[axis] - limit) >= 0.0;
        let mut kept = Vec::with_capacity(points.len() + 4);
        for k in 0..points.len() {
            let (a, b) = (points[k], points[(k + 1) % points.len()]);
            if inside(&a) {
                kept.push(a);
            }
            if inside(&a) != inside(&b) {
                let t = (limit - a[axis]) / (b[axis] - a[axis]);
                kept.push(std::array::from_fn(|c| if c == axis { limit } else { a[c] + t * (b[c] - a[c]) }));
            }
        }
        points = kept;
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Rect = Rect { left: 0.0, top: 0.0, right: 1.0, bottom: 1.0 };

    #[test]
    fn lines_are_cut_at_the_edges() {
        let parts = polyline(&[[-1.0, 0.5], [0.5, 0.5], [0.5, 2.0], [0.5, 0.75]], &UNIT);
        assert_eq!(parts, [vec![[0.0, 0.5], [0.5, 0.5], [0.5, 1.0]], vec![[0.5, 1.0], [0.5, 0.75]]]);
        assert!(polyline(&[[2.0, 2.0], [3.0, 0.0]], &UNIT).is_empty());
    }

    #[test]
    fn areas_are_cut_at_the_edges() {
        let square = polygon(&[[-1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [-1.0, 2.0]], &UNIT);
        assert_eq!(square.len(), 4);
        assert!(square.iter().all(|p| UNIT.contains(*p, 0.0)));
        assert!(polygon(&[[2.0, 2.0], [3.0, 2.0], [3.0, 3.0]], &UNIT).is_empty());
    }

    #[test]
    fn segments_in_space() {
        let cut = segment([0.5, 0.5, -1.0], [0.5, 0.5, 3.0], [0.0; 3], [1.0; 3]);
        assert_eq!(cut, Some((0.25, 0.5)));
        assert_eq!(segment([2.0, 0.5, 0.5], [3.0, 0.5, 0.5], [0.0; 3], [1.0; 3]), None);
    }
}
