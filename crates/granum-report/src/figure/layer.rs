//! The layers of a plot: lines, points, bands and reference lines.

use super::axis::{Scale, usable};
use super::clip::{self, Rect};
use super::marks::Shape;
use super::svg::{Point, Stroke, Svg};

/// One layer of a plot; later layers are drawn over earlier ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Kind of the layer, with its data.
    pub kind: LayerKind,
    /// Marked-up name in the legend; `None` if the layer is not in the legend.
    pub label: Option<String>,
}

/// The kinds of layers. Values that are not finite, or not positive on a logarithmic axis, leave a gap.
#[derive(Clone, Debug, PartialEq)]
pub enum LayerKind {
    /// A line through points.
    Line {
        /// x and y.
        points: Vec<Point>,
        /// Colour, width, dashes.
        stroke: Stroke,
    },
    /// Points.
    Points {
        /// x and y.
        points: Vec<Point>,
        /// Shape of the marks.
        shape: Shape,
        /// Size (half a side), px.
        radius: f64,
        /// Colour.
        color: String,
        /// True if the marks are filled with the colour, false if they are white with a coloured edge.
        filled: bool,
    },
    /// The area between two curves.
    Band {
        /// x, lower and upper y.
        points: Vec<[f64; 3]>,
        /// Colour.
        color: String,
        /// Opacity, 0..1.
        opacity: f64,
    },
    /// A horizontal line across the plot.
    Horizontal {
        /// y.
        at: f64,
        /// Colour, width, dashes.
        stroke: Stroke,
    },
    /// A vertical line across the plot.
    Vertical {
        /// x.
        at: f64,
        /// Colour, width, dashes.
        stroke: Stroke,
    },
}

impl Layer {
    fn new(kind: LayerKind) -> Self {
        Layer { kind, label: None }
    }

    /// A line, 1.6 px wide.
    pub fn line(points: Vec<Point>, color: &str) -> Self {
        Layer::stroked(points, Stroke::new(color, 1.6))
    }

    /// A line with a given stroke.
    pub fn stroked(points: Vec<Point>, stroke: Stroke) -> Self {
        Layer::new(LayerKind::Line { points, stroke })
    }

    /// Open points.
    pub fn points(points: Vec<Point>, shape: Shape, color: &str) -> Self {
        Layer::new(LayerKind::Points { points, shape, radius: 2.7, color: color.to_owned(), filled: false })
    }

    /// Filled points.
    pub fn dots(points: Vec<Point>, shape: Shape, radius: f64, color: &str) -> Self {
        Layer::new(LayerKind::Points { points, shape, radius, color: color.to_owned(), filled: true })
    }

    /// A pale area between two curves: x, lower y, upper y.
    pub fn band(points: Vec<[f64; 3]>, color: &str) -> Self {
        Layer::new(LayerKind::Band { points, color: color.to_owned(), opacity: 0.2 })
    }

    /// An area with a given opacity.
    pub fn area(points: Vec<[f64; 3]>, color: &str, opacity: f64) -> Self {
        Layer::new(LayerKind::Band { points, color: color.to_owned(), opacity })
    }

    /// A thin dashed horizontal line.
    pub fn horizontal(at: f64, color: &str) -> Self {
        Layer::new(LayerKind::Horizontal { at, stroke: Stroke::new(color, 1.0).dashed(&[5.0, 3.0]) })
    }

    /// A thin dashed vertical line.
    pub fn vertical(at: f64, color: &str) -> Self {
        Layer::new(LayerKind::Vertical { at, stroke: Stroke::new(color, 1.0).dashed(&[2.0, 3.0]) })
    }

    /// Sets the name in the legend.
    pub fn named(mut self, label: &str) -> Self {
        self.label = Some(label.to_owned());
        self
    }

    /// Calls `see` with every point that the axes must include.
    pub fn visit(&self, log: [bool; 2], mut see: impl FnMut([Option<f64>; 2])) {
        let mut pair = |x: f64, y: f64| {
            if usable(x, log[0]) && usable(y, log[1]) {
                see([Some(x), Some(y)]);
            }
        };
        match &self.kind {
            LayerKind::Line { points, .. } | LayerKind::Points { points, .. } => {
                points.iter().for_each(|&[x, y]| pair(x, y));
            }
            LayerKind::Band { points, .. } => points.iter().for_each(|&[x, low, high]| {
                pair(x, low);
                pair(x, high);
            }),
            LayerKind::Horizontal { at, .. } if usable(*at, log[1]) => see([None, Some(*at)]),
            LayerKind::Vertical { at, .. } if usable(*at, log[0]) => see([Some(*at), None]),
            LayerKind::Horizontal { .. } | LayerKind::Vertical { .. } => {}
        }
    }

    /// Draws the layer in a frame.
    pub fn draw(&self, svg: &mut Svg, frame: &Rect, x: &Scale, y: &Scale) {
        match &self.kind {
            LayerKind::Line { stroke, .. } => {
                for part in self.runs(x, y) {
                    for piece in clip::polyline(&part, frame) {
                        svg.path(&piece, false, None, Some(stroke));
                    }
                }
            }
            LayerKind::Points { shape, radius, color, filled, .. } => {
                let inside = self.runs(x, y).into_iter().flatten().filter(|p| frame.contains(*p, 0.5));
                let data: String = inside.map(|p| shape.path(p, *radius)).collect();
                if !data.is_empty() {
                    mark(svg, &data, *shape, color, *filled);
                }
            }
            LayerKind::Band { color, opacity, .. } => {
                for outline in self.runs(x, y) {
                    let area = clip::polygon(&outline, frame);
                    svg.path(&area, true, Some((color, *opacity)), None);
                }
            }
            LayerKind::Horizontal { at, stroke } => {
                if let Some(at) = y.at(*at).filter(|at| (frame.top..=frame.bottom).contains(at)) {
                    svg.line([frame.left, at], [frame.right, at], stroke);
                }
            }
            LayerKind::Vertical { at, stroke } => {
                if let Some(at) = x.at(*at).filter(|at| (frame.left..=frame.right).contains(at)) {
                    svg.line([at, frame.bottom], [at, frame.top], stroke);
                }
            }
        }
    }

    /// The pieces between gaps, in positions on the page: lines, points, or outlines of areas.
    pub fn runs(&self, x: &Scale, y: &Scale) -> Vec<Vec<Point>> {
        match &self.kind {
            LayerKind::Line { points, .. } | LayerKind::Points { points, .. } => {
                gapless(points.iter().map(|p| Some([x.at(p[0])?, y.at(p[1])?])))
            }
            LayerKind::Band { points, .. } => {
                let bottom = gapless(points.iter().map(|p| {
                    y.at(p[2])?;
                    // On a logarithmic axis, a lower edge of a band at or below zero is moved to the end of the axis.
                    let low = if y.log && p[1].is_finite() { p[1].max(y.low) } else { p[1] };
                    Some([x.at(p[0])?, y.at(low)?, y.at(p[2])?])
                }));
                bottom
                    .into_iter()
                    .map(|run| {
                        let upper = run.iter().rev().map(|p| [p[0], p[2]]);
                        run.iter().map(|p| [p[0], p[1]]).chain(upper).collect()
                    })
                    .collect()
            }
            LayerKind::Horizontal { .. } | LayerKind::Vertical { .. } => Vec::new(),
        }
    }
}

/// Draws marks with a given path.
pub fn mark(svg: &mut Svg, data: &str, shape: Shape, color: &str, filled: bool) {
    if shape.is_open() {
        let width = if shape == Shape::Bar { 2.0 } else { 1.3 };
        svg.path_of(data, None, Some(&Stroke::new(color, width)));
    } else if filled {
        svg.path_of(data, Some((color, 1.0)), Some(&Stroke::new("#ffffff", 0.6)));
    } else {
        svg.path_of(data, Some(("#ffffff", 1.0)), Some(&Stroke::new(color, 1.0)));
    }
}

fn gapless<T>(items: impl Iterator<Item = Option<T>>) -> Vec<Vec<T>> {
    let mut runs: Vec<Vec<T>> = Vec::new();
    let mut open = false;
    for item in items {
        match item {
            Some(item) => {
                if !open {
                    runs.push(Vec::new());
                }
                if let Some(run) = runs.last_mut() {
                    run.push(item);
                }
                open = true;
            }
            None => open = false,
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Axis;

    #[test]
    fn what_cannot_be_drawn_leaves_a_gap() {
        let layer = Layer::line(
            vec![[0.0, 1.0], [1.0, 1.0], [2.0, f64::NAN], [3.0, 1.0], [4.0, f64::INFINITY]],
            "#000",
        );
        let scale = Axis::new("").between(0.0, 4.0).resolve(None).laid(0.0, 40.0);
        let runs = layer.runs(&scale, &scale);
        assert_eq!(runs.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
    }

    #[test]
    fn a_band_that_reaches_zero_ends_at_a_logarithmic_axis() {
        let layer = Layer::band(vec![[0.0, 0.0, 1.0], [1.0, 0.5, 1.0]], "#000");
        let x = Axis::new("").between(0.0, 1.0).resolve(None).laid(0.0, 10.0);
        let y = Axis::new("").logarithmic().between(0.1, 1.0).resolve(None).laid(10.0, 0.0);
        let runs = layer.runs(&x, &y);
        assert_eq!(runs.len(), 1);
        assert_eq!(runs[0][0], [0.0, 10.0]);
        assert_eq!(runs[0].len(), 4);
    }
}
