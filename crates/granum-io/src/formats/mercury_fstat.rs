//! `.fstat` files of MercuryDPM: three lines of comments for each time, then for each contact `time i j x y z overlap
//! tangential_overlap normal_force tangential_force nx ny nz tx ty tz`.
//!
//! The file contains every contact of two particles twice, once for each particle; it is read once, from whichever of the two is there. `i` and `j` are the positions of the
//! particles in the list of the `.data` file, counted from 0; contacts with walls (a negative `j`) do not occur in a periodic cell and
//! are refused. The normal points from `j` to `i`, and both forces act on `i`.

use std::collections::HashSet;
use std::path::Path;

use super::result::{FileContact, Frame, ReadOptions, ResultFormat};
use super::words::Words;
use crate::error::{Error, Result};

/// The format.
pub struct MercuryFstat;

impl ResultFormat for MercuryFstat {
    fn name(&self) -> &'static str {
        "MercuryDPM fstat"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["fstat"]
    }
    fn recognises(&self, _: &[u8]) -> bool {
        // The file contains only comments and numbers, so that it can be recognised only by its name.
        false
    }
    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Vec<Frame>> {
        let mut words = Words::open(path)?;
        let mut frames: Vec<Frame> = Vec::new();
        while words.advance_to_text()? {
            if words.word(0).starts_with('#') {
                // The first comment of a time is "# time marker"; the other two have six numbers.
                if words.len() == 3 {
                    let time = words.number(1, "the time")?;
                    frames.push(Frame { time: Some(time), contacts: Some(Vec::new()), ..Frame::default() });
                }
                continue;
            }
            let time = words.number(0, "the time")?;
            if frames.last().is_none_or(|frame| frame.time != Some(time)) {
                frames.push(Frame { time: Some(time), contacts: Some(Vec::new()), ..Frame::default() });
            }
            let pair = pair(&words)?;
            if let Some(contacts) = frames.last_mut().and_then(|frame| frame.contacts.as_mut()) {
                contacts.push(pair);
            }
        }
        for contacts in frames.iter_mut().filter_map(|frame| frame.contacts.as_mut()) {
            leave_out_mirrored(contacts);
        }
        if frames.is_empty() {
            return Err(Error::content(path, "has no contacts"));
        }
        Ok(frames)
    }
}

/// Leaves out the second appearance of each contact, once for each particle.
fn leave_out_mirrored(contacts: &mut Vec<FileContact>) {
    let first: HashSet<(u64, u64)> = (contacts.iter().filter(|pair| pair.first < pair.second))
        .map(|pair| (pair.first, pair.second))
        .collect();
    contacts.retain(|pair| pair.first < pair.second || !first.contains(&(pair.second, pair.first)));
}

/// The contact of a line.
fn pair(words: &Words) -> Result<FileContact> {
    if words.len() != 16 {
        let message = format!("the contact has {} columns; 16 are needed", words.len());
        return Err(words.error(message));
    }
    let (i, j) = (words.number(1, "i")?, words.number(2, "j")?);
    if i < 0.0 || j < 0.0 {
        return Err(
            words.error("the contact is one with a wall: only samples in a periodic cell can be measured")
        );
    }
    let (first, second) = (words.whole(1, "i")?, words.whole(2, "j")?);
    let (normal_force, tangential_force) =
        (words.number(8, "the normal force")?, words.number(9, "the tangential force")?);
    let (n, t) =
        (words.vector(10, "a component of the normal")?, words.vector(13, "a component of the tangent")?);
    Ok(FileContact {
        first,
        second,
        normal: Some(n.map(|x| -x)),
        approach: Some(words.number(6, "the overlap")?),
        normal_force: Some(normal_force),
        tangential_force: Some(t.map(|x| tangential_force * x)),
        ..FileContact::default()
    })
}
