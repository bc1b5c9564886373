//! A store of the states of many points, under tickets that a finite-element program can carry in its state variables.
//!
//! A host asks with the name of a point and the ticket of a state, and gets a new ticket. A ticket that comes in was accepted by the
//! host: what was there before it, and what else was tried, is dropped. No call is needed at the end of a step, and a step that is cut
//! back comes in with the ticket of the step before. Of each point the last answers are kept in memory; an older trial is remembered by
//! what was asked, and computed again, with the same bits, if the host accepts it after all.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};

use granum_core::geometry::Matrix;

use crate::error::PointError;
use crate::increment::Increment;
use crate::material_point::MaterialPoint;
use crate::recipe::Recipe;
use crate::state::State;
use crate::store_error::StoreError;

/// Number of trials of a point whose states are kept in memory.
const TRIALS_IN_MEMORY: usize = 8;
/// Number of trials of a point that are remembered at all since its last accepted state.
const MOST_TRIALS: usize = 4096;

/// An answer with the ticket under which its state is kept.
#[derive(Clone, Debug)]
pub struct StoredAnswer {
    /// The ticket of the state: a whole number from 1 to 2^52.
    pub ticket: u64,
    /// The state.
    pub state: State,
    /// Number of steps of the engine; zero if the answer was remembered.
    pub steps: u64,
}

/// The states of many points.
#[derive(Default)]
pub struct Store {
    pub(crate) points: RwLock<BTreeMap<u64, Arc<Mutex<StoredPoint>>>>,
}

/// The states of one point.
pub(crate) struct StoredPoint {
    /// The state that the host has accepted.
    pub(crate) accepted: State,
    /// What was tried since, the last one at the end.
    pub(crate) trials: Vec<Trial>,
    /// What led from the first state to the accepted one.
    pub(crate) path: Vec<Recipe>,
}

/// Something that was tried from the accepted state or from another trial.
pub(crate) struct Trial {
    pub(crate) ticket: u64,
    /// Ticket of the state from which it started.
    pub(crate) from: u64,
    pub(crate) recipe: Recipe,
    /// Its state, unless it has been dropped to save memory.
    pub(crate) state: Option<State>,
}

impl StoredPoint {
    /// A point at its first state.
    fn new(state: State) -> StoredPoint {
        StoredPoint { accepted: state, trials: Vec::new(), path: Vec::new() }
    }

    /// The state of a ticket, computed again if it was dropped.
    fn state(&mut self, ticket: u64, material: &MaterialPoint) -> Result<Option<State>, PointError> {
        if self.accepted.identity().ticket() == ticket {
            return Ok(Some(self.accepted.clone()));
        }
        let Some(at) = self.trials.iter().position(|trial| trial.ticket == ticket) else { return Ok(None) };
        if let Some(state) = &self.trials[at].state {
            return Ok(Some(state.clone()));
        }
        let (from, recipe) = (self.trials[at].from, self.trials[at].recipe);
        let Some(start) = self.state(from, material)? else { return Ok(None) };
        Ok(Some(material.follow(&start, &recipe)?.state))
    }

    /// Takes a state as accepted, and notes what led to it.
    fn accept(&mut self, state: State) {
        let first = self.accepted.identity().ticket();
        let mut ticket = state.identity().ticket();
        let mut way = Vec::new();
        while ticket != first {
            let Some(trial) = self.trials.iter().find(|trial| trial.ticket == ticket) else { break };
            way.push(trial.recipe);
            ticket = trial.from;
        }
        self.path.extend(way.into_iter().rev());
        self.accepted = state;
        self.trials.clear();
    }

    /// Remembers a trial.
    fn note(&mut self, trial: Trial) {
        self.trials.retain(|known| known.ticket != trial.ticket);
        self.trials.push(trial);
        if self.trials.len() > MOST_TRIALS {
            self.trials.remove(0);
        }
        let old = self.trials.len().saturating_sub(TRIALS_IN_MEMORY);
        self.trials[..old].iter_mut().for_each(|trial| trial.state = None);
    }
}

fn locked(point: &Mutex<StoredPoint>) -> MutexGuard<'_, StoredPoint> {
    // What is kept is replaced as a whole, so that a panic elsewhere leaves nothing half done.
    point.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Store {
    /// A store without points.
    pub fn new() -> Store {
        Store::default()
    }

    /// Keeps a state as the accepted one of a point, and returns its ticket. What the point had before is dropped.
    pub fn put(&self, name: u64, state: State) -> u64 {
        let ticket = state.identity().ticket();
        let point = StoredPoint::new(state);
        let mut points = self.points.write().unwrap_or_else(PoisonError::into_inner);
        points.insert(name, Arc::new(Mutex::new(point)));
        ticket
    }

    /// The same unless there is a point of that name; returns the ticket of its accepted state.
    pub fn put_if_absent(&self, name: u64, state: &State) -> u64 {
        let mut points = self.points.write().unwrap_or_else(PoisonError::into_inner);
        let new = || Arc::new(Mutex::new(StoredPoint::new(state.clone())));
        let point = points.entry(name).or_insert_with(new);
        locked(point).accepted.identity().ticket()
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.read().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// True if it has no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of states that are in memory, of all points; states that several points share are counted once for each.
    pub fn states(&self) -> usize {
        let points = self.points.read().unwrap_or_else(PoisonError::into_inner);
        let states = |point: &Arc<Mutex<StoredPoint>>| {
            1 + locked(point).trials.iter().filter(|trial| trial.state.is_some()).count()
        };
        points.values().map(states).sum()
    }

    /// The names of all points, in ascending order.
    pub fn names(&self) -> Vec<u64> {
        self.points.read().unwrap_or_else(PoisonError::into_inner).keys().copied().collect()
    }

    /// The state of a point that was accepted last, and what led to it from the first state: [`MaterialPoint::follow`] gives the same
    /// bits again.
    ///
    /// # Errors
    /// [`StoreError::NoPoint`].
    pub fn accepted(&self, name: u64) -> Result<(State, Vec<Recipe>), StoreError> {
        let point = self.point(name)?;
        let point = locked(&point);
        Ok((point.accepted.clone(), point.path.clone()))
    }

    /// Takes the state of a ticket as accepted, as a question with it would. A host that saves its own state calls it for its points first,
    /// so that the last step is in the paths; it can be left out.
    ///
    /// # Errors
    /// As [`Store::state`].
    pub fn accept(&self, name: u64, ticket: u64, material: &MaterialPoint) -> Result<State, StoreError> {
        let point = self.point(name)?;
        let mut point = locked(&point);
        let state = found(&mut point, name, ticket, material)?;
        if point.accepted.identity() != state.identity() {
            point.accept(state.clone());
        }
        Ok(state)
    }

    /// The state of a ticket, without taking it as accepted.
    ///
    /// # Errors
    /// [`StoreError::NoPoint`], [`StoreError::NoTicket`], and [`StoreError::Point`] if a dropped state cannot be computed again.
    pub fn state(&self, name: u64, ticket: u64, material: &MaterialPoint) -> Result<State, StoreError> {
        let point = self.point(name)?;
        let mut point = locked(&point);
        found(&mut point, name, ticket, material)
    }

    /// The answer of a point to an increment from the state of a ticket, which is thereby accepted. `stress`, Pa, compression positive,
    /// is that of the host: if it is given and differs from that of the state, the point is brought to it before the increment.
    ///
    /// # Errors
    /// [`StoreError`]; the point then has the states that it had, but for those that the ticket left behind.
    pub fn advance(
        &self,
        name: u64,
        ticket: u64,
        material: &MaterialPoint,
        stress: Option<&Matrix>,
        increment: &Increment,
    ) -> Result<StoredAnswer, StoreError> {
        let point = self.point(name)?;
        let mut point = locked(&point);
        let start = found(&mut point, name, ticket, material)?;
        if point.accepted.identity() != start.identity() {
            point.accept(start.clone());
        }
        let mut from = start;
        let mut steps = 0;
        let recipes =
            stress.map(|stress| Recipe::Impose(*stress)).into_iter().chain([Recipe::Advance(*increment)]);
        for recipe in recipes {
            let ticket = recipe.follows(&from.identity()).ticket();
            let known = point.trials.iter().find(|trial| trial.ticket == ticket);
            if let Some(state) = known.and_then(|trial| trial.state.clone()) {
                from = state;
                continue;
            }
            let answer =
                material.follow(&from, &recipe).map_err(|source| StoreError::Point { name, source })?;
            steps += answer.steps;
            if !answer.state.is_same_value(&from) {
                let trial = Trial {
                    ticket,
                    from: from.identity().ticket(),
                    recipe,
                    state: Some(answer.state.clone()),
                };
                point.note(trial);
                from = answer.state;
            }
        }
        Ok(StoredAnswer { ticket: from.identity().ticket(), state: from, steps })
    }

    fn point(&self, name: u64) -> Result<Arc<Mutex<StoredPoint>>, StoreError> {
        let points = self.points.read().unwrap_or_else(PoisonError::into_inner);
        points.get(&name).cloned().ok_or(StoreError::NoPoint { name, count: points.len() })
    }
}

/// The state of a ticket.
fn found(
    point: &mut StoredPoint,
    name: u64,
    ticket: u64,
    material: &MaterialPoint,
) -> Result<State, StoreError> {
    let accepted = point.accepted.identity().ticket();
    let state = point.state(ticket, material).map_err(|source| StoreError::Point { name, source })?;
    state.ok_or(StoreError::NoTicket { name, ticket, accepted })
}
