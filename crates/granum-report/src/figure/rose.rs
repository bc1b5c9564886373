//! A rose: a polar histogram of directions without sign, measured from the vertical.

use super::clip::Rect;
use super::layer::{Layer, LayerKind};
use super::palette::{GREY, INK, PALE, TICK_SIZE};
use super::plot::plain;
use super::rich::text;
use super::svg::{Anchor, Point, Stroke, Svg, number};
use super::ticks;
use std::fmt::Write;

/// A rose with the bins of one quadrant, which are mirrored into the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rose {
    /// Series, from back to front; the first is filled, the others are outlines.
    pub series: Vec<Series>,
    /// A value at which a dashed circle is drawn.
    pub reference: Option<f64>,
    /// Value at the rim; `None` if it follows from the data.
    pub rim: Option<f64>,
    /// Marked-up name of the vertical direction.
    pub up: String,
    /// Marked-up name of the horizontal direction.
    pub right: String,
}

/// One series of a rose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Marked-up name in the legend.
    pub label: String,
    /// One value per bin; the bins divide the range of 0 to 90 degrees from the vertical into equal parts.
    pub values: Vec<f64>,
    /// Colour.
    pub color: String,
}

impl Rose {
    /// The largest value; 0 if there are none.
    pub fn largest(&self) -> f64 {
        let values = self.series.iter().flat_map(|series| series.values.iter().copied());
        values.filter(|value| value.is_finite() && *value < 1e100).fold(0.0, f64::max)
    }

    /// The layers that represent the series in a legend.
    pub fn legend_layers(&self) -> Vec<Layer> {
        let mut layers: Vec<Layer> = Vec::new();
        for (k, series) in self.series.iter().enumerate() {
            let layer = if k == 0 {
                Layer::area(Vec::new(), &series.color, FILL)
            } else {
                Layer::stroked(Vec::new(), Stroke::new(&series.color, 1.8))
            };
            layers.push(layer.named(&series.label));
        }
        if self.reference.is_some() {
            layers.push(Layer { kind: reference_kind(), label: Some("isotropic".to_owned()) });
        }
        layers
    }

    /// Draws the rose in a frame.
    pub fn draw(&self, svg: &mut Svg, frame: &Rect) {
        let centre = [0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom)];
        let radius = 0.5 * (frame.width().min(frame.height()) - 3.0 * TICK_SIZE).max(20.0);
        let largest = self.rim.unwrap_or_else(|| self.largest()).max(self.reference.unwrap_or(0.0));
        let rim = if largest > 0.0 && largest.is_finite() { 1.04 * largest } else { 1.0 };
        let scale = radius / rim;
        let step = ticks::nice_step(rim, 3.0);
        let circles = (rim / step).floor().clamp(0.0, 20.0) as usize;

        svg.circle(centre, radius, None, Some(&Stroke::new(INK, 1.0)));
        for k in 1..=circles {
            svg.circle(centre, scale * step * k as f64, None, Some(&Stroke::new(PALE, 0.7)));
        }
        for (k, series) in self.series.iter().enumerate() {
            let data =
                if k == 0 { wedges(centre, scale, &series.values) } else { outline(centre, scale, series) };
            if data.is_empty() {
                continue;
            }
            if k == 0 {
                svg.path_of(&data, Some((&series.color, FILL)), Some(&Stroke::new("#ffffff", 0.8)));
            } else {
                svg.path_of(&data, None, Some(&Stroke::new(&series.color, 1.8)));
            }
        }
        if let (Some(value), LayerKind::Line { stroke, .. }) = (self.reference, reference_kind()) {
            svg.circle(centre, scale * value, None, Some(&stroke));
        }
        for k in 1..=circles {
            let value = step * k as f64;
            let at = direction(centre, scale * value, 60.0);
            let label = ticks::fixed(value, (-libm::log10(step).floor()).clamp(0.0, 3.0) as usize);
            text(svg, [at[0] + 2.0, at[1] - 2.0], &label, plain(GREY, Anchor::Start, 0.85 * TICK_SIZE));
        }
        self.draw_directions(svg, centre, radius);
        if self.largest() == 0.0 {
            text(svg, centre, "nothing to show", plain(GREY, Anchor::Middle, TICK_SIZE));
        }
    }

    fn draw_directions(&self, svg: &mut Svg, centre: Point, radius: f64) {
        let rays: String = (0..36)
            .map(|k| {
                let angle = 10.0 * k as f64;
                let length = if k % 9 == 0 {
                    6.0
                } else if k % 3 == 0 {
                    4.0
                } else {
                    2.5
                };
                super::svg::path_data(&[
                    direction(centre, radius, angle),
                    direction(centre, radius - length, angle),
                ])
            })
            .collect();
        svg.path_of(&rays, None, Some(&Stroke::new(INK, 0.8)));
        let up = [centre[0], centre[1] - radius - 6.0];
        text(svg, up, &self.up, plain(INK, Anchor::Middle, TICK_SIZE));
        let right = [centre[0] + radius + 6.0, centre[1] + 0.36 * TICK_SIZE];
        text(svg, right, &self.right, plain(INK, Anchor::Start, TICK_SIZE));
    }
}

/// Opacity of the filled series.
const FILL: f64 = 0.42;

fn reference_kind() -> LayerKind {
    LayerKind::Line { points: Vec::new(), stroke: Stroke::new(INK, 1.0).dashed(&[4.0, 3.0]) }
}

/// The point at an angle in degrees, clockwise from the vertical.
fn direction(centre: Point, radius: f64, degrees: f64) -> Point {
    let (sine, cosine) = libm::sincos(degrees.to_radians());
    [centre[0] + radius * sine, centre[1] - radius * cosine]
}

/// Radii of the bins of the full circle, clockwise from the vertical; 0 for values that are negative or not finite.
fn around(values: &[f64], scale: f64) -> Vec<f64> {
    let clean = |value: &f64| if value.is_finite() { scale * value.clamp(0.0, 1e100) } else { 0.0 };
    let quarter: Vec<f64> = values.iter().map(clean).collect();
    let half: Vec<f64> = quarter.iter().chain(quarter.iter().rev()).copied().collect();
    half.iter().chain(half.iter()).copied().collect()
}

fn wedges(centre: Point, scale: f64, values: &[f64]) -> String {
    let radii = around(values, scale);
    let width = 360.0 / radii.len().max(1) as f64;
    let mut data = String::new();
    for (k, &radius) in radii.iter().enumerate().filter(|(_, radius)| **radius > 0.0) {
        let (a, b) = (width * k as f64, width * (k + 1) as f64);
        let [p, q] = [a, b].map(|angle| direction(centre, radius, angle));
        let [x, y, px, py, qx, qy, r] = [centre[0], centre[1], p[0], p[1], q[0], q[1], radius].map(number);
        let _ = write!(data, "M{x} {y}L{px} {py}A{r} {r} 0 0 1 {qx} {qy}Z");
    }
    data
}

fn outline(centre: Point, scale: f64, series: &Series) -> String {
    let radii = around(&series.values, scale);
    let width = 360.0 / radii.len().max(1) as f64;
    let mut data = String::new();
    for (k, &radius) in radii.iter().enumerate() {
        let (a, b) = (width * k as f64, width * (k + 1) as f64);
        let [p, q] = [a, b].map(|angle| direction(centre, radius, angle));
        let [px, py, qx, qy, r] = [p[0], p[1], q[0], q[1], radius].map(number);
        let _ = write!(data, "{}{px} {py}A{r} {r} 0 0 1 {qx} {qy}", if k == 0 { 'M' } else { 'L' });
    }
    if !data.is_empty() {
        data.push('Z');
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadrant_is_mirrored_into_the_others() {
        assert_eq!(
            around(&[1.0, 2.0, f64::NAN], 2.0),
            [2.0, 4.0, 0.0, 0.0, 4.0, 2.0, 2.0, 4.0, 0.0, 0.0, 4.0, 2.0]
        );
        assert_eq!(wedges([0.0, 0.0], 1.0, &[1.0, 0.0]).matches('A').count(), 4);
        assert_eq!(wedges([0.0, 0.0], 1.0, &[]), "");
    }
}
