//! A plot: a frame with two axes and layers in it.

use super::axis::{Axis, Scale};
use super::clip::Rect;
use super::layer::{Layer, LayerKind};
use super::legend;
use super::palette::{GREY, INK, LABEL_SIZE, TICK_SIZE};
use super::rich::{Rich, TextStyle, text};
use super::svg::{Anchor, Point, Stroke, Svg};
use super::ticks::Tick;

/// A plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// The layers from back to front.
    pub layers: Vec<Layer>,
    /// Text in the frame.
    pub notes: Vec<Note>,
    /// Share of the vertical axis that is added above the data as room for a legend.
    pub headroom: f64,
}

/// Text in the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Marked-up text.
    pub text: String,
    /// Position in data coordinates.
    pub at: Point,
    /// The part of the text at this position.
    pub anchor: Anchor,
    /// Colour.
    pub color: String,
    /// Offset on the page, px.
    pub shift: Point,
}

impl Note {
    /// A note that begins at a point.
    pub fn new(text: &str, at: Point) -> Self {
        Note { text: text.to_owned(), at, anchor: Anchor::Start, color: GREY.to_owned(), shift: [0.0, 0.0] }
    }

    /// Sets the colour.
    pub fn color(mut self, color: &str) -> Self {
        self.color = color.to_owned();
        self
    }

    /// Sets the anchor.
    pub fn anchored(mut self, anchor: Anchor) -> Self {
        self.anchor = anchor;
        self
    }

    /// Sets the offset on the page.
    pub fn shifted(mut self, shift: Point) -> Self {
        self.shift = shift;
        self
    }
}

/// Space that a plot needs around its frame, px: left, top, right, bottom.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Insets {
    /// Left.
    pub left: f64,
    /// Right.
    pub right: f64,
    /// Top.
    pub top: f64,
    /// Bottom.
    pub bottom: f64,
}

impl Plot {
    /// A plot with two axes.
    pub fn new(x: Axis, y: Axis) -> Self {
        Plot { x, y, ..Plot::default() }
    }

    /// Adds a layer on top.
    pub fn with(mut self, layer: Layer) -> Self {
        self.layers.push(layer);
        self
    }

    /// Adds several layers on top.
    pub fn with_all(mut self, layers: impl IntoIterator<Item = Layer>) -> Self {
        self.layers.extend(layers);
        self
    }

    /// Adds a note.
    pub fn note(mut self, note: Note) -> Self {
        self.notes.push(note);
        self
    }

    fn scales(&self) -> [Scale; 2] {
        let mut extent: [Option<[f64; 2]>; 2] = [None, None];
        for layer in &self.layers {
            layer.visit([self.x.log, self.y.log], |values| {
                for (extent, value) in extent.iter_mut().zip(values) {
                    if let Some(value) = value {
                        *extent = Some(extent.map_or([value, value], |[a, b]| [a.min(value), b.max(value)]));
                    }
                }
            });
        }
        let mut y = self.y.resolve(extent[1]);
        if y.log {
            y.high *= libm::pow(y.high / y.low, self.headroom);
        } else {
            y.high += self.headroom * (y.high - y.low);
        }
        [self.x.resolve(extent[0]), y]
    }

    /// Units of its axes with the exponents of the powers of ten that they choose themselves, and whether they are linear: these have
    /// precedence.
    pub(super) fn units(&self) -> Vec<(String, (bool, i32))> {
        let axes = [&self.x, &self.y].into_iter().zip(self.scales());
        let with_unit = axes.filter(|(axis, _)| !axis.unit.is_empty());
        with_unit.map(|(axis, scale)| (axis.unit.clone(), (!axis.log, axis.exponent(&scale)))).collect()
    }

    /// Gives its axes of a unit an exponent.
    pub(super) fn share_exponent(&mut self, unit: &str, exponent: i32) {
        for axis in [&mut self.x, &mut self.y].into_iter().filter(|axis| axis.unit == unit) {
            axis.shared_exponent = Some(exponent);
        }
    }

    /// True if no layer has a point to show.
    pub fn is_empty(&self) -> bool {
        let mut empty = true;
        for layer in &self.layers {
            if !matches!(layer.kind, LayerKind::Horizontal { .. } | LayerKind::Vertical { .. }) {
                layer.visit([self.x.log, self.y.log], |_| empty = false);
            }
        }
        empty
    }

    /// Space needed around the frame for ticks and labels, for a frame with a height of about `height`.
    pub fn insets(&self, height: f64) -> Insets {
        let [x, y] = self.scales();
        let widest_of = |ticks: &[Tick]| {
            let labels = ticks.iter().filter_map(|tick| tick.label.as_ref());
            labels.map(|label| Rich::new(label).width(TICK_SIZE)).fold(0.0, f64::max)
        };
        let widest = widest_of(&self.y.ticks(&y, self.vertical_target(height)));
        // Half of the label of the last tick extends beyond the frame.
        let right = if self.x.categories.is_empty() {
            0.5 * widest_of(&self.x.ticks(&x, tick_target(height, 58.0))) + 2.0
        } else {
            0.0
        };
        let title = if self.y.label.is_empty() { 0.0 } else { LABEL_SIZE + TITLE_GAP };
        let below = if self.x.label.is_empty() { 0.0 } else { LABEL_SIZE + 7.0 };
        Insets {
            left: widest + 7.0 + title,
            right: right.max(10.0),
            top: 6.0,
            bottom: TICK_SIZE + 8.0 + below,
        }
    }

    fn vertical_target(&self, height: f64) -> f64 {
        if self.y.log { (height / 24.0).clamp(2.0, 12.0) } else { tick_target(height, 44.0) }
    }

    /// The scales for positions in the frame `frame`.
    pub(super) fn laid(&self, frame: &Rect) -> [Scale; 2] {
        let [x, y] = self.scales();
        [x.laid(frame.left, frame.right), y.laid(frame.bottom, frame.top)]
    }

    /// A position in the frame where the legend hides nothing but vertical reference lines, if there is one.
    pub fn legend_place(&self, frame: &Rect, entries: &[legend::Entry]) -> Option<Point> {
        let [x, y] = self.laid(frame);
        let mut lines: Vec<Vec<Point>> = self.layers.iter().flat_map(|layer| layer.runs(&x, &y)).collect();
        for layer in &self.layers {
            match &layer.kind {
                LayerKind::Horizontal { at, .. } => {
                    lines.extend(y.at(*at).map(|at| vec![[frame.left, at], [frame.right, at]]));
                }
                LayerKind::Band { points, .. } => {
                    // The interior of a band counts as well.
                    lines.extend(points.iter().filter_map(|p| {
                        let x = x.at(p[0])?;
                        Some(vec![[x, y.at(p[1].max(y.low))?], [x, y.at(p[2])?]])
                    }));
                }
                _ => {}
            }
        }
        let mut marks = legend::covered(&lines);
        for note in &self.notes {
            if let (Some(x), Some(y)) = (x.at(note.at[0]), y.at(note.at[1])) {
                let width = Rich::new(&note.text).width(TICK_SIZE);
                let start = match note.anchor {
                    Anchor::Start => x,
                    Anchor::Middle => x - 0.5 * width,
                    Anchor::End => x - width,
                } + note.shift[0];
                let steps = (width / 5.0).ceil() as usize;
                marks.extend((0..=steps).map(|k| [start + 5.0 * k as f64, y + note.shift[1] - 4.0]));
            }
        }
        legend::free_place(legend::size(entries), frame, &marks)
    }

    /// Draws the plot in a frame.
    pub fn draw(&self, svg: &mut Svg, frame: &Rect) {
        let [x, y] = self.laid(frame);
        for layer in &self.layers {
            layer.draw(svg, frame, &x, &y);
        }
        self.draw_x_axis(svg, frame, &x);
        self.draw_y_axis(svg, frame, &y);
        svg.rectangle(
            [frame.left, frame.top],
            [frame.width(), frame.height()],
            None,
            Some(&Stroke::new(INK, 1.0)),
        );
        for note in &self.notes {
            if let (Some(x), Some(y)) = (x.at(note.at[0]), y.at(note.at[1])) {
                let style = TextStyle {
                    size: TICK_SIZE,
                    color: &note.color,
                    anchor: note.anchor,
                    bold: false,
                    vertical: false,
                };
                text(svg, [x + note.shift[0], y + note.shift[1]], &note.text, style);
            }
        }
        if self.is_empty() {
            let centre = [0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom)];
            text(svg, centre, "nothing to show", plain(GREY, Anchor::Middle, TICK_SIZE));
        }
    }

    fn draw_x_axis(&self, svg: &mut Svg, frame: &Rect, scale: &Scale) {
        let ticks = self.x.ticks(scale, tick_target(frame.width(), 58.0));
        let named = !self.x.categories.is_empty();
        let mut lines = [String::new(), String::new()];
        let mut free_from = f64::NEG_INFINITY;
        for tick in &ticks {
            let Some(at) = inside(scale, tick, frame.left, frame.right) else { continue };
            if !named {
                let length = tick_length(tick);
                push_vertical(&mut lines, tick, at, frame.bottom, -length);
                push_vertical(&mut lines, tick, at, frame.top, length);
            }
            if let Some(label) = &tick.label {
                let half = 0.5 * Rich::new(label).width(TICK_SIZE);
                if at - half < free_from {
                    continue;
                }
                free_from = at + half + 4.0;
                text(svg, [at, frame.bottom + TICK_SIZE + 5.0], label, plain(INK, Anchor::Middle, TICK_SIZE));
            }
        }
        draw_ticks(svg, &lines);
        let middle = 0.5 * (frame.left + frame.right);
        let base = frame.bottom + TICK_SIZE + 8.0 + LABEL_SIZE;
        text(svg, [middle, base + 2.0], &self.x.title(scale), plain(INK, Anchor::Middle, LABEL_SIZE));
    }

    fn draw_y_axis(&self, svg: &mut Svg, frame: &Rect, scale: &Scale) {
        let ticks = self.y.ticks(scale, self.vertical_target(frame.height()));
        let named = !self.y.categories.is_empty();
        let mut lines = [String::new(), String::new()];
        let mut widest = 0.0f64;
        for tick in &ticks {
            let Some(at) = inside(scale, tick, frame.top, frame.bottom) else { continue };
            if !named {
                let length = tick_length(tick);
                push_horizontal(&mut lines, tick, frame.left, at, length);
                push_horizontal(&mut lines, tick, frame.right, at, -length);
            }
            if let Some(label) = &tick.label {
                widest = widest.max(Rich::new(label).width(TICK_SIZE));
                let place = [frame.left - 6.0, at + 0.36 * TICK_SIZE];
                text(svg, place, label, plain(INK, Anchor::End, TICK_SIZE));
            }
        }
        draw_ticks(svg, &lines);
        let middle = 0.5 * (frame.top + frame.bottom);
        let base = frame.left - widest - TITLE_GAP - 5.0;
        let style = TextStyle { vertical: true, ..plain(INK, Anchor::Middle, LABEL_SIZE) };
        text(svg, [base, middle], &self.y.title(scale), style);
    }
}

/// Distance between the tick labels and the title of a vertical axis, px; a subscript of the title extends into it.
const TITLE_GAP: f64 = 12.0;

/// The style of horizontal text.
pub fn plain(color: &str, anchor: Anchor, size: f64) -> TextStyle<'_> {
    TextStyle { size, color, anchor, bold: false, vertical: false }
}

/// Suitable number of labelled ticks for an axis of a given length, with `spacing` px for each.
fn tick_target(length: f64, spacing: f64) -> f64 {
    (length / spacing).clamp(2.0, 7.0)
}

fn inside(scale: &Scale, tick: &Tick, low: f64, high: f64) -> Option<f64> {
    scale.at(tick.value).filter(|at| (low - 0.5..=high + 0.5).contains(at))
}

fn tick_length(tick: &Tick) -> f64 {
    if tick.label.is_some() { 5.0 } else { 2.6 }
}

fn push_vertical(lines: &mut [String; 2], tick: &Tick, x: f64, y: f64, length: f64) {
    let line = &mut lines[tick.label.is_none() as usize];
    line.push_str(&super::svg::path_data(&[[x, y], [x, y + length]]));
}

fn push_horizontal(lines: &mut [String; 2], tick: &Tick, x: f64, y: f64, length: f64) {
    let line = &mut lines[tick.label.is_none() as usize];
    line.push_str(&super::svg::path_data(&[[x, y], [x + length, y]]));
}

fn draw_ticks(svg: &mut Svg, lines: &[String; 2]) {
    for (data, width) in lines.iter().zip([1.0, 0.7]) {
        if !data.is_empty() {
            svg.path_of(data, None, Some(&Stroke::new(INK, width)));
        }
    }
}
