//! What the points, cells and arrays of a VTK XML file mean: grains, contacts, a periodic cell.

use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Sphere, Vector};
use granum_core::geometry::determinant;

use super::document::{Array, Document, GridCell, Shape};
use crate::error::{Error, Result};
use crate::formats::meanings::{self, Meanings};
use crate::formats::result::{FileContact, Frame, FrameCell};

/// The frame that a document holds.
pub(super) fn frame(path: &Path, document: &Document) -> Result<Frame> {
    let lines: Vec<usize> = cells_of(document, Shape::Line);
    let mut frame = Frame::default();
    if Table::new(&document.point_data, None).has(&RADII) {
        frame = grains(path, document)?;
    }
    let of_lines = Table::new(&document.cell_data, Some(&lines));
    // A file of grains alone has the arrays of contacts as well, without rows.
    if of_lines.has(&FIRST) && of_lines.has(&SECOND) && !lines.is_empty() {
        frame.contacts = Some(pieces(path, document, &lines)?);
    } else if of_lines.has(&["forceN"]) {
        (frame.contacts, frame.centres) = recorded(path, document, &lines)?;
    }
    frame.cell =
        of_fields(path, document, &mut frame)?.or(hexahedron(path, document)?).or(bounds(path, document)?);
    if frame.grains.is_empty() && frame.contacts.is_none() && frame.cell.is_none() {
        let message = "holds neither grains (points with the array radii or radius), nor contacts (lines with the array forceN), nor a \
                       cell (one hexahedron)";
        return Err(Error::content(path, message));
    }
    Ok(frame)
}

/// Ids of the grains of a contact, in granum's files and in those of LIGGGHTS.
const FIRST: [&str; 2] = ["first", "id1"];
const SECOND: [&str; 2] = ["second", "id2"];

/// Names of radii; a diameter is halved.
const RADII: [&str; 4] = ["radii", "radius", "Radius", "diameter"];

fn cells_of(document: &Document, shape: Shape) -> Vec<usize> {
    let fits = |(_, cell): &(usize, &GridCell)| cell.shape == shape;
    document.cells.iter().enumerate().filter(fits).map(|(k, _)| k).collect()
}

/// Arrays, and the rows of them that are wanted; all without a list.
struct Table<'a> {
    arrays: &'a [Array],
    rows: Option<&'a [usize]>,
}

impl<'a> Table<'a> {
    fn new(arrays: &'a [Array], rows: Option<&'a [usize]>) -> Table<'a> {
        Table { arrays, rows }
    }

    fn array(&self, names: &[&str]) -> Option<&'a Array> {
        names.iter().find_map(|name| self.arrays.iter().find(|array| array.name == *name))
    }

    fn has(&self, names: &[&str]) -> bool {
        self.array(names).is_some()
    }

    /// The wanted rows of an array of `N` components; none if it is not there.
    fn read<const N: usize>(
        &self,
        path: &Path,
        names: &[&str],
        count: usize,
    ) -> Result<Option<Vec<[f64; N]>>> {
        let Some(array) = self.array(names) else { return Ok(None) };
        let wrong = |what: String| Err(Error::content(path, format!("the array {} {what}", array.name)));
        if array.components != N {
            return wrong(format!("has {} components; {N} are needed", array.components));
        }
        let all: Vec<[f64; N]> =
            array.values.chunks_exact(N).map(|row| std::array::from_fn(|a| row[a])).collect();
        let rows: Vec<[f64; N]> = match self.rows {
            Some(rows) => rows.iter().filter_map(|row| all.get(*row).copied()).collect(),
            None => all,
        };
        if rows.len() != count {
            return wrong(format!("has {} rows; {count} are needed", rows.len()));
        }
        if let Some(k) = rows.iter().position(|row| row.iter().any(|x| !x.is_finite())) {
            return wrong(format!("has no finite number in row {}", k + 1));
        }
        Ok(Some(rows))
    }
}

/// The grains: the vertices, or all points where there are none.
fn grains(path: &Path, document: &Document) -> Result<Frame> {
    let vertices = cells_of(document, Shape::Vertex);
    let points: Vec<usize> = match vertices.len() {
        0 => (0..document.points.len()).collect(),
        _ => vertices.iter().flat_map(|k| document.cells[*k].points.iter().copied()).collect(),
    };
    let count = points.len();
    // Of points if they are there, as YADE has them; granum's files have those of vertices.
    let (of_points, of_vertices) =
        (Table::new(&document.point_data, Some(&points)), Table::new(&document.cell_data, Some(&vertices)));
    let scalars = |names: &[&str]| -> Result<Option<Vec<f64>>> {
        let table = if of_points.has(names) { &of_points } else { &of_vertices };
        Ok(table.read::<1>(path, names, count)?.map(|rows| rows.into_iter().map(|[x]| x).collect()))
    };
    let vectors = |names: &[&str]| -> Result<Option<Vec<Vector>>> {
        let table = if of_points.has(names) { &of_points } else { &of_vertices };
        table.read::<3>(path, names, count)
    };
    let radii = scalars(&RADII)?.unwrap_or_default();
    let half = if of_points.has(&RADII[..3]) { 1.0 } else { 0.5 };
    let ids = scalars(&["id"])?;
    let mut frame = Frame::default();
    for (k, point) in points.iter().enumerate() {
        let id = ids.as_ref().map_or(k as f64, |ids| ids[k]);
        let (position, radius) = (document.points[*point], half * radii[k]);
        if !(id >= 0.0 && id.fract() == 0.0) {
            return Err(Error::content(path, format!("grain {}: id = {id} is no whole number", k + 1)));
        }
        if !position.iter().all(|x| x.is_finite()) || radius <= 0.0 {
            let message =
                format!("grain {id}: its place {position:?} must be finite and its radius {radius} positive");
            return Err(Error::content(path, message));
        }
        frame.grains.push(Sphere { id: id as u64, position, radius, ..Sphere::default() });
    }
    frame.knows(&[Part::Positions, Part::Radii]);
    let (clumps, molecules) =
        (scalars(&["clumpId"])?, scalars(&["molecule", "mol", "id_multisphere", "body"])?);
    frame.masses_add_up = of_points.has(&["body_mass"]) || of_vertices.has(&["body_mass"]);
    let kinds = scalars(&["type", "materialId"])?;
    let value = |values: &Option<Vec<f64>>, k: usize| values.as_ref().map(|values| values[k]);
    let meaning = |k: usize| Meanings {
        body: value(&clumps, k).or(value(&molecules, k)),
        kind: value(&kinds, k).map(|kind| kind.to_string()),
    };
    let meanings: Vec<Meanings> = (0..count).map(meaning).collect();
    let of_bodies = if clumps.is_some() { ("clumpId", -1.0) } else { ("of the molecule", 0.0) };
    meanings::note(&mut frame, &meanings, of_bodies, "of the type");
    if let Some(masses) = scalars(&["mass"])?.filter(|masses| masses.iter().all(|mass| *mass > 0.0)) {
        frame.grains.iter_mut().zip(masses).for_each(|(grain, mass)| grain.mass = mass);
        frame.knows(&[Part::Masses]);
    }
    for (names, part) in [
        (["linVelVec", "v", "Velocity", "velocity"], Some(Part::Velocities)),
        (["angVelVec", "omega", "AngularVelocity", "angular_velocity"], Some(Part::Spins)),
        (["forceVec", "f", "Force", "force_on_grain"], Some(Part::ResultantForces)),
        (["torqueVec", "tq", "Torque", "torque_on_grain"], None),
    ] {
        let Some(values) = vectors(&names)? else { continue };
        for (grain, value) in frame.grains.iter_mut().zip(values) {
            match part {
                Some(Part::Velocities) => grain.velocity = value,
                Some(Part::Spins) => grain.spin = value,
                Some(_) => grain.force = value,
                None => grain.torque = value,
            }
        }
        part.into_iter().for_each(|part| frame.knows(&[part]));
    }
    Ok(frame)
}

/// The contacts of files that name their grains. In granum's own each is one or several lines, since it is cut at the faces of the
/// cell; in those of LIGGGHTS (`dump local/gran/vtk`) a line, with the force on the first grain.
fn pieces(path: &Path, document: &Document, lines: &[usize]) -> Result<Vec<FileContact>> {
    let table = Table::new(&document.cell_data, Some(lines));
    let scalars = |names: &[&str]| table.read::<1>(path, names, lines.len());
    let vectors = |name: &str| match table.array(&[name]).is_some_and(|array| array.components == 3) {
        true => table.read::<3>(path, &[name], lines.len()),
        false => Ok(None),
    };
    let (first, second) = (scalars(&FIRST)?.unwrap_or_default(), scalars(&SECOND)?.unwrap_or_default());
    let (normal_force, approach) = (scalars(&["normal_force"])?, scalars(&["overlap", "delta"])?);
    let (tangential, force) = (vectors("tangential_force")?, vectors("force")?);
    let is_own = table.has(&FIRST[..1]);
    let mut pairs: Vec<FileContact> = Vec::new();
    for (k, line) in lines.iter().enumerate() {
        let [from, to] = ends(path, &document.cells[*line])?.map(|point| document.points[point]);
        let step: Vector = std::array::from_fn(|a| to[a] - from[a]);
        let ids = (first[k][0] as u64, second[k][0] as u64);
        if let Some(last) = pairs.last_mut().filter(|last| is_own && (last.first, last.second) == ids) {
            last.branch = last.branch.map(|branch| std::array::from_fn(|a| branch[a] + step[a]));
            continue;
        }
        pairs.push(FileContact {
            first: ids.0,
            second: ids.1,
            // Lines of LIGGGHTS may lead to any image of a grain.
            branch: is_own.then_some(step),
            force: force.as_ref().map(|values| values[k]),
            normal_force: normal_force.as_ref().map(|values| values[k][0]),
            tangential_force: tangential.as_ref().map(|values| values[k]),
            approach: approach.as_ref().map(|values| values[k][0]),
            ..FileContact::default()
        });
    }
    Ok(pairs)
}

fn ends(path: &Path, line: &GridCell) -> Result<[usize; 2]> {
    let wrong = || Error::content(path, format!("a line has {} points; two are needed", line.points.len()));
    <[usize; 2]>::try_from(line.points.as_slice()).map_err(|_| wrong())
}

/// The contacts of YADE's recorder `intr` and the centres that they name.
fn recorded(
    path: &Path,
    document: &Document,
    lines: &[usize],
) -> Result<(Option<Vec<FileContact>>, Vec<Vector>)> {
    // Rows may outnumber the lines, so that they are not taken by line.
    let table = Table::new(&document.cell_data, None);
    let rows = table.array(&["forceN"]).map_or(0, |array| array.values.len());
    let normal = table.read::<1>(path, &["forceN"], rows)?.unwrap_or_default();
    let tangential = table.read::<3>(path, &["absForceT"], rows)?;
    let row = |k: usize| (normal[k], tangential.as_ref().map(|values| values[k]));
    let mut named: Vec<[usize; 2]> = Vec::new();
    let mut of_row: Vec<usize> = Vec::new();
    let mut inside = lines.iter().map(|line| ends(path, &document.cells[*line]));
    let bodies = document.points.len().checked_sub(rows.saturating_sub(lines.len()));
    let mut across = bodies.unwrap_or(0);
    let mut k = 0;
    while k < rows {
        // A doubled row is a contact across a face: its centres are among the points after the bodies.
        let doubled = rows > lines.len() && k + 1 < rows && row(k) == row(k + 1);
        if doubled {
            named.push([across, across + 1]);
            across += 2;
        } else if let Some(ends) = inside.next() {
            named.push(ends?);
        }
        of_row.push(k);
        k += 1 + usize::from(doubled);
    }
    if bodies.is_none()
        || across > document.points.len()
        || named.len() != of_row.len()
        || inside.next().is_some()
    {
        let message = format!(
            "has {rows} rows of forces for {} lines, and which belong together cannot be found",
            lines.len()
        );
        return Err(Error::content(path, message));
    }
    let frictionless = tangential.as_ref().is_some_and(|values| values.iter().flatten().all(|x| *x == 0.0));
    let pair = |(ends, k): ([usize; 2], usize)| FileContact {
        first: ends[0] as u64,
        second: ends[1] as u64,
        normal_force: Some(normal[k][0]),
        tangential_force: frictionless.then_some([0.0; 3]),
        ..FileContact::default()
    };
    let pairs = named.into_iter().zip(of_row).map(pair).collect();
    Ok((Some(pairs), document.points.clone()))
}

/// Cell, time and step where granum wrote them.
fn of_fields(path: &Path, document: &Document, frame: &mut Frame) -> Result<Option<FrameCell>> {
    let table = Table::new(&document.field_data, None);
    frame.time = table.read::<1>(path, &["TimeValue"], 1)?.map(|rows| rows[0][0]);
    frame.step = table.read::<1>(path, &["step"], 1)?.map(|rows| rows[0][0] as u64);
    let Some(edges) = table.read::<9>(path, &["cell"], 1)? else { return Ok(None) };
    let origin = table.read::<3>(path, &["origin"], 1)?.map_or([0.0; 3], |rows| rows[0]);
    Ok(Some(FrameCell {
        origin,
        edges: std::array::from_fn(|a| std::array::from_fn(|k| edges[0][3 * k + a])),
    }))
}

/// The box of a rectilinear grid of one cell, as LIGGGHTS writes it beside its grains.
fn bounds(path: &Path, document: &Document) -> Result<Option<FrameCell>> {
    let [x, y, z] = &document.coordinates[..] else { return Ok(None) };
    let wrong = || {
        Error::content(
            path,
            "is a grid that is no box: each axis must have two coordinates, the second above the first",
        )
    };
    let of = |axis: &Array| match axis.values[..] {
        [low, high] if low < high && low.is_finite() && high.is_finite() => Ok([low, high]),
        _ => Err(wrong()),
    };
    let axes = [of(x)?, of(y)?, of(z)?];
    Ok(Some(FrameCell::between(axes.map(|axis| axis[0]), axes.map(|axis| axis[1]))))
}

/// The cell as YADE records it, its corners in the order of its legacy files: the fifth is its own, the edges lead to the eighth,
/// sixth and first.
fn hexahedron(path: &Path, document: &Document) -> Result<Option<FrameCell>> {
    let found = cells_of(document, Shape::Hexahedron);
    let [only] = found[..] else { return Ok(None) };
    let corners = &document.cells[only].points;
    if corners.len() != 8 {
        return Err(Error::content(
            path,
            format!("the hexahedron has {} corners instead of 8", corners.len()),
        ));
    }
    let corner = |k: usize| document.points[corners[k]];
    let origin = corner(4);
    let edge = |to: usize| -> Vector { std::array::from_fn(|a| corner(to)[a] - origin[a]) };
    let (x, y, z) = (edge(7), edge(5), edge(0));
    let cell = FrameCell { origin, edges: std::array::from_fn(|a| [x[a], y[a], z[a]]) };
    let far: Vector = std::array::from_fn(|a| x[a] + y[a] + z[a]);
    let size = far.iter().map(|x| x.abs()).sum::<f64>();
    let is_skewed_box = (0..3).all(|a| (far[a] - edge(2)[a]).abs() <= 1e-5 * size);
    if determinant(&cell.edges) > 0.0 && is_skewed_box {
        return Ok(Some(cell));
    }
    Err(Error::content(path, "has a hexahedron that is no cell as the recorder pericell of YADE writes it"))
}
