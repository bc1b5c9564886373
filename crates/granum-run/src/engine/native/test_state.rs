//! The state of a test: a sequence of stages, each with its own recorder.

use granum_dem::bond::BondPlaces;
use granum_dem::config::RecordedColumns;
use granum_dem::loading::{Stage, StageEnd, StageProgress, Start, begin};
use granum_dem::simulation::Simulation;
use granum_io::Case;
use granum_io::case::TestDefinition;
use granum_io::run::StageEndRecord;
use granum_sensors::{Record, RecordedState, Recorder, SavedRecorder, SensorError, Sensors};
use serde::{Deserialize, Deserializer, Serialize};

use super::energy_balance::StoredEnergy;
use super::follow::{snapshot_name, stage_snapshot};
use super::saved_state::SavedState;
use super::snapshot_names::END;
use crate::task::laboratory_error::LaboratoryError;

/// The state of a test in addition to that of the simulation.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Test<R = Recorder> {
    /// The loading of each stage.
    pub(super) stages: Vec<Stage>,
    /// Data of the current stage that its end conditions need.
    pub(super) stage_progress: StageProgress,
    /// One recorder for each stage that has begun; the last belongs to the current stage.
    pub(super) recorders: Vec<R>,
    /// The ends of the completed stages.
    pub(super) ends: Vec<StageEnd>,
    /// The states at these ends, as far as they are recorded; checkpoints of earlier versions have none.
    #[serde(default)]
    pub(super) stage_ends: Vec<StageEndRecord>,
    /// Energy of the sample when strain and work were last set to zero.
    pub(super) before: StoredEnergy,
    /// True if global damping has dissipated energy since then.
    pub(super) damped: bool,
    /// The columns that it records.
    #[serde(alias = "staged", deserialize_with = "columns_of_any_version")]
    pub(super) columns: RecordedColumns,
    /// Values of the measure by which states are spaced at which snapshots are still due.
    #[serde(default)]
    pub(super) snapshots: Vec<f64>,
    /// The state to which stages return, once a stage has saved one.
    #[serde(default)]
    kept: Option<SavedStart>,
}

/// A test in the form of a checkpoint, with recorders that lack their sensors.
pub(super) type SavedTest = Test<SavedRecorder>;

impl SavedTest {
    /// The same with stages as the present version makes them of the case. Checkpoints of earlier versions have the factor on the
    /// densities of the section `[shear]` at one, since it was not yet a part of the stage.
    pub(super) fn of_this_version(mut self, case: &Case) -> SavedTest {
        for (own, stage) in self.stages.iter_mut().zip(case.test_stages()) {
            let was_kept_elsewhere =
                own.density_scaling == 1.0 && self.columns == RecordedColumns::FirstPublished;
            if was_kept_elsewhere && stage.clone().with(|stage| stage.density_scaling = 1.0) == *own {
                *own = stage;
            }
        }
        self
    }

    /// Restores the test by adding the sensors to its recorders.
    pub(super) fn with_sensors(self, sensors: &Sensors) -> Result<Test, SensorError> {
        let recorders = self.recorders.into_iter().map(|recorder| recorder.with_sensors(sensors));
        Ok(Test {
            recorders: recorders.collect::<Result<_, _>>()?,
            stages: self.stages,
            stage_progress: self.stage_progress,
            ends: self.ends,
            stage_ends: self.stage_ends,
            before: self.before,
            damped: self.damped,
            columns: self.columns,
            snapshots: self.snapshots,
            kept: self.kept,
        })
    }
}

/// Checkpoints of earlier versions say whether a test is given as stages, which decided its columns.
fn columns_of_any_version<'d, D: Deserializer<'d>>(from: D) -> Result<RecordedColumns, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Written {
        Columns(RecordedColumns),
        Staged(bool),
    }
    Ok(match Written::deserialize(from)? {
        Written::Columns(columns) => columns,
        Written::Staged(true) => RecordedColumns::All,
        Written::Staged(false) => RecordedColumns::FirstPublished,
    })
}

/// A saved state, with the energy of the sample in it.
#[derive(Clone, Serialize, Deserialize)]
struct SavedStart {
    state: SavedState,
    before: StoredEnergy,
    damped: bool,
}

impl std::fmt::Debug for SavedStart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SavedStart").finish_non_exhaustive()
    }
}

/// Largest number of stages of a test for which a snapshot and a note are written at the end of every stage.
pub(in crate::engine) const MOST_STAGES_NOTED: usize = 24;

impl Test {
    /// Begins the first stage of a case's test.
    pub(super) fn begin(
        case: &Case,
        sensors: &Sensors,
        simulation: &mut Simulation,
    ) -> Result<Test, LaboratoryError> {
        simulation.reset_phase(0.0);
        let TestDefinition { stages, snapshots, columns, .. } = case.test_definition();
        let mut test = Test {
            stages,
            stage_progress: StageProgress::default(),
            recorders: Vec::new(),
            ends: Vec::new(),
            stage_ends: Vec::new(),
            before: StoredEnergy::from_assembly(&simulation.assembly()),
            damped: false,
            columns,
            snapshots,
            kept: None,
        };
        test.begin_stage(case, sensors, simulation)?;
        Ok(test)
    }

    /// Begins the next stage.
    pub(super) fn begin_stage(
        &mut self,
        case: &Case,
        sensors: &Sensors,
        simulation: &mut Simulation,
    ) -> Result<(), LaboratoryError> {
        let Some(stage) = self.stages.get(self.recorders.len()) else { return Ok(()) };
        match (stage.start, &self.kept) {
            (Start::Here, _) => {}
            (Start::Kept, _) => {
                let state = SavedState::from_simulation(simulation)?;
                self.kept = Some(SavedStart { state, before: self.before, damped: self.damped });
            }
            (Start::Back, Some(kept)) => {
                *simulation = kept.state.restore(case.vocabulary.laws())?;
                (self.before, self.damped) = (kept.before, kept.damped);
            }
            (Start::Back, None) => return Err(LaboratoryError::NothingKept { stage: stage.name.clone() }),
        }
        let properties = case.properties().with_densities(stage.density_scaling);
        if *simulation.properties() != properties {
            simulation.set_properties(properties)?;
        }
        for bond in case.bonds.iter().filter(|bond| bond.before_stage() == self.recorders.len() + 1) {
            simulation.bond(&bond.bonding(case.vocabulary.laws()))?;
        }
        if stage.resets {
            self.before = StoredEnergy::from_assembly(&simulation.assembly());
            self.damped = false;
        }
        self.damped |= stage.settling;
        self.stage_progress = begin(stage, simulation)?;
        let recorder = self.fresh_recorder(case, sensors, self.recorders.len())?;
        self.recorders.extend(recorder);
        Ok(())
    }

    /// A new recorder for a stage that begins.
    fn fresh_recorder(
        &self,
        case: &Case,
        sensors: &Sensors,
        at: usize,
    ) -> Result<Option<Recorder>, SensorError> {
        let Some(stage) = self.stages.get(at) else { return Ok(None) };
        let origin = self.stage_progress.origin(stage.record.measure);
        let laws = case.vocabulary.laws();
        let agglomerates = case.bonds.iter().any(|bond| bond.bonding(laws).places == BondPlaces::Inside);
        let sensors = sensors
            .for_clumps(!case.grains.are_spheres())
            .for_bonds(!case.bonds.is_empty())
            .for_agglomerates(agglomerates);
        Recorder::of_stage(&sensors, &case.recording, self.columns, &stage.record, origin).map(Some)
    }

    /// True if this can be a test of the case. A state with another end condition or rate might never reach its end.
    pub(super) fn is_of(&self, case: &Case, sensors: &Sensors) -> bool {
        let (at, test) = (self.ends.len(), case.test_definition());
        let last = self.fresh_recorder(case, sensors, at.min(self.recorders.len().saturating_sub(1)));
        let last = last.ok().flatten();
        let alike = self.recorders.last().zip(last).is_some_and(|(own, fresh)| own.is_like(&fresh));
        alike
            && self.columns == test.columns
            && self.stages == test.stages
            && (at..=at + 1).contains(&self.recorders.len())
            && self.recorders.len() <= self.stages.len()
            && test.snapshots.ends_with(&self.snapshots)
    }

    /// The measurements so far.
    pub(super) fn record(&self) -> Record {
        Recorder::record_of_stages(&self.recorders, self.columns)
    }

    /// The states that have been recorded so far, without the one under way.
    pub(super) fn recorded_states(&self) -> Vec<RecordedState> {
        let mut states = Vec::new();
        for (k, recorder) in self.recorders.iter().enumerate() {
            let count = if k < self.ends.len() { recorder.states() } else { recorder.complete_states() };
            states.extend((0..count).map(|index| recorder.state(index, k + 1, self.columns)));
        }
        states
    }

    /// Number of samples that could not be taken, summed over all stages.
    pub(super) fn missed_observations(&self) -> granum_sensors::MissedObservations {
        self.recorders
            .iter()
            .map(Recorder::missed_observations)
            .fold(Default::default(), |sum, one| sum.plus(one))
    }

    /// Number of steps of all stages; `step` is the current step of the simulation.
    pub(super) fn steps(&self, step: u64) -> u64 {
        let before: u64 = self.ends.iter().map(|end| end.steps).sum();
        let under_way = self.recorders.len() > self.ends.len();
        if under_way { before + step.saturating_sub(self.stage_progress.start_step) } else { before }
    }

    /// True if a snapshot is still due, or is written at the end of the test in any case.
    pub(super) fn will_write(&self, snapshot: &str) -> bool {
        let of_stages = (self.ends.len() + 1..self.stages.len()).map(stage_snapshot);
        let mut due = self.snapshots.iter().map(|strain| snapshot_name(*strain)).chain(of_stages);
        snapshot == END || due.any(|name| name == snapshot)
    }

    /// Number of stages.
    pub(super) fn stages(&self) -> usize {
        self.stages.len()
    }

    /// The stages.
    pub(super) fn list(&self) -> &[Stage] {
        &self.stages
    }

    /// Name of the current stage.
    pub(super) fn stage_name(&self) -> &str {
        self.stages.get(self.ends.len()).map_or("", |stage| stage.name.as_str())
    }
}
