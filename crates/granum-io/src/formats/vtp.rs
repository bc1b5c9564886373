//! VTK PolyData (`.vtp`) for ParaView: grains as vertices and contacts as lines from centre to centre, in one file.
//!
//! A line that leaves the cell is cut at the face and continues from the opposite one, so that no line crosses the whole picture.
//! Arrays of vertices and lines (cell data): `id`, `radius`, `diameter`, `mass`, `velocity`, `angular_velocity`, `force_on_grain`,
//! `torque_on_grain`, `coordination_number` of grains; `first`, `second` (ids of the grains), `overlap`, `normal_force`,
//! `tangential_force`, `force` (magnitude), `sliding` of contacts; each is zero for the other kind, and `is_contact` distinguishes
//! them (filter Threshold). Point data: `radius` (of grains, zero elsewhere) for the filter Glyph, and `normal_force` for the filter
//! Tube. Field data: `cell` (its three edges), `origin`, `TimeValue`, `step`. granum reads its own files [again](super::vtk_xml).
//!
//! Of grains of several pieces each piece is a vertex with the number of the piece as its `id`, and there are further arrays: `body`, the id of its
//! grain, also among the point data, by which ParaView can colour; and `body_mass`, to which the masses of the pieces of a grain add up.
//! Contacts name pieces. Forces on grains are not written then. The grains themselves, with their orientations, are in a [file of
//! bodies](super::vtp_bodies), bonds and cracks in a [file of bonds](super::vtp_bonds).

use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Assembly, Contact, Vector};
use granum_core::geometry::{apply, invert};

use super::atoms::{Atom, atoms};
use super::result::{Frame, ObservedAssembly, ReadOptions, ResultFormat};
use super::vtk_xml::VtkXml;
use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// The format.
pub struct Vtp;

impl ResultFormat for Vtp {
    fn name(&self) -> &'static str {
        "VTP"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["vtp"]
    }
    fn recognises(&self, _: &[u8]) -> bool {
        // All files of VTK XML are recognised in the same way, whatever they contain.
        false
    }
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Frame>> {
        VtkXml.read(path, options)
    }
    fn holds_one_instant(&self) -> bool {
        true
    }
    fn is_written(&self) -> bool {
        true
    }
    fn holds_bodies(&self) -> bool {
        true
    }
    fn write(&self, path: &Path, observations: &[ObservedAssembly]) -> Result<()> {
        write_one(path, observations, text)
    }
}

/// Writes the text of the one instant that a VTP file holds.
pub(super) fn write_one(
    path: &Path,
    observations: &[ObservedAssembly],
    text: fn(&ObservedAssembly) -> String,
) -> Result<()> {
    let [observation] = observations else {
        let message = format!("a VTP file holds one instant, not {}", observations.len());
        return Err(Error::content(path, message));
    };
    let text = text(observation);
    write_atomically(path, |file| file.write_all(text.as_bytes()))
}

/// A straight piece of the line between the centres of a contact, inside the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLine {
    /// The contact, by its place among them.
    pub contact: usize,
    /// Where it begins, m.
    pub from: Vector,
    /// Where it ends, m.
    pub to: Vector,
}

/// The lines of all contacts, cut at the faces of the cell.
pub fn contact_lines(assembly: &Assembly) -> Vec<ContactLine> {
    lines_in_cell(assembly, assembly.contacts.iter().map(|contact| (contact.i, contact.branch)))
}

/// Lines from pieces along branches, cut at the faces of the cell, each with its place among them.
pub(super) fn lines_in_cell(
    assembly: &Assembly,
    lines: impl Iterator<Item = (usize, Vector)>,
) -> Vec<ContactLine> {
    let inverse = invert(&assembly.cell);
    let is_cell = inverse.iter().flatten().all(|x| x.is_finite());
    let mut found = Vec::new();
    for (k, (piece, branch)) in lines.enumerate() {
        let Some(grain) = assembly.pieces.get(piece) else { continue };
        if is_cell {
            cut(k, grain.position, branch, assembly, &inverse, &mut found);
        } else {
            let to = std::array::from_fn(|a| grain.position[a] + branch[a]);
            found.push(ContactLine { contact: k, from: grain.position, to });
        }
    }
    found
}

/// Cuts one line where a coordinate in units of the edges leaves the range 0 to 1.
fn cut(
    k: usize,
    start: Vector,
    branch: Vector,
    assembly: &Assembly,
    inverse: &granum_core::assembly::Matrix,
    into: &mut Vec<ContactLine>,
) {
    let place = apply(inverse, start);
    let step = apply(inverse, branch);
    // Every crossing of a face, by the share of the line before it.
    let mut crossings: Vec<(f64, usize, f64)> = Vec::new();
    for a in 0..3 {
        let (mut face, way) = if step[a] > 0.0 { (1.0, 1.0) } else { (0.0, -1.0) };
        while step[a] != 0.0 && (face - place[a]) / step[a] < 1.0 {
            crossings.push((((face - place[a]) / step[a]).max(0.0), a, way));
            face += way;
        }
    }
    crossings.sort_by(|one, two| one.0.total_cmp(&two.0));
    let (mut before, mut shift) = (0.0, [0.0; 3]);
    let end = (1.0, 0, 0.0);
    for (share, axis, way) in crossings.into_iter().chain([end]) {
        let at = |share: f64| {
            let inside = std::array::from_fn(|a| place[a] + share * step[a] - shift[a]);
            apply(&assembly.cell, inside)
        };
        if share > before {
            into.push(ContactLine { contact: k, from: at(before), to: at(share) });
        }
        before = share;
        shift[axis] += way;
    }
}

/// The beginning of every file.
pub(super) const BEGINNING: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\">\n<PolyData>\n";

/// A vector of each grain.
type OfGrain = fn(&Atom) -> Vector;

fn text(observation: &ObservedAssembly) -> String {
    let assembly = &observation.assembly;
    let (grains, contacts) = (&atoms(assembly), &assembly.contacts);
    let has_bodies = !assembly.all_spheres();
    let drawn = contact_lines(assembly);
    let origin = observation.origin;
    let moved = |v: &Vector| -> Vector { std::array::from_fn(|a| v[a] + origin[a]) };
    let mut points: Vec<Vector> = grains.iter().map(|grain| moved(&grain.position)).collect();
    points.extend(drawn.iter().flat_map(|line| [moved(&line.from), moved(&line.to)]));
    let mut degree = vec![0.0; grains.len()];
    for contact in contacts {
        for index in [contact.i, contact.j] {
            if let Some(count) = degree.get_mut(index) {
                *count += 1.0;
            }
        }
    }
    let (n, lines) = (grains.len(), drawn.len());
    let mut xml = String::from(BEGINNING);
    fields(&mut xml, observation);
    let _ = writeln!(
        xml,
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{n}\" NumberOfLines=\"{lines}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">",
        points.len()
    );
    // A value for each point: of the grain, then of both ends of each piece.
    xml.push_str("<PointData>\n");
    let ends = |value: &dyn Fn(&Contact) -> f64| -> Vec<f64> {
        drawn.iter().flat_map(|p| [value(&contacts[p.contact]); 2]).collect()
    };
    let of_points =
        |grain: Vec<f64>, contact: Vec<f64>| grain.into_iter().chain(contact).collect::<Vec<f64>>();
    let radii: Vec<f64> = grains.iter().map(|grain| grain.radius).collect();
    array(&mut xml, "radius", 1, &of_points(radii.clone(), vec![0.0; 2 * lines]));
    array(&mut xml, "normal_force", 1, &of_points(vec![0.0; n], ends(&|contact| contact.normal_force)));
    let bodies: Vec<f64> = grains.iter().map(|grain| grain.body as f64).collect();
    if has_bodies {
        array(&mut xml, "body", 1, &of_points(bodies.clone(), vec![0.0; 2 * lines]));
    }
    xml.push_str("</PointData>\n<CellData>\n");
    let both = |grain: Vec<f64>, contact: &dyn Fn(&Contact) -> Vec<f64>| -> Vec<f64> {
        grain.into_iter().chain(drawn.iter().flat_map(|line| contact(&contacts[line.contact]))).collect()
    };
    let one = |value: f64| vec![value];
    array(&mut xml, "is_contact", 1, &both(vec![0.0; n], &|_| one(1.0)));
    array(&mut xml, "id", 1, &both(grains.iter().map(|grain| grain.id as f64).collect(), &|_| one(0.0)));
    array(&mut xml, "radius", 1, &both(radii.clone(), &|_| one(0.0)));
    array(&mut xml, "diameter", 1, &both(radii.iter().map(|r| 2.0 * r).collect(), &|_| one(0.0)));
    array(&mut xml, "coordination_number", 1, &both(degree, &|_| one(0.0)));
    let parts = observation.parts;
    if has_bodies {
        array(&mut xml, "body", 1, &both(bodies, &|_| one(0.0)));
    }
    if parts.has(Part::Masses) {
        array(&mut xml, "mass", 1, &both(grains.iter().map(|grain| grain.mass).collect(), &|_| one(0.0)));
    }
    if parts.has(Part::Masses) && has_bodies {
        let masses = grains.iter().map(|grain| grain.body_mass).collect();
        array(&mut xml, "body_mass", 1, &both(masses, &|_| one(0.0)));
    }
    let vectors: [(Part, &str, OfGrain); 4] = [
        (Part::Velocities, "velocity", |grain| grain.velocity),
        (Part::Spins, "angular_velocity", |grain| grain.spin),
        (Part::ResultantForces, "force_on_grain", |grain| grain.force),
        (Part::ResultantForces, "torque_on_grain", |grain| grain.torque),
    ];
    let is_written = |part: Part| parts.has(part) && !(has_bodies && part == Part::ResultantForces);
    for (_, name, value) in vectors.into_iter().filter(|(part, _, _)| is_written(*part)) {
        let values = grains.iter().flat_map(value).collect();
        array(&mut xml, name, 3, &both(values, &|_| vec![0.0; 3]));
    }
    if parts.has(Part::Contacts) {
        let id = |index: usize| one(grains.get(index).map_or(0.0, |grain| grain.id as f64));
        array(&mut xml, "first", 1, &both(vec![0.0; n], &|contact| id(contact.i)));
        array(&mut xml, "second", 1, &both(vec![0.0; n], &|contact| id(contact.j)));
    }
    if parts.has(Part::Overlaps) {
        array(&mut xml, "overlap", 1, &both(vec![0.0; n], &|contact| one(contact.approach)));
    }
    if parts.has(Part::NormalForces) {
        array(&mut xml, "normal_force", 1, &both(vec![0.0; n], &|contact| one(contact.normal_force)));
    }
    if parts.has(Part::TangentialForces) {
        array(
            &mut xml,
            "tangential_force",
            3,
            &both(vec![0.0; 3 * n], &|contact| contact.tangential_force.to_vec()),
        );
        let magnitude = |contact: &Contact| contact.force().iter().map(|x| x * x).sum::<f64>().sqrt();
        array(&mut xml, "force", 1, &both(vec![0.0; n], &|contact| one(magnitude(contact))));
    }
    if parts.has(Part::Sliding) {
        array(
            &mut xml,
            "sliding",
            1,
            &both(vec![0.0; n], &|contact| one(f64::from(u8::from(contact.sliding)))),
        );
    }
    xml.push_str("</CellData>\n<Points>\n");
    array(&mut xml, "Points", 3, &points.into_iter().flatten().collect::<Vec<f64>>());
    xml.push_str("</Points>\n");
    cells(&mut xml, "Verts", 0, n, 1);
    cells(&mut xml, "Lines", n, lines, 2);
    xml.push_str("</Piece>\n</PolyData>\n</VTKFile>\n");
    xml
}

/// Cell, corner, time and step.
pub(super) fn fields(xml: &mut String, observation: &ObservedAssembly) {
    let (assembly, parts) = (&observation.assembly, observation.parts);
    xml.push_str("<FieldData>\n");
    let mut field = |name: &str, values: &[f64]| {
        let numbers: Vec<String> = values.iter().map(|x| format!("{x:?}")).collect();
        let count = values.len();
        let _ = writeln!(
            xml,
            "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{count}\" NumberOfTuples=\"1\" format=\"ascii\">\n{}\n\
             </DataArray>",
            numbers.join(" ")
        );
    };
    if parts.has(Part::Cell) {
        let edges: Vec<f64> = (0..9).map(|n| assembly.cell[n % 3][n / 3]).collect();
        field("cell", &edges);
        field("origin", &observation.origin);
    }
    if parts.has(Part::Time) {
        field("TimeValue", &[assembly.time]);
    }
    field("step", &[assembly.step as f64]);
    xml.push_str("</FieldData>\n");
}

/// One array of numbers.
pub(super) fn array(xml: &mut String, name: &str, components: usize, values: &[f64]) {
    let _ = writeln!(
        xml,
        "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">"
    );
    for row in values.chunks(components.max(1)) {
        let row: Vec<String> = row.iter().map(|x| format!("{x:?}")).collect();
        xml.push_str(&row.join(" "));
        xml.push('\n');
    }
    xml.push_str("</DataArray>\n");
}

/// The topology of vertices or lines: `count` cells of `points` points each, from the point `first` on.
pub(super) fn cells(xml: &mut String, kind: &str, first: usize, count: usize, points: usize) {
    let integers = |xml: &mut String, name: &str, values: &mut dyn Iterator<Item = usize>| {
        let _ = writeln!(xml, "<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">");
        let values: Vec<String> = values.map(|value| value.to_string()).collect();
        xml.push_str(&values.join(" "));
        xml.push_str("\n</DataArray>\n");
    };
    let _ = writeln!(xml, "<{kind}>");
    integers(xml, "connectivity", &mut (first..first + points * count));
    integers(xml, "offsets", &mut (1..=count).map(|k| k * points));
    let _ = writeln!(xml, "</{kind}>");
}
