//! Extended XYZ, as OVITO, ASE and freud read it: for each instant the number of grains, a comment line with `Lattice="ax ay az bx by
//! bz cx cy cz"`, `Origin="x y z"`, `Time=` and `Properties=name:type:columns:...`, then one line per grain.
//!
//! The properties `id`, `pos`, `radius` (or `diameter`), `mass` (or `masses`), `velo` (or `velocities`, `vel`), `angular_velocity` and
//! `force` (or `forces`) are read; only `pos` is required. Those that are known are written, with the names of OVITO. The species is
//! the material of a grain, by which OVITO chooses colours; without named materials it is `X`, since ASE refuses names that are not
//! chemical elements.
//!
//! Of grains of several pieces each piece is a line, and there are further properties: `molecule`, the id of the body (OVITO: Molecule
//! Identifier), by which pieces are put together again; `orientation`, that of the body, in the order x, y, z, w of OVITO; and `body_mass`, to
//! which the masses of its pieces add up. Forces are not written then, since they act on bodies.

use std::io::Write;
use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Sphere, Vector};

use super::atoms::{Atom, atoms};
use super::meanings::{self, Meanings};
use super::quaternion::w_last;
use super::result::{Frame, FrameCell, ObservedAssembly, ReadOptions, ResultFormat};
use super::words::{Words, head_lines};
use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// The format.
pub struct ExtendedXyz;

impl ResultFormat for ExtendedXyz {
    fn name(&self) -> &'static str {
        "extended XYZ"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["xyz", "extxyz"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        let lines = head_lines(head);
        matches!(&lines[..], [count, comment, ..] if count.parse::<u64>().is_ok() && comment.contains("Properties="))
    }
    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Vec<Frame>> {
        let mut words = Words::open(path)?;
        let mut frames = Vec::new();
        while words.advance_to_text()? {
            let count = words.count(0, "the number of grains")?;
            words.need("the comment line")?;
            frames.push(frame(&mut words, count)?);
        }
        if frames.is_empty() {
            return Err(Error::content(path, "has no grains"));
        }
        Ok(frames)
    }
    fn is_written(&self) -> bool {
        true
    }
    fn holds_bodies(&self) -> bool {
        true
    }
    fn write(&self, path: &Path, observations: &[ObservedAssembly]) -> Result<()> {
        write_atomically(path, |file| {
            for observation in observations {
                write_frame(file, observation)?;
            }
            Ok(())
        })
    }
}

/// The values of `key=value` and `key="several words"` in a comment line.
fn value<'a>(comment: &'a str, key: &str) -> Option<&'a str> {
    let lower = comment.to_ascii_lowercase();
    let wanted = format!("{}=", key.to_ascii_lowercase());
    let starts = lower.match_indices(&wanted).map(|(at, _)| at);
    let start = starts.into_iter().find(|at| *at == 0 || comment.as_bytes()[at - 1].is_ascii_whitespace())?
        + wanted.len();
    let rest = &comment[start..];
    match rest.strip_prefix('"') {
        Some(quoted) => quoted.split('"').next(),
        None => rest.split_whitespace().next(),
    }
}

fn numbers<const N: usize>(words: &Words, key: &str, text: &str) -> Result<[f64; N]> {
    let found: Vec<f64> = text.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
    <[f64; N]>::try_from(found)
        .map_err(|found| words.error(format!("{key}=\"{text}\" has {} numbers; {N} are needed", found.len())))
}

fn frame(words: &mut Words, count: usize) -> Result<Frame> {
    let comment = words.line().to_string();
    let mut frame = Frame::default();
    let periodic = value(&comment, "pbc").is_none_or(|pbc| !pbc.to_ascii_uppercase().contains('F'));
    if let Some(text) = value(&comment, "Lattice").filter(|_| periodic) {
        let n: [f64; 9] = numbers(words, "Lattice", text)?;
        let origin = value(&comment, "Origin").map_or(Ok([0.0; 3]), |text| numbers(words, "Origin", text))?;
        frame.cell = Some(FrameCell { origin, edges: std::array::from_fn(|a| [n[a], n[3 + a], n[6 + a]]) });
    }
    if let Some(text) = value(&comment, "Time") {
        frame.time = Some(numbers::<1>(words, "Time", text)?[0]);
    }
    if let Some(text) = value(&comment, "Step").or(value(&comment, "Timestep")) {
        frame.step = Some(numbers::<1>(words, "Step", text)?[0] as u64);
    }
    let layout =
        Layout::from_properties(words, value(&comment, "Properties").unwrap_or("species:S:1:pos:R:3"))?;
    let mut known = vec![Part::Positions];
    let parts = [Part::Radii, Part::Masses, Part::Velocities, Part::Spins, Part::ResultantForces];
    let places =
        [layout.radius.map(|found| found.0), layout.mass, layout.velocity, layout.spin, layout.force];
    known.extend(places.into_iter().zip(parts).filter_map(|(place, part)| place.map(|_| part)));
    frame.knows(&known);
    frame.masses_add_up = layout.adds_up;
    let mut meanings = Vec::with_capacity(count.min(1 << 20));
    for number in 0..count {
        words.need("a grain")?;
        if words.len() != layout.columns {
            let message =
                format!("the grain has {} columns; Properties gives {}", words.len(), layout.columns);
            return Err(words.error(message));
        }
        frame.grains.push(layout.grain(words, number as u64 + 1)?);
        frame.lines.push(words.line_number());
        let kind = layout.species.map(|at| words.word(at).to_string());
        meanings.push(Meanings { body: layout.body.and_then(|at| words.word(at).parse().ok()), kind });
    }
    meanings::note(&mut frame, &meanings, ("of the molecule", 0.0), "species");
    Ok(frame)
}

/// Where the properties stand.
struct Layout {
    columns: usize,
    id: Option<usize>,
    position: usize,
    radius: Option<(usize, f64)>,
    mass: Option<usize>,
    velocity: Option<usize>,
    spin: Option<usize>,
    force: Option<usize>,
    species: Option<usize>,
    body: Option<usize>,
    /// True if the masses of a body add up to its own.
    adds_up: bool,
}

impl Layout {
    fn from_properties(words: &Words, text: &str) -> Result<Layout> {
        let fields: Vec<&str> = text.split(':').collect();
        let mut places: Vec<(String, usize, usize)> = Vec::new();
        let mut columns = 0;
        for field in fields.chunks(3) {
            let width =
                field.get(2).and_then(|width| width.parse::<usize>().ok()).filter(|width| *width < 100);
            let Some(width) = width else {
                return Err(words.error(format!("Properties={text} is not name:type:columns:...")));
            };
            places.push((field[0].to_ascii_lowercase(), columns, width));
            columns += width;
        }
        let place = |names: &[&str], width: usize| {
            let fits =
                |known: &&(String, usize, usize)| names.contains(&known.0.as_str()) && known.2 == width;
            places.iter().find(fits).map(|found| found.1)
        };
        let Some(position) = place(&["pos", "positions", "position"], 3) else {
            return Err(words.error("Properties has no pos:R:3"));
        };
        let radius = place(&["radius", "radii"], 1).map(|at| (at, 1.0));
        Ok(Layout {
            columns,
            id: place(&["id"], 1),
            position,
            radius: radius.or_else(|| place(&["diameter"], 1).map(|at| (at, 0.5))),
            mass: place(&["mass", "masses"], 1),
            velocity: place(&["velo", "vel", "velocities", "velocity"], 3),
            spin: place(&["angular_velocity", "omega"], 3),
            force: place(&["force", "forces"], 3),
            species: place(&["species", "type"], 1),
            adds_up: place(&["body_mass"], 1).is_some(),
            body: place(&["molecule", "molecule_identifier", "mol", "body"], 1),
        })
    }

    fn grain(&self, words: &Words, number: u64) -> Result<Sphere> {
        let vector = |at: Option<usize>, what: &str| at.map_or(Ok([0.0; 3]), |at| words.vector(at, what));
        Ok(Sphere {
            id: self.id.map_or(Ok(number), |at| words.whole(at, "id"))?,
            position: words.vector(self.position, "a coordinate")?,
            radius: self
                .radius
                .map_or(Ok(0.0), |(at, factor)| words.positive(at, "radius").map(|r| factor * r))?,
            mass: self.mass.map_or(Ok(0.0), |at| words.number(at, "mass"))?,
            velocity: vector(self.velocity, "a velocity")?,
            spin: vector(self.spin, "an angular velocity")?,
            force: vector(self.force, "a force")?,
            ..Sphere::default()
        })
    }
}

/// A property with the part of an assembly that it needs.
type Property = (Part, &'static str, fn(&Atom) -> Vec<f64>);

const PROPERTIES: [Property; 4] = [
    (Part::Radii, ":radius:R:1", |atom| vec![atom.radius]),
    (Part::Masses, ":mass:R:1", |atom| vec![atom.mass]),
    (Part::Velocities, ":velo:R:3", |atom| atom.velocity.to_vec()),
    (Part::Spins, ":angular_velocity:R:3", |atom| atom.spin.to_vec()),
];
const OF_SPHERES: [Property; 1] = [(Part::ResultantForces, ":force:R:3", |atom| atom.force.to_vec())];
const OF_BODIES: [Property; 2] = [
    (Part::Positions, ":orientation:R:4", |atom| w_last(&atom.orientation).to_vec()),
    (Part::Masses, ":body_mass:R:1", |atom| vec![atom.body_mass]),
];

fn write_frame(file: &mut impl Write, observation: &ObservedAssembly) -> std::io::Result<()> {
    let (assembly, parts) = (&observation.assembly, observation.parts);
    let (atoms, has_bodies) = (atoms(assembly), !assembly.all_spheres());
    let further: &[Property] = if has_bodies { &OF_BODIES } else { &OF_SPHERES };
    let columns: Vec<&Property> =
        PROPERTIES.iter().chain(further).filter(|(part, _, _)| parts.has(*part)).collect();
    let mut properties = String::from("species:S:1:id:I:1:pos:R:3");
    properties.push_str(if has_bodies { ":molecule:I:1" } else { "" });
    columns.iter().for_each(|(_, text, _)| properties.push_str(text));
    writeln!(file, "{}", atoms.len())?;
    if parts.has(Part::Cell) {
        let h = &assembly.cell;
        let edges: Vec<String> = (0..9).map(|n| format!("{:?}", h[n % 3][n / 3])).collect();
        let origin = vector_text(&observation.origin);
        write!(file, "Lattice=\"{}\" Origin=\"{origin}\" pbc=\"T T T\" ", edges.join(" "))?;
    } else {
        write!(file, "pbc=\"F F F\" ")?;
    }
    if parts.has(Part::Time) {
        write!(file, "Time={:?} ", assembly.time)?;
    }
    writeln!(file, "Properties={properties}")?;
    for atom in &atoms {
        let place: Vector = std::array::from_fn(|a| observation.origin[a] + atom.position[a]);
        let species = match assembly.materials.get(atom.material as usize) {
            Some(name) => name.as_str(),
            // ASE takes the species for a chemical element; X is none.
            None => "X",
        };
        write!(file, "{species} {} {}", atom.id, vector_text(&place))?;
        if has_bodies {
            write!(file, " {}", atom.body)?;
        }
        for (_, _, values) in &columns {
            values(atom).iter().try_for_each(|value| write!(file, " {value:?}"))?;
        }
        writeln!(file)?;
    }
    Ok(())
}

fn vector_text(v: &Vector) -> String {
    v.map(|x| format!("{x:?}")).join(" ")
}
