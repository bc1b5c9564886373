//! Legends: inside a frame if they hide nothing there, otherwise above it.

use super::clip::Rect;
use super::layer::{self, Layer, LayerKind};
use super::palette::{INK, TICK_SIZE};
use super::rich::{Rich, TextStyle, text};
use super::svg::{Anchor, Point, Stroke, Svg};

/// Width of the sample next to a name, px.
const SAMPLE: f64 = 22.0;
/// Space between sample and name, px.
const GAP: f64 = 6.0;
/// Height of a line, px.
pub const ROW: f64 = 15.5;
/// Space inside the box, px.
const PAD: f64 = 5.0;

/// An entry: a name and its layers (a line and its band share an entry).
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    label: String,
    samples: Vec<LayerKind>,
}

/// The entries of layers; layers with the same name share an entry.
pub fn entries<'a>(layers: impl Iterator<Item = &'a Layer>) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for layer in layers {
        let Some(label) = &layer.label else { continue };
        let sample = bare(&layer.kind);
        match entries.iter_mut().find(|entry| &entry.label == label) {
            Some(entry) if entry.samples.contains(&sample) => {}
            Some(entry) => entry.samples.push(sample),
            None => entries.push(Entry { label: label.clone(), samples: vec![sample] }),
        }
    }
    entries
}

/// A kind of layer without its data.
fn bare(kind: &LayerKind) -> LayerKind {
    let mut kind = kind.clone();
    match &mut kind {
        LayerKind::Line { points, .. } | LayerKind::Points { points, .. } => points.clear(),
        LayerKind::Band { points, .. } => points.clear(),
        LayerKind::Horizontal { stroke, .. } | LayerKind::Vertical { stroke, .. } => {
            return LayerKind::Line { points: Vec::new(), stroke: stroke.clone() };
        }
    }
    kind
}

/// Widths are those of Helvetica; the letters of what takes its place where it is not installed, such as DejaVu Sans, are wider.
const WIDEST_FONT: f64 = 1.13;

fn entry_width(entry: &Entry) -> f64 {
    SAMPLE + GAP + WIDEST_FONT * Rich::new(&entry.label).width(TICK_SIZE)
}

/// Size of a legend with one entry per line.
pub fn size(entries: &[Entry]) -> [f64; 2] {
    let width = entries.iter().map(entry_width).fold(0.0, f64::max);
    [width + 2.0 * PAD, ROW * entries.len() as f64 + 2.0 * PAD - 2.0]
}

/// A position in the frame, preferably in a corner, where a box of the given size hides none of the marks.
pub fn free_place(size: [f64; 2], frame: &Rect, marks: &[Point]) -> Option<Point> {
    let edge = 8.0;
    let (x0, x1) = (frame.left + edge, frame.right - edge - size[0]);
    let (y0, y1) = (frame.top + edge, frame.bottom - edge - size[1]);
    if x1 < x0 || y1 < y0 {
        return None;
    }
    let mut places = vec![[x1, y0], [x0, y0], [x1, y1], [x0, y1]];
    for row in 0..=8 {
        for column in 0..=8 {
            let at = |from: f64, to: f64, k: i32| from + (to - from) * k as f64 / 8.0;
            places.push([at(x0, x1, column), at(y0, y1, row)]);
        }
    }
    places.into_iter().find(|[x, y]| {
        let taken = Rect::new(*x, *y, x + size[0], y + size[1]);
        !marks.iter().any(|mark| taken.contains(*mark, 4.0))
    })
}

/// Points on lines, so dense that no box of the size of a legend fits between them.
pub fn covered(lines: &[Vec<Point>]) -> Vec<Point> {
    let mut marks = Vec::new();
    for line in lines {
        marks.extend(line.iter().copied());
        for pair in line.windows(2) {
            let length = libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let steps = (length / 5.0).clamp(1.0, 400.0) as usize;
            for k in 1..steps {
                let t = k as f64 / steps as f64;
                marks.push(std::array::from_fn(|c| pair[0][c] + t * (pair[1][c] - pair[0][c])));
            }
        }
    }
    marks
}

/// Draws entries in a column.
pub fn draw_column(svg: &mut Svg, corner: Point, entries: &[Entry]) {
    // The box may only cover vertical reference lines.
    svg.rectangle(corner, size(entries), Some(("#ffffff", 1.0)), None);
    for (k, entry) in entries.iter().enumerate() {
        draw_entry(svg, [corner[0] + PAD, corner[1] + PAD + ROW * k as f64], entry);
    }
}

/// The lines into which entries are broken at the given width, as ranges.
pub fn lines(entries: &[Entry], width: f64) -> Vec<std::ops::Range<usize>> {
    let mut lines = Vec::new();
    let (mut start, mut x) = (0, 0.0);
    for (k, entry) in entries.iter().enumerate() {
        let needed = entry_width(entry);
        if k > start && x + needed > width {
            lines.push(start..k);
            (start, x) = (k, 0.0);
        }
        x += needed + 20.0;
    }
    if start < entries.len() {
        lines.push(start..entries.len());
    }
    lines
}

/// Draws entries side by side, centred, in as many lines as needed.
pub fn draw_rows(svg: &mut Svg, left: f64, top: f64, width: f64, entries: &[Entry]) {
    for (row, range) in lines(entries, width).into_iter().enumerate() {
        let total: f64 =
            entries[range.clone()].iter().map(|entry| entry_width(entry) + 20.0).sum::<f64>() - 20.0;
        let mut x = left + 0.5 * (width - total).max(0.0);
        for entry in &entries[range] {
            draw_entry(svg, [x, top + ROW * row as f64], entry);
            x += entry_width(entry) + 20.0;
        }
    }
}

fn draw_entry(svg: &mut Svg, corner: Point, entry: &Entry) {
    let middle = corner[1] + 0.5 * ROW - 1.0;
    for sample in &entry.samples {
        match sample {
            LayerKind::Band { color, opacity, .. } => {
                svg.rectangle([corner[0], middle - 4.5], [SAMPLE, 9.0], Some((color, *opacity)), None);
            }
            LayerKind::Points { shape, radius, color, filled, .. } => {
                let data = shape.path([corner[0] + 0.5 * SAMPLE, middle], radius.min(4.0));
                layer::mark(svg, &data, *shape, color, *filled);
            }
            LayerKind::Line { stroke, .. }
            | LayerKind::Horizontal { stroke, .. }
            | LayerKind::Vertical { stroke, .. } => {
                let stroke = Stroke { width: stroke.width.min(3.0), ..stroke.clone() };
                svg.line([corner[0], middle], [corner[0] + SAMPLE, middle], &stroke);
            }
        }
    }
    let style =
        TextStyle { size: TICK_SIZE, color: INK, anchor: Anchor::Start, bold: false, vertical: false };
    text(svg, [corner[0] + SAMPLE + GAP, middle + 0.36 * TICK_SIZE], &entry.label, style);
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Rect = Rect { left: 0.0, top: 0.0, right: 300.0, bottom: 200.0 };

    #[test]
    fn a_legend_keeps_off_the_data() {
        let rising = covered(&[vec![[0.0, 200.0], [300.0, 0.0]]]);
        let place = free_place([80.0, 50.0], &FRAME, &rising).unwrap();
        let taken = Rect::new(place[0], place[1], place[0] + 80.0, place[1] + 50.0);
        assert!(rising.iter().all(|mark| !taken.contains(*mark, 3.0)));
        let everywhere: Vec<Vec<Point>> =
            (0..20).map(|k| vec![[0.0, 10.0 * k as f64], [300.0, 10.0 * k as f64]]).collect();
        assert_eq!(free_place([80.0, 50.0], &FRAME, &covered(&everywhere)), None);
        assert_eq!(free_place([400.0, 50.0], &FRAME, &[]), None);
    }

    #[test]
    fn layers_of_one_name_share_an_entry_and_rows_break() {
        let layers = [
            Layer::band(vec![], "#000").named("DEM"),
            Layer::line(vec![], "#000").named("DEM"),
            Layer::line(vec![], "#111"),
            Layer::line(vec![], "#222").named("network"),
        ];
        let entries = entries(layers.iter());
        assert_eq!(entries.len(), 2);
        assert_eq!(entries[0].samples.len(), 2);
        assert_eq!(lines(&entries, 1000.0), vec![0..2]);
        assert_eq!(lines(&entries, 60.0), vec![0..1, 1..2]);
        assert!(lines(&[], 60.0).is_empty());
    }
}
