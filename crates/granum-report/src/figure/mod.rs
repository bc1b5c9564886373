//! Figures as SVG for print and screen, without font files, scripts or other external files.
//!
//! A [`Figure`] is a grid of [`Panel`]s: plots, roses and pictures of force chains. Text uses fonts that exist on every
//! system, and is measured by the widths of Helvetica. The same data always give identical bytes.

pub mod axis;
pub mod chains;
pub mod clip;
pub mod layer;
pub mod legend;
pub mod marks;
pub mod palette;
mod places;
pub mod plot;
pub mod rich;
pub mod rose;
pub mod solid;
pub mod svg;
pub mod ticks;

#[cfg(test)]
mod tests;

pub use axis::Axis;
pub use chains::ForceChains;
pub use layer::Layer;
pub use marks::{SHAPES, Shape};
pub use plot::{Note, Plot};
pub use rich::{Rich, literal};
pub use rose::Rose;
pub use solid::{Side, Solid};
pub use svg::{Anchor, Stroke};

use clip::Rect;
use palette::{INK, LABEL_SIZE, TAG_SIZE};
use plot::Insets;
use rich::TextStyle;
use svg::{Svg, escape, number};

/// Width of a figure across the page, px.
pub const FULL_WIDTH: f64 = 720.0;
/// Width of a figure in half of the page, px.
pub const HALF_WIDTH: f64 = 400.0;

/// Factor by which a figure of a single plot is drawn larger than its layout.
const SINGLE: f64 = 1.25;

/// Space between panels, px.
const GUTTER: f64 = 14.0;

/// Height of a line of the heading, px.
const HEADING_ROW: f64 = 15.0;

/// A figure: a grid of panels with a common legend or a legend in each panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Description of the contents for readers who cannot see the figure.
    pub description: String,
    /// Width, px.
    pub width: f64,
    /// Height of a row of panels, px.
    pub row_height: f64,
    /// Number of panels in a row.
    pub columns: usize,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
    /// Position of the legend.
    pub legend: Legend,
    /// Marked-up text above everything, broken where lines are full; empty for none.
    pub heading: Vec<String>,
}

/// Position of the legend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Legend {
    /// In each panel with new entries, at a position where it hides nothing; if there is none, above all panels.
    #[default]
    Inside,
    /// Above all panels.
    Above,
    /// There is no legend.
    Hidden,
}

/// A panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Marked-up title above the panel; empty for no title.
    pub title: String,
    /// Content of the panel.
    pub content: Content,
}

/// Entries of a legend, and its position.
type InsideLegend = (Vec<legend::Entry>, Option<[f64; 2]>);

/// The content of a panel.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A plot.
    Plot(Box<Plot>),
    /// A rose.
    Rose(Rose),
    /// A picture of force chains.
    Chains(ForceChains),
    /// A picture of a body.
    Solid(Solid),
}

impl Panel {
    /// A plot.
    pub fn plot(plot: Plot) -> Self {
        Panel { title: String::new(), content: Content::Plot(Box::new(plot)) }
    }

    /// A rose.
    pub fn rose(rose: Rose) -> Self {
        Panel { title: String::new(), content: Content::Rose(rose) }
    }

    /// A picture of force chains.
    pub fn chains(chains: ForceChains) -> Self {
        Panel { title: String::new(), content: Content::Chains(chains) }
    }

    /// A picture of a body.
    pub fn solid(solid: Solid) -> Self {
        Panel { title: String::new(), content: Content::Solid(solid) }
    }

    /// Sets the title.
    pub fn titled(mut self, title: &str) -> Self {
        self.title = title.to_owned();
        self
    }

    fn insets(&self, height: f64) -> Insets {
        match &self.content {
            Content::Plot(plot) => plot.insets(height),
            Content::Rose(_) | Content::Chains(_) | Content::Solid(_) => {
                Insets { left: 4.0, right: 4.0, top: 4.0, bottom: 4.0 }
            }
        }
    }

    fn layers(&self) -> Vec<Layer> {
        match &self.content {
            Content::Plot(plot) => plot.layers.clone(),
            Content::Rose(rose) => rose.legend_layers(),
            Content::Chains(_) | Content::Solid(_) => Vec::new(),
        }
    }
}

impl Figure {
    /// A figure across the page with `columns` panels in a row.
    pub fn new(description: &str, columns: usize, panels: Vec<Panel>) -> Self {
        Figure {
            description: description.to_owned(),
            width: if panels.len() == 1 { 480.0 } else { FULL_WIDTH },
            row_height: 270.0,
            columns: columns.max(1),
            panels,
            legend: Legend::Inside,
            heading: Vec::new(),
        }
    }

    /// Sets the text above everything: what the figure shows, for whoever sees it without its caption. It is broken between the parts, of
    /// which as many stand on a line as have room.
    pub fn headed(mut self, parts: &[String]) -> Self {
        self.heading = parts.to_vec();
        self
    }

    /// Sets the width and the height of a row, px.
    pub fn sized(mut self, width: f64, row_height: f64) -> Self {
        (self.width, self.row_height) = (width, row_height);
        self
    }

    /// Sets the position of the legend.
    pub fn legend(mut self, legend: Legend) -> Self {
        self.legend = legend;
        self
    }

    /// The SVG as a separate file with a white background.
    pub fn to_svg(&self) -> String {
        format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}", self.render(true))
    }

    /// The SVG as a part of an HTML page.
    pub fn to_inline_svg(&self) -> String {
        self.render(false)
    }

    fn render(&self, own_file: bool) -> String {
        let mut figure = self.clone();
        figure.share_units();
        figure.width /= self.enlargement();
        figure.row_height /= self.enlargement();
        match figure.legend {
            Legend::Inside => {
                let mut roomy = figure.clone();
                match roomy.inside_legends() {
                    Some(places) => roomy.draw(&[], &places, own_file),
                    None => figure.draw(&figure.entries(), &[], own_file),
                }
            }
            Legend::Above => figure.draw(&figure.entries(), &[], own_file),
            Legend::Hidden => figure.draw(&[], &[], own_file),
        }
    }

    /// Gives all axes of one unit the same prefix, that of the linear axis with the largest values.
    fn share_units(&mut self) {
        let mut exponents: std::collections::BTreeMap<String, (bool, i32)> =
            std::collections::BTreeMap::new();
        for panel in &self.panels {
            let Content::Plot(plot) = &panel.content else { continue };
            for (unit, exponent) in plot.units() {
                let shared = exponents.entry(unit).or_insert(exponent);
                *shared = exponent.max(*shared);
            }
        }
        for panel in &mut self.panels {
            let Content::Plot(plot) = &mut panel.content else { continue };
            for (unit, (_, exponent)) in &exponents {
                plot.share_exponent(unit, *exponent);
            }
        }
    }

    /// Factor by which a figure is drawn larger than its layout: the type of a single plot is larger than that of a row of plots.
    fn enlargement(&self) -> f64 {
        match self.panels.as_slice() {
            [Panel { content: Content::Plot(_), .. }] => SINGLE,
            _ => 1.0,
        }
    }

    fn entries(&self) -> Vec<legend::Entry> {
        legend::entries(self.panels.iter().flat_map(Panel::layers).collect::<Vec<_>>().iter())
    }

    fn draw(&self, above: &[legend::Entry], inside: &[InsideLegend], own_file: bool) -> String {
        let rows = legend::lines(above, self.width - 20.0).len();
        let heading = heading_lines(&self.heading, self.width - 20.0);
        let head = if heading.is_empty() { 0.0 } else { HEADING_ROW * heading.len() as f64 + 6.0 };
        let top = head + if rows > 0 { legend::ROW * rows as f64 + 8.0 } else { 0.0 };
        let mut svg = Svg::new();
        for (k, line) in heading.iter().enumerate() {
            let at = [10.0, HEADING_ROW * (k as f64 + 1.0)];
            rich::text(&mut svg, at, line, plot::plain(INK, Anchor::Start, LABEL_SIZE));
        }
        legend::draw_rows(&mut svg, 10.0, head + 4.0, self.width - 20.0, above);
        svg.begin_group(&format!("transform=\"translate(0 {})\"", number(top)));
        for (k, (panel, frame)) in self.panels.iter().zip(self.frames()).enumerate() {
            self.draw_panel(&mut svg, k, panel, &frame);
            if let Some((entries, Some(place))) = inside.get(k) {
                legend::draw_column(&mut svg, *place, entries);
            }
        }
        svg.end_group();
        self.envelope(svg, top + self.height(), own_file)
    }

    fn envelope(&self, svg: Svg, height: f64, own_file: bool) -> String {
        let (w, h) = (number(self.width), number(height));
        let [shown_width, shown_height] = [self.width, height].map(|size| number(size * self.enlargement()));
        let space = if own_file { " xmlns=\"http://www.w3.org/2000/svg\"" } else { "" };
        let label = escape(&Rich::new(&self.description).plain());
        let white = format!("<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n");
        format!(
            "<svg{space} width=\"{shown_width}\" height=\"{shown_height}\" viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"{label}\" \
             font-family=\"{}\">\n<title>{label}</title>\n{}{}</svg>\n",
            escape(rich::FONT),
            if own_file { &white } else { "" },
            svg.into_body()
        )
    }

    fn rows(&self) -> usize {
        self.panels.len().div_ceil(self.columns)
    }

    fn height(&self) -> f64 {
        self.rows() as f64 * (self.row_height + GUTTER) - GUTTER
    }

    /// The frames of the panels. Panels in a column share their left edge, those in a row their lower edge, and all have the
    /// same width.
    fn frames(&self) -> Vec<Rect> {
        let insets: Vec<Insets> = self.panels.iter().map(|panel| panel.insets(self.row_height)).collect();
        let largest = |start: usize, step: usize, count: usize, part: fn(&Insets) -> f64| {
            insets.iter().skip(start).step_by(step).take(count).map(part).fold(0.0, f64::max)
        };
        let sides: Vec<[f64; 2]> = (0..self.columns)
            .map(|c| {
                [|i: &Insets| i.left, |i: &Insets| i.right]
                    .map(|part| largest(c, self.columns, usize::MAX, part))
            })
            .collect();
        let taken: f64 = sides.iter().flatten().sum::<f64>() + GUTTER * (self.columns - 1) as f64;
        let width = ((self.width - taken) / self.columns as f64).max(10.0);
        (0..self.panels.len())
            .map(|k| {
                let (row, column) = (k / self.columns, k % self.columns);
                let in_row = |part| largest(row * self.columns, 1, self.columns, part);
                let mut of_row = self.panels.iter().skip(row * self.columns).take(self.columns);
                let titled = self.panels.len() > 1 || of_row.any(|panel| !panel.title.is_empty());
                let title = if titled { 20.0 } else { 0.0 };
                let before: f64 = sides[..column].iter().flatten().sum();
                let left = before + column as f64 * (width + GUTTER) + sides[column][0];
                let y = row as f64 * (self.row_height + GUTTER);
                let bottom = y + self.row_height - in_row(|i| i.bottom);
                Rect::new(left, y + title + in_row(|i| i.top), left + width, bottom)
            })
            .collect()
    }

    fn tag(&self, k: usize) -> Option<String> {
        let letter = char::from_u32('a' as u32 + k as u32).filter(char::is_ascii_lowercase)?;
        (self.panels.len() > 1).then(|| format!("({letter})"))
    }

    /// The legend of each panel with its position; axes are extended if that makes room. `None` if there is no room for
    /// one of the legends.
    fn inside_legends(&mut self) -> Option<Vec<InsideLegend>> {
        let mut seen: Vec<legend::Entry> = Vec::new();
        let mut places = Vec::new();
        for k in 0..self.panels.len() {
            let mut entries = legend::entries(self.panels[k].layers().iter());
            entries.retain(|entry| !seen.contains(entry));
            seen.extend(entries.iter().cloned());
            let place = if entries.is_empty() { None } else { Some(self.place_inside(k, &entries)?) };
            places.push((entries, place));
        }
        Some(places)
    }

    /// A position in panel k where the entries hide nothing, with as little additional headroom as possible.
    fn place_inside(&mut self, k: usize, entries: &[legend::Entry]) -> Option<[f64; 2]> {
        for headroom in [0.0, 0.15, 0.3, 0.45, 0.6] {
            let Content::Plot(plot) = &mut self.panels[k].content else { return None };
            plot.headroom = headroom;
            let frame = self.frames()[k];
            if let Content::Plot(plot) = &self.panels[k].content
                && let Some(place) = plot.legend_place(&frame, entries)
            {
                return Some(place);
            }
        }
        None
    }

    fn draw_panel(&self, svg: &mut Svg, k: usize, panel: &Panel, frame: &Rect) {
        match &panel.content {
            Content::Plot(plot) => plot.draw(svg, frame),
            Content::Rose(rose) => rose.draw(svg, frame),
            Content::Chains(chains) => chains.draw(svg, frame),
            Content::Solid(solid) => solid.draw(svg, frame),
        }
        // The entries are drawn above the frame, where they hide nothing.
        let base = frame.top - 9.0;
        let mut x = frame.left;
        if let Some(tag) = self.tag(k) {
            let style = TextStyle { bold: true, ..plot::plain(INK, Anchor::Start, TAG_SIZE) };
            rich::text(svg, [x, base], &tag, style);
            x += Rich::new(&tag).width(TAG_SIZE) + 7.0;
        }
        rich::text(svg, [x, base], &panel.title, plot::plain(INK, Anchor::Start, LABEL_SIZE));
    }
}

/// The lines of a heading: as many of its parts on each as have room.
fn heading_lines(parts: &[String], width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for part in parts {
        match lines.last_mut() {
            Some(line) if Rich::new(&format!("{line}; {part}")).width(LABEL_SIZE) <= width => {
                *line += &format!("; {part}");
            }
            _ => lines.push(part.clone()),
        }
    }
    lines
}
