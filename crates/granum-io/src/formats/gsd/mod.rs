//! GSD, the binary format of HOOMD-blue, as OVITO and freud read it (layout of versions 1 and 2, schema `hoomd` 1).
//!
//! The chunks `configuration/step`, `configuration/box`, `particles/N`, `position`, `velocity`, `mass` and `diameter` are read;
//! `angmom` is ignored. A chunk that is missing in a frame is taken from the first frame, as in HOOMD-blue. The box of HOOMD-blue has
//! its centre at the origin, and its tilt factors are those of the edges divided by their lengths. If the file has no diameters or
//! masses, the radii or masses are unknown.
//!
//! Values are written in single precision, as the schema requires, and positions and radii also in double precision
//! (`log/particles/granum_position`, `log/particles/granum_radius`), which granum prefers when it reads the file. The cell is rotated
//! as for a LAMMPS data file.
//!
//! Of grains of several pieces each piece is a particle. `particles/body` is then the number of its grain, from 0, and -1 for a grain that is one
//! sphere; `particles/orientation` the orientation of the grain in the order w, x, y, z of HOOMD-blue, and `log/particles/granum_body` its id. The
//! masses of the particles of a grain add up to its mass. Without this last chunk, as in files of HOOMD-blue, the spheres of a body have masses
//! of density times volume.

mod layout;

use std::io::Write;
use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Piece, Quaternion, Sphere, Vector};
use granum_core::geometry::apply;
use granum_core::rotation::product;

use self::layout::{ChunkType, File, Writer};
use super::atoms::{Atom, atoms};
use super::lammps_data::restricted;
use super::meanings::{self, Meanings};
use super::quaternion::of_matrix;
use super::result::{Frame, FrameCell, ObservedAssembly, ReadOptions, ResultFormat};
use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// The format.
pub struct Gsd;

/// Places and radii in double precision.
const EXACT: [&str; 2] = ["log/particles/granum_position", "log/particles/granum_radius"];
/// The ids of the grains of which particles are pieces.
const BODY: &str = "log/particles/granum_body";

impl ResultFormat for Gsd {
    fn name(&self) -> &'static str {
        "GSD"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["gsd"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(&layout::MAGIC)
    }
    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Vec<Frame>> {
        let file = File::open(path)?;
        let frames: Vec<Frame> = (0..file.frames()).map(|k| frame(path, &file, k)).collect::<Result<_>>()?;
        if frames.is_empty() {
            return Err(Error::content(path, "has no frames"));
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
        let mut writer = Writer::new();
        for observation in observations {
            if !observation.parts.has(Part::Cell) {
                return Err(Error::content(path, "a GSD file needs a periodic cell, which the data lack"));
            }
            add(&mut writer, observation);
        }
        let bytes = writer.finish();
        write_atomically(path, |file| file.write_all(&bytes))
    }
}

fn frame(path: &Path, file: &File, k: u64) -> Result<Frame> {
    let numbers = |name: &str| file.numbers(k, name);
    let count = numbers("particles/N")?.and_then(|n| n.first().copied()).unwrap_or(0.0) as usize;
    let step = numbers("configuration/step")?.and_then(|n| n.first().copied()).unwrap_or(0.0);
    let mut frame = Frame { step: Some(step as u64), ..Frame::default() };
    let Some(cell) = numbers("configuration/box")? else {
        return Err(Error::content(path, format!("frame {k} has no configuration/box")));
    };
    let [lx, ly, lz, xy, xz, yz] = <[f64; 6]>::try_from(cell)
        .map_err(|_| Error::content(path, format!("frame {k}: configuration/box must have six numbers")))?;
    let edges = [[lx, xy * ly, xz * lz], [0.0, ly, yz * lz], [0.0, 0.0, lz]];
    let origin = apply(&edges, [-0.5; 3]);
    frame.cell = Some(FrameCell { origin, edges });
    let rows = |name: &str, width: usize| -> Result<Option<Vec<f64>>> {
        let found = numbers(name)?;
        if found.as_ref().is_some_and(|values| values.len() != width * count) {
            let message =
                format!("frame {k}: {name} must have {width} numbers for each of {count} particles");
            return Err(Error::content(path, message));
        }
        Ok(found)
    };
    let exact = rows(EXACT[0], 3)?;
    let Some(places) = exact.map_or_else(|| rows("particles/position", 3), |found| Ok(Some(found)))? else {
        return Err(Error::content(path, format!("frame {k} has no particles/position")));
    };
    let exact = rows(EXACT[1], 1)?;
    let halved = |values: Vec<f64>| values.into_iter().map(|diameter| 0.5 * diameter).collect::<Vec<f64>>();
    let radii = match exact {
        Some(found) => Some(found),
        None => rows("particles/diameter", 1)?.map(halved),
    };
    let (masses, velocities) = (rows("particles/mass", 1)?, rows("particles/velocity", 3)?);
    let three =
        |values: &[f64], at: usize| -> Vector { [values[3 * at], values[3 * at + 1], values[3 * at + 2]] };
    frame.grains = (0..count)
        .map(|at| Sphere {
            id: at as u64 + 1,
            position: three(&places, at),
            radius: radii.as_ref().map_or(0.0, |values| values[at]),
            mass: masses.as_ref().map_or(0.0, |values| values[at]),
            velocity: velocities.as_ref().map_or([0.0; 3], |values| three(values, at)),
            ..Sphere::default()
        })
        .collect();
    let (own, kinds) = (rows(BODY, 1)?, rows("particles/typeid", 1)?);
    frame.masses_add_up = own.is_some();
    let bodies = own.map_or_else(|| rows("particles/body", 1), |own| Ok(Some(own)))?;
    let value = |values: &Option<Vec<f64>>, at: usize| values.as_ref().map(|values| values[at]);
    let meanings: Vec<Meanings> = (0..count)
        .map(|at| Meanings { body: value(&bodies, at), kind: value(&kinds, at).map(|kind| kind.to_string()) })
        .collect();
    meanings::note(&mut frame, &meanings, ("particles/body", -1.0), "particles/typeid");
    frame.knows(&[Part::Positions]);
    let known = [
        (radii.is_some(), Part::Radii),
        (masses.is_some(), Part::Masses),
        (velocities.is_some(), Part::Velocities),
    ];
    for (_, part) in known.into_iter().filter(|(known, _)| *known) {
        frame.knows(&[part]);
    }
    Ok(frame)
}

/// Adds the chunks of one observation.
fn add(writer: &mut Writer, observation: &ObservedAssembly) {
    let (assembly, parts) = (&observation.assembly, observation.parts);
    let (turn, edges) = restricted(&assembly.cell);
    let middle = apply(&edges, [0.5; 3]);
    let inverse = granum_core::geometry::invert(&edges);
    let place = |atom: &Atom| {
        let turned = apply(&turn, atom.position);
        // Into the cell whose centre is the origin.
        let shift = apply(&inverse, turned).map(f64::floor);
        let back = apply(&edges, shift);
        let place: Vector = std::array::from_fn(|a| turned[a] - back[a] - middle[a]);
        place
    };
    let atoms = atoms(assembly);
    let (lx, ly, lz) = (edges[0][0], edges[1][1], edges[2][2]);
    let cell = [lx, ly, lz, edges[0][1] / ly, edges[0][2] / lz, edges[1][2] / lz];
    writer.chunk("configuration/step", ChunkType::U64, 1, &[assembly.step as f64]);
    writer.chunk("configuration/box", ChunkType::F32, 1, &cell);
    writer.chunk("particles/N", ChunkType::U32, 1, &[atoms.len() as f64]);
    let places: Vec<f64> = atoms.iter().flat_map(place).collect();
    writer.chunk("particles/position", ChunkType::F32, 3, &places);
    writer.chunk(EXACT[0], ChunkType::F64, 3, &places);
    if parts.has(Part::Radii) {
        let radii: Vec<f64> = atoms.iter().map(|atom| atom.radius).collect();
        let diameters: Vec<f64> = radii.iter().map(|radius| 2.0 * radius).collect();
        writer.chunk("particles/diameter", ChunkType::F32, 1, &diameters);
        writer.chunk(EXACT[1], ChunkType::F64, 1, &radii);
    }
    if parts.has(Part::Masses) {
        let masses: Vec<f64> = atoms.iter().map(|atom| atom.mass).collect();
        writer.chunk("particles/mass", ChunkType::F32, 1, &masses);
    }
    if parts.has(Part::Velocities) {
        let velocities: Vec<f64> = atoms.iter().flat_map(|atom| apply(&turn, atom.velocity)).collect();
        writer.chunk("particles/velocity", ChunkType::F32, 3, &velocities);
    }
    if !assembly.all_spheres() {
        add_bodies(writer, observation, &of_matrix(&turn), &atoms);
    }
    writer.end_frame();
}

/// Adds what says of which grain each particle is a piece.
fn add_bodies(writer: &mut Writer, observation: &ObservedAssembly, turn: &Quaternion, atoms: &[Atom]) {
    let assembly = &observation.assembly;
    let index = |piece: &Piece| match assembly.bodies.get(piece.body).and_then(|body| body.rigid) {
        Some(_) => piece.body as f64,
        None => -1.0,
    };
    let indices: Vec<f64> = assembly.pieces.iter().map(index).collect();
    writer.chunk("particles/body", ChunkType::I32, 1, &indices);
    let orientations: Vec<f64> = atoms.iter().flat_map(|atom| product(turn, &atom.orientation)).collect();
    writer.chunk("particles/orientation", ChunkType::F32, 4, &orientations);
    let ids: Vec<f64> = atoms.iter().map(|atom| atom.body as f64).collect();
    writer.chunk(BODY, ChunkType::U64, 1, &ids);
}
