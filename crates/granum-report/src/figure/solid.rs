//! A picture of a body: spheres or a surface of triangles, lit from where the reader is, in the order of their depth.
//!
//! A sphere is drawn as its cuts across the line of sight, from its rim to its front. The cuts of all spheres are drawn in the order of their
//! depth, so that spheres that enter each other meet where they do in space, within the distance of two cuts.

use std::collections::BTreeMap;

use granum_core::assembly::Vector;
use granum_core::geometry::{cross, length};
use granum_dem::shape::mesh::TriangleMesh;

use super::clip::Rect;
use super::palette::hex;
use super::svg::{Point, Stroke, Svg, path_data};

/// Number of cuts of a sphere, at equal angles from its rim to its front.
const CUTS: usize = 36;
/// A triangle whose normal has a smaller part towards the reader is not drawn: it would be a line.
const EDGEWISE: f64 = 0.04;
/// Number of shades of triangles.
const SHADES: f64 = 24.0;
/// Number of cells along the longest side of a mesh, in each of which its corners become one.
const CELLS: f64 = 28.0;
/// A mesh of fewer triangles is drawn as it is.
const FEW: usize = 3000;
/// Colour of spheres, and of surfaces of triangles: red, green and blue.
const BALLS: [f64; 3] = [128.0, 176.0, 214.0];
const SURFACE: [f64; 3] = [222.0, 190.0, 144.0];
/// Colour of the outlines of spheres.
const OUTLINE: &str = "#24435c";

/// The direction from which a body is seen, in its principal axes: the first is the longest, the third the shortest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Along the shortest axis: the widest face.
    Broad,
    /// Along the intermediate axis.
    Narrow,
    /// Along the longest axis.
    End,
}

impl Side {
    /// All sides.
    pub const ALL: [Side; 3] = [Side::Broad, Side::Narrow, Side::End];

    /// Its name: the axis along which one looks.
    pub fn name(self) -> &'static str {
        match self {
            Side::Broad => "along the shortest axis",
            Side::Narrow => "along the intermediate axis",
            Side::End => "along the longest axis",
        }
    }

    /// A place as seen from here: to the right, up, and towards the reader.
    fn seen(self, [a, b, c]: Vector) -> Vector {
        match self {
            Side::Broad => [a, b, c],
            Side::Narrow => [a, c, -b],
            Side::End => [b, c, a],
        }
    }
}

/// A picture of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Centre and radius of each sphere: to the right, up, towards the reader.
    balls: Vec<(Vector, f64)>,
    triangles: Vec<[Vector; 3]>,
    /// Length that fits into the frame.
    extent: f64,
}

/// A cut of a sphere across the line of sight.
struct Cut {
    at: Point,
    radius: f64,
    depth: f64,
    /// The part of the normal towards the reader: 0 at the rim and 1 in front.
    facing: f64,
}

impl Solid {
    /// Spheres, given by centre and radius, at the scale at which a length fits into the frame.
    pub fn of_spheres(spheres: impl IntoIterator<Item = (Vector, f64)>, side: Side, extent: f64) -> Solid {
        let balls = spheres.into_iter().map(|(centre, radius)| (side.seen(centre), radius)).collect();
        Solid { balls, triangles: Vec::new(), extent }
    }

    /// A surface of triangles, with fewer of them where there are many.
    pub fn of_surface(mesh: &TriangleMesh, side: Side, extent: f64) -> Solid {
        let few = if mesh.triangles.len() > FEW { merged(mesh) } else { mesh.clone() };
        let triangles = (0..few.triangles.len()).map(|k| few.corners(k).map(|place| side.seen(place)));
        Solid { balls: Vec::new(), triangles: triangles.collect(), extent }
    }

    /// Draws the picture in the middle of a frame.
    pub fn draw(&self, svg: &mut Svg, frame: &Rect) {
        let scale = frame.width().min(frame.height()) / self.extent;
        if !(scale.is_finite() && scale > 0.0) {
            return;
        }
        let middle = [0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom)];
        let place = |p: &Vector| [middle[0] + scale * p[0], middle[1] - scale * p[1]];
        self.draw_triangles(svg, &place);
        self.draw_balls(svg, &place, scale);
    }

    fn draw_balls(&self, svg: &mut Svg, place: &dyn Fn(&Vector) -> Point, scale: f64) {
        let mut cuts: Vec<Cut> = Vec::new();
        for (centre, radius) in &self.balls {
            for k in 0..CUTS {
                let angle = 0.5 * std::f64::consts::PI * k as f64 / CUTS as f64;
                let (sine, cosine) = libm::sincos(angle);
                let (radius, depth) = (scale * radius * cosine, centre[2] + radius * sine);
                cuts.push(Cut { at: place(centre), radius, depth, facing: sine });
            }
        }
        cuts.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        for (k, cut) in cuts.iter().enumerate() {
            let hides = |front: &Cut| {
                let [dx, dy] = [front.at[0] - cut.at[0], front.at[1] - cut.at[1]];
                // The outline is drawn beyond the rim.
                (dx * dx + dy * dy).sqrt() + cut.radius + 1.0 < front.radius
            };
            if cuts[k + 1..].iter().any(hides) {
                continue;
            }
            let outline = (cut.facing == 0.0).then(|| Stroke::new(OUTLINE, 1.4));
            svg.circle(cut.at, cut.radius, Some((&shade(BALLS, cut.facing), 1.0)), outline.as_ref());
        }
    }

    fn draw_triangles(&self, svg: &mut Svg, place: &dyn Fn(&Vector) -> Point) {
        let mut facing: Vec<(f64, i64, &[Vector; 3])> = (self.triangles.iter())
            .filter_map(|corners| {
                let towards = facing(corners);
                let depth = corners.iter().map(|p| p[2]).sum::<f64>();
                (towards > EDGEWISE).then_some((depth, (towards * SHADES).floor() as i64, corners))
            })
            .collect();
        facing.sort_by(|a, b| a.0.total_cmp(&b.0));
        for equal in facing.chunk_by(|a, b| a.1 == b.1) {
            let data: String = equal.iter().map(|(_, _, p)| path_data(&p.map(|p| place(&p))) + "Z").collect();
            let fill = shade(SURFACE, equal[0].1 as f64 / SHADES);
            // A thin line of the same colour closes the gaps that rounding leaves between triangles.
            svg.path_of(&data, Some((&fill, 1.0)), Some(&Stroke::new(&fill, 0.6)));
        }
    }
}

/// The part of the normal of a triangle towards the reader.
fn facing(corners: &[Vector; 3]) -> f64 {
    let [p, q, r] = corners;
    let edge = |to: &Vector| -> Vector { std::array::from_fn(|k| to[k] - p[k]) };
    let normal = cross(&edge(q), &edge(r));
    let size = length(&normal);
    if size > 0.0 { normal[2] / size } else { 0.0 }
}

/// A colour in the light of a lamp beside the reader.
fn shade(rgb: [f64; 3], facing: f64) -> String {
    let light = 0.42 + 0.58 * facing.clamp(0.0, 1.0);
    hex(rgb.map(|part| part * light), 0.25 * facing.clamp(0.0, 1.0))
}

/// The mesh with one corner for all corners in a cell of a grid.
fn merged(mesh: &TriangleMesh) -> TriangleMesh {
    let end = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| {
        mesh.vertices.iter().map(|p| p[axis]).fold(start, pick)
    };
    let low: Vector = std::array::from_fn(|axis| end(axis, f64::min, f64::INFINITY));
    let size = (0..3).map(|axis| end(axis, f64::max, f64::NEG_INFINITY) - low[axis]).fold(0.0, f64::max);
    let mut cells: BTreeMap<[i64; 3], (Vector, f64, usize)> = BTreeMap::new();
    let keys: Vec<[i64; 3]> = (mesh.vertices.iter())
        .map(|place| std::array::from_fn(|k| ((place[k] - low[k]) / size * CELLS).floor() as i64))
        .collect();
    for (place, key) in mesh.vertices.iter().zip(&keys) {
        let (sum, count, _) = cells.entry(*key).or_default();
        *sum = std::array::from_fn(|k| sum[k] + place[k]);
        *count += 1.0;
    }
    for (index, (_, _, place)) in cells.values_mut().enumerate() {
        *place = index;
    }
    let vertices = cells.values().map(|(sum, count, _)| sum.map(|x| x / count)).collect();
    let triangles = (mesh.triangles.iter())
        .map(|corners| corners.map(|k| cells.get(&keys[k]).map_or(0, |cell| cell.2)))
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    TriangleMesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(solid: &Solid) -> String {
        let mut svg = Svg::new();
        solid.draw(&mut svg, &Rect::new(0.0, 0.0, 100.0, 100.0));
        svg.into_body()
    }

    #[test]
    fn a_sphere_behind_another_is_not_drawn_and_one_in_front_is_drawn_last() {
        let alone = Solid::of_spheres([([0.0; 3], 1.0)], Side::Broad, 2.0);
        let behind = Solid::of_spheres([([0.0; 3], 1.0), ([0.0, 0.0, -2.0], 0.5)], Side::Broad, 2.0);
        assert_eq!(drawn(&alone), drawn(&behind));
        let front = Solid::of_spheres([([0.0, 0.0, 2.0], 0.5), ([0.0; 3], 1.0)], Side::Broad, 2.0);
        let last = drawn(&front).lines().last().unwrap_or_default().to_string();
        let radius: f64 = last.split("r=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
        assert!(radius < 5.0, "{last}");
    }

    #[test]
    fn triangles_that_face_away_are_not_drawn() {
        let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let towards = TriangleMesh { vertices, triangles: vec![[0, 1, 2]] };
        let away = TriangleMesh { triangles: vec![[0, 2, 1]], ..towards.clone() };
        assert!(drawn(&Solid::of_surface(&towards, Side::Broad, 2.0)).contains("<path"));
        assert_eq!(drawn(&Solid::of_surface(&away, Side::Broad, 2.0)), "");
        assert!(drawn(&Solid::of_surface(&towards, Side::End, 2.0)).is_empty());
    }

    #[test]
    fn many_triangles_become_few() {
        let count = 60;
        let corner = |i: usize, j: usize| i * (count + 1) + j;
        let vertices =
            (0..=count).flat_map(|i| (0..=count).map(move |j| [i as f64, j as f64, 0.0])).collect();
        let squares = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
        let triangles = squares
            .flat_map(|(i, j)| {
                let square = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                [[square[0], square[1], square[2]], [square[0], square[2], square[3]]]
            })
            .collect();
        let few = merged(&TriangleMesh { vertices, triangles });
        assert!(few.triangles.len() > 500 && few.triangles.len() < 2000, "{}", few.triangles.len());
    }
}
