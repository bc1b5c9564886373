//! The test of a sample: a sequence of stages, each with its own recorder.

use granum_dem::loading::{
    self, Ending, Stage as Loading, StageEnd, StageProgress, Start, begin, density_scaling,
};
use granum_dem::observer::{Observer, Observers};
use granum_dem::simulation::Simulation;
use granum_io::Case;
use granum_sensors::{Record, Recorder, SavedRecorder, SensorError, Sensors};
use serde::{Deserialize, Serialize};

use super::follow::{self, Follow, Snapshots};
use super::run_state::{RunState, Stage};
use super::saved_state::SavedState;
use super::store::Store;
use super::{Interval, Laboratory, LaboratoryError, Segment, Speedometer, quality};

/// The state of a test in addition to that of the simulation.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Test<R = Recorder> {
    /// The loading of each stage.
    stages: Vec<Loading>,
    /// Data of the current stage that its end conditions need.
    stage_progress: StageProgress,
    /// One recorder for each stage that has begun; the last belongs to the current stage.
    recorders: Vec<R>,
    /// The ends of the completed stages.
    pub(super) ends: Vec<StageEnd>,
    /// Energy of the sample when strain and work were last set to zero.
    pub(super) before: quality::Stored,
    /// True if global damping has dissipated energy since then.
    pub(super) damped: bool,
    /// True if the case defines its test as a list of stages.
    pub(super) staged: bool,
    /// Deviator strains at which snapshots are still due.
    #[serde(default)]
    snapshots: Vec<f64>,
    /// The state that stages go back to, once a stage has kept one.
    #[serde(default)]
    kept: Option<Kept>,
}

/// A test in the form of a checkpoint, with recorders that lack their sensors.
pub(super) type SavedTest = Test<SavedRecorder>;

impl SavedTest {
    /// Restores the test by adding the sensors to its recorders.
    pub(super) fn with_sensors(self, sensors: &Sensors) -> Result<Test, SensorError> {
        let recorders = self.recorders.into_iter().map(|recorder| recorder.with_sensors(sensors));
        Ok(Test {
            recorders: recorders.collect::<Result<_, _>>()?,
            stages: self.stages,
            stage_progress: self.stage_progress,
            ends: self.ends,
            before: self.before,
            damped: self.damped,
            staged: self.staged,
            snapshots: self.snapshots,
            kept: self.kept,
        })
    }
}

/// A state that was kept, with what is known of the energy there.
#[derive(Clone, Serialize, Deserialize)]
struct Kept {
    state: SavedState,
    before: quality::Stored,
    damped: bool,
}

impl std::fmt::Debug for Kept {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Kept").finish_non_exhaustive()
    }
}

/// Most stages for each of which a snapshot and a note are left behind.
pub(super) const STAGES_TOLD: usize = 24;

/// Name of the snapshot at the end of a stage that is followed by another.
fn stage_snapshot(number: usize) -> String {
    format!("stage-{number}")
}

impl Test {
    /// Begins the first stage of a case's test.
    fn begin(case: &Case, sensors: &Sensors, simulation: &mut Simulation) -> Result<Test, LaboratoryError> {
        simulation.reset_phase(0.0);
        let mut test = Test {
            stages: case.test_stages(),
            stage_progress: StageProgress::default(),
            recorders: Vec::new(),
            ends: Vec::new(),
            before: quality::Stored::of(&simulation.assembly()),
            damped: false,
            staged: case.has_stages(),
            snapshots: case.recording.snapshots.clone(),
            kept: None,
        };
        test.begin_stage(case, sensors, simulation)?;
        Ok(test)
    }

    /// Begins the next stage.
    fn begin_stage(
        &mut self,
        case: &Case,
        sensors: &Sensors,
        simulation: &mut Simulation,
    ) -> Result<(), LaboratoryError> {
        let Some(stage) = self.stages.get(self.recorders.len()) else { return Ok(()) };
        match (stage.start, &self.kept) {
            (Start::Here, _) => {}
            (Start::Kept, _) => {
                let state = SavedState::of(simulation)?;
                self.kept = Some(Kept { state, before: self.before, damped: self.damped });
            }
            (Start::Back, Some(kept)) => {
                *simulation = kept.state.restore()?;
                (self.before, self.damped) = (kept.before, kept.damped);
            }
            (Start::Back, None) => return Err(LaboratoryError::NothingKept { stage: stage.name.clone() }),
        }
        if self.staged {
            let properties = case.properties().with_densities(stage.density_scaling);
            if *simulation.properties() != properties {
                simulation.set_properties(properties)?;
            }
        }
        if stage.resets {
            self.before = quality::Stored::of(&simulation.assembly());
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
        if !self.staged {
            return Recorder::new(sensors, &case.recording, case.shear.deviator_strain).map(Some);
        }
        let origin = self.stage_progress.origin(stage.record.measure);
        Recorder::of_stage(sensors, &case.recording, &stage.record, origin).map(Some)
    }

    /// True if this can be a test of the case. A state with another end condition or rate might never reach its end.
    pub(super) fn is_of(&self, case: &Case, sensors: &Sensors) -> bool {
        let (at, staged) = (self.ends.len(), case.has_stages());
        let last = self.fresh_recorder(case, sensors, at.min(self.recorders.len().saturating_sub(1)));
        let last = last.ok().flatten();
        let alike = self.recorders.last().zip(last).is_some_and(|(own, fresh)| own.is_like(&fresh));
        alike
            && self.staged == staged
            && self.stages == case.test_stages()
            && (at..=at + 1).contains(&self.recorders.len())
            && self.recorders.len() <= self.stages.len()
            && case.recording.snapshots.ends_with(&self.snapshots)
    }

    /// The measurements so far.
    pub(super) fn record(&self) -> Record {
        match self.recorders.first() {
            Some(only) if !self.staged => only.record(),
            _ => Recorder::record_of_stages(&self.recorders),
        }
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

    /// Number of stages.
    pub(super) fn stages(&self) -> usize {
        self.stages.len()
    }

    /// The stages.
    pub(super) fn list(&self) -> &[Loading] {
        &self.stages
    }

    /// Name of the current stage.
    pub(super) fn stage_name(&self) -> &str {
        self.stages.get(self.ends.len()).map_or("", |stage| stage.name.as_str())
    }
}

impl Laboratory {
    /// Prepares a sample for the test that the case defines.
    pub(super) fn begin_test(
        &self,
        case: &Case,
        run_state: &mut RunState,
    ) -> Result<Segment, LaboratoryError> {
        let simulation = &mut run_state.simulation;
        let mut properties = case.properties();
        if !case.has_stages() {
            properties = properties.with_densities(density_scaling(&case.shear.rate));
        }
        simulation.set_properties(properties)?;
        simulation.set_time_step_factor(case.numerics.time_step_factor);
        run_state.stage = Stage::Test(Box::new(Test::begin(case, &self.sensors, simulation)?));
        Ok(Segment::GoOn)
    }

    /// Continues a test until the end of its stage, until a checkpoint is due, or until the observer stops it.
    pub(super) fn test_on(
        &self,
        case: &Case,
        run_state: &mut RunState,
        store: Store,
        speedometer: &mut Speedometer,
        observer: &mut dyn Observer,
    ) -> Result<Segment, LaboratoryError> {
        let Stage::Test(test) = &mut run_state.stage else { return Ok(Segment::GoOn) };
        let simulation = &mut run_state.simulation;
        let at = test.ends.len();
        if test.recorders.len() == at {
            // The last stage is complete, or a stage ended before its goal.
            return Ok(Segment::Complete);
        }
        let (Some(stage), Some(recorder)) = (test.stages.get(at), test.recorders.last_mut()) else {
            return Ok(Segment::Complete);
        };
        simulation.set_hardware(self.hardware_for(simulation.state().grains()));
        observer.stage(at + 1);
        let before = test.stage_progress.clone();
        let mut follow = Follow {
            observer,
            speedometer,
            checkpoint: Interval::new(self.checkpoint_every),
            stage: test.staged.then_some(stage.name.as_str()),
            place: [at, test.stages.len()],
            stopped: false,
        };
        let mut record = follow::Record(recorder);
        let mut snapshots = Snapshots {
            due: &mut test.snapshots,
            measure: stage.record.measure,
            stage_progress: &before,
            store,
            failed: None,
        };
        let mut observers = Observers(vec![&mut record, &mut snapshots, &mut follow]);
        let ending = loading::follow(stage, &mut test.stage_progress, simulation, &mut observers)?;
        if let Some(error) = snapshots.failed {
            return Err(error.into());
        }
        let stopped = follow.stopped;
        let reason = match ending {
            Ending::Complete(reason) => reason,
            Ending::Stopped if stopped => return Ok(Segment::Stop),
            Ending::Stopped => return Ok(Segment::GoOn),
        };
        if let Some(recorder) = test.recorders.last_mut() {
            recorder.end();
        }
        test.ends.push(StageEnd::of(stage, &test.stage_progress, reason, simulation));
        // After a stage that did not reach its goal, the following stages would not start from the state that was asked for.
        if !reason.is_asked_for() || test.ends.len() == test.stages.len() {
            return Ok(Segment::Complete);
        }
        if test.stages.len() <= STAGES_TOLD {
            store.snapshot(&stage_snapshot(test.ends.len()), &simulation.assembly())?;
        }
        test.begin_stage(case, &self.sensors, simulation)?;
        Ok(Segment::GoOn)
    }
}
