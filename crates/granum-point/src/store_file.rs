//! The states of all points in one file.
//!
//! Layout: `GRANUMPT`, version (u32), length of the body (u64), SHA-256 of the body (32 bytes), body; little endian. The body has each
//! state once, though several points may share it, with the checkpoint of its grains or what its surrogate keeps; and of each point the accepted state and the trials.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use granum_core::geometry::Matrix;
use granum_core::input::{self, LARGEST_INPUT};
use granum_dem::contact::choice::registry::Laws;
use granum_dem::simulation::Simulation;
use granum_io::atomic::write_atomically;
use granum_learn::surrogate::{Outside, RunMemory};
use granum_run::stiffness::Tensor;
use serde::{Deserialize, Serialize};

use crate::identity::Identity;
use crate::increment::{Increment, Pace};
use crate::path_so_far::{PathPart, parts};
use crate::recipe::Recipe;
use crate::state::{Content, Matter, State};
use crate::store::{Store, StoredPoint, Trial};
use crate::store_error::StoreError;
use crate::surrogate_state::SurrogateState;

const MAGIC: &[u8; 8] = b"GRANUMPT";
const HEADER: usize = 52;
/// What the checkpoint of a state begins with that has no grains. Files of grains alone are as they always were.
const SURROGATE: &[u8; 8] = b"GRANUMSU";
/// What the checkpoint of a state of a hybrid point begins with: its path, before what it consists of.
const HYBRID: &[u8; 8] = b"GRANUMHY";
/// The version of the file that this granum reads and writes.
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
struct Body {
    /// Version of granum that wrote it.
    granum: String,
    states: Vec<SavedState>,
    points: Vec<SavedPoint>,
}

#[derive(Serialize, Deserialize)]
struct SavedState {
    identity: Identity,
    /// Of the grains, or [`SURROGATE`] and a [`SavedSurrogate`].
    checkpoint: Vec<u8>,
    rotation: Matrix,
    stress: Matrix,
    noise: Matrix,
    secant: [[f64; 6]; 6],
}

#[derive(Serialize, Deserialize)]
struct SavedSurrogate {
    memory: RunMemory,
    strain: [f64; 6],
    void_ratio: Option<f64>,
    outputs: Vec<String>,
    values: Vec<f64>,
    /// Name, value and trained range.
    outside: Vec<(String, f64, [f64; 2])>,
}

#[derive(Serialize, Deserialize)]
struct SavedHybrid {
    /// The parts of the path, the first one first.
    path: Vec<SavedPart>,
    /// As [`SavedState::checkpoint`].
    matter: Vec<u8>,
}

#[derive(Serialize, Deserialize)]
struct SavedPart {
    strain: Matrix,
    pace: SavedPace,
    stress: Matrix,
}

#[derive(Serialize, Deserialize)]
struct SavedPoint {
    name: u64,
    /// Place of the accepted state among the states.
    accepted: u64,
    trials: Vec<SavedTrial>,
    path: Vec<SavedRecipe>,
}

#[derive(Serialize, Deserialize)]
struct SavedTrial {
    ticket: u64,
    from: u64,
    recipe: SavedRecipe,
    /// Place of its state among the states, if it was in memory.
    state: Option<u64>,
}

#[derive(Serialize, Deserialize)]
enum SavedRecipe {
    Advance { strain: Matrix, rotation: Matrix, pace: SavedPace },
    Impose(Matrix),
}

#[derive(Serialize, Deserialize)]
enum SavedPace {
    OfControls,
    InertialNumber(f64),
    Duration(f64),
}

impl Store {
    /// Writes all points to a file. It is written beside its place and then renamed, so that a file that was there is whole at any instant.
    ///
    /// # Errors
    /// [`StoreError::Write`] if the file cannot be written; a previous one is then unchanged.
    pub fn save(&self, path: &Path) -> Result<(), StoreError> {
        let points = self.points.read().unwrap_or_else(PoisonError::into_inner);
        let mut states = States::default();
        let mut saved = Vec::new();
        for (name, point) in points.iter() {
            let point = point.lock().unwrap_or_else(PoisonError::into_inner);
            let accepted = states.place(&point.accepted, path)?;
            let mut trials = Vec::new();
            for trial in &point.trials {
                let state = trial.state.as_ref().map(|state| states.place(state, path)).transpose()?;
                let (ticket, from, recipe) = (trial.ticket, trial.from, saved_recipe(&trial.recipe));
                trials.push(SavedTrial { ticket, from, recipe, state });
            }
            let path = point.path.iter().map(saved_recipe).collect();
            saved.push(SavedPoint { name: *name, accepted, trials, path });
        }
        let granum = env!("CARGO_PKG_VERSION").to_string();
        let body = Body { granum, states: states.saved, points: saved };
        let unwritable = |error: postcard::Error| wrong(path, format!("cannot be written: {error}"));
        let bytes = postcard::to_allocvec(&body).map_err(unwritable)?;
        write_atomically(path, |file| {
            file.write_all(MAGIC)?;
            file.write_all(&VERSION.to_le_bytes())?;
            file.write_all(&(bytes.len() as u64).to_le_bytes())?;
            file.write_all(&sum(&bytes))?;
            file.write_all(&bytes)
        })?;
        Ok(())
    }

    /// Reads the points of a file, with granum's own contact laws.
    ///
    /// # Errors
    /// As [`Store::load_among`].
    pub fn load(path: &Path) -> Result<Store, StoreError> {
        Store::load_among(path, &Laws::standard())
    }

    /// Reads the points of a file, with laws that are among those of a program. Tickets and states are those that were saved, to the bit.
    ///
    /// # Errors
    /// [`StoreError::Read`] if the file cannot be read, [`StoreError::File`] if it is not a store, is damaged or cut short, or is of another
    /// version.
    pub fn load_among(path: &Path, laws: &Laws) -> Result<Store, StoreError> {
        let bytes = input::read(path, LARGEST_INPUT)
            .map_err(|source| StoreError::Read { path: path.to_path_buf(), source })?;
        let body = checked_body(&bytes).map_err(|what| wrong(path, what))?;
        let damaged = |what: String| wrong(path, format!("contradicts itself: {what}"));
        let (body, rest): (Body, &[u8]) =
            postcard::take_from_bytes(body).map_err(|error| damaged(error.to_string()))?;
        if !rest.is_empty() {
            return Err(damaged("there is more than the points".to_string()));
        }
        let mut states = Vec::new();
        for saved in body.states {
            states.push(restored(saved, laws).map_err(damaged)?);
        }
        let state = |at: u64| {
            let state = usize::try_from(at).ok().and_then(|at| states.get(at)).cloned();
            state.ok_or_else(|| damaged(format!("there is no state {at}")))
        };
        let mut points = BTreeMap::new();
        for point in body.points {
            let mut trials = Vec::new();
            for trial in point.trials {
                let SavedTrial { ticket, from, recipe, state: at } = trial;
                trials.push(Trial {
                    ticket,
                    from,
                    recipe: recipe.restored(),
                    state: at.map(state).transpose()?,
                });
            }
            let path = point.path.into_iter().map(SavedRecipe::restored).collect();
            let stored = StoredPoint { accepted: state(point.accepted)?, trials, path };
            points.insert(point.name, Arc::new(Mutex::new(stored)));
        }
        Ok(Store { points: points.into() })
    }
}

fn wrong(path: &Path, what: String) -> StoreError {
    StoreError::File { path: path.to_path_buf(), what }
}

/// The states of a file, each once.
#[derive(Default)]
struct States {
    places: BTreeMap<Identity, u64>,
    saved: Vec<SavedState>,
}

impl States {
    /// The place of a state, which is added if it is not there.
    fn place(&mut self, state: &State, path: &Path) -> Result<u64, StoreError> {
        if let Some(place) = self.places.get(&state.identity()) {
            return Ok(*place);
        }
        let content = state.content();
        let checkpoint = saved_content(content);
        let checkpoint = checkpoint.map_err(|error| wrong(path, format!("cannot be written: {error}")))?;
        let Content { identity, rotation, stress, noise, secant, .. } = *content;
        self.saved.push(SavedState { identity, checkpoint, rotation, stress, noise, secant: secant.0 });
        let place = self.saved.len() as u64 - 1;
        self.places.insert(identity, place);
        Ok(place)
    }
}

fn restored(saved: SavedState, laws: &Laws) -> Result<State, String> {
    let SavedState { identity, checkpoint, rotation, stress, noise, secant } = saved;
    let numbers = rotation.iter().chain(&stress).chain(&noise).flatten().chain(secant.iter().flatten());
    if !numbers.copied().all(f64::is_finite) {
        return Err("a stress or a rotation is not finite".to_string());
    }
    let (matter, path) = match checkpoint.strip_prefix(HYBRID) {
        Some(saved) => restored_hybrid(saved, laws)?,
        None => (restored_matter(&checkpoint, laws)?, None),
    };
    Ok(State::new(Content { identity, matter, rotation, stress, noise, secant: Tensor(secant), path }))
}

/// Grains, or what a surrogate keeps.
fn restored_matter(bytes: &[u8], laws: &Laws) -> Result<Matter, String> {
    match bytes.strip_prefix(SURROGATE) {
        Some(saved) => Ok(Matter::Surrogate(restored_surrogate(saved)?)),
        None => {
            let restored = Simulation::restore_among(bytes, laws);
            Ok(Matter::Grains(Box::new(restored.map_err(|error| error.to_string())?.0)))
        }
    }
}

/// What a state of a hybrid point consists of, and its path.
fn restored_hybrid(bytes: &[u8], laws: &Laws) -> Result<(Matter, Option<Arc<PathPart>>), String> {
    let (saved, rest): (SavedHybrid, &[u8]) =
        postcard::take_from_bytes(bytes).map_err(|error| error.to_string())?;
    let mut path = None;
    for SavedPart { strain, pace, stress } in saved.path {
        if !strain.iter().chain(&stress).flatten().all(|value| value.is_finite()) {
            return Err("a part of a path is not finite".to_string());
        }
        path = Some(Arc::new(PathPart { before: path, strain, pace: pace.restored(), stress }));
    }
    if !rest.is_empty() {
        return Err("there is more than a path and a state".to_string());
    }
    Ok((restored_matter(&saved.matter, laws)?, path))
}

/// The bytes of what a state consists of, with its path if it has one.
fn saved_content(content: &Content) -> Result<Vec<u8>, String> {
    let matter = saved_matter(&content.matter)?;
    if content.path.is_none() {
        return Ok(matter);
    }
    let part =
        |part: &PathPart| SavedPart { strain: part.strain, pace: part.pace.into(), stress: part.stress };
    let path = parts(content.path.as_ref()).into_iter().map(part).collect();
    let bytes = postcard::to_allocvec(&SavedHybrid { path, matter }).map_err(|error| error.to_string())?;
    Ok([HYBRID.as_slice(), &bytes].concat())
}

/// The bytes of grains, or of what a surrogate keeps.
fn saved_matter(matter: &Matter) -> Result<Vec<u8>, String> {
    let state = match matter {
        Matter::Grains(simulation) => return simulation.checkpoint("").map_err(|error| error.to_string()),
        Matter::Surrogate(state) => state,
    };
    let outside = state.outside.iter().map(|own| (own.name.clone(), own.value, own.range));
    let saved = SavedSurrogate {
        memory: state.memory.clone(),
        strain: state.strain,
        void_ratio: state.void_ratio,
        outputs: state.outputs.to_vec(),
        values: state.values.clone(),
        outside: outside.collect(),
    };
    let bytes = postcard::to_allocvec(&saved).map_err(|error| error.to_string())?;
    Ok([SURROGATE.as_slice(), &bytes].concat())
}

/// What a surrogate keeps. Whether the memory is that of the surrogate of a point is seen when the point goes on from it.
fn restored_surrogate(bytes: &[u8]) -> Result<SurrogateState, String> {
    let (saved, rest): (SavedSurrogate, &[u8]) =
        postcard::take_from_bytes(bytes).map_err(|error| error.to_string())?;
    let SavedSurrogate { memory, strain, void_ratio, outputs, values, outside } = saved;
    let finite = strain.iter().chain(&void_ratio).chain(&values).all(|value| value.is_finite());
    if !rest.is_empty() || !finite || outputs.len() != values.len() {
        return Err("the state of a surrogate is not whole".to_string());
    }
    let outside = outside.into_iter().map(|(name, value, range)| Outside { name, value, range }).collect();
    Ok(SurrogateState { memory, strain, void_ratio, outputs: outputs.into(), values, outside })
}

fn saved_recipe(recipe: &Recipe) -> SavedRecipe {
    match recipe {
        Recipe::Impose(stress) => SavedRecipe::Impose(*stress),
        Recipe::Advance(increment) => SavedRecipe::Advance {
            strain: increment.strain,
            rotation: increment.rotation,
            pace: increment.pace.into(),
        },
    }
}

impl From<Pace> for SavedPace {
    fn from(pace: Pace) -> SavedPace {
        match pace {
            Pace::OfControls => SavedPace::OfControls,
            Pace::InertialNumber(number) => SavedPace::InertialNumber(number),
            Pace::Duration(time) => SavedPace::Duration(time),
        }
    }
}

impl SavedPace {
    fn restored(self) -> Pace {
        match self {
            SavedPace::OfControls => Pace::OfControls,
            SavedPace::InertialNumber(number) => Pace::InertialNumber(number),
            SavedPace::Duration(time) => Pace::Duration(time),
        }
    }
}

impl SavedRecipe {
    fn restored(self) -> Recipe {
        match self {
            SavedRecipe::Impose(stress) => Recipe::Impose(stress),
            SavedRecipe::Advance { strain, rotation, pace } => {
                Recipe::Advance(Increment { strain, rotation, pace: pace.restored() })
            }
        }
    }
}

/// The SHA-256 of some bytes.
fn sum(bytes: &[u8]) -> [u8; 32] {
    let mut digest = granum_core::digest::Digest::new();
    digest.bytes(bytes);
    *Identity::new(digest).bytes()
}

/// The body of a file after its head was found correct.
fn checked_body(bytes: &[u8]) -> Result<&[u8], String> {
    let start = bytes.len().min(MAGIC.len());
    if bytes[..start] != MAGIC[..start] || bytes.is_empty() {
        return Err("is not a file of material points (it does not start with GRANUMPT)".to_string());
    }
    let cut = |expected: u64| format!("is cut short: {} bytes of {expected}", bytes.len());
    let Some((head, body)) = bytes.split_at_checked(HEADER) else { return Err(cut(HEADER as u64)) };
    let number =
        |from: usize, to: usize| head[from..to].iter().rev().fold(0u64, |n, &b| (n << 8) | u64::from(b));
    let version = number(8, 12);
    if version != u64::from(VERSION) {
        return Err(format!(
            "has version {version}, but this granum reads version {VERSION}: use the granum that wrote it"
        ));
    }
    let length = number(12, 20);
    if body.len() as u64 != length {
        return Err(cut(length.saturating_add(HEADER as u64)));
    }
    if sum(body) != head[20..52] {
        return Err("is damaged: its checksum does not match its content".to_string());
    }
    Ok(body)
}
