//! Restart files of MercuryDPM: the particles with their keywords (`position`, `velocity`, `angularVelocity`, `radius`, `invMass`,
//! `force`, `torque`), the domain or the periodic boundaries, and the contacts of two particles with their force.
//!
//! The cell follows from the periodic boundaries along the three axes; if one of them is missing, there is no cell. The force of an
//! interaction acts on the first of its particles. Contacts with walls are ignored.
//!
//! Clumps (`ClumpParticle`) are refused: the file has a clump and each of its pebbles as particles, and does not say which are which.

use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Sphere, Vector};

use super::meanings::{self, Meanings};
use super::result::{FileContact, Frame, FrameCell, ReadOptions, ResultFormat};
use super::words::Words;
use crate::error::{Error, Result};

/// The format.
pub struct MercuryRestart;

impl ResultFormat for MercuryRestart {
    fn name(&self) -> &'static str {
        "MercuryDPM restart"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["restart"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"MercuryDPM ") || head.starts_with(b"restart_version ")
    }
    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Vec<Frame>> {
        let mut words = Words::open(path)?;
        let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
        let mut frame = Frame { contacts: Some(Vec::new()), ..Frame::default() };
        let mut meanings = Vec::new();
        let (mut all_masses, mut is_periodic) = (true, [false; 3]);
        while words.advance_to_text()? {
            let at = |name: &str| words.words().position(|word| word == name);
            for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
                for (name, into) in [("Min", &mut low), ("Max", &mut high)] {
                    if let Some(place) = at(&format!("{axis}{name}")) {
                        into[k] = words.number(place + 1, "a bound of the domain")?;
                    }
                }
            }
            if let Some(place) = at("time").filter(|_| words.word(0) == "timeStep") {
                frame.time = Some(words.number(place + 1, "the time")?);
            }
            // Boundaries of other kinds (angled, in time, Lees-Edwards) make no cell of three edges at rest.
            if words.word(0) == "PeriodicBoundary" {
                let axis = periodic(&words, &mut low, &mut high)?;
                is_periodic[axis] = true;
            } else if words.word(0) == "ClumpParticle" {
                return Err(words.error(
                    "clumps cannot be read: the file has a clump and its pebbles as particles and does not say which pebble belongs to which clump; \
                     write the pebbles with the number of their clump, as a table with a column clump",
                ));
            } else if words.word(0).ends_with("Particle") && at("radius").is_some() {
                let grain = grain(&words)?;
                all_masses &= grain.mass > 0.0;
                frame.grains.push(grain);
                frame.lines.push(words.line_number());
                let kind = at("indSpecies").map(|place| words.word(place + 1).to_string());
                meanings.push(Meanings { body: None, kind });
            } else if let Some(place) = at("particleIds") {
                let pair = pair(&words, place)?;
                frame.contacts.get_or_insert_default().push(pair);
            }
        }
        if frame.grains.is_empty() {
            return Err(Error::content(path, "is no restart file with particles"));
        }
        meanings::note(&mut frame, &meanings, ("", 0.0), "indSpecies");
        let has_cell = is_periodic.iter().all(|is| *is);
        if has_cell && (0..3).any(|a| high[a] <= low[a]) {
            return Err(Error::content(path, "has periodic boundaries without a distance between them"));
        }
        frame.cell = has_cell.then(|| FrameCell::between(low, high));
        frame.knows(&[Part::Positions, Part::Velocities, Part::Spins, Part::Radii, Part::ResultantForces]);
        if all_masses {
            frame.knows(&[Part::Masses]);
        }
        Ok(vec![frame])
    }
}

/// `PeriodicBoundary id 0 normal 1 0 0 distanceLeft 0 distanceRight 1 ...`: the bounds of the cell along one axis.
fn periodic(words: &Words, low: &mut Vector, high: &mut Vector) -> Result<usize> {
    let after = |name: &str| words.words().position(|word| word == name).map(|at| at + 1);
    let (Some(normal), Some(left), Some(right)) = (
        after("normal"),
        after("distanceLeft").or(after("distance_left")),
        after("distanceRight").or(after("distance_right")),
    ) else {
        return Err(words.error("the periodic boundary has no normal, distanceLeft and distanceRight"));
    };
    let direction = words.vector(normal, "a component of the normal")?;
    let Some(axis) = (0..3).find(|a| direction[*a].abs() == 1.0) else {
        return Err(words.error("the periodic boundary is not across an axis: only cuboid cells can be read"));
    };
    let bounds = [words.number(left, "distanceLeft")?, words.number(right, "distanceRight")?]
        .map(|x| direction[axis] * x);
    (low[axis], high[axis]) = (bounds[0].min(bounds[1]), bounds[0].max(bounds[1]));
    Ok(axis)
}

fn grain(words: &Words) -> Result<Sphere> {
    let after = |name: &str| words.words().position(|word| word == name).map(|at| at + 1);
    let vector = |name: &'static str| after(name).map_or(Ok([0.0; 3]), |at| words.vector(at, name));
    let (Some(id), Some(position), Some(radius)) = (after("id"), after("position"), after("radius")) else {
        return Err(words.error("the particle has no id, position and radius"));
    };
    let inverse = after("invMass").map_or(Ok(0.0), |at| words.number(at, "invMass"))?;
    Ok(Sphere {
        id: words.whole(id, "id")?,
        position: words.vector(position, "position")?,
        velocity: vector("velocity")?,
        spin: vector("angularVelocity")?,
        radius: words.positive(radius, "radius")?,
        mass: if inverse > 0.0 { 1.0 / inverse } else { 0.0 },
        force: vector("force")?,
        torque: vector("torque")?,
        ..Sphere::default()
    })
}

fn pair(words: &Words, at: usize) -> Result<FileContact> {
    let force =
        words.words().position(|word| word == "force").map(|at| words.vector(at + 1, "force")).transpose()?;
    let (first, second) = (words.whole(at + 1, "particleIds")?, words.whole(at + 2, "particleIds")?);
    Ok(FileContact { first, second, force, ..FileContact::default() })
}
