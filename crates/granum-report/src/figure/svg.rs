//! The lowest layer: elements of an SVG file, with numbers that are always finite and text that is always escaped.

use std::fmt::Write;

/// A point on the page, in px from the top left.
pub type Point = [f64; 2];

/// Limit of the coordinates that are written; larger values are far outside every page.
const LARGEST: f64 = 1e5;

/// An SVG file that is being written.
#[derive(Clone, Debug, Default)]
pub struct Svg {
    body: String,
}

/// The style of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Colour, as in CSS.
    pub color: String,
    /// Width, px.
    pub width: f64,
    /// Lengths of dashes and gaps, px; empty for a solid line.
    pub dash: Vec<f64>,
}

impl Stroke {
    /// A solid line.
    pub fn new(color: &str, width: f64) -> Self {
        Stroke { color: color.to_owned(), width, dash: Vec::new() }
    }

    /// The same line, dashed.
    pub fn dashed(mut self, dash: &[f64]) -> Self {
        self.dash = dash.to_vec();
        self
    }

    fn attributes(&self) -> String {
        let mut text = format!("stroke=\"{}\" stroke-width=\"{}\"", escape(&self.color), number(self.width));
        if !self.dash.is_empty() {
            let dash: Vec<String> = self.dash.iter().map(|&length| number(length)).collect();
            let _ = write!(text, " stroke-dasharray=\"{}\"", dash.join(" "));
        }
        text
    }
}

/// Horizontal position of a text relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins at the point.
    Start,
    /// The text is centred at the point.
    Middle,
    /// The text ends at the point.
    End,
}

impl Anchor {
    /// The value of the attribute `text-anchor`.
    pub fn name(self) -> &'static str {
        match self {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        }
    }
}

impl Svg {
    /// An empty SVG file.
    pub fn new() -> Self {
        Svg::default()
    }

    /// Draws a straight line.
    pub fn line(&mut self, a: Point, b: Point, stroke: &Stroke) {
        self.path(&[a, b], false, None, Some(stroke));
    }

    /// Draws a line through points, optionally closed and filled.
    pub fn path(
        &mut self,
        points: &[Point],
        closed: bool,
        fill: Option<(&str, f64)>,
        stroke: Option<&Stroke>,
    ) {
        if points.len() < 2 {
            return;
        }
        let mut data = path_data(points);
        if closed {
            data.push('Z');
        }
        self.path_of(&data, fill, stroke);
    }

    /// Draws a path from its data, e.g. `M0 0L1 1`.
    pub fn path_of(&mut self, data: &str, fill: Option<(&str, f64)>, stroke: Option<&Stroke>) {
        let _ = write!(self.body, "<path d=\"{}\" {}", data, fill_attributes(fill));
        if let Some(stroke) = stroke {
            let _ = write!(self.body, " {} stroke-linejoin=\"round\"", stroke.attributes());
        }
        self.body.push_str("/>\n");
    }

    /// Draws a rectangle.
    pub fn rectangle(
        &mut self,
        corner: Point,
        size: Point,
        fill: Option<(&str, f64)>,
        stroke: Option<&Stroke>,
    ) {
        let _ = write!(
            self.body,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" {}",
            number(corner[0]),
            number(corner[1]),
            number(size[0].max(0.0)),
            number(size[1].max(0.0)),
            fill_attributes(fill)
        );
        if let Some(stroke) = stroke {
            let _ = write!(self.body, " {}", stroke.attributes());
        }
        self.body.push_str("/>\n");
    }

    /// Draws a circle.
    pub fn circle(&mut self, centre: Point, radius: f64, fill: Option<(&str, f64)>, stroke: Option<&Stroke>) {
        let _ = write!(
            self.body,
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {}",
            number(centre[0]),
            number(centre[1]),
            number(radius.max(0.0)),
            fill_attributes(fill)
        );
        if let Some(stroke) = stroke {
            let _ = write!(self.body, " {}", stroke.attributes());
        }
        self.body.push_str("/>\n");
    }

    /// Opens a group with attributes, which are not escaped; it must be closed with [`Svg::end_group`].
    pub fn begin_group(&mut self, attributes: &str) {
        let _ = writeln!(self.body, "<g {attributes}>");
    }

    /// Closes a group.
    pub fn end_group(&mut self) {
        self.body.push_str("</g>\n");
    }

    /// Opens a window at which everything is cut off; coordinates remain those of the page.
    pub fn begin_window(&mut self, corner: Point, size: Point) {
        let [x, y, w, h] = [corner[0], corner[1], size[0].max(0.0), size[1].max(0.0)].map(number);
        let _ = writeln!(
            self.body,
            "<svg x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" viewBox=\"{x} {y} {w} {h}\" overflow=\"hidden\">"
        );
    }

    /// Closes a window.
    pub fn end_window(&mut self) {
        self.body.push_str("</svg>\n");
    }

    /// Appends markup that is already complete and escaped.
    pub fn raw(&mut self, markup: &str) {
        self.body.push_str(markup);
    }

    /// The elements that have been drawn.
    pub fn into_body(self) -> String {
        self.body
    }
}

fn fill_attributes(fill: Option<(&str, f64)>) -> String {
    match fill {
        None => "fill=\"none\"".to_owned(),
        Some((color, opacity)) if opacity >= 1.0 => format!("fill=\"{}\"", escape(color)),
        Some((color, opacity)) => format!("fill=\"{}\" fill-opacity=\"{}\"", escape(color), number(opacity)),
    }
}

/// Data of a path through points.
pub fn path_data(points: &[Point]) -> String {
    let mut data = String::with_capacity(12 * points.len());
    for (k, point) in points.iter().enumerate() {
        let _ = write!(data, "{}{} {}", if k == 0 { 'M' } else { 'L' }, number(point[0]), number(point[1]));
    }
    data
}

/// A coordinate with at most two decimals; never NaN, infinite or `-0`.
pub fn number(value: f64) -> String {
    let value = if value.is_finite() { value.clamp(-LARGEST, LARGEST) } else { 0.0 };
    let mut text = format!("{value:.2}");
    while text.ends_with('0') {
        text.pop();
    }
    if text.ends_with('.') {
        text.pop();
    }
    if text == "-0" { "0".to_owned() } else { text }
}

/// Escapes the five special characters of XML, and shows what a viewer would obey: control characters, marks of the direction of writing.
pub fn escape(text: &str) -> String {
    granum_io::safe_text::html(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_finite() {
        for (value, text) in [
            (1.0, "1"),
            (1.5, "1.5"),
            (-0.001, "0"),
            (0.126, "0.13"),
            (100.0, "100"),
            (f64::NAN, "0"),
            (f64::INFINITY, "0"),
            (1e300, "100000"),
            (-1e300, "-100000"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn text_is_escaped() {
        assert_eq!(escape("a<b & \"c\"\u{0}"), "a&lt;b &amp; &quot;c&quot;\u{fffd}");
    }
}
