//! The test itself: its stages one after another, with a recorder each.

use granum_core::quantity::format_number;
use granum_dem::loading::{
    self, Ending, Stage as Loading, StageEnd, StageProgress, Start, Watcher, begin, density_scaling,
};
use granum_dem::preparation::{Flow, Progress};
use granum_dem::simulation::{Properties, Simulation};
use granum_io::Case;
use granum_sensors::{Record, Recorder};
use serde::{Deserialize, Serialize};

use super::run_state::{RunState, Stage};
use super::saved_state::SavedState;
use super::store::Store;
use super::{Interval, Laboratory, LaboratoryError, RunObserver, Segment, Speedometer, Status, quality};

/// What a test remembers beside the state of the simulation.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Test {
    /// What is done, stage by stage.
    stages: Vec<Loading>,
    /// What the ends of the stage under way have to remember.
    stage_progress: StageProgress,
    /// One for each stage that was begun; the last belongs to the one under way.
    recorders: Vec<Recorder>,
    /// The stages that are over.
    pub(super) ends: Vec<StageEnd>,
    /// Energy of the sample when strains and energy began to be counted.
    pub(super) before: quality::Stored,
    /// True if energy has been lost to global damping since then.
    pub(super) damped: bool,
    /// True if the case gives its test as stages.
    pub(super) staged: bool,
    /// Deviator strains at which a snapshot is still to be taken.
    #[serde(default)]
    snapshots: Vec<f64>,
    /// The state that stages go back to, once a stage has kept one.
    #[serde(default)]
    kept: Option<Kept>,
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

/// Name of the snapshot at a strain, e.g. `strain-0_05`.
fn snapshot_name(strain: f64) -> String {
    format!("strain-{}", format_number(strain).replace('.', "_"))
}

/// Name of the snapshot at the end of a stage that others follow.
fn stage_snapshot(number: usize) -> String {
    format!("stage-{number}")
}

impl Test {
    /// Begins the first stage of a case's test.
    fn begin(case: &Case, simulation: &mut Simulation) -> Result<Test, LaboratoryError> {
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
        test.begin_stage(case, simulation)?;
        Ok(test)
    }

    /// Begins the next stage.
    fn begin_stage(&mut self, case: &Case, simulation: &mut Simulation) -> Result<(), LaboratoryError> {
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
            let mut properties = *simulation.properties();
            let density = case.grains.material.density * stage.density_scaling;
            if properties.material.density != density {
                properties.material.density = density;
                simulation.set_properties(properties)?;
            }
        }
        if stage.resets {
            self.before = quality::Stored::of(&simulation.assembly());
            self.damped = false;
        }
        self.damped |= stage.settling;
        self.stage_progress = begin(stage, simulation)?;
        let recorder = self.fresh_recorder(case, self.recorders.len());
        self.recorders.extend(recorder);
        Ok(())
    }

    /// The recorder of a stage that is just begun.
    fn fresh_recorder(&self, case: &Case, at: usize) -> Option<Recorder> {
        let stage = self.stages.get(at)?;
        if !self.staged {
            return Some(Recorder::new(&case.recording, case.shear.deviator_strain));
        }
        let origin = self.stage_progress.origin(stage.record.measure);
        Some(Recorder::of_stage(&case.recording, &stage.record, origin))
    }

    /// True if it can be a test of the case: with another end or rate it would perhaps never end.
    pub(super) fn is_of(&self, case: &Case) -> bool {
        let (at, staged) = (self.ends.len(), case.has_stages());
        let last = self.fresh_recorder(case, at.min(self.recorders.len().saturating_sub(1)));
        let alike = self.recorders.last().zip(last).is_some_and(|(own, fresh)| own.is_like(&fresh));
        alike
            && self.staged == staged
            && self.stages == case.test_stages()
            && (at..=at + 1).contains(&self.recorders.len())
            && self.recorders.len() <= self.stages.len()
            && case.recording.snapshots.ends_with(&self.snapshots)
    }

    /// What the sensors saw so far.
    pub(super) fn record(&self) -> Record {
        match self.recorders.first() {
            Some(only) if !self.staged => only.record(),
            _ => Recorder::record_of_stages(&self.recorders),
        }
    }

    /// Looks that could not be taken in all stages.
    pub(super) fn shortfall(&self) -> granum_sensors::Shortfall {
        self.recorders.iter().map(Recorder::shortfall).fold(Default::default(), |sum, one| sum.plus(one))
    }

    /// Steps of all stages; `step` is that of the simulation now.
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

    /// Name of the stage under way.
    pub(super) fn stage_name(&self) -> &str {
        self.stages.get(self.ends.len()).map_or("", |stage| stage.name.as_str())
    }
}

/// Watches a stage: lets the recorder look, takes snapshots, reports, stops for a checkpoint.
struct Watch<'a> {
    stage: &'a Loading,
    stage_progress: StageProgress,
    /// Where it stands among how many.
    place: [usize; 2],
    staged: bool,
    recorder: &'a mut Recorder,
    snapshots: &'a mut Vec<f64>,
    store: Store<'a>,
    /// Why a snapshot could not be written; the test then stops.
    failed: Option<granum_io::Error>,
    observer: &'a mut dyn RunObserver,
    speedometer: &'a mut Speedometer,
    interval: Interval,
    stopped: bool,
}

impl Watcher for Watch<'_> {
    fn next_look(&self) -> f64 {
        self.snapshots.first().copied().unwrap_or(f64::INFINITY).min(self.recorder.next_look())
    }
    fn look(&mut self, simulation: &Simulation) {
        let measure = self.stage.record.measure;
        let here = measure.of(&simulation.state().macro_state()) - self.stage_progress.origin(measure);
        let assembly = simulation.assembly();
        // The recorder may not look earlier for the sake of a snapshot.
        if self.recorder.next_look() <= here {
            self.recorder.look(&assembly);
        }
        while self.snapshots.first().is_some_and(|due| *due <= here) {
            let name = snapshot_name(self.snapshots.remove(0));
            if let Err(error) = self.store.snapshot(&name, &assembly) {
                self.failed.get_or_insert(error);
            }
        }
    }
    fn progress(&mut self, progress: &Progress) -> Flow {
        if self.failed.is_some() {
            return Flow::Stop;
        }
        let simulation = progress.simulation;
        let [at, all] = self.place;
        let fraction = self.stage.fraction(&self.stage_progress, simulation);
        self.observer.status(&Status {
            phase: progress.phase,
            trial: 1,
            stage: self.staged.then_some(self.stage.name.as_str()),
            fraction: fraction.map(|part| (at as f64 + part) / all.max(1) as f64),
            grain_steps_per_second: self.speedometer.rate(simulation),
            simulation,
        });
        self.stopped = self.observer.stop();
        if self.stopped || self.interval.is_over() { Flow::Stop } else { Flow::Continue }
    }
}

impl Laboratory {
    /// Makes a sample ready to be tested as the case says.
    pub(super) fn begin_test(
        &self,
        case: &Case,
        run_state: &mut RunState,
    ) -> Result<Segment, LaboratoryError> {
        let simulation = &mut run_state.simulation;
        let mut material = case.grains.material;
        if !case.has_stages() {
            material.density *= density_scaling(&case.shear.rate);
        }
        simulation.set_properties(Properties { material, contact: case.contact })?;
        simulation.set_time_step_factor(case.numerics.time_step_factor);
        run_state.stage = Stage::Test(Box::new(Test::begin(case, simulation)?));
        Ok(Segment::GoOn)
    }

    /// Goes on with a test to the end of its stage, until a checkpoint is due or the observer stops it.
    pub(super) fn test_on(
        &self,
        case: &Case,
        run_state: &mut RunState,
        store: Store,
        speedometer: &mut Speedometer,
        observer: &mut dyn RunObserver,
    ) -> Result<Segment, LaboratoryError> {
        let Stage::Test(test) = &mut run_state.stage else { return Ok(Segment::GoOn) };
        let simulation = &mut run_state.simulation;
        let at = test.ends.len();
        if test.recorders.len() == at {
            // The last stage is over, or one was cut short.
            return Ok(Segment::Complete);
        }
        let (Some(stage), Some(recorder)) = (test.stages.get(at), test.recorders.last_mut()) else {
            return Ok(Segment::Complete);
        };
        simulation.set_hardware(self.hardware_for(simulation.state().grains()));
        let mut watch = Watch {
            stage,
            stage_progress: test.stage_progress.clone(),
            place: [at, test.stages.len()],
            staged: test.staged,
            recorder,
            snapshots: &mut test.snapshots,
            store,
            failed: None,
            observer,
            speedometer,
            interval: Interval::new(self.checkpoint_every),
            stopped: false,
        };
        let ending = loading::follow(stage, &mut test.stage_progress, simulation, &mut watch)?;
        if let Some(error) = watch.failed {
            return Err(error.into());
        }
        let stopped = watch.stopped;
        let reason = match ending {
            Ending::Complete(reason) => reason,
            Ending::Stopped if stopped => return Ok(Segment::Stop),
            Ending::Stopped => return Ok(Segment::GoOn),
        };
        test.ends.push(StageEnd::of(stage, &test.stage_progress, reason, simulation));
        // What follows a stage that did not come to its end would not be what was asked for.
        if !reason.is_asked_for() || test.ends.len() == test.stages.len() {
            return Ok(Segment::Complete);
        }
        if test.stages.len() <= STAGES_TOLD {
            store.snapshot(&stage_snapshot(test.ends.len()), &simulation.assembly())?;
        }
        test.begin_stage(case, simulation)?;
        Ok(Segment::GoOn)
    }
}
