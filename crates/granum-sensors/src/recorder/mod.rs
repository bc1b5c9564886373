//! Averages observations into recorded states during a test.

mod schedule;

use std::sync::Arc;

use granum_core::assembly::Assembly;
use granum_dem::config::{RecordedColumns, Recording};
use granum_dem::loading;
use serde::{Deserialize, Serialize, Serializer};

use self::schedule::Schedule;
use crate::recorded_state::RecordedState;
use crate::registry::Known;
use crate::state_sums::StateSums;
use crate::{Bins, Memory, Observation, Record, SensorColumn, SensorError, Sensors, Values};

/// Makes observations during a test and averages them into states.
///
/// The following describes tests whose states are spaced by the deviator strain. The states of a stage can be spaced by another
/// measure, and at equal intervals without an end ([`Recorder::of_stage`]).
///
/// State k of `0..=states` is at the fraction `k / states` of the deviator strain at the end, and its window is one interval wide
/// and centred on it (half a window at the end). Observations are evenly spaced in a window, half a spacing from its edges, so
/// that they are evenly spaced over the whole test. A column of strain is averaged like every other, so that each row consists of
/// mean values over the same observations.
///
/// With another [`Spacing`](granum_dem::config::Spacing) the window of a state is centred on it too, and its width is the
/// distance to the nearer of the two neighbouring states (below the first state the start counts as a neighbour, above the last
/// one the end), so that windows never overlap.
///
/// State 0 is the sample before it is strained: one observation at strain zero. A window around it would contain the elastic rise
/// of the stress, which in stiff grains ends at a strain of about 1e-3; its mean would describe neither the sample nor the
/// sheared state.
///
/// A recorder can be serialised with the data that its sensors store, and is read back as a [`SavedRecorder`], so that a resumed run
/// gives the same bits.
///
/// ```
/// use granum_dem::{assembly::Assembly, config::Recording};
/// use granum_sensors::{Recorder, Sensors};
///
/// let recording = Recording::default().with(|recording| { recording.states = 2; recording.observations_per_state = 4; });
/// let mut recorder = Recorder::new(&Sensors::standard(), &recording, 0.3)?;
/// let mut assembly = Assembly::default();
/// while assembly.strain[0][0] < 0.3 {
///     if assembly.strain[0][0] >= recorder.next_observation() {
///         recorder.observe(&assembly);
///     }
///     assembly.strain[0][0] += 0.001;
/// }
/// assert_eq!(recorder.record().series.rows(), 3);
/// # Ok::<(), granum_sensors::SensorError>(())
/// ```
#[derive(Clone)]
pub struct Recorder {
    saved: SavedRecorder,
    /// The sensors that `saved` names, in the same order.
    sensors: Vec<Instance>,
}

/// The serialised form of a recorder, with the names of the sensors and the data that they store, but without the sensors themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedRecorder {
    schedule: Schedule,
    /// Names of the sensors, in the order of their columns.
    sensors: Vec<String>,
    /// The data that each of them stores.
    memories: Vec<Memory>,
    states: Vec<StateSums>,
}

/// A sensor with its bins for this recording.
#[derive(Clone)]
struct Instance {
    known: Arc<Known>,
    bins: Vec<Bins>,
}

/// Observations that were requested and could not be made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MissedObservations {
    /// Number of observations requested.
    pub wanted: usize,
    /// Number of observations that were not made.
    pub missing: usize,
    /// Number of states with fewer observations than requested.
    pub states: usize,
    /// Number of these states without any observation, which are not in the record.
    pub empty_states: usize,
}

impl MissedObservations {
    /// The sum of two missed observations.
    pub fn plus(self, other: MissedObservations) -> MissedObservations {
        MissedObservations {
            wanted: self.wanted + other.wanted,
            missing: self.missing + other.missing,
            states: self.states + other.states,
            empty_states: self.empty_states + other.empty_states,
        }
    }
}

impl SavedRecorder {
    /// Restores the recorder by adding its sensors.
    ///
    /// # Errors
    /// [`SensorError::Unknown`] if one of its sensors is not known.
    pub fn with_sensors(self, sensors: &Sensors) -> Result<Recorder, SensorError> {
        let recording = &self.schedule.recording;
        let instance = |name: &String| {
            let known = sensors.find(name)?.clone();
            let bins = known.sensor.histograms(recording);
            Ok(Instance { known, bins })
        };
        let sensors = self.sensors.iter().map(instance).collect::<Result<_, SensorError>>()?;
        Ok(Recorder { saved: self, sensors })
    }
}

impl Serialize for Recorder {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.saved.serialize(to)
    }
}

impl std::fmt::Debug for Recorder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.saved.fmt(f)
    }
}

impl PartialEq for Recorder {
    fn eq(&self, other: &Recorder) -> bool {
        self.saved == other.saved
    }
}

impl Recorder {
    /// A recorder for a test of one stage that ends at a deviator strain `end`, with the columns of the first version. If the number
    /// of states or of observations is zero, it is taken as one.
    ///
    /// # Errors
    /// [`SensorError::Unknown`] if the recording names a sensor that is not known.
    pub fn new(sensors: &Sensors, recording: &Recording, end: f64) -> Result<Recorder, SensorError> {
        Recorder::with_schedule(sensors, Schedule::of_test(recording, end), RecordedColumns::FirstPublished)
    }

    /// A recorder for a stage whose measure is counted from `origin`. Of the recording only the number of observations, the bins
    /// and the sensors are used.
    ///
    /// # Errors
    /// As [`Recorder::new`].
    pub fn of_stage(
        sensors: &Sensors,
        recording: &Recording,
        columns: RecordedColumns,
        record: &loading::RecordedStates,
        origin: f64,
    ) -> Result<Recorder, SensorError> {
        Recorder::with_schedule(sensors, Schedule::of_stage(recording, record, origin), columns)
    }

    fn with_schedule(
        sensors: &Sensors,
        schedule: Schedule,
        columns: RecordedColumns,
    ) -> Result<Recorder, SensorError> {
        let names = sensors.of_test(&schedule.recording, columns)?;
        let saved = SavedRecorder {
            schedule,
            memories: vec![Memory::new(); names.len()],
            sensors: names.into_iter().map(String::from).collect(),
            states: Vec::new(),
        };
        saved.with_sensors(sensors)
    }

    /// The record of all stages of a test with these columns, with one recorder per stage; the stages are numbered from 1.
    pub fn record_of_stages<'a>(
        recorders: impl IntoIterator<Item = &'a Recorder>,
        columns: RecordedColumns,
    ) -> Record {
        let recorders: Vec<&Recorder> = recorders.into_iter().collect();
        let Some(first) = recorders.first() else { return Record::default() };
        let stages = recorders.iter().enumerate();
        let rows =
            stages.flat_map(|(k, recorder)| recorder.saved.states.iter().map(move |sums| (k + 1, sums)));
        Record::from_states(&first.columns_by_sensor(), &first.bins(), rows, columns)
    }

    /// The record so far, without a number of the stage: one row for each state with at least one observation.
    pub fn record(&self) -> Record {
        Recorder::record_of_stages([self], RecordedColumns::FirstPublished)
    }

    /// Number of its states so far that no further observation will change.
    pub fn complete_states(&self) -> usize {
        let under_way = |last: &StateSums| last.state >= self.saved.schedule.next_state();
        self.saved.states.len() - usize::from(self.saved.states.last().is_some_and(under_way))
    }

    /// Number of its states so far, with the one under way.
    pub fn states(&self) -> usize {
        self.saved.states.len()
    }

    /// A state by its place among those so far, of a stage with this number in a test with these columns.
    pub fn state(&self, index: usize, stage: usize, columns: RecordedColumns) -> RecordedState {
        let rows = self.saved.states.get(index).into_iter().map(|sums| (stage, sums));
        RecordedState::from_record(Record::from_states(
            &self.columns_by_sensor(),
            &self.bins(),
            rows,
            columns,
        ))
    }

    /// True if its state can follow from the given fresh recorder: a recorder from a file may be damaged or belong to another test.
    pub fn is_like(&self, fresh: &Recorder) -> bool {
        let empty = fresh.empty_state(0);
        let (own, other) = (&self.saved, &fresh.saved);
        let observations = other.schedule.recording.observations_per_state;
        own.schedule.is_like(&other.schedule)
            && (&own.sensors, own.memories.len()) == (&other.sensors, other.memories.len())
            && own.states.iter().all(|sums| sums.is_like(&empty, observations))
            && own.states.windows(2).all(|pair| pair[0].state < pair[1].state)
            && own.states.last().is_none_or(|last| last.state <= own.schedule.next_state())
    }

    /// Value of the measure (in the paper's test the deviator strain) at which the next observation is due; infinite when there
    /// is none.
    pub fn next_observation(&self) -> f64 {
        self.saved.schedule.next_observation()
    }

    /// True when the last observation has been made.
    pub fn is_complete(&self) -> bool {
        self.saved.schedule.is_complete()
    }

    /// Makes one observation, for the last one that is due, and advances to the first that is not. It does nothing if none is due, so
    /// that it may be called at any time.
    pub fn observe(&mut self, assembly: &Assembly) {
        let Some(state) = self.saved.schedule.due(assembly) else { return };
        if self.saved.states.last().is_none_or(|sums| sums.state != state) {
            let fresh = self.empty_state(state);
            self.saved.states.push(fresh);
        }
        let Some(sums) = self.saved.states.last_mut() else { return };
        measure(&self.sensors, &self.saved.schedule.recording, assembly, &mut self.saved.memories, sums);
    }

    /// Records an assembly as the next state, of one observation, whether one is due or not: for a program that chooses the states itself.
    /// If a sensor panics, the recorder is as it was before.
    ///
    /// ```
    /// use granum_dem::{assembly::Assembly, config::Recording};
    /// use granum_sensors::{Recorder, Sensors};
    ///
    /// let mut recorder = Recorder::new(&Sensors::standard(), &Recording::default(), 0.3)?;
    /// recorder.observe_state(&Assembly::default());
    /// recorder.observe_state(&Assembly::default());
    /// assert_eq!(recorder.record().series.values("state"), Some([0.0, 1.0].as_slice()));
    /// # Ok::<(), granum_sensors::SensorError>(())
    /// ```
    pub fn observe_state(&mut self, assembly: &Assembly) {
        let state = self.saved.schedule.next_state();
        let (mut sums, mut memories) = (self.empty_state(state), self.saved.memories.clone());
        measure(&self.sensors, &self.saved.schedule.recording, assembly, &mut memories, &mut sums);
        self.saved.memories = memories;
        self.saved.states.push(sums);
        self.saved.schedule.end_state();
    }

    /// Discards the data that the sensors store: the stage has ended, and nothing will be compared with its last observation.
    pub fn end(&mut self) {
        self.saved.memories.iter_mut().for_each(|memory| *memory = Memory::new());
    }

    /// The missed observations of the completed states: the number of states that were recorded with fewer observations than
    /// requested, or with none, and the number of missing observations. It occurs if the steps of the test are long compared
    /// with a window.
    pub fn missed_observations(&self) -> MissedObservations {
        let mut found = MissedObservations::default();
        let (schedule, states) = (&self.saved.schedule, &self.saved.states);
        for state in 0..schedule.next_state().min(schedule.last_state().saturating_add(1)) {
            let wanted = schedule.observations_of(state);
            let at = states.binary_search_by_key(&state, |sums| sums.state);
            let taken = at.map_or(0, |at| states[at].observations as usize);
            found.wanted += wanted;
            if taken < wanted {
                found.missing += wanted - taken;
                found.states += 1;
                found.empty_states += usize::from(taken == 0);
            }
        }
        found
    }

    fn columns(&self) -> impl Iterator<Item = &SensorColumn> {
        self.sensors.iter().flat_map(|instance| &instance.known.description.columns)
    }

    /// The columns of each sensor.
    fn columns_by_sensor(&self) -> Vec<&[SensorColumn]> {
        self.sensors.iter().map(|instance| instance.known.description.columns.as_slice()).collect()
    }

    fn bins(&self) -> Vec<Bins> {
        self.sensors.iter().flat_map(|instance| instance.bins.iter().copied()).collect()
    }

    fn empty_state(&self, state: usize) -> StateSums {
        StateSums::new(state, self.columns().count(), self.bins().iter().map(Bins::empty).collect())
    }
}

/// Adds what some sensors measure on an assembly to the sums of a state.
fn measure(
    sensors: &[Instance],
    recording: &Recording,
    assembly: &Assembly,
    memories: &mut [Memory],
    sums: &mut StateSums,
) {
    let observation = Observation::new(assembly).with_recording(recording);
    let mut row = Vec::with_capacity(sums.sums.len());
    let mut first = 0;
    for (Instance { known, bins }, memory) in sensors.iter().zip(memories) {
        let columns = row.len() + known.description.columns.len();
        let end = (first + bins.len()).min(sums.histograms.len());
        let histograms = sums.histograms.get_mut(first..end).unwrap_or_default();
        if known.costs_too_much(assembly).is_none() {
            known.sensor.measure(&observation, memory, &mut Values::new(&mut row, histograms));
        }
        // A sensor that measured nothing, or has too many or too few values, must not shift the columns of the sensors after it.
        row.resize(columns, f64::NAN);
        first = end;
    }
    sums.add(&row, sensors.iter().flat_map(|instance| &instance.known.description.columns));
}

#[cfg(test)]
mod tests;
