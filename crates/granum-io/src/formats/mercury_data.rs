//! `.data` files of MercuryDPM: for each time a line `N time xmin ymin zmin xmax ymax zmax`, then for each particle `x y z vx vy vz
//! radius a b c wx wy wz info` (the three-dimensional format of 14 columns).
//!
//! The domain in the header is taken as the periodic cell. The id of a particle is its position in the list, counted from 0, by which
//! `.fstat` files refer to it; periodic images that follow the particles (overlapping copies outside the domain) are ignored.

use std::path::Path;

use granum_core::Part;
use granum_core::assembly::Sphere;

use super::meanings::{self, Meanings};
use super::result::{Frame, FrameCell, ReadOptions, ResultFormat};
use super::words::{Words, head_lines};
use crate::error::{Error, Result};

/// The format.
pub struct MercuryData;

/// Columns of a particle.
const COLUMNS: usize = 14;

impl ResultFormat for MercuryData {
    fn name(&self) -> &'static str {
        "MercuryDPM data"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["data"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        let lines = head_lines(head);
        let numbers = |line: &String| {
            let values: Option<Vec<f64>> = line.split_whitespace().map(|word| word.parse().ok()).collect();
            values.map_or(0, |values| values.len())
        };
        let [first, second, ..] = &lines[..] else { return false };
        // An instant without particles is followed by the next one; files of two dimensions are refused by name.
        let is_empty = first.split_whitespace().next() == Some("0");
        match numbers(first) {
            8 => numbers(second) == COLUMNS || is_empty && numbers(second) == 8,
            6 => numbers(second) == 8 || is_empty && numbers(second) == 6,
            _ => false,
        }
    }
    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Vec<Frame>> {
        let mut words = Words::open(path)?;
        let mut frames = Vec::new();
        while words.advance_to_text()? {
            let frame = frame(&mut words)?;
            if !frame.grains.is_empty() {
                frames.push(frame);
            }
        }
        if frames.is_empty() {
            return Err(Error::content(path, "has no particles"));
        }
        Ok(frames)
    }
}

fn frame(words: &mut Words) -> Result<Frame> {
    if words.len() != 8 {
        let message = format!(
            "the line has {} words; a time begins with N time xmin ymin zmin xmax ymax zmax (two-dimensional files cannot be read)",
            words.len()
        );
        return Err(words.error(message));
    }
    let count = words.count(0, "the number of particles")?;
    let (low, high) = (words.vector(2, "a lower bound")?, words.vector(5, "an upper bound")?);
    if (0..3).any(|a| high[a] <= low[a]) {
        return Err(words.error("the upper bounds of the domain must be above the lower ones"));
    }
    let mut frame = Frame { time: Some(words.number(1, "the time")?), ..Frame::default() };
    frame.cell = Some(FrameCell::between(low, high));
    let mut meanings = Vec::with_capacity(count.min(1 << 20));
    for id in 0..count {
        words.need("a particle")?;
        if words.len() != COLUMNS {
            let message = format!("the particle has {} columns; {COLUMNS} are needed", words.len());
            return Err(words.error(message));
        }
        frame.grains.push(Sphere {
            id: id as u64,
            position: words.vector(0, "a coordinate")?,
            velocity: words.vector(3, "a velocity")?,
            radius: words.positive(6, "radius")?,
            spin: words.vector(10, "an angular velocity")?,
            ..Sphere::default()
        });
        frame.lines.push(words.line_number());
        meanings.push(Meanings { body: None, kind: Some(words.word(COLUMNS - 1).to_string()) });
    }
    meanings::note(&mut frame, &meanings, ("", 0.0), "of the species");
    frame.knows(&[Part::Positions, Part::Velocities, Part::Spins, Part::Radii]);
    Ok(frame)
}
