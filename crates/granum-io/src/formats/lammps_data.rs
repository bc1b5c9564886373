//! Data files of LAMMPS and LIGGGHTS (`read_data`, `write_data`) with `atom_style sphere` (`granular` in LIGGGHTS): grains with
//! diameter and density in a box that may be tilted or, in files since 2024, of any orientation (`avec`, `bvec`, `cvec`, `abc origin`), and
//! their velocities if the file has this section.
//!
//! The same data are written. Velocities are written as LAMMPS defines them, including the homogeneous part. LAMMPS requires the first
//! edge along x and the second in the plane of x and y, with small tilts: a cell of another shape is rotated together with its
//! contents, and its edges are replaced by equivalent ones.
//!
//! Grains of several pieces are molecules: each piece is an atom, and the section `Molecules` (`id molecule`) gives the body of each, as
//! LAMMPS reads it by
//!
//! ```text
//! fix molecules all property/atom mol ghost yes
//! read_data packing.data fix molecules NULL Molecules
//! ```
//!
//! Where grains are bonded the atoms are written as `atom_style bpm/sphere` has them, of which the molecule is the body, and the section `Bonds`
//! follows (`lammps_bonds.rs`). Atoms of one molecule that are bonded to each other move by themselves.
//!
//! The densities are such that the masses of the atoms of a molecule add up to the mass of the body, as `fix rigid` takes it; where pieces
//! overlap they are less than that of the material. The image flags belong to the cell that is written, so that the unwrapped pieces of a body
//! lie together. Read are this section, `atom_style bpm/sphere`, and `hybrid` where the comment of the section names its styles as `hybrid
//! sphere molecular`. Of files of granum the masses of a molecule add up; in others they are density times volume of each atom, of which the
//! body has the density and the volume of the union.

use std::io::Write;
use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Matrix, Sphere, Vector};
use granum_core::geometry::{apply, cross, determinant, invert, length, multiply};

use super::atoms::{Atom, atoms};
use super::file_bonds;
use super::lammps_bonds::{self, BondHeader};
use super::meanings::{self, Meanings};
use super::result::{Frame, FrameCell, ObservedAssembly, ReadOptions, ResultFormat};
use super::words::{Words, head_lines};
use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// The format.
pub struct LammpsData;

impl ResultFormat for LammpsData {
    fn name(&self) -> &'static str {
        "LAMMPS data"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["data", "lmp"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        // The first line is a comment, then numbers of atoms and bounds follow in any order.
        let lines = head_lines(head);
        let ends = |end: &[&str]| {
            lines.iter().skip(1).any(|line| {
                let words: Vec<&str> = line.split('#').next().unwrap_or("").split_whitespace().collect();
                words.len() > end.len() && words.ends_with(end) && words[0].parse::<f64>().is_ok()
            })
        };
        ends(&["atoms"]) && (ends(&["xlo", "xhi"]) || ends(&["avec"]))
    }
    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Vec<Frame>> {
        Ok(vec![read(&mut Words::open(path)?)?])
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
    fn holds_bonds(&self) -> bool {
        true
    }
    fn write(&self, path: &Path, observations: &[ObservedAssembly]) -> Result<()> {
        let [observation] = observations else {
            let message = format!("a LAMMPS data file holds one instant, not {}", observations.len());
            return Err(Error::content(path, message));
        };
        if let [missing, ..] = observation.parts.missing(&[Part::Cell, Part::Radii, Part::Masses])[..] {
            let message = format!("a LAMMPS data file needs {}, which the data lack", missing.name());
            return Err(Error::content(path, message));
        }
        write(path, observation)
    }
}

#[derive(Default)]
struct Header {
    atoms: usize,
    bonds: BondHeader,
    low: Vector,
    high: Vector,
    tilt: Vector,
    bounds: usize,
    /// Edges and corner of a box in any orientation, as far as they are read.
    general: [Option<Vector>; 4],
}

/// Ends of the lines of a box in any orientation: its edges and its corner (LAMMPS, Howto triclinic).
const GENERAL: [&str; 4] = ["avec", "bvec", "cvec", "origin"];

impl Header {
    /// The cell, if all of it is there.
    fn cell(&self) -> Option<FrameCell> {
        if let [Some(a), Some(b), Some(c), Some(origin)] = self.general {
            let edges = std::array::from_fn(|k| [a[k], b[k], c[k]]);
            return (determinant(&edges) != 0.0).then_some(FrameCell { origin, edges });
        }
        let mut cell = FrameCell::between(self.low, self.high);
        (cell.edges[0][1], cell.edges[0][2], cell.edges[1][2]) = (self.tilt[0], self.tilt[1], self.tilt[2]);
        (self.bounds == 3).then_some(cell)
    }
}

fn read(words: &mut Words) -> Result<Frame> {
    words.need("a comment")?;
    let mut header = Header::default();
    let title = words.line();
    let masses_add_up = title.starts_with(TITLE) && title.contains(ADD_UP);
    let mut frame = Frame { masses_add_up, ..Frame::default() };
    let mut meanings = Vec::new();
    let (mut velocities, mut bonds) = (false, false);
    while words.advance_to_text()? {
        let line = words.line().split('#').next().unwrap_or("").trim().to_string();
        let style = words.line().split('#').nth(1).map(|style| style.trim().to_string());
        match line.as_str() {
            "" => {}
            "Atoms" => {
                let layout = Layout::of_style(words, style.as_deref())?;
                read_atoms(words, header.atoms, &layout, &mut frame, &mut meanings)?;
            }
            "Molecules" => read_molecules(words, &frame.grains, &mut meanings)?,
            "Velocities" => {
                read_velocities(words, &mut frame.grains)?;
                velocities = true;
            }
            "Bonds" => {
                frame.bonds = lammps_bonds::read(words, &header.bonds)?;
                bonds = true;
            }
            "Masses" | "Pair Coeffs" | "Atom Type Labels" | "PairIJ Coeffs" | "Bond Coeffs"
            | "Bond Type Labels" => {
                skip_section(words)?;
            }
            _ if line.starts_with(|c: char| c.is_ascii_alphabetic()) => {
                let message = format!("the section {line} cannot be read: only spheres and their bonds can");
                return Err(words.error(message));
            }
            _ => read_header(words, &mut header)?,
        }
    }
    frame.cell = header.cell();
    if frame.grains.is_empty() || frame.cell.is_none() {
        let message = "is no LAMMPS data file: it needs xlo xhi, ylo yhi, zlo zhi, or avec, bvec, cvec and abc origin of a box with a volume, \
                       and the section Atoms";
        return Err(Error::content(Path::new(words.file()), message));
    }
    if let Some(count) = header.bonds.bonds.filter(|count| *count > 0 && !bonds) {
        let message =
            format!("announces {count} bonds, but has no section Bonds: it may have been cut short");
        return Err(Error::content(Path::new(words.file()), message));
    }
    meanings::note(&mut frame, &meanings, ("of the molecule", 0.0), "type");
    file_bonds::release_bonded_bodies(&mut frame);
    frame.knows(&[Part::Positions, Part::Radii, Part::Masses]);
    if velocities {
        frame.knows(&[Part::Velocities, Part::Spins]);
    }
    Ok(frame)
}

fn read_header(words: &Words, header: &mut Header) -> Result<()> {
    let text: Vec<&str> = words.words().take_while(|word| !word.starts_with('#')).collect();
    let ends = |end: &[&str]| text.len() > end.len() && text[text.len() - end.len()..] == *end;
    if ends(&["atoms"]) {
        header.atoms = words.count(0, "the number of atoms")?;
    } else if ends(&["bonds"]) {
        header.bonds.bonds = Some(words.count(0, "the number of bonds")?);
    } else if ends(&["bond", "types"]) {
        header.bonds.types = Some(words.count(0, "the number of bond types")?);
    } else if ends(&["xy", "xz", "yz"]) {
        header.tilt = words.vector(0, "a tilt")?;
    } else if let Some(k) = GENERAL.iter().position(|end| ends(&[end])) {
        header.general[k] = Some(words.vector(0, "a component of the box")?);
    } else if let Some(a) = [["xlo", "xhi"], ["ylo", "yhi"], ["zlo", "zhi"]].iter().position(|end| ends(end))
    {
        (header.low[a], header.high[a]) = (words.number(0, "a bound")?, words.number(1, "a bound")?);
        if header.high[a] <= header.low[a] {
            return Err(words.error("the upper bound must be above the lower one"));
        }
        header.bounds += 1;
    }
    Ok(())
}

/// Where the words of an atom stand.
struct Layout {
    columns: usize,
    kind: usize,
    diameter: usize,
    density: usize,
    position: usize,
    molecule: Option<usize>,
    /// What a row has, for messages.
    row: &'static str,
}

impl Layout {
    fn of_style(words: &Words, style: Option<&str>) -> Result<Layout> {
        let sphere = Layout {
            columns: 7,
            kind: 1,
            diameter: 2,
            density: 3,
            position: 4,
            molecule: None,
            row: "id type diameter density x y z",
        };
        let names: Vec<&str> = style.unwrap_or("sphere").split_whitespace().collect();
        let molecular = |name: &str| ["bond", "angle", "molecular"].contains(&name);
        match names[..] {
            ["sphere" | "granular"] => Ok(sphere),
            ["bpm/sphere"] => Ok(Layout {
                columns: 8,
                kind: 2,
                diameter: 3,
                density: 4,
                position: 5,
                molecule: Some(1),
                row: "id molecule type diameter density x y z",
            }),
            ["hybrid", "sphere", other] if molecular(other) => Ok(Layout {
                columns: 8,
                position: 2,
                diameter: 5,
                density: 6,
                molecule: Some(7),
                row: "id type x y z diameter density molecule",
                ..sphere
            }),
            ["hybrid", other, "sphere"] if molecular(other) => Ok(Layout {
                columns: 8,
                position: 2,
                diameter: 6,
                density: 7,
                molecule: Some(5),
                row: "id type x y z molecule diameter density",
                ..sphere
            }),
            ["hybrid", ..] => Err(words.error(
                "atom_style hybrid does not say the order of its columns; write behind Atoms # the styles as they were given, as hybrid sphere \
                 molecular",
            )),
            _ => Err(words.error(format!(
                "atom_style {} cannot be read; spheres need atom_style sphere",
                names.join(" ")
            ))),
        }
    }
}

/// Rows as `id type diameter density x y z [ix iy iz]`. The image flags are passed over: the cell repeats all places.
fn read_atoms(
    words: &mut Words,
    count: usize,
    layout: &Layout,
    into: &mut Frame,
    meanings: &mut Vec<Meanings>,
) -> Result<()> {
    let end = into.grains.len() + count;
    into.grains.reserve(count.min(1 << 20));
    meanings.reserve(count.min(1 << 20));
    while into.grains.len() < end {
        words.need("an atom")?;
        let length = words.words().take_while(|word| !word.starts_with('#')).count();
        if length == 0 {
            continue;
        }
        let columns = layout.columns;
        if length != columns && length != columns + 3 {
            let message = format!(
                "the row has {length} words; a sphere has {}, {columns} or {} in all",
                layout.row,
                columns + 3
            );
            return Err(words.error(message));
        }
        let radius = 0.5 * words.positive(layout.diameter, "diameter")?;
        let density = words.positive(layout.density, "density")?;
        into.lines.push(words.line_number());
        let body = layout.molecule.map(|at| words.whole(at, "molecule")).transpose()?;
        let kind = Some(words.word(layout.kind).to_string());
        meanings.push(Meanings { kind, body: body.map(|body| body as f64) });
        into.grains.push(Sphere {
            id: words.whole(0, "id")?,
            position: words.vector(layout.position, "a coordinate")?,
            radius,
            mass: density * 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius,
            ..Sphere::default()
        });
    }
    Ok(())
}

/// Rows `id molecule`, as `fix property/atom` reads them.
fn read_molecules(words: &mut Words, grains: &[Sphere], meanings: &mut [Meanings]) -> Result<()> {
    of_each_atom(words, grains, "a molecule", |words, at| {
        let molecule = words.whole(1, "molecule")? as f64;
        if let Some(meaning) = meanings.get_mut(at) {
            meaning.body = Some(molecule);
        }
        Ok(())
    })
}

/// Calls `read` with the row of each atom of a section and the place of the atom among `grains`.
fn of_each_atom(
    words: &mut Words,
    grains: &[Sphere],
    what: &str,
    mut read: impl FnMut(&Words, usize) -> Result<()>,
) -> Result<()> {
    let mut places: Vec<(u64, usize)> = grains.iter().enumerate().map(|(k, grain)| (grain.id, k)).collect();
    places.sort_unstable();
    let mut left = grains.len();
    while left > 0 {
        words.need(what)?;
        if words.len() == 0 {
            continue;
        }
        let id = words.whole(0, "id")?;
        let Ok(at) = places.binary_search_by_key(&id, |place| place.0) else {
            return Err(words.word_error(0, format!("atom {id} has {what} but no place")));
        };
        read(words, places[at].1)?;
        left -= 1;
    }
    Ok(())
}

/// Rows `id vx vy vz wx wy wz`.
fn read_velocities(words: &mut Words, grains: &mut [Sphere]) -> Result<()> {
    let mut motion = vec![([0.0; 3], [0.0; 3]); grains.len()];
    of_each_atom(words, grains, "a velocity", |words, at| {
        motion[at] = (words.vector(1, "a velocity")?, words.vector(4, "a spin")?);
        Ok(())
    })?;
    for (grain, (velocity, spin)) in grains.iter_mut().zip(motion) {
        (grain.velocity, grain.spin) = (velocity, spin);
    }
    Ok(())
}

/// A section that says nothing of grains: to the next blank line after its rows.
fn skip_section(words: &mut Words) -> Result<()> {
    words.need("a section")?;
    while words.advance()? && words.len() > 0 {}
    Ok(())
}

/// The first line of files that granum writes, and what follows it where grains have several pieces.
const TITLE: &str = "grains written by granum";
const ADD_UP: &str = "; the masses of the atoms of a molecule add up to that of its body";

fn write(path: &Path, observation: &ObservedAssembly) -> Result<()> {
    let assembly = &observation.assembly;
    let (turn, edges) = restricted(&assembly.cell);
    let origin = apply(&turn, observation.origin);
    let (atoms, has_bodies) = (atoms(assembly), !assembly.all_spheres());
    let bonds = observation.bonded_pairs();
    lammps_bonds::check(path, &bonds)?;
    let inverse = invert(&edges);
    write_atomically(path, |file| {
        writeln!(file, "{TITLE}{}\n\n{} atoms", if has_bodies { ADD_UP } else { "" }, atoms.len())?;
        writeln!(file, "{} atom types", assembly.materials.len().max(1))?;
        if !bonds.is_empty() {
            lammps_bonds::write_header(file, &bonds)?;
        }
        writeln!(file)?;
        for (a, axis) in ["x", "y", "z"].into_iter().enumerate() {
            writeln!(file, "{:?} {:?} {axis}lo {axis}hi", origin[a], origin[a] + edges[a][a])?;
        }
        if [edges[0][1], edges[0][2], edges[1][2]] != [0.0; 3] {
            writeln!(file, "{:?} {:?} {:?} xy xz yz", edges[0][1], edges[0][2], edges[1][2])?;
        }
        writeln!(file, "\nAtoms # {}\n", if bonds.is_empty() { "sphere" } else { "bpm/sphere" })?;
        for atom in &atoms {
            let (place, flags) = match has_bodies {
                true => wrapped(&edges, &inverse, &apply(&turn, atom.unwrapped())),
                false => (apply(&turn, atom.position), [0; 3]),
            };
            let [x, y, z]: Vector = std::array::from_fn(|a| origin[a] + place[a]);
            let Atom { id, material, radius, .. } = atom;
            let (kind, diameter, density) = (material + 1, 2.0 * radius, atom.density());
            write!(file, "{id} ")?;
            if !bonds.is_empty() {
                write!(file, "{} ", atom.body)?;
            }
            write!(file, "{kind} {diameter:?} {density:?} {x:?} {y:?} {z:?}")?;
            match flags {
                [ix, iy, iz] if has_bodies => writeln!(file, " {ix} {iy} {iz}")?,
                _ => writeln!(file)?,
            }
        }
        if observation.parts.has(Part::Velocities) {
            writeln!(file, "\nVelocities\n")?;
            for atom in &atoms {
                let [vx, vy, vz] = apply(&turn, atom.whole_velocity(assembly));
                let [wx, wy, wz] = apply(&turn, atom.spin);
                writeln!(file, "{} {vx:?} {vy:?} {vz:?} {wx:?} {wy:?} {wz:?}", atom.id)?;
            }
        }
        if !bonds.is_empty() {
            lammps_bonds::write(file, &bonds, &atoms)?;
        } else if has_bodies {
            writeln!(file, "\nMolecules\n")?;
            for atom in &atoms {
                writeln!(file, "{} {}", atom.id, atom.body)?;
            }
        }
        Ok(())
    })
}

/// A place moved into a cell, and by how many of its edges.
pub(super) fn wrapped(edges: &Matrix, inverse: &Matrix, place: &Vector) -> (Vector, [i64; 3]) {
    let shift = apply(inverse, *place).map(f64::floor);
    let back = apply(edges, shift);
    (std::array::from_fn(|a| place[a] - back[a]), shift.map(|n| n as i64))
}

/// The rotation by which the first edge of a cell comes to lie along x and the second into the plane of x and y, and the edges
/// after it, with tilts of at most half an edge. Both are exact for a cell that lies so already.
pub fn restricted(cell: &Matrix) -> (Matrix, Matrix) {
    let column = |k: usize| [cell[0][k], cell[1][k], cell[2][k]];
    let upper = cell[1][0] == 0.0 && cell[2][0] == 0.0 && cell[2][1] == 0.0;
    let turn = if upper {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    } else {
        let e1 = unit(column(0));
        let e3 = unit(cross(&e1, &column(1)));
        [e1, cross(&e3, &e1), e3]
    };
    let mut edges = if upper { *cell } else { multiply(&turn, cell) };
    (edges[1][0], edges[2][0], edges[2][1]) = (0.0, 0.0, 0.0);
    for (edge, by) in [(2, 1), (1, 0), (2, 0)] {
        let times = libm::round(edges[by][edge] / edges[by][by]);
        if times != 0.0 {
            for row in &mut edges {
                row[edge] -= times * row[by];
            }
        }
    }
    (turn, edges)
}

fn unit(v: Vector) -> Vector {
    let length = length(&v);
    v.map(|x| x / length)
}
