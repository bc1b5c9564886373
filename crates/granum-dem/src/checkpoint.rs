//! The complete state of a simulation in bytes, so that a run can be resumed and gives the same bits as one that was never
//! interrupted: grains, neighbour list in its order, contact histories, forces of the last step, servo, time step.
//!
//! Layout: `GRANUMCP`, version (u32), length of the body (u64), CRC-32 of the body (u32), body; little endian. The body ends with the
//! energies in the channels of all laws where there are others than that of the normal law's first channel. Where grains have several pieces
//! the version is 9, and the body ends with these energies, which are always there, and the clumps. Where there are bonds, or were, the version
//! is 11, and the body ends with the names of the laws of bonds and the bonds, and with the pairs that a file lists as bonded, if it lists any.

use std::io::Write;

use granum_simd::LANES;
use postcard::ser_flavors::Flavor;
use serde::{Deserialize, Serialize};

use crate::bond::Bonds;
use crate::clump::clumps::Clumps;
use crate::contact::choice::registry::Laws;
use crate::images::IMAGES;
use crate::pairs::{Marks, NORMAL_COLUMNS, Pairs};
use crate::particle_row::ParticleRow;
use crate::properties::Properties;
use crate::saved_properties::SavedProperties;
use crate::simulation::Simulation;
use crate::simulation_error::SimulationError;
use crate::state::State;

const MAGIC: &[u8; 8] = b"GRANUMCP";
const HEADER: usize = 24;
/// Newest version that this granum reads and writes: of states with bonds.
pub const VERSION: u32 = 11;
/// Version of states without bonds in which grains have several pieces.
pub const OF_CLUMPS: u32 = 9;
/// Version of states in which every grain is a sphere.
pub const OF_SPHERES: u32 = 8;

/// Reasons why bytes are not a usable checkpoint.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CheckpointError {
    /// Not a checkpoint at all.
    #[error("this is not a granum checkpoint (it does not start with GRANUMCP)")]
    NotACheckpoint,
    /// Written by a newer granum.
    #[error(
        "the checkpoint has version {0}, but this granum reads versions up to {VERSION}: use a newer granum"
    )]
    Newer(u32),
    /// Written by an older granum.
    #[error(
        "the checkpoint has version {0}, but this granum reads version {VERSION}: run the case again, or use the \
         granum that wrote it"
    )]
    Older(u32),
    /// Cut short.
    #[error("the checkpoint is truncated: {found} bytes of {expected}")]
    Truncated {
        /// Number of bytes found.
        found: usize,
        /// Number of bytes that the header announces.
        expected: u64,
    },
    /// The content does not match its checksum.
    #[error("the checkpoint is damaged: its checksum does not match its content")]
    Damaged,
    /// The checksum is correct, but the content is impossible.
    #[error("the checkpoint contradicts itself: {0}")]
    Inconsistent(String),
    /// The contact laws in it cannot be combined.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}

/// The content of a checkpoint.
#[derive(Deserialize)]
struct Body {
    properties: SavedProperties,
    time_step_factor: f64,
    fixed_time_step: Option<f64>,
    expected_force: f64,
    state: State,
    attachment: String,
}

/// The same content by reference, for writing: a large state is not copied.
#[derive(Serialize)]
struct BodyOf<'a> {
    properties: &'a Properties,
    time_step_factor: f64,
    fixed_time_step: Option<f64>,
    expected_force: f64,
    state: &'a State,
    attachment: &'a str,
}

/// Passes bytes on, counts them and computes their checksum.
struct Stream<W> {
    out: W,
    length: u64,
    sum: crc32fast::Hasher,
    error: Option<std::io::Error>,
}

impl<W: Write> Flavor for &mut Stream<W> {
    type Output = ();
    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.try_extend(&[byte])
    }
    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.length += bytes.len() as u64;
        self.sum.update(bytes);
        self.out.write_all(bytes).map_err(|error| {
            self.error = Some(error);
            postcard::Error::SerializeBufferFull
        })
    }
    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

impl BodyOf<'_> {
    /// Writes the body; returns its length and checksum.
    fn write(&self, out: impl Write) -> std::io::Result<(u64, u32)> {
        let mut stream = Stream { out, length: 0, sum: crc32fast::Hasher::new(), error: None };
        let mut written = postcard::serialize_with_flavor(self, &mut stream);
        let (clumps, bonds, listed) = (&self.state.clumps, &self.state.bonds, &self.state.listed_pairs);
        if written.is_ok() && is_bonded(self.state) {
            let end = (&self.state.ledger.channels, clumps, bonds.law_names(), bonds);
            written = postcard::serialize_with_flavor(&end, &mut stream);
            if written.is_ok() && !listed.is_empty() {
                written = postcard::serialize_with_flavor(listed, &mut stream);
            }
        } else if written.is_ok() && !clumps.is_empty() {
            written = postcard::serialize_with_flavor(&(&self.state.ledger.channels, clumps), &mut stream);
        } else if let (Ok(()), Some(channels)) = (&written, self.state.ledger.further_channels()) {
            written = postcard::serialize_with_flavor(channels, &mut stream);
        }
        match (written, stream.error) {
            (_, Some(error)) => Err(error),
            (Err(error), None) => Err(std::io::Error::other(error)),
            (Ok(()), None) => Ok((stream.length, stream.sum.finalize())),
        }
    }
}

impl Simulation {
    /// Writes the simulation together with a text of the caller (for example the state of its recorder). Nothing is copied:
    /// the memory needed is negligible, but the state is serialized twice.
    pub fn write_checkpoint(&self, attachment: &str, out: &mut dyn Write) -> std::io::Result<()> {
        let body = BodyOf {
            properties: &self.integrator.properties,
            time_step_factor: self.integrator.time_step_factor,
            fixed_time_step: self.integrator.fixed_time_step,
            expected_force: self.integrator.expected_force,
            state: &self.integrator.state,
            attachment,
        };
        let (length, sum) = body.write(std::io::sink())?;
        out.write_all(MAGIC)?;
        let version = match self.state() {
            state if is_bonded(state) => VERSION,
            state if state.has_clumps() => OF_CLUMPS,
            _ => OF_SPHERES,
        };
        out.write_all(&version.to_le_bytes())?;
        out.write_all(&length.to_le_bytes())?;
        out.write_all(&sum.to_le_bytes())?;
        body.write(out).map(|_| ())
    }

    /// The same as [`Simulation::write_checkpoint`], into memory.
    pub fn checkpoint(&self, attachment: &str) -> Result<Vec<u8>, CheckpointError> {
        let mut bytes = Vec::new();
        self.write_checkpoint(attachment, &mut bytes)
            .map_err(|e| CheckpointError::Inconsistent(e.to_string()))?;
        Ok(bytes)
    }

    /// Restores a simulation with laws of granum from its bytes, and the caller's text. The number of threads and the
    /// instruction set are the defaults of this computer.
    pub fn restore(bytes: &[u8]) -> Result<(Simulation, String), CheckpointError> {
        Simulation::restore_among(bytes, &Laws::standard())
    }

    /// The same as [`Simulation::restore`], with laws that are among those of a program.
    pub fn restore_among(bytes: &[u8], laws: &Laws) -> Result<(Simulation, String), CheckpointError> {
        let unreadable = |e: postcard::Error| CheckpointError::Inconsistent(e.to_string());
        let (version, content) = checked_body(bytes)?;
        let (mut body, rest): (Body, &[u8]) = postcard::take_from_bytes(content).map_err(unreadable)?;
        if version == VERSION {
            let ((channels, clumps, names, bonds), rest) =
                postcard::take_from_bytes::<(_, _, Vec<String>, Bonds)>(rest).map_err(unreadable)?;
            if !rest.is_empty() {
                let (listed, rest) = postcard::take_from_bytes(rest).map_err(unreadable)?;
                no_more(rest)?;
                body.state.listed_pairs = listed;
            }
            body.state.ledger.channels = channels;
            body.state.clumps = clumps;
            body.state.bonds = bonds.with_laws(&names, laws).map_err(CheckpointError::Inconsistent)?;
        } else if version == OF_CLUMPS {
            let ((channels, clumps), rest) = postcard::take_from_bytes(rest).map_err(unreadable)?;
            no_more(rest)?;
            body.state.ledger.channels = channels;
            body.state.clumps = clumps;
        } else if !rest.is_empty() {
            let (channels, rest) = postcard::take_from_bytes(rest).map_err(unreadable)?;
            no_more(rest)?;
            body.state.ledger.channels = channels;
        }
        check_numbers(&body)?;
        check_state(&body.state)?;
        check_clumps(&body.state)?;
        let pieces = body.state.ids.len();
        let listed = body.state.listed_pairs.iter().all(|pair| pair.is_possible(pieces));
        if !listed || !body.state.bonds.are_consistent(pieces) {
            return Err(inconsistent("bonds"));
        }
        let properties = body.properties.among(laws).map_err(CheckpointError::Inconsistent)?;
        let mut simulation = Simulation::from_parts(body.state, properties)?;
        let integrator = &mut simulation.integrator;
        integrator.time_step_factor = body.time_step_factor;
        integrator.fixed_time_step = body.fixed_time_step;
        integrator.expected_force = body.expected_force;
        let [tangential, moments, adhesion, normal] = integrator.properties.contact.history();
        if integrator.state.pairs.columns != [NORMAL_COLUMNS + tangential, moments, adhesion, normal] {
            return Err(inconsistent("the contact history does not match the contact laws"));
        }
        let shares = integrator.properties.contact.adhesion.law().shares_liquid();
        if shares && integrator.state.films.is_empty() {
            return Err(inconsistent("there are no films of liquid for the bridges"));
        }
        integrator.prepare_constants();
        Ok((simulation, body.attachment))
    }
}

/// True if there are or were bonds, or a list of pairs of which some are to be made.
fn is_bonded(state: &State) -> bool {
    !(state.bonds.is_empty() && state.listed_pairs.is_empty())
}

/// Refuses bytes after the end of a state.
fn no_more(rest: &[u8]) -> Result<(), CheckpointError> {
    if rest.is_empty() { Ok(()) } else { Err(inconsistent("there is more than a state")) }
}

fn inconsistent(what: &str) -> CheckpointError {
    CheckpointError::Inconsistent(what.to_string())
}

/// The version and the body, after magic bytes, version, length and checksum were found correct.
fn checked_body(bytes: &[u8]) -> Result<(u32, &[u8]), CheckpointError> {
    if bytes.len() < HEADER {
        let start = bytes.len().min(MAGIC.len());
        if bytes[..start] != MAGIC[..start] {
            return Err(CheckpointError::NotACheckpoint);
        }
        return Err(CheckpointError::Truncated { found: bytes.len(), expected: HEADER as u64 });
    }
    if &bytes[..8] != MAGIC {
        return Err(CheckpointError::NotACheckpoint);
    }
    let number =
        |from: usize, to: usize| bytes[from..to].iter().rev().fold(0u64, |n, &b| (n << 8) | u64::from(b));
    let version = number(8, 12) as u32;
    if version > VERSION {
        return Err(CheckpointError::Newer(version));
    }
    if version < OF_SPHERES {
        return Err(CheckpointError::Older(version));
    }
    let length = number(12, 20);
    let body = &bytes[HEADER..];
    if (body.len() as u64) != length {
        let expected = length.saturating_add(HEADER as u64);
        return Err(CheckpointError::Truncated { found: bytes.len(), expected });
    }
    if crc32fast::hash(body) != number(20, 24) as u32 {
        return Err(CheckpointError::Damaged);
    }
    Ok((version, body))
}

/// More edges of the cell than any piece is from its body.
const FARTHEST_IMAGE: i32 = 1000;
/// More steps than any run can have made.
const MOST_STEPS: u64 = 1 << 60;

/// Checks the numbers of the servo and of the time step: with a NaN among them a run would neither advance nor end.
fn check_numbers(body: &Body) -> Result<(), CheckpointError> {
    let require = |good: bool, what: &str| if good { Ok(()) } else { Err(inconsistent(what)) };
    let (state, control) = (&body.state, &body.state.control);
    let positive = |x: f64| x > 0.0 && x.is_finite();
    let not_negative = |x: f64| x >= 0.0 && x.is_finite();
    require(positive(state.dt) && body.fixed_time_step.is_none_or(positive), "time step")?;
    require(positive(body.time_step_factor) && not_negative(body.expected_force), "time step")?;
    require(not_negative(control.rate_limit) && not_negative(state.global_damping), "control of the cell")?;
    let rates = state.gradient.iter().chain(&state.strain).chain(&state.anchor).flatten();
    require(
        control.is_finite() && rates.chain([&state.walked]).all(|x| x.is_finite()),
        "control of the cell",
    )?;
    require(positive(state.skin) && state.time.is_finite() && !state.judge_from.is_nan(), "time and skin")?;
    let inner_list = &state.inner_list;
    require(
        positive(inner_list.inner_skin) && !inner_list.travel.is_nan() && inner_list.distortion.is_finite(),
        "skin of the pruned neighbour list",
    )?;
    let counts = [state.step, state.steps_since_rebuild, state.rebuilds, inner_list.steps];
    require(counts.iter().chain(&state.servo_error.steps).all(|n| *n < MOST_STEPS), "number of steps")
}

/// Checks the indices of a state, which must not reach the kernels when out of range: a checksum can be forged.
fn check_state(state: &State) -> Result<(), CheckpointError> {
    let n = state.ids.len();
    let p = &state.pairs;
    let batches = p.first.len();
    let require = |good: bool, what: &str| if good { Ok(()) } else { Err(inconsistent(what)) };
    require(n > 0 && n < u32::MAX as usize / 8, "number of grains")?;
    require(state.particles.len() == n + 2 && state.spin.len() == n + 2, "grains and spins")?;
    let lists = [p.second.len(), p.target.len(), p.image.len(), p.marks.len()];
    require(lists == [batches; 4], "lists of pairs")?;
    let columns = p.columns.iter().fold(0usize, |sum, count| sum.saturating_add(*count));
    require((NORMAL_COLUMNS..64).contains(&p.columns[0]) && columns < 64, "columns of the contact history")?;
    require(p.memory.len() == batches * columns, "contact history")?;
    require(p.outer_offsets.len() == n + 1, "offsets of grains")?;
    let ordered = p.outer_offsets.windows(2).all(|w| w[0] <= w[1]);
    require(p.blocks.len() < 1 << 20, "blocks of pairs")?;
    require(ordered && p.outer_offsets.last() == Some(&(p.outer.len() as u32)), "offsets of grains")?;
    require(p.outer.iter().all(|&row| (row as usize) < p.forces.len()), "forces of grains")?;
    check_blocks(p, n)?;
    check_seconds(p, n)?;
    require(p.image.iter().flatten().all(|&c| (c as usize) < IMAGES), "images of grains")?;
    let volume = state.cell.volume();
    require(volume.is_finite() && volume > 0.0, "volume of the cell")?;
    require(state.films.is_empty() || state.films.len() == n, "films of liquid")?;
    require(state.films.iter().all(|film| film.is_finite() && *film >= 0.0), "films of liquid")?;
    let finite = state.particles.iter().flat_map(|r| r.0).all(f64::is_finite);
    require(finite && state.particles.iter().all(|r| r.radius() > 0.0 && r.mass() > 0.0), "grains")?;
    let largest = state.particles[..n].iter().fold(0.0f64, |m, row| m.max(row.radius()));
    let (far, wide) = (1e6 * largest, 1e5 * largest);
    require(state.particles[n + 1].0 == [far, far, far, largest, 0.0, 0.0, 0.0, 1.0], "the phantom grain")?;
    // At such a distance nothing comes near the phantom.
    let near = |x: &f64| x.abs() < wide;
    let inside = state.particles[..n].iter().all(|row| row.0[..3].iter().all(near));
    require(inside && state.cell.edges.iter().flatten().all(near), "size of the cell")
}

/// Every piece of a clump has a row of its own, and the numbers of clumps can be those of bodies: threads write the rows concurrently.
fn check_clumps(state: &State) -> Result<(), CheckpointError> {
    let require = |good: bool| if good { Ok(()) } else { Err(inconsistent("grains of several pieces")) };
    let Clumps { bodies, pieces } = &state.clumps;
    let mut next = 0;
    for clump in bodies {
        let [from, to] = clump.pieces;
        require(from == next && from < to && to as usize <= pieces.len())?;
        next = to;
        let vectors = [clump.centre, clump.velocity, clump.momentum, clump.inertia];
        require(vectors.iter().flatten().chain(&clump.orientation).all(|x| x.is_finite()))?;
        let positive = [clump.mass, clump.volume, clump.time_step_share];
        require(clump.inertia.iter().chain(&positive).all(|x| *x > 0.0 && x.is_finite()))?;
        let length: f64 = clump.orientation.iter().map(|x| x * x).sum();
        require((length - 1.0).abs() < 1e-9)?;
    }
    require(next as usize == pieces.len())?;
    let mut owned = vec![false; state.pieces()];
    for piece in pieces {
        let row = owned.get_mut(piece.row as usize);
        let near = piece.image.iter().all(|edges| edges.abs() <= FARTHEST_IMAGE);
        require(near && piece.centre.iter().all(|x| x.is_finite()))?;
        require(row.as_ref().is_some_and(|owned| !**owned))?;
        row.into_iter().for_each(|owned| *owned = true);
    }
    Ok(())
}

/// The second grain of a pair is a grain of the sample or the distant phantom, on which nothing acts.
fn check_seconds(p: &Pairs, grains: usize) -> Result<(), CheckpointError> {
    let good = |(second, marks): (&[u32; LANES], &Marks)| {
        (0..LANES).all(|l| {
            let acted = (marks.touched | marks.attracting) >> l & 1 != 0;
            (second[l] as usize) < grains || (second[l] as usize == grains + 1 && !acted)
        })
    };
    if p.second.iter().zip(&p.marks).all(good) { Ok(()) } else { Err(inconsistent("indices of grains")) }
}

/// Blocks must follow each other without a gap, and no two of them may write the same row: threads process them
/// concurrently.
fn check_blocks(p: &Pairs, grains: usize) -> Result<(), CheckpointError> {
    let require = |good: bool| if good { Ok(()) } else { Err(inconsistent("blocks of pairs")) };
    let (mut grain, mut batch, mut row) = (0, 0, grains as u32);
    for block in &p.blocks {
        let ([from, to], [start, inner, end], [first, last]) = (block.grains, block.batches, block.outer);
        require(from == grain && from < to && start == batch && first == row)?;
        require(start <= inner && inner <= end && end as usize <= p.first.len() && first <= last)?;
        let [within, across] = block.inner_ends;
        require((start..=inner).contains(&within) && (inner..=end).contains(&across))?;
        require(block.touching <= within - start)?;
        let left_out = (within..inner).chain(across..end);
        require(left_out.map(|b| p.marks[b as usize]).all(|m| m.touched == 0 && m.attracting == 0))?;
        let own = |g: u32| (from..to).contains(&g);
        let batches = start as usize..end as usize;
        require(p.first[batches.clone()].iter().flatten().all(|&g| own(g)))?;
        require(p.target[batches].iter().flatten().all(|&g| own(g) || (first..last).contains(&g)))?;
        (grain, batch, row) = (to, end, last);
    }
    require(grain as usize == grains && batch as usize == p.first.len() && row as usize == p.forces.len())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::config::{ContactModel, Grains, Material};
    use crate::random_insertion::random_insertion;
    use crate::servo::CellControl;

    /// A sample under compression, in which contacts form and break all the time.
    pub(crate) fn running(count: usize, spread: f64) -> Simulation {
        let grains = Grains { count, spread, ..Grains::default() };
        let (cell, spheres) = random_insertion(&grains, 0.3, 11).unwrap();
        let contact = ContactModel::default();
        let mut s = Simulation::new(cell, &spheres, Properties::new(Material::default(), contact)).unwrap();
        s.set_control(CellControl::isotropic(20e3, 8000.0));
        s.advance(6000).unwrap();
        s
    }

    #[test]
    fn a_restored_run_goes_on_to_the_same_bits() {
        for spread in [0.0, 0.3] {
            let mut straight = running(150, spread);
            let bytes = straight.checkpoint("note").unwrap();
            let (mut restored, note) = Simulation::restore(&bytes).unwrap();
            assert_eq!(note, "note");
            assert_eq!(restored.state(), straight.state());
            straight.advance(1777).unwrap();
            restored.advance(1000).unwrap();
            let (mut again, _) = Simulation::restore(&restored.checkpoint("").unwrap()).unwrap();
            again.advance(777).unwrap();
            assert_eq!(again.state(), straight.state());
            let contacts = straight.state().contacts();
            assert!(
                contacts > 50,
                "{contacts} contacts at solid fraction {}",
                straight.state().solid_fraction()
            );
        }
    }

    #[test]
    fn damaged_checkpoints_are_refused() {
        let bytes = running(150, 0.0).checkpoint("").unwrap();
        assert_eq!(Simulation::restore(b"something").err(), Some(CheckpointError::NotACheckpoint));
        for cut in [0, 5, 20, 24, 1000, bytes.len() - 1] {
            assert!(
                matches!(Simulation::restore(&bytes[..cut]), Err(CheckpointError::Truncated { .. })),
                "cut at {cut}"
            );
        }
        for at in (24..bytes.len()).step_by(997) {
            let mut flipped = bytes.clone();
            flipped[at] ^= 4;
            assert_eq!(Simulation::restore(&flipped).err(), Some(CheckpointError::Damaged));
        }
        let mut newer = bytes.clone();
        newer[8] = 99;
        assert_eq!(Simulation::restore(&newer).err(), Some(CheckpointError::Newer(99)));
    }

    /// The result of restoring a checkpoint that was changed and given a matching checksum.
    fn forged(change: impl FnOnce(&mut State)) -> Result<(Simulation, String), CheckpointError> {
        let mut simulation = running(150, 0.0);
        change(&mut simulation.integrator.state);
        Simulation::restore(&simulation.checkpoint("").unwrap())
    }

    #[test]
    fn numbers_that_cannot_be_are_refused() {
        let changes: [fn(&mut State); 14] = [
            |s| s.control.rate_limit = -1.0,
            |s| s.control.rate_limit = f64::NAN,
            |s| s.dt = f64::NAN,
            |s| s.step = u64::MAX,
            |s| s.particles[0].0[0] = 10.0,
            |s| s.particles[151].0[0] = 0.0,
            |s| s.pairs.second[0][0] = 151,
            |s| s.pairs.second[0][0] = 150,
            |s| s.skin = 0.0,
            |s| s.inner_list.inner_skin = f64::NAN,
            |s| s.inner_list.travel = f64::NAN,
            |s| s.pairs.blocks[0].inner_ends[0] = 0,
            |s| s.pairs.blocks[0].inner_ends[1] += 1000,
            |s| s.pairs.blocks[0].touching = u32::MAX,
        ];
        for (k, change) in changes.into_iter().enumerate() {
            // The first pairs of the list touch.
            let found = forged(change).err();
            assert!(matches!(found, Some(CheckpointError::Inconsistent(_))), "{k}: {found:?}");
        }
        assert!(forged(|_| {}).is_ok());
    }

    /// Found by mutation: an attraction between a grain and the phantom, which has no place among the grains.
    #[test]
    fn nothing_acts_on_the_phantom() {
        let found = forged(|s| {
            let phantom = s.pieces() as u32 + 1;
            let lanes = s
                .pairs
                .second
                .iter()
                .enumerate()
                .flat_map(|(b, row)| row.iter().enumerate().map(move |(l, j)| (b, l, *j)));
            let (batch, lane, _) =
                lanes.into_iter().find(|(_, _, j)| *j == phantom).expect("a lane without a pair");
            s.pairs.marks[batch].attracting = 1 << lane;
            let inner = s
                .pairs
                .blocks
                .iter_mut()
                .find(|block| (block.batches[0]..block.batches[2]).contains(&(batch as u32)));
            let block = inner.expect("the batch is in a block");
            block.inner_ends = [block.batches[1], block.batches[2]];
        });
        assert_eq!(found.err(), Some(inconsistent("indices of grains")));
    }

    /// Found by fuzzing: adhesion that reaches the phantom.
    #[test]
    fn materials_that_cannot_be_are_refused() {
        let refused = |change: fn(&mut Material)| {
            let mut simulation = running(150, 0.0);
            change(&mut simulation.integrator.properties.material);
            Simulation::restore(&simulation.checkpoint("").unwrap()).err().map(|e| e.to_string())
        };
        let said = |change, text: &str| {
            let found = refused(change).expect("refused");
            assert!(found.contains(text), "{found}");
        };
        assert_eq!(refused(|_| {}), None);
        said(
            |m| m.youngs_modulus = 1e3,
            "beyond half the radius, where the theory of small contacts fails: lower",
        );
        said(|m| m.youngs_modulus = 0.0, "the material's youngs_modulus is 0; it must be positive");
        said(|m| m.poissons_ratio = 0.51, "poissons_ratio");
        said(|m| m.interface_energy = -1.0, "interface_energy is -1; it must be zero or positive");
        said(|m| m.friction = f64::NAN, "friction is NaN");
    }

    #[test]
    fn forged_content_does_not_panic() {
        let bytes = running(150, 0.0).checkpoint("").unwrap();
        for at in (24..bytes.len()).step_by(311) {
            let mut forged = bytes.clone();
            forged[at] = forged[at].wrapping_add(77);
            let sum = crc32fast::hash(&forged[24..]);
            forged[20..24].copy_from_slice(&sum.to_le_bytes());
            // An accepted checkpoint can be inspected and run; absurd numbers end in an error, never in a panic.
            if let Ok((mut s, _)) = Simulation::restore(&forged) {
                assert_eq!(s.assembly().bodies.len(), 150);
                let _ = s.advance(2);
            }
        }
    }
}
