//! A picture of the forces in an assembly: grains as faint circles, contacts as lines from centre to centre, whose width and
//! colour show the normal force.
//!
//! The picture is an orthographic projection of the periodic cell or of a slice of it. A contact across the boundary is
//! drawn at both of its images, each cut off where it leaves the cell, so that no line runs across the whole picture.

use granum_core::assembly::{Assembly, Contact, Matrix, Vector};
use granum_core::geometry::{apply, determinant, invert};

use super::clip::{self, Rect};
use super::palette::{GREY, INK, TICK_SIZE, sequential};
use super::plot::plain;
use super::rich::text;
use super::svg::{Anchor, Point, Stroke, Svg, path_data};
use std::collections::BTreeMap;

/// The view of an assembly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Axis of the cell that points up, 0 to 2.
    pub up: usize,
    /// Axis of the cell that points right.
    pub right: usize,
    /// Visible range of depth, as fractions of the cell along the remaining axis; `None` for the whole cell.
    pub slice: Option<[f64; 2]>,
    /// Smallest `f = N/<N>` that is drawn; contacts in tension are drawn only in slices.
    pub smallest_force: f64,
}

impl View {
    /// A slice through the middle with a thickness of about `thickness` grain diameters, axis 1 up and axis 2 right.
    pub fn slice(assembly: &Assembly, thickness: f64) -> Self {
        let radii: f64 = assembly.bodies.iter().map(|body| body.equivalent_radius).sum();
        let diameter = 2.0 * radii / assembly.bodies.len().max(1) as f64;
        let depth = edge_length(&assembly.cell, 2);
        let half = if depth > 0.0 { (0.5 * thickness * diameter / depth).clamp(0.0, 0.5) } else { 0.5 };
        View { up: 0, right: 1, slice: Some([0.5 - half, 0.5 + half]), smallest_force: f64::NEG_INFINITY }
    }

    /// The whole cell with only its strong contacts (f > 1).
    pub fn strong() -> Self {
        View { up: 0, right: 1, slice: None, smallest_force: 1.0 }
    }
}

/// Largest f with a distinct colour and width.
const LARGEST_FORCE: f64 = 4.0;
/// Width of a class of forces.
const CLASS: f64 = 0.25;
/// Height of the scale of forces below a picture, px.
const SCALE_HEIGHT: f64 = 44.0;
/// Number of layers of depth.
const LAYERS: usize = 8;
/// Colour of contacts in tension.
const TENSION: &str = "#3d8fb8";

/// A picture of force chains that can be drawn at any size. Lengths are in m, with x to the right and y up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForceChains {
    outline: Vec<Point>,
    grains: Vec<Disc>,
    lines: Vec<Line>,
    /// True for a slice. Grains are drawn only in slices, since otherwise they would hide everything.
    slice: bool,
    mean_radius: f64,
    /// Width and height that must fit into a frame, m: those of the picture, or larger ones if several pictures share a
    /// scale.
    extent: [f64; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Disc {
    at: Point,
    radius: f64,
    depth: f64,
    loaded: bool,
    /// The grain, if it has several pieces: their discs are drawn as one.
    body: Option<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    from: Point,
    to: Point,
    force: f64,
    depth: f64,
}

impl ForceChains {
    /// The picture of an assembly in a view.
    pub fn new(assembly: &Assembly, view: View) -> Self {
        let (up, right) = (view.up.min(2), view.right.min(2));
        let (Some(inverse), Some(depth)) =
            (inverse(&assembly.cell), (0..3).find(|k| *k != up && *k != right))
        else {
            return ForceChains::default();
        };
        let project = |s: Vector| -> Point {
            let x = apply(&assembly.cell, s);
            [x[right], x[up]]
        };
        let inside = |s: &Vector| view.slice.is_none_or(|[low, high]| s[depth] >= low && s[depth] <= high);
        let place = |position: Vector| -> Option<Vector> {
            let s = apply(&inverse, position).map(|s| s - s.floor());
            s.iter().all(|s| s.is_finite()).then_some(s)
        };
        let has_several = |body: usize| assembly.bodies.get(body).is_some_and(|body| body.rigid.is_some());
        // Centres of grains; that of a sphere is that of its piece.
        let centres: Vec<Option<Vector>> = assembly.bodies.iter().map(|body| place(body.position)).collect();
        let centre_of_body = |body: usize| centres.get(body).copied().flatten();
        let centre_of = |piece: usize| centre_of_body(assembly.body_of(piece)?);
        let mut degree = vec![0u32; assembly.bodies.len()];
        let mean = mean_force(&assembly.contacts);
        let mut picture = ForceChains {
            outline: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                .map(|corner: [f64; 2]| {
                    let mut s = [0.0; 3];
                    (s[right], s[up]) = (corner[0], corner[1]);
                    project(s)
                })
                .to_vec(),
            slice: view.slice.is_some(),
            mean_radius: mean_radius(assembly),
            ..Default::default()
        };
        for contact in &assembly.contacts {
            let (Some(i), Some(j)) = (centre_of(contact.i), centre_of(contact.j)) else { continue };
            let force = if mean > 0.0 { contact.normal_force / mean } else { 0.0 };
            for body in assembly.bodies_of(contact).into_iter().flatten() {
                if let Some(degree) = degree.get_mut(body) {
                    *degree += 1;
                }
            }
            let shown = inside(&i) && inside(&j) && force.is_finite() && force >= view.smallest_force;
            let branch = apply(&inverse, assembly.branch_of_bodies(contact));
            if !shown || !branch.iter().all(|b| b.is_finite()) {
                continue;
            }
            let end: Vector = std::array::from_fn(|k| i[k] + branch[k]);
            let begin: Vector = std::array::from_fn(|k| j[k] - branch[k]);
            let crosses = end.iter().any(|s| !(0.0..=1.0).contains(s));
            let images = [(i, end), (begin, j)];
            for (a, b) in images.into_iter().take(if crosses { 2 } else { 1 }) {
                let Some((enter, leave)) = clip::segment(a, b, [0.0; 3], [1.0; 3]) else { continue };
                let at = |t: f64| -> Vector { std::array::from_fn(|k| a[k] + t * (b[k] - a[k])) };
                let middle = 0.5 * (at(enter)[depth] + at(leave)[depth]);
                picture.lines.push(Line {
                    from: project(at(enter)),
                    to: project(at(leave)),
                    force,
                    depth: middle,
                });
            }
        }
        let pieces = if picture.slice { &assembly.pieces[..] } else { &[] };
        for piece in pieces {
            let (Some(s), Some(centre)) = (place(piece.position), centre_of_body(piece.body)) else {
                continue;
            };
            // A grain is shown as a whole, if its centre is in the slice.
            if inside(&centre) {
                let disc = Disc {
                    at: [0.0; 2],
                    radius: piece.radius,
                    depth: centre[depth],
                    loaded: degree.get(piece.body).is_some_and(|degree| *degree >= 2),
                    body: has_several(piece.body).then_some(piece.body),
                };
                picture.add_grain(s, disc, [right, up], &assembly.cell, &project);
            }
        }
        picture.extent = bounds(&picture.outline).1;
        picture.grains.sort_by(|a, b| b.depth.total_cmp(&a.depth).then(a.body.cmp(&b.body)));
        picture
    }

    /// Adds a piece of a grain and those of its periodic images that reach into the picture.
    fn add_grain(
        &mut self,
        s: Vector,
        disc: Disc,
        [right, up]: [usize; 2],
        cell: &Matrix,
        project: &impl Fn(Vector) -> Point,
    ) {
        let margin = |axis: usize| disc.radius / edge_length(cell, axis).max(f64::MIN_POSITIVE);
        let offsets = |axis: usize| {
            let near_low = (s[axis] < margin(axis)).then_some(1.0);
            let near_high = (s[axis] > 1.0 - margin(axis)).then_some(-1.0);
            [Some(0.0), near_low, near_high].into_iter().flatten()
        };
        for a in offsets(right) {
            for b in offsets(up) {
                let mut image = s;
                image[right] += a;
                image[up] += b;
                self.grains.push(Disc { at: project(image), ..disc });
            }
        }
    }

    /// Width and height that fit into a frame, m.
    pub fn extent(&self) -> [f64; 2] {
        self.extent
    }

    /// The same picture with a scale at which the given width and height fit into the frame.
    pub fn with_extent(mut self, extent: [f64; 2]) -> Self {
        self.extent = extent;
        self
    }

    /// Height of a frame of the given width that a picture of the given extent and its scale of forces fill, px.
    pub fn height_for(extent: [f64; 2], width: f64) -> f64 {
        let ratio = extent[1] / extent[0];
        width * if ratio.is_finite() { ratio.clamp(0.2, 2.0) } else { 1.0 } + SCALE_HEIGHT
    }

    /// Number of lines; a contact across the boundary has two.
    pub fn lines(&self) -> usize {
        self.lines.len()
    }

    /// Draws the picture in a frame, with a scale of forces below.
    pub fn draw(&self, svg: &mut Svg, frame: &Rect) {
        let frame = &Rect { bottom: frame.bottom - SCALE_HEIGHT, ..*frame };
        let Some(page) = Page::new(&self.outline, self.extent, frame) else {
            let centre = [0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom)];
            text(svg, centre, "nothing to show", plain(GREY, Anchor::Middle, TICK_SIZE));
            return;
        };
        let share = if self.slice { 0.95 } else { 0.6 };
        let widest = (share * self.mean_radius * page.scale).clamp(1.5, 14.0);
        let corners: Vec<Point> = self.outline.iter().map(|p| page.at(*p)).collect();
        let upright = is_upright(&corners);
        if upright {
            let (corner, size) = bounds(&corners);
            svg.begin_window(corner, size);
        }
        if self.slice {
            self.draw_grains(svg, &page);
            self.draw_lines(svg, &page, widest, 0..LAYERS);
        } else {
            for layer in (0..LAYERS).rev() {
                self.draw_lines(svg, &page, widest, layer..layer + 1);
            }
        }
        if upright {
            svg.end_window();
        }
        svg.path(&corners, true, None, Some(&Stroke::new(INK, 1.0)));
        self.draw_scale(svg, [0.5 * (frame.left + frame.right), frame.bottom + 14.0], widest);
    }

    fn draw_grains(&self, svg: &mut Svg, page: &Page) {
        for loaded in [false, true] {
            let fill = if loaded { "#eeece7" } else { "#ffffff" };
            svg.begin_group(&format!("fill=\"{fill}\" stroke=\"#c4bfb4\" stroke-width=\"0.7\""));
            let discs: Vec<&Disc> = self.grains.iter().filter(|disc| disc.loaded == loaded).collect();
            for grain in discs.chunk_by(|a, b| a.body.is_some() && a.body == b.body) {
                grain.iter().for_each(|disc| draw_disc(svg, page, disc, ""));
                if grain.len() > 1 {
                    // Once more without outlines, so that the outline is that of the whole grain.
                    grain.iter().for_each(|disc| draw_disc(svg, page, disc, " stroke=\"none\""));
                }
            }
            svg.end_group();
        }
    }

    /// Draws the lines by class of force, weak ones first and distant ones paler.
    fn draw_lines(&self, svg: &mut Svg, page: &Page, widest: f64, layers: std::ops::Range<usize>) {
        let mut classes: BTreeMap<(usize, i64), String> = BTreeMap::new();
        for line in &self.lines {
            let layer = layer_of(line.depth);
            if layers.contains(&layer) {
                let layer = if self.slice { 0 } else { layer };
                let class = (line.force.clamp(-1.0, LARGEST_FORCE) / CLASS).floor() as i64;
                let data = path_data(&[page.at(line.from), page.at(line.to)].map(|p| p.map(tenth)));
                classes.entry((layer, class.max(-1))).or_default().push_str(&data);
            }
        }
        svg.begin_group("stroke-linecap=\"round\"");
        for ((layer, class), data) in classes {
            // Most of the contrast is lost in the first layers, so that the front stands out.
            let white = 0.93 * libm::pow(layer as f64 / (LAYERS - 1) as f64, 0.6);
            let force = (class as f64 + 0.5) * CLASS;
            let stroke =
                if class < 0 { Stroke::new(TENSION, 1.0) } else { line_stroke(force, widest, white) };
            if !self.slice {
                // A thin white edge separates lines in front from those behind.
                svg.path_of(&data, None, Some(&Stroke::new("#ffffff", stroke.width + 1.2)));
            }
            svg.path_of(&data, None, Some(&stroke));
        }
        svg.end_group();
    }

    /// Draws a wedge with the width and colour of each force, and a line for tension if there is any.
    fn draw_scale(&self, svg: &mut Svg, top_middle: Point, widest: f64) {
        let (length, steps) = (160.0, 40);
        let tension = self.lines.iter().any(|line| line.force < 0.0);
        let [before, after] = [if tension { 84.0 } else { 0.0 }, 56.0];
        let left = top_middle[0] - 0.5 * (before + length + after) + before;
        let from = if self.slice { 0.0 } else { 1.0 };
        let middle = top_middle[1] + 0.5 * widest.max(6.0);
        for k in 0..steps {
            let force = from + (LARGEST_FORCE - from) * (k as f64 + 0.5) / steps as f64;
            let stroke = line_stroke(force, widest, 0.0);
            let corner = [left + length * k as f64 / steps as f64, middle - 0.5 * stroke.width];
            svg.rectangle(
                corner,
                [length / steps as f64 + 0.3, stroke.width],
                Some((&stroke.color, 1.0)),
                None,
            );
        }
        let base = middle + 0.5 * widest.max(6.0) + TICK_SIZE + 1.0;
        for k in from as usize..=LARGEST_FORCE as usize {
            let x = left + length * (k as f64 - from) / (LARGEST_FORCE - from);
            let label = if k == LARGEST_FORCE as usize { format!("≥ {k}") } else { k.to_string() };
            text(svg, [x, base], &label, plain(INK, Anchor::Middle, TICK_SIZE));
        }
        text(svg, [left + length + 18.0, middle + 4.0], "*N*/⟨*N*⟩", plain(INK, Anchor::Start, TICK_SIZE));
        if tension {
            svg.line([left - 84.0, middle], [left - 64.0, middle], &Stroke::new(TENSION, 1.4));
            text(svg, [left - 59.0, middle + 4.0], "tension", plain(INK, Anchor::Start, TICK_SIZE));
        }
    }
}

fn draw_disc(svg: &mut Svg, page: &Page, disc: &Disc, more: &str) {
    let at = page.at(disc.at);
    let [x, y, r] = [at[0], at[1], disc.radius * page.scale].map(one_decimal);
    svg.raw(&format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"{more}/>\n"));
}

/// The stroke of a contact: its width is proportional to the force, and its colour darkens with the force.
fn line_stroke(force: f64, widest: f64, white: f64) -> Stroke {
    let share = (force / LARGEST_FORCE).clamp(0.0, 1.0);
    Stroke::new(&sequential(share, white), (widest * share).max(0.35))
}

/// The position and scale of the picture on the page.
struct Page {
    scale: f64,
    origin: Point,
}

impl Page {
    /// Centres the outline in a frame, with the scale at which `extent` fits.
    fn new(outline: &[Point], extent: [f64; 2], frame: &Rect) -> Option<Self> {
        let (corner, size) = bounds(outline);
        let scale = (frame.width() / extent[0]).min(frame.height() / extent[1]);
        if !(scale.is_finite() && scale > 0.0 && size[0] > 0.0 && size[1] > 0.0) {
            return None;
        }
        let left = 0.5 * (frame.left + frame.right) - 0.5 * scale * size[0];
        let top = 0.5 * (frame.top + frame.bottom) - 0.5 * scale * size[1];
        Some(Page { scale, origin: [left - scale * corner[0], top + scale * (corner[1] + size[1])] })
    }

    fn at(&self, p: Point) -> Point {
        [self.origin[0] + self.scale * p[0], self.origin[1] - self.scale * p[1]]
    }
}

/// Lower corner and size of the bounding box of points.
fn bounds(points: &[Point]) -> (Point, [f64; 2]) {
    let end =
        |axis: usize, pick: fn(f64, f64) -> f64, start: f64| points.iter().map(|p| p[axis]).fold(start, pick);
    let low = [0, 1].map(|axis| end(axis, f64::min, f64::INFINITY));
    let high = [0, 1].map(|axis| end(axis, f64::max, f64::NEG_INFINITY));
    (low, [high[0] - low[0], high[1] - low[1]])
}

/// True if the outline is an upright rectangle, so that it can serve as a window that cuts off lines.
fn is_upright(corners: &[Point]) -> bool {
    corners.len() == 4
        && (corners[0][1] - corners[1][1]).abs() < 0.01
        && (corners[1][0] - corners[2][0]).abs() < 0.01
        && (corners[2][1] - corners[3][1]).abs() < 0.01
}

fn layer_of(depth: f64) -> usize {
    // With axis 1 up and axis 2 to the right, axis 3 points away from the reader.
    ((depth * LAYERS as f64) as usize).min(LAYERS - 1)
}

fn tenth(value: f64) -> f64 {
    (10.0 * value).round() / 10.0
}

fn one_decimal(value: f64) -> String {
    super::svg::number(tenth(value))
}

fn mean_force(contacts: &[Contact]) -> f64 {
    contacts.iter().map(|contact| contact.normal_force).sum::<f64>() / contacts.len().max(1) as f64
}

fn mean_radius(assembly: &Assembly) -> f64 {
    assembly.bodies.iter().map(|body| body.equivalent_radius).sum::<f64>()
        / assembly.bodies.len().max(1) as f64
}

fn edge_length(cell: &Matrix, edge: usize) -> f64 {
    (0..3).map(|i| cell[i][edge] * cell[i][edge]).sum::<f64>().sqrt()
}

/// Inverse of a 3 x 3 matrix; `None` if the matrix is singular.
fn inverse(m: &Matrix) -> Option<Matrix> {
    let d = determinant(m);
    (d.is_finite() && d != 0.0).then(|| invert(m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::assembly::Sphere;

    fn two_grains(x: f64, y: f64, branch: Vector) -> Assembly {
        let grain = |id, x| Sphere { id, position: [x, 0.5, 0.5], radius: 0.1, ..Default::default() };
        Assembly {
            cell: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            contacts: vec![Contact { i: 0, j: 1, branch, normal_force: 1.0, ..Default::default() }],
            ..Default::default()
        }
        .with_spheres(vec![grain(1, x), grain(2, y)])
    }

    #[test]
    fn a_contact_across_the_boundary_is_drawn_at_both_images_and_cut_off() {
        let inner = ForceChains::new(&two_grains(0.4, 0.6, [0.2, 0.0, 0.0]), View::strong());
        assert_eq!(inner.lines(), 1);
        let outer = ForceChains::new(&two_grains(0.95, 0.15, [0.2, 0.0, 0.0]), View::strong());
        assert_eq!(outer.lines(), 2);
        let close = |p: Point, q: Point| (p[0] - q[0]).abs() < 1e-12 && (p[1] - q[1]).abs() < 1e-12;
        assert!(close(outer.lines[0].from, [0.5, 0.95]) && close(outer.lines[0].to, [0.5, 1.0]));
        assert!(close(outer.lines[1].from, [0.5, 0.0]) && close(outer.lines[1].to, [0.5, 0.15]));
    }

    #[test]
    fn positions_outside_the_cell_are_wrapped_and_images_of_grains_added() {
        let picture = ForceChains::new(&two_grains(-0.6, 1.6, [0.2, 0.0, 0.0]), View::strong());
        assert_eq!(picture.lines(), 1);
        let slice = View { slice: Some([0.0, 1.0]), ..View::strong() };
        let edge = ForceChains::new(&two_grains(0.95, 0.5, [0.2, 0.0, 0.0]), slice);
        assert_eq!(edge.grains.len(), 3);
    }

    #[test]
    fn a_sheared_cell_is_projected_along_its_edges() {
        let mut assembly = two_grains(0.4, 0.6, [0.2, 0.0, 0.0]);
        assembly.cell[1][0] = 0.3;
        let picture = ForceChains::new(&assembly, View::strong());
        assert_eq!(picture.outline, [[0.0, 0.0], [1.0, 0.0], [1.3, 1.0], [0.3, 1.0]]);
        let identity = apply(&inverse(&assembly.cell).unwrap(), apply(&assembly.cell, [0.1, 0.2, 0.3]));
        assert!((0..3).all(|k| (identity[k] - [0.1, 0.2, 0.3][k]).abs() < 1e-12));
    }

    /// A grain of two pieces is drawn as one: its outline has no part inside, and it is shown as a whole or not at all.
    #[test]
    fn the_pieces_of_a_grain_are_drawn_as_one() {
        let mut assembly = two_grains(0.4, 0.7, [0.3, 0.0, 0.0]);
        assembly.bodies[0].rigid = Some(0);
        assembly
            .rigid
            .push(granum_core::assembly::Rigid { orientation: [1.0, 0.0, 0.0, 0.0], inertia: [1.0; 3] });
        let first = assembly.pieces[0];
        let arm = [0.0, 0.0, 0.09];
        assembly.pieces.push(granum_core::assembly::Piece { arm, position: [0.4, 0.5, 0.59], ..first });
        let slice = View { slice: Some([0.45, 0.55]), ..View::strong() };
        let picture = ForceChains::new(&assembly, slice);
        let bodies: Vec<Option<usize>> = picture.grains.iter().map(|disc| disc.body).collect();
        assert_eq!(bodies, [None, Some(0), Some(0)]);
        let mut svg = Svg::new();
        picture.draw(&mut svg, &Rect::new(0.0, 0.0, 200.0, 244.0));
        let drawn = svg.into_body();
        assert_eq!(drawn.matches("stroke=\"none\"").count(), 2);
        assert_eq!(drawn.matches("<circle").count(), 5);
        let elsewhere = View { slice: Some([0.56, 0.7]), ..View::strong() };
        assert!(ForceChains::new(&assembly, elsewhere).grains.is_empty());
    }

    #[test]
    fn broken_assemblies_give_an_empty_picture() {
        let mut assembly = two_grains(f64::NAN, 0.6, [0.2, 0.0, 0.0]);
        assert_eq!(ForceChains::new(&assembly, View::strong()).lines(), 0);
        assembly.contacts[0].i = 99;
        assert_eq!(ForceChains::new(&assembly, View::strong()).lines(), 0);
        assembly.cell = [[0.0; 3]; 3];
        assert_eq!(ForceChains::new(&assembly, View::slice(&assembly, 2.0)), ForceChains::default());
        assert_eq!(ForceChains::new(&Assembly::default(), View::strong()), ForceChains::default());
    }
}
