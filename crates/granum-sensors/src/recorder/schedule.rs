//! When states are observed.

use std::collections::BTreeMap;

use granum_core::Assembly;
use granum_dem::config::{Recording, Spacing};
use granum_dem::loading::{self, MacroState, Measure};
use serde::{Deserialize, Deserializer, Serialize};

use crate::force_distribution::{BIN_WIDTH, LARGEST_FORCE};

/// The positions of the states of a test or stage, the number of observations of each, and the next observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Schedule {
    #[serde(deserialize_with = "recording_of_any_version")]
    pub(super) recording: Recording,
    /// The measure by which states are spaced, and the origin that is subtracted from it.
    measure: Measure,
    origin: f64,
    /// Value of the measure at the last state; `None` if there is no last state.
    end: Option<f64>,
    /// The next state, and the next observation within its window.
    next: (usize, usize),
}

/// A recording; in checkpoints of earlier versions some parameters of sensors had places of their own.
fn recording_of_any_version<'d, D: Deserializer<'d>>(from: D) -> Result<Recording, D::Error> {
    #[derive(Deserialize)]
    struct Stored {
        #[serde(flatten)]
        recording: Recording,
        bin_width: Option<f64>,
        largest_force: Option<f64>,
        #[serde(default)]
        critical_state: BTreeMap<String, Option<f64>>,
    }
    let mut stored = Stored::deserialize(from)?;
    for (parameter, value) in [(BIN_WIDTH, stored.bin_width), (LARGEST_FORCE, stored.largest_force)] {
        if let Some(value) = value.filter(|value| parameter.default_value() != Some(*value)) {
            stored.recording.parameters.insert(parameter.key.into(), value);
        }
    }
    for (key, value) in stored.critical_state {
        stored.recording.parameters.extend(value.map(|value| (format!("critical_{key}"), value)));
    }
    Ok(stored.recording)
}

impl Schedule {
    /// The schedule of a test that ends at a deviator strain `end`. Numbers of states or observations of zero count as one.
    pub(super) fn of_test(recording: &Recording, end: f64) -> Schedule {
        let (states, observations) = (recording.states.max(1), recording.observations_per_state.max(1));
        // The recorder does not take snapshots.
        let recording = recording.clone().with(|recording| {
            recording.states = states;
            recording.observations_per_state = observations;
            recording.snapshots = Vec::new();
        });
        Schedule {
            recording,
            measure: Measure::AxialDeviatorStrain,
            origin: 0.0,
            end: Some(end),
            next: (0, 0),
        }
    }

    /// The schedule of a stage whose measure is counted from `origin`.
    pub(super) fn of_stage(recording: &Recording, record: &loading::RecordedStates, origin: f64) -> Schedule {
        let recording = recording.clone().with(|recording| {
            recording.states = record.states;
            recording.spacing = record.spacing.clone();
        });
        let end = record.end.is_finite().then_some(record.end);
        Schedule { measure: record.measure, origin, end, ..Schedule::of_test(&recording, 0.0) }
    }

    /// True if its state can follow from the given fresh schedule.
    pub(super) fn is_like(&self, fresh: &Schedule) -> bool {
        let (state, observation) = self.next;
        self.recording == fresh.recording
            && (self.measure, self.origin, self.end) == (fresh.measure, fresh.origin, fresh.end)
            && state <= fresh.last_state().saturating_add(1)
            && observation < fresh.recording.observations_per_state
    }

    /// The next state.
    pub(super) fn next_state(&self) -> usize {
        self.next.0
    }

    /// Number of the last state.
    pub(super) fn last_state(&self) -> usize {
        match &self.recording.spacing {
            Spacing::Strains(strains) => strains.len(),
            Spacing::Every(_) => usize::MAX,
            Spacing::Equal | Spacing::Geometric(_) => self.recording.states,
        }
    }

    /// Value of the measure at the end; infinite if there is none.
    fn end(&self) -> f64 {
        self.end.unwrap_or(f64::INFINITY)
    }

    /// Distance by which the measure may fall short of a state because of rounding.
    fn tolerance(&self) -> f64 {
        match (self.end, &self.recording.spacing) {
            (Some(end), _) => 1e-9 * end,
            (None, Spacing::Every(interval)) => 1e-9 * interval,
            (None, _) => 0.0,
        }
    }

    /// Value of the measure at a state.
    fn strain_of(&self, state: usize) -> f64 {
        let states = self.recording.states;
        let end = self.end();
        match &self.recording.spacing {
            _ if state == 0 => 0.0,
            Spacing::Every(interval) => interval * state as f64,
            Spacing::Strains(strains) => strains.get(state - 1).copied().unwrap_or(end),
            Spacing::Geometric(first) if state < states => {
                first * libm::pow(end / first, (state - 1) as f64 / (states - 1) as f64)
            }
            Spacing::Geometric(_) => end,
            Spacing::Equal => end * (state as f64 / states as f64),
        }
    }

    /// Half the width of the window of a state, for states that are not equally spaced.
    fn half_window(&self, state: usize) -> f64 {
        let here = self.strain_of(state);
        let below = 0.5 * (here - self.strain_of(state - 1));
        if state < self.last_state() {
            return below.min(0.5 * (self.strain_of(state + 1) - here));
        }
        if here < self.end() { below.min(self.end() - here) } else { below }
    }

    /// Value of the measure at which the next observation is due; infinite when there is none.
    pub(super) fn next_observation(&self) -> f64 {
        let (state, observation) = self.next;
        if state > self.last_state() {
            return f64::INFINITY;
        }
        if state == 0 {
            return 0.0;
        }
        let offset = (2 * observation + 1) as f64 / (2 * self.recording.observations_per_state) as f64 - 0.5;
        match self.recording.spacing {
            Spacing::Equal => self.end() * ((state as f64 + offset) / self.recording.states as f64),
            _ => self.strain_of(state) + 2.0 * self.half_window(state) * offset,
        }
    }

    /// Number of observations of a state: half of them where the window ends with the test.
    pub(super) fn observations_of(&self, state: usize) -> usize {
        let observations = self.recording.observations_per_state;
        match state {
            0 => 1,
            last if last == self.last_state() && self.strain_of(last) >= self.end() => {
                observations.div_ceil(2)
            }
            _ => observations,
        }
    }

    /// True when the last observation has been made.
    pub(super) fn is_complete(&self) -> bool {
        self.next.0 > self.last_state()
    }

    /// The state to which an observation of an assembly belongs, if one is due; advances to the first observation that is not due. An
    /// observation is also due if the strain falls short only by a rounding error: the caller may have summed it in another order.
    pub(super) fn due(&mut self, assembly: &Assembly) -> Option<usize> {
        let reading = match self.measure.needs_stress() {
            true => MacroState::from_assembly(assembly),
            false => MacroState::without_stress(assembly),
        };
        let strain = self.measure.value(&reading) - self.origin + self.tolerance();
        if strain.is_nan() || strain < self.next_observation() {
            return None;
        }
        // If several observations are due, the last one is made: the nearest to the present strain.
        let mut state = 0;
        while self.next_observation() <= strain {
            state = self.next.0;
            self.advance();
        }
        Some(state)
    }

    /// The next state is over, however many observations of it were made.
    pub(super) fn end_state(&mut self) {
        self.next = (self.next.0 + 1, 0);
    }

    pub(super) fn advance(&mut self) {
        let (state, observation) = self.next;
        self.next = if observation + 1 < self.observations_of(state) {
            (state, observation + 1)
        } else {
            (state + 1, 0)
        };
    }
}
