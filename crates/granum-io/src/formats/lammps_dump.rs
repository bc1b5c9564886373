//! Dumps of LAMMPS and LIGGGHTS: `dump custom` (grains) and `dump local` (contacts), any number of time steps in a file.
//!
//! Grains: `id` and a position (`x y z`, unwrapped `xu yu zu`, or scaled `xs ys zs`, `xsu ysu zsu`) are required; `radius` or
//! `diameter`, `mass` or `density`, `vx vy vz`, `omegax omegay omegaz`, `fx fy fz` and `tqx tqy tqz` are read if they are present, and
//! other columns are ignored, except that spheres of one molecule (`mol`, `body`, `clump`, `id_multisphere`) are pieces of one rigid body, and that several types are said. Where there is a column `body_mass` the masses of a molecule add up to it. The box may be tilted. If a boundary is not periodic, the grains have no periodic cell.
//!
//! Contacts: the header of a `dump local` names computes, not quantities. The columns are therefore named by options of the reader,
//! with the keywords of the computes: `patom1 patom2` (or `natom1 natom2`, `id1 id2`), `dx dy dz`, `fx fy fz`, `p1 p2
//! p3`, `p10 p11 p12`, and `-` for a column to be ignored. `compute pair/local` gives as `fx fy fz` the normal force on the
//! first atom, as `p1 p2 p3` the tangential force on it (pair styles `gran/...` and `granular`), and as `dx dy dz` (for
//! `granular` of LAMMPS from 2021 also `p10 p11 p12`) the vector from the second to the first. `force_x force_y force_z` is the
//! total force on the first grain, as `compute pair/gran/local` of LIGGGHTS writes it. Forces include those of the dashpots.

use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Sphere, Vector};
use granum_core::geometry::apply;

use super::column_names;
use super::lammps_dump_text::write_frame;
use super::meanings::{self, Meanings};
use super::result::{FileContact, Frame, FrameCell, ObservedAssembly, ReadOptions, ResultFormat};
use super::words::Words;
use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// The format.
pub struct LammpsDump;

impl ResultFormat for LammpsDump {
    fn name(&self) -> &'static str {
        "LAMMPS dump"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["dump", "lammpstrj"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"ITEM: ")
    }
    fn names_columns(&self) -> bool {
        true
    }
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Frame>> {
        if let Some(given) = &options.columns {
            check_names(path, given)?;
        }
        read(&mut Words::open(path)?, options)
    }
    fn is_written(&self) -> bool {
        true
    }
    fn holds_bodies(&self) -> bool {
        true
    }
    fn write(&self, path: &Path, observations: &[ObservedAssembly]) -> Result<()> {
        if observations.iter().any(|observation| !observation.parts.has(Part::Cell)) {
            return Err(Error::content(path, "a LAMMPS dump needs a periodic cell, which the data lack"));
        }
        write_atomically(path, |file| {
            observations.iter().try_for_each(|observation| write_frame(file, observation))
        })
    }
}

/// Names of the columns of contacts: the grains, and vectors.
const GRAINS_OF_PAIR: [&str; 8] = ["patom1", "patom2", "natom1", "natom2", "id1", "id2", "first", "second"];
const VECTORS_OF_PAIR: [[&str; 3]; 5] = [
    ["dx", "dy", "dz"],
    ["fx", "fy", "fz"],
    ["p1", "p2", "p3"],
    ["p10", "p11", "p12"],
    ["force_x", "force_y", "force_z"],
];
/// A number of the row, which means nothing.
const INDEX: &str = "index";

/// Checks the names that a user gives to the columns of contacts.
fn check_names(path: &Path, given: &[String]) -> Result<()> {
    let vectors = VECTORS_OF_PAIR.map(column_names::owned);
    let mut known = vec![INDEX.to_string()];
    known.extend(column_names::owned(GRAINS_OF_PAIR));
    known.extend(vectors.iter().flatten().cloned());
    column_names::check(path, given, &known, &vectors)?;
    let has = |name: &str| given.iter().any(|known| known == name);
    if has("fx") && !(has("force_x") || has("p1") || has("dx") || has("p10")) {
        let message = "--columns: fx fy fz are the normal force of a contact; p1 p2 p3, its tangential force, are missing: name them as \
                       well, or dx dy dz beside the normal force alone";
        return Err(Error::content(path, message));
    }
    Ok(())
}

/// What stands before the rows of one time step.
#[derive(Default)]
struct Head {
    step: Option<u64>,
    time: Option<f64>,
    rows: Option<usize>,
    cell: Option<FrameCell>,
    periodic: bool,
}

fn read(words: &mut Words, options: &ReadOptions) -> Result<Vec<Frame>> {
    let mut frames = Vec::new();
    let mut head = Head::default();
    while words.advance_to_text()? {
        let Some(item) = words.line().trim().strip_prefix("ITEM:").map(|item| item.trim().to_string()) else {
            let message = "a line that begins with \"ITEM:\" should stand here; is a number of rows wrong?";
            return Err(words.error(message));
        };
        let kind = item.split_whitespace().next().unwrap_or("").to_string();
        match kind.as_str() {
            "UNITS" => {
                words.need("the units")?;
                if !["si", "lj"].contains(&words.word(0)) {
                    let message =
                        format!("units {}: only si, and lj as they are, can be read", words.word(0));
                    return Err(words.error(message));
                }
            }
            "TIMESTEP" => {
                words.need("the time step")?;
                // LAMMPS writes the time before the step.
                head =
                    Head { step: Some(words.whole(0, "the time step")?), time: head.time, ..Head::default() };
            }
            "TIME" => {
                words.need("the time")?;
                head.time = Some(words.number(0, "the time")?);
            }
            "NUMBER" => {
                words.need("a number of rows")?;
                head.rows = Some(words.count(0, "the number of rows")?);
            }
            "BOX" => read_box(words, &item, &mut head)?,
            "ATOMS" | "ENTRIES" => {
                frames.push(read_rows(words, &item, kind == "ATOMS", &head, options)?);
                head = Head::default();
            }
            other => return Err(words.error(format!("ITEM: {other} is not known"))),
        }
    }
    if frames.is_empty() {
        return Err(Error::content(Path::new(words.file()), "is a dump without a time step"));
    }
    Ok(frames)
}

/// The three lines of a box. For a tilted one the bounds are those of the box around it (LAMMPS, Howto triclinic).
fn read_box(words: &mut Words, item: &str, head: &mut Head) -> Result<()> {
    let words_of: Vec<&str> = item.split_whitespace().skip(2).collect();
    if words_of.contains(&"abc") || words_of.contains(&"origin") {
        return read_general_box(words, head);
    }
    let tilted = words_of.contains(&"xy");
    let boundaries: Vec<&&str> =
        words_of.iter().filter(|word| word.len() == 2 && !TILTS.contains(word)).collect();
    // Versions of before 2010 do not say the kind of the boundaries.
    head.periodic = boundaries.iter().all(|word| ***word == *"pp");
    let (mut low, mut high, mut tilt) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    for a in 0..3 {
        words.need("the bounds of the box")?;
        low[a] = words.number(0, "the lower bound")?;
        high[a] = words.number(1, "the upper bound")?;
        if tilted {
            tilt[a] = words.number(2, "the tilt")?;
        }
    }
    let [xy, xz, yz] = tilt;
    let (least, most) = (
        |v: &[f64]| v.iter().copied().fold(0.0, f64::min),
        |v: &[f64]| v.iter().copied().fold(0.0, f64::max),
    );
    low[0] -= least(&[xy, xz, xy + xz]);
    high[0] -= most(&[xy, xz, xy + xz]);
    low[1] -= least(&[yz]);
    high[1] -= most(&[yz]);
    let mut cell = FrameCell::between(low, high);
    (cell.edges[0][1], cell.edges[0][2], cell.edges[1][2]) = (xy, xz, yz);
    check_volume(words, &cell)?;
    head.cell = Some(cell);
    Ok(())
}

const TILTS: [&str; 3] = ["xy", "xz", "yz"];

/// `ITEM: BOX BOUNDS abc origin`: in each line an edge, and one component of the corner.
fn read_general_box(words: &mut Words, head: &mut Head) -> Result<()> {
    let mut cell = FrameCell { origin: [0.0; 3], edges: [[0.0; 3]; 3] };
    for edge in 0..3 {
        words.need("an edge of the box")?;
        let vector = words.vector(0, "a component of the edge")?;
        for a in 0..3 {
            cell.edges[a][edge] = vector[a];
        }
        cell.origin[edge] = words.number(3, "a component of the corner")?;
    }
    head.periodic = true;
    check_volume(words, &cell)?;
    head.cell = Some(cell);
    Ok(())
}

fn check_volume(words: &Words, cell: &FrameCell) -> Result<()> {
    let volume = granum_core::geometry::determinant(&cell.edges);
    if volume.abs() > 0.0 && volume.is_finite() {
        return Ok(());
    }
    Err(words.error(format!("the box has the volume {volume:e}; it must not be zero")))
}

fn read_rows(
    words: &mut Words,
    item: &str,
    atoms: bool,
    head: &Head,
    options: &ReadOptions,
) -> Result<Frame> {
    let Some(rows) = head.rows else {
        return Err(words.error("ITEM: NUMBER OF ATOMS or ENTRIES must stand before the rows"));
    };
    let names: Vec<String> = item.split_whitespace().skip(1).map(String::from).collect();
    let mut frame = Frame { step: head.step, time: head.time, ..Frame::default() };
    frame.cell = head.cell.filter(|_| head.periodic);
    if atoms {
        if options.columns.is_some() {
            return Err(words
                .error("--columns: this line names the columns of the atoms; name those of a dump local"));
        }
        let columns = Columns(names);
        let layout = GrainLayout::from_words(words, &columns)?;
        frame.knows(&layout.parts());
        frame.masses_add_up = columns.place(&["body_mass"]).is_some();
        frame.rounding = head.cell.filter(|_| layout.scaled).map(|cell| rounding_of_shares(&cell));
        let mut meanings = Vec::with_capacity(rows.min(1 << 20));
        for _ in 0..rows {
            words.need("an atom")?;
            columns.check_length(words)?;
            frame.grains.push(layout.grain(words, head.cell.as_ref())?);
            frame.lines.push(words.line_number());
            let kind = layout.kind.map(|at| words.word(at).to_string());
            meanings.push(Meanings { body: layout.body.and_then(|at| words.word(at).parse().ok()), kind });
        }
        let name = |at: Option<usize>| at.map_or("", |at| &columns.0[at]);
        meanings::note(&mut frame, &meanings, (name(layout.body), 0.0), name(layout.kind));
    } else {
        let columns = Columns(options.columns.clone().unwrap_or(names));
        let layout = PairLayout::from_words(words, &columns)?;
        let mut pairs = Vec::with_capacity(rows.min(1 << 20));
        for _ in 0..rows {
            words.need("a contact")?;
            columns.check_length(words)?;
            pairs.push(layout.pair(words)?);
        }
        frame.contacts = Some(pairs);
    }
    Ok(frame)
}

/// The names of columns.
struct Columns(Vec<String>);

impl Columns {
    /// The place of the first of several names for one quantity.
    fn place(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.0.iter().position(|known| known == name))
    }

    /// The places of three columns, if all are there.
    fn three(&self, names: [&str; 3]) -> Option<[usize; 3]> {
        let [x, y, z] = names.map(|name| self.place(&[name]));
        Some([x?, y?, z?])
    }

    fn check_length(&self, words: &Words) -> Result<()> {
        if words.len() == self.0.len() {
            return Ok(());
        }
        let message = format!("the row has {} words, but there are {} columns", words.len(), self.0.len());
        Err(words.error(message))
    }
}

fn vector(words: &Words, places: [usize; 3], what: &str) -> Result<Vector> {
    Ok([words.number(places[0], what)?, words.number(places[1], what)?, words.number(places[2], what)?])
}

/// Where the quantities of a grain stand.
struct GrainLayout {
    id: usize,
    position: [usize; 3],
    scaled: bool,
    radius: Option<(usize, f64)>,
    mass: Option<usize>,
    density: Option<usize>,
    vectors: [(Option<[usize; 3]>, &'static str, Part); 3],
    torque: Option<[usize; 3]>,
    /// The molecule or body that a grain is a part of.
    body: Option<usize>,
    /// Its type.
    kind: Option<usize>,
}

/// Largest error of a distance by places that are shares of a box with six digits, m.
fn rounding_of_shares(cell: &FrameCell) -> f64 {
    2e-6 * (0..3).map(|k| cell.edges.iter().map(|row| row[k].abs()).sum::<f64>()).fold(0.0, f64::max)
}

impl GrainLayout {
    fn from_words(words: &Words, columns: &Columns) -> Result<GrainLayout> {
        let missing = |what: &str| {
            let help = "write them with dump custom";
            words.error(format!("the atoms have no {what}, only {}; {help}", columns.0.join(" ")))
        };
        let plain = columns.three(["x", "y", "z"]).or_else(|| columns.three(["xu", "yu", "zu"]));
        let scaled = columns.three(["xs", "ys", "zs"]).or_else(|| columns.three(["xsu", "ysu", "zsu"]));
        let half = |names: &[&str], factor: f64| columns.place(names).map(|place| (place, factor));
        Ok(GrainLayout {
            id: columns.place(&["id"]).ok_or_else(|| missing("id"))?,
            position: plain.or(scaled).ok_or_else(|| missing("x y z"))?,
            scaled: plain.is_none(),
            radius: half(&["radius", "c_radius"], 1.0).or_else(|| half(&["diameter", "c_diameter"], 0.5)),
            mass: columns.place(&["mass"]),
            density: columns.place(&["density"]),
            vectors: [
                (columns.three(["vx", "vy", "vz"]), "velocity", Part::Velocities),
                (columns.three(["omegax", "omegay", "omegaz"]), "spin", Part::Spins),
                (columns.three(["fx", "fy", "fz"]), "force", Part::ResultantForces),
            ],
            torque: columns.three(["tqx", "tqy", "tqz"]),
            body: columns.place(&["mol", "id_multisphere", "f_id_multisphere", "body", "clump"]),
            kind: columns.place(&["type"]),
        })
    }

    fn parts(&self) -> Vec<Part> {
        let mut parts = vec![Part::Positions];
        parts.extend(self.radius.map(|_| Part::Radii));
        parts.extend(self.mass.or(self.density.and(self.radius.map(|_| 0))).map(|_| Part::Masses));
        parts.extend(self.vectors.iter().filter(|(places, _, _)| places.is_some()).map(|(_, _, part)| *part));
        parts
    }

    fn grain(&self, words: &Words, cell: Option<&FrameCell>) -> Result<Sphere> {
        let mut grain = Sphere { id: words.whole(self.id, "id")?, ..Sphere::default() };
        grain.position = vector(words, self.position, "a coordinate")?;
        if self.scaled {
            let Some(cell) = cell else { return Err(words.error("scaled places need ITEM: BOX BOUNDS")) };
            let place = apply(&cell.edges, grain.position);
            grain.position = std::array::from_fn(|a| cell.origin[a] + place[a]);
        }
        if let Some((place, factor)) = self.radius {
            grain.radius = factor * words.positive(place, "radius or diameter")?;
        }
        if let Some(place) = self.mass {
            grain.mass = words.positive(place, "mass")?;
        } else if let (Some(place), true) = (self.density, grain.radius > 0.0) {
            let volume = 4.0 / 3.0 * std::f64::consts::PI * grain.radius.powi(3);
            grain.mass = words.positive(place, "density")? * volume;
        }
        let into = [&mut grain.velocity, &mut grain.spin, &mut grain.force];
        for (value, (places, what, _)) in into.into_iter().zip(&self.vectors) {
            if let Some(places) = places {
                *value = vector(words, *places, what)?;
            }
        }
        if let Some(places) = self.torque {
            grain.torque = vector(words, places, "torque")?;
        }
        Ok(grain)
    }
}

/// Where the quantities of a contact stand.
struct PairLayout {
    first: usize,
    second: usize,
    /// From the second to the first grain.
    apart: Option<[usize; 3]>,
    normal: Option<[usize; 3]>,
    tangential: Option<[usize; 3]>,
    force: Option<[usize; 3]>,
}

impl PairLayout {
    fn from_words(words: &Words, columns: &Columns) -> Result<PairLayout> {
        let first = columns.place(&["patom1", "natom1", "id1", "first"]);
        let second = columns.place(&["patom2", "natom2", "id2", "second"]);
        let (Some(first), Some(second)) = (first, second) else {
            let message = format!(
                "the columns {} do not say which atoms touch; name them with --columns, as --columns \
                 FILE=index,patom1,patom2,fx,fy,fz,p1,p2,p3",
                columns.0.join(" ")
            );
            return Err(words.error(message));
        };
        Ok(PairLayout {
            first,
            second,
            apart: columns.three(["dx", "dy", "dz"]).or_else(|| columns.three(["p10", "p11", "p12"])),
            normal: columns.three(["fx", "fy", "fz"]),
            tangential: columns.three(["p1", "p2", "p3"]),
            force: columns.three(["force_x", "force_y", "force_z"]),
        })
    }

    fn pair(&self, words: &Words) -> Result<FileContact> {
        let mut pair = FileContact {
            first: words.whole(self.first, "the id of an atom")?,
            second: words.whole(self.second, "the id of an atom")?,
            ..FileContact::default()
        };
        let read =
            |places: Option<[usize; 3]>, what| places.map(|places| vector(words, places, what)).transpose();
        pair.branch = read(self.apart, "a component of the distance")?.map(|apart| apart.map(|x| -x));
        pair.force = read(self.force, "a component of the force")?;
        if let (None, Some(normal)) = (pair.force, read(self.normal, "a component of the force")?) {
            match read(self.tangential, "a component of the tangential force")? {
                Some(t) => pair.force = Some(std::array::from_fn(|a| normal[a] + t[a])),
                // The normal force alone: its sign follows from the branch, which only the places of the grains may give.
                None => pair.normal_force = pair.branch.map(|branch| normal_component(&normal, &branch)),
            }
        }
        Ok(pair)
    }
}

/// Compression of a force on the first grain along a branch.
fn normal_component(force: &Vector, branch: &Vector) -> f64 {
    let length = branch.iter().map(|x| x * x).sum::<f64>().sqrt();
    -(0..3).map(|a| force[a] * branch[a]).sum::<f64>() / length
}
