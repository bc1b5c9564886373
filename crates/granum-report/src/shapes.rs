//! The shapes of grains: their descriptors, how well spheres stand for the body of a file, and their picture.

use granum_core::geometry::length;
use granum_core::rotation::to_body;
use granum_dem::shape::cover::{CoverReport, CoveredBody};
use granum_dem::shape::mesh::TriangleMesh;
use granum_dem::shape::{ShapeDescriptors, ShapeEntry, ShapeError, ShapeOfSpheres, Spheres, widest_seam};
use granum_dem::time_step_share;

use super::data::RunReport;
use super::figure::{Figure, Legend, Panel, Side, Solid, literal};
use super::numbers::{significant, trimmed};
use super::page::{Page, PageTable};
use maud::{Markup, html};

/// Largest number of shapes that are drawn from all sides.
const FROM_ALL_SIDES: usize = 3;
/// Largest number of shapes that are drawn or listed in a report.
pub const MOST_SHOWN: usize = 24;
/// Number of panels in a row where each shape has one picture.
const IN_A_ROW: usize = 4;

/// The body of a file that spheres stand for.
#[derive(Clone, Debug)]
pub struct OriginalBody {
    /// Its volume, in the unit of length of the file.
    pub volume: f64,
    /// The volume of the spheres that stand for it, likewise.
    pub volume_of_spheres: f64,
    /// Its sphericity; not a number where its surface is not known, as of voxels.
    pub sphericity: f64,
    /// Errors of the spheres.
    pub report: CoverReport,
    /// Its surface, in the principal axes of the spheres and in their unit of length.
    surface: TriangleMesh,
}

/// A shape with all that is told about it. Its unit of length is the diameter of the sphere of equal volume.
#[derive(Clone, Debug)]
pub struct ShownShape {
    /// The family, with the label of the grain where there are several.
    pub name: String,
    /// Share of the mass of the grains.
    pub share: f64,
    /// The shape.
    pub shape: ShapeOfSpheres,
    /// The spheres as a case can have them.
    pub spheres: Spheres,
    /// Its descriptors.
    pub descriptors: ShapeDescriptors,
    /// The time step over that of spheres of the same mass.
    pub time_step_share: f64,
    /// Slope of the widest seam, if one can be touched.
    pub seam: Option<f64>,
    /// The body of a file that its spheres stand for.
    pub original: Option<OriginalBody>,
}

impl ShownShape {
    /// The shapes of an entry of a case, with notices: what was mended or left out, and how well spheres stand for a file.
    ///
    /// # Errors
    /// The key that is wrong, and what would be right.
    pub fn of_entry(entry: &ShapeEntry, notices: &mut Vec<String>) -> Result<Vec<ShownShape>, ShapeError> {
        entry.check()?;
        let family = entry.kind.family();
        let name = family.description().name;
        if family.description().takes_file {
            let bodies = family.covered_bodies(entry, notices)?;
            let share = entry.share / bodies.len().max(1) as f64;
            return bodies.into_iter().map(|body| ShownShape::of_body(name, share, body)).collect();
        }
        let (shapes, told) = entry.shapes_with_notices()?;
        notices.extend(told);
        let (descriptors, share) = (entry.descriptors()?, entry.share / shapes.len().max(1) as f64);
        let all = shapes.iter().zip(descriptors.iter());
        Ok(all
            .map(|(shape, found)| Self::new(name, share, shape.clone(), spheres_of(entry, shape), *found))
            .collect())
    }

    fn new(
        name: &str,
        share: f64,
        shape: ShapeOfSpheres,
        spheres: Spheres,
        descriptors: ShapeDescriptors,
    ) -> ShownShape {
        let (time_step_share, seam) = (time_step_share(&shape.shape), widest_seam(&shape.shape));
        let name = name.to_string();
        ShownShape { name, share, shape, spheres, descriptors, time_step_share, seam, original: None }
    }

    fn of_body(name: &str, share: f64, body: CoveredBody) -> Result<ShownShape, ShapeError> {
        let CoveredBody { label, volume, cover, surface } = body;
        let found =
            ShapeOfSpheres::new(&cover.spheres).map_err(|why| ShapeError { key: "kind", message: why })?;
        let factor = 0.5 / found.shape.equivalent_radius();
        let vertices = (surface.vertices.iter())
            .map(|place| {
                let apart = std::array::from_fn(|k| place[k] - found.centre[k]);
                to_body(&found.axes, &apart).map(|x| factor * x)
            })
            .collect();
        let shape = found.scaled(factor);
        let descriptors = ShapeDescriptors::new(&shape);
        let original = OriginalBody {
            volume,
            volume_of_spheres: found.shape.volume,
            sphericity: descriptors.sphericity / (1.0 + cover.report.sphericity),
            report: cover.report,
            surface: TriangleMesh { vertices, triangles: surface.triangles },
        };
        let name = label.map_or(name.to_string(), |label| format!("{name} {label}"));
        let shown = ShownShape::new(&name, share, shape, cover.spheres, descriptors);
        Ok(ShownShape { original: Some(original), ..shown })
    }

    /// Number of its spheres.
    pub fn pieces(&self) -> usize {
        self.shape.shape.pieces.len()
    }

    /// Largest distance of anything that is drawn from the centre.
    fn reach(&self) -> f64 {
        let surface = self.original.iter().flat_map(|body| &body.surface.vertices);
        surface.map(length).fold(self.shape.shape.reach(), f64::max)
    }

    fn picture(&self, side: Side, extent: f64) -> Panel {
        let spheres = self.shape.shape.pieces.iter().map(|piece| (piece.centre, piece.radius));
        Panel::solid(Solid::of_spheres(spheres, side, extent))
    }

    fn picture_of_original(&self, side: Side, extent: f64) -> Option<Panel> {
        Some(Panel::solid(Solid::of_surface(&self.original.as_ref()?.surface, side, extent)))
    }
}

/// The spheres as they were given, or those of the shape.
fn spheres_of(entry: &ShapeEntry, shape: &ShapeOfSpheres) -> Spheres {
    if entry.spheres.is_empty() {
        return shape.shape.pieces.iter().map(|piece| (piece.centre, piece.radius)).collect();
    }
    entry.spheres.iter().map(|[x, y, z, radius]| ([*x, *y, *z], *radius)).collect()
}

/// The picture of shapes with its caption: from three sides where they are few, and from their broadest side where they are many; beside the
/// bodies that their spheres stand for.
pub fn figure(shapes: &[ShownShape]) -> (Figure, String) {
    let shown = &shapes[..shapes.len().min(MOST_SHOWN)];
    let extent = 2.04 * shown.iter().map(ShownShape::reach).fold(0.0, f64::max);
    let few = shown.len() <= FROM_ALL_SIDES;
    let (columns, panels) = if few { (3, sides(shown, extent)) } else { (IN_A_ROW, broad(shown, extent)) };
    let mut caption =
        "The grains as spheres (blue), in the order of their depth and all at one scale".to_string();
    if shown.iter().any(|shape| shape.original.is_some()) {
        caption += ", and the bodies of the file that they stand for (sand)";
    }
    caption +=
        if few { ", along the three principal axes." } else { ", seen along the shortest principal axis." };
    if shown.len() < shapes.len() {
        caption += &format!(" The first {} of {} shapes.", shown.len(), shapes.len());
    }
    let height = if few { 250.0 } else { 196.0 };
    let figure = Figure::new("The shapes of the grains", columns, panels);
    (figure.sized(720.0, height).legend(Legend::Hidden), caption)
}

/// Three pictures of each shape in a row, and three of its original below.
fn sides(shapes: &[ShownShape], extent: f64) -> Vec<Panel> {
    let mut panels = Vec::new();
    for shape in shapes {
        let name = literal(&shape.name);
        panels.extend(Side::ALL.map(|side| shape.picture(side, extent).titled(&title(&name, side))));
        let original = Side::ALL.iter().filter_map(|side| {
            let panel = shape.picture_of_original(*side, extent)?;
            Some(panel.titled(&title("original", *side)))
        });
        panels.extend(original);
    }
    panels
}

/// The name and the side: the name stands above the first side alone.
fn title(name: &str, side: Side) -> String {
    match side {
        Side::Broad => format!("{name}, {}", side.name()),
        _ => side.name().to_string(),
    }
}

/// A picture of each shape, followed by one of its original.
fn broad(shapes: &[ShownShape], extent: f64) -> Vec<Panel> {
    let panels = |(k, shape): (usize, &ShownShape)| {
        let own = shape.picture(Side::Broad, extent).titled(&format!("{} {}", k + 1, literal(&shape.name)));
        let original = shape.picture_of_original(Side::Broad, extent);
        [Some(own), original.map(|panel| panel.titled("original"))].into_iter().flatten()
    };
    shapes.iter().enumerate().flat_map(panels).collect()
}

/// Table and picture of the shapes of a run, unless all grains are spheres.
pub fn section(page: &mut Page, run: &RunReport) -> Option<Markup> {
    let grains = &run.case.grains;
    if grains.are_spheres() || run.run.packing.is_some() {
        return None;
    }
    let mut shapes = Vec::new();
    for entry in &grains.shapes {
        shapes.extend(ShownShape::of_entry(entry, &mut Vec::new()).ok()?);
    }
    let label = page.own_table_label();
    let (figure, caption) = figure(&shapes);
    Some(html! { (table(&label, &shapes).html()) (page.own_figure("shapes", &caption, &figure)) })
}

/// The table of shapes with their descriptors.
pub fn table(label: &str, shapes: &[ShownShape]) -> PageTable {
    let caption = "The shapes of the grains. Elongation is intermediate over largest length and flatness least over intermediate length, both of \
                   the ellipsoid of equal inertia; tan *χ* is the slope of the widest seam between two spheres, which acts as friction.";
    let columns = [
        "Shape",
        "Mass",
        "Spheres",
        "Elongation",
        "Flatness",
        "Sphericity",
        "Convexity",
        "Roundness",
        "Sieve over volume diameter",
        "Time step over that of spheres",
        "tan *χ*",
    ];
    let mut table = PageTable::new(label, caption, &columns);
    for shape in shapes.iter().take(MOST_SHOWN) {
        let found = &shape.descriptors;
        let numbers = [
            found.elongation,
            found.flatness,
            found.sphericity,
            found.convexity,
            found.roundness,
            found.sieve_diameter() / found.volume_diameter,
            shape.time_step_share,
        ];
        let share = format!("{} %", significant(100.0 * shape.share, 3));
        let mut row = vec![literal(&shape.name), share, trimmed(shape.pieces() as f64)];
        row.extend(numbers.map(|number| significant(number, 3)));
        row.push(shape.seam.map_or("–".into(), |slope| significant(slope, 2)));
        table.row(row);
    }
    if shapes.len() > MOST_SHOWN {
        table.note = format!("The first {MOST_SHOWN} of {} shapes.", shapes.len());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_dem::shape::ShapeKind;

    #[test]
    fn a_capsule_is_drawn_from_three_sides_and_listed() {
        let shapes = ShownShape::of_entry(&ShapeEntry::new(ShapeKind::CAPSULE), &mut Vec::new()).unwrap();
        let (figure, caption) = figure(&shapes);
        assert_eq!((figure.panels.len(), figure.columns), (3, 3));
        assert!(caption.contains("three principal axes") && !caption.contains("sand"), "{caption}");
        let table = table("Table S1", &shapes);
        assert_eq!(table.rows[0].len(), table.columns.len());
        assert_eq!((table.rows[0][0].as_str(), table.rows[0][2].as_str()), ("capsule", "3"));
    }

    #[test]
    fn many_shapes_are_drawn_from_one_side() {
        let sand = ShapeEntry::new(ShapeKind::SAND);
        let one = ShownShape::of_entry(&sand, &mut Vec::new()).unwrap();
        let many: Vec<ShownShape> = one.into_iter().cycle().take(MOST_SHOWN + 1).collect();
        let (figure, caption) = figure(&many);
        assert_eq!(figure.panels.len(), MOST_SHOWN);
        assert!(caption.contains("The first 24 of 25 shapes"), "{caption}");
    }
}
