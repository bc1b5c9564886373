//! Loading: a test is a list of stages. A stage defines the control of the cell ([`Control`]), its end ([`Until`]), and the
//! values of a measure at which states are recorded ([`RecordedStates`]). Named paths are presets, one file each ([`preset`]).

mod control;
mod control_error;
mod equations;
mod history;
pub(crate) mod measure;
pub mod preset;
mod recorded_states;
mod reference_stress;
mod stage_progress;
mod tension;
mod until;
mod zero_stress;

use serde::{Deserialize, Serialize};

pub use self::control::{
    Constraint, Control, Drive, EASE, Kinematics, RESPONSE, Ramp, SERVO_LIMIT, SHORTEST_RAMP, Speed, Target,
    YIELDING,
};
pub use self::control_error::ControlError;
pub use self::history::{History, HistoryQuantity, MOST_ROWS};
pub use self::measure::{MacroState, Measure, MeasureGoal};
pub use self::recorded_states::RecordedStates;
pub use self::stage_progress::StageProgress;
use self::tension::Tension;
pub(crate) use self::until::overlap_text;
pub use self::until::{Reason, Until};
use crate::config::{LARGEST_OVERLAP, Rate};
use crate::observer::{Flow, Phase, SimulationObserver, SimulationProgress};
use crate::simulation::Simulation;
use crate::simulation_error::SimulationError;
use crate::slices;
use crate::state::ServoError;

/// Largest number of steps between two calls of the observer.
const STRIDE: u64 = 500;
/// Global damping of a settling stage: fraction of a velocity that is lost per `sqrt(m / k_t)`.
const SETTLING: f64 = 0.005;
/// Arc length of strain from which on the accuracy of the servo is evaluated where the cell is strained.
pub const START_UP: f64 = 1.0 / 300.0;

/// One stage of a test.
///
/// ```
/// use granum_dem::loading::{Control, Drive, Measure, Speed, Stage, Target, Until};
///
/// // Drained triaxial compression to an axial strain of 0.1.
/// let (held, fixed) = (Drive::Stress(Target::current()), Drive::Fixed);
/// let speed = Speed::InertialNumber { number: 1e-3, at: None };
/// let control = Control::new(speed, [Drive::Rate(1.0), held, held, fixed, fixed, fixed]);
/// let end = Until::Reaches { measure: Measure::Strain(0), value: 0.1 };
/// let stage = Stage::new("shear", control, vec![end]);
/// assert!(stage.control.check().is_ok() && !stage.resets);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Stage {
    /// Its name in reports, e.g. `shear`.
    pub name: String,
    /// The control of the cell.
    pub control: Control,
    /// Points at which base rates and moving targets are reversed.
    pub turns: Option<Turns>,
    /// Its end conditions; the first that is met ends it.
    pub until: Vec<Until>,
    /// Arc length of strain after which it ends in any case. It also ends after the time that four times this arc length
    /// takes at the speed of the stage, and when the sample no longer carries stress while its volume does not decrease, unless the
    /// stage asks for no stress. `None` for a stage that is certain to reach its end.
    pub most_arc_length: Option<f64>,
    /// The states that are recorded.
    pub record: RecordedStates,
    /// True if velocities are damped globally, so that the sample comes to rest.
    pub settling: bool,
    /// True if strain, time and energy are reset to zero at the start of this stage.
    pub resets: bool,
    /// Factor on the density of the grains in this stage. Without gravity only the inertial number matters, so that a strain
    /// rate with a factor is equivalent to a higher rate without it.
    #[serde(default = "one")]
    pub density_scaling: f64,
    /// The state from which it begins, and whether that state is saved for later stages.
    #[serde(default)]
    pub start: Start,
    /// Largest overlap of two grains over the sum of their radii with which it goes on.
    #[serde(default = "usual_overlap", skip_serializing_if = "is_usual_overlap")]
    pub largest_overlap: f64,
}

fn one() -> f64 {
    1.0
}

fn usual_overlap() -> f64 {
    LARGEST_OVERLAP
}

fn is_usual_overlap(overlap: &f64) -> bool {
    *overlap == LARGEST_OVERLAP
}

/// The state from which a stage begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Start {
    /// The end of the previous stage.
    #[default]
    Here,
    /// The end of the previous stage; this state is saved for later stages.
    Kept,
    /// The state that was saved last: everything since then is undone.
    Back,
}

/// Values of a measure between which a stage cycles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Turns {
    /// The measure.
    pub measure: Measure,
    /// Upper turning point, which comes first.
    pub high: f64,
    /// Lower turning point.
    pub low: f64,
}

impl Stage {
    /// The same with some fields changed.
    ///
    /// ```
    /// use granum_dem::loading::{Control, Drive, Measure, Speed, Stage, Until};
    ///
    /// let control = Control::new(Speed::StrainRate(1.0), [Drive::Rate(1.0); 6]);
    /// let end = Until::Reaches { measure: Measure::Strain(0), value: 0.1 };
    /// let stage = Stage::new("strain", control, vec![end]).with(|stage| stage.resets = true);
    /// assert!(stage.resets);
    /// ```
    pub fn with(mut self, change: impl FnOnce(&mut Stage)) -> Stage {
        change(&mut self);
        self
    }

    /// A stage that records nothing and has at most an arc length of strain of one.
    pub fn new(name: impl Into<String>, control: Control, until: Vec<Until>) -> Stage {
        Stage {
            name: name.into(),
            control,
            turns: None,
            until,
            most_arc_length: Some(1.0),
            record: RecordedStates::default(),
            settling: false,
            resets: false,
            density_scaling: 1.0,
            start: Start::Here,
            largest_overlap: LARGEST_OVERLAP,
        }
    }

    /// A stage without duration, which records the present state of the sample.
    pub fn mark(name: impl Into<String>) -> Stage {
        let control = Control { speed: Speed::StrainRate(1.0), ..Control::default() };
        Stage::new(name, control, vec![Until::Reaches { measure: Measure::Time, value: 0.0 }])
    }

    /// True if it is one of [`Stage::mark`].
    pub fn is_mark(&self) -> bool {
        self.until == [Until::Reaches { measure: Measure::Time, value: 0.0 }]
    }

    /// The same with states recorded.
    pub fn recording(self, record: RecordedStates) -> Stage {
        Stage { record, ..self }
    }

    /// The value of a measure at which it ends, if that is one of its end conditions.
    pub fn end_at(&self, measure: Measure) -> Option<f64> {
        self.until.iter().find_map(|until| match *until {
            Until::Reaches { measure: of_end, value } => (of_end == measure).then_some(value),
            _ => None,
        })
    }

    /// The completed fraction of the stage, where it follows from the first end condition that is a value of a measure.
    pub fn fraction(&self, stage_progress: &StageProgress, simulation: &Simulation) -> Option<f64> {
        self.until.iter().find_map(|until| {
            let Until::Reaches { measure, value } = *until else { return None };
            let start = measure.value(&stage_progress.start);
            let here = measure.value(&simulation.state().macro_state());
            let way = value + stage_progress.origin(measure) - start;
            (way != 0.0).then(|| ((here - start) / way).clamp(0.0, 1.0))
        })
    }
}

/// How the execution of a stage ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// The stage is complete.
    Complete(Reason),
    /// The observer stopped it; the simulation can be continued from here.
    Stopped,
}

/// The end of a completed stage, for the record of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageEnd {
    /// Its name.
    pub name: String,
    /// Why it ended.
    pub reason: Reason,
    /// Number of its steps.
    pub steps: u64,
    /// Its duration, s.
    pub time: f64,
    /// How accurately its stresses were held.
    pub servo_error: ServoError,
}

impl StageEnd {
    /// The record of a stage that has just ended.
    pub fn new(
        stage: &Stage,
        stage_progress: &StageProgress,
        reason: Reason,
        simulation: &Simulation,
    ) -> StageEnd {
        let state = simulation.state();
        StageEnd {
            name: stage.name.clone(),
            reason,
            steps: state.step().saturating_sub(stage_progress.start_step),
            time: state.time() - stage_progress.start.time,
            servo_error: state.servo_error(),
        }
    }
}

/// Begins a stage: sets the control of the cell and the start of the servo statistics.
///
/// # Errors
/// [`ControlError`] if the control is not possible.
pub fn begin(stage: &Stage, simulation: &mut Simulation) -> Result<StageProgress, ControlError> {
    if stage.resets {
        simulation.reset_phase(0.0);
    }
    let control = stage.control.begin(simulation)?;
    simulation.damp_globally(if stage.settling { SETTLING } else { 0.0 });
    let mut stage_progress = StageProgress::begin(simulation);
    // While rates increase from zero, only half of the full change takes place.
    let ramp = stage.control.ramp_time(simulation);
    stage_progress.ramp = ramp.map(|time| time + 0.5 * control.ease);
    stage_progress.tension = Tension::asked_for(&stage.until, &control, ramp, simulation.state());
    let start_up = if stage.control.is_strained() && !stage.control.eases { START_UP } else { 0.0 };
    simulation.judge_servo(stage_progress.start.arc_length + start_up);
    simulation.set_control(control);
    Ok(stage_progress)
}

/// Executes a stage that was begun, from the present state of the simulation to its end.
///
/// Every event of a stage happens at the first step at which it is due, regardless of how the steps before were grouped.
///
/// # Errors
/// [`SimulationError`] if the simulation fails.
pub fn follow(
    stage: &Stage,
    stage_progress: &mut StageProgress,
    simulation: &mut Simulation,
    observer: &mut dyn SimulationObserver,
) -> Result<Ending, SimulationError> {
    let measure = stage.record.measure;
    let origin = stage_progress.origin(measure);
    let most_time = most_time(stage, stage_progress, simulation);
    let mut goals = Vec::new();
    add_events(stage, stage_progress, observer, &mut goals);
    let since = simulation.state().step() - stage_progress.start_step;
    // A run that was stopped between two checks goes on to the next one.
    let mut between = !since.is_multiple_of(STRIDE) && !slices::has_come(&goals, simulation);
    loop {
        if !std::mem::take(&mut between) {
            let here = measure.value(&simulation.state().macro_state()) - origin;
            while observer.next_observation() <= here {
                let due = observer.next_observation();
                observer.observe(&*simulation);
                if observer.next_observation() == due {
                    // The observer computes the measure in another way and finds it short by a rounding error: it will be
                    // reached in the next step.
                    break;
                }
            }
            turn(stage, stage_progress, simulation);
            let end = stage_progress.check(&stage.until, simulation.state());
            let torn = stage_progress.note_tension(simulation.state());
            let end = end.or(torn).or_else(|| too_deep(stage, stage_progress, simulation));
            if let Some(reason) = end.or_else(|| cut_short(stage, stage_progress, simulation, most_time)) {
                return Ok(Ending::Complete(reason));
            }
            if observer.progress(&progress_of(stage, stage_progress, simulation)) == Flow::Stop {
                return Ok(Ending::Stopped);
            }
            add_events(stage, stage_progress, observer, &mut goals);
        }
        let left = STRIDE - (simulation.state().step() - stage_progress.start_step) % STRIDE;
        let flow = slices::advance(simulation, &goals, left, observer, |simulation| {
            progress_of(stage, stage_progress, simulation)
        })?;
        if flow == Flow::Stop {
            return Ok(Ending::Stopped);
        }
    }
}

/// The progress of a stage as observers see it.
fn progress_of<'a>(
    stage: &Stage,
    stage_progress: &StageProgress,
    simulation: &'a Simulation,
) -> SimulationProgress<'a> {
    let (steps, time) = (simulation.state().step(), simulation.state().time());
    let fraction = stage.fraction(stage_progress, simulation);
    let progress = SimulationProgress::new(Phase::Test, steps, time, simulation);
    SimulationProgress { fraction, measure: Some(stage.record.measure), ..progress }
}

/// The goals at which something may be due in a stage.
fn add_events(
    stage: &Stage,
    stage_progress: &StageProgress,
    observer: &dyn SimulationObserver,
    goals: &mut Vec<MeasureGoal>,
) {
    goals.clear();
    let (measure, next) = (stage.record.measure, observer.next_observation());
    if next.is_finite() {
        goals.push(MeasureGoal {
            measure,
            origin: stage_progress.origin(measure),
            value: next,
            rising: true,
        });
    }
    goals.extend(turning_point(stage, stage_progress));
    stage_progress.goals(&stage.until, goals);
}

/// The reason for the end if grains overlap too far. This is checked at the start and every [`STRIDE`] steps, whatever is observed.
fn too_deep(stage: &Stage, stage_progress: &StageProgress, simulation: &Simulation) -> Option<Reason> {
    let state = simulation.state();
    if !(state.step() - stage_progress.start_step).is_multiple_of(STRIDE) {
        return None;
    }
    let (overlap, limit) = (state.largest_overlap(), stage.largest_overlap);
    (overlap > limit).then_some(Reason::TooDeep { overlap, limit })
}

/// Reverses a stage at its turning points.
fn turn(stage: &Stage, stage_progress: &mut StageProgress, simulation: &mut Simulation) {
    let Some(goal) = turning_point(stage, stage_progress) else { return };
    if goal.has_come(&simulation.state().macro_state()) {
        simulation.reverse();
        stage_progress.turn(simulation.state());
    }
}

fn turning_point(stage: &Stage, stage_progress: &StageProgress) -> Option<MeasureGoal> {
    let Turns { measure, high, low } = stage.turns?;
    let rising = stage_progress.reversals.is_multiple_of(2);
    let value = if rising { high } else { low };
    Some(MeasureGoal { measure, origin: stage_progress.origin(measure), value, rising })
}

/// The longest permitted duration of a stage, s. A stage that ends at a given time is permitted twice that time.
fn most_time(stage: &Stage, stage_progress: &StageProgress, simulation: &Simulation) -> f64 {
    let control = simulation.state().control();
    let limit = control.rate_limit / stage.control.servo_limit.max(f64::MIN_POSITIVE);
    let asked = stage.until.iter().filter_map(|until| match until {
        Until::Reaches { measure: Measure::Time, value } => Some(2.0 * value),
        Until::RampOver => stage_progress.ramp.map(|time| 2.0 * time),
        _ => None,
    });
    let by_strain =
        if limit > 0.0 { 4.0 * stage.most_arc_length.unwrap_or(f64::MAX) / limit } else { f64::INFINITY };
    asked.fold(by_strain, f64::max)
}

/// The reason why a stage cannot be continued, if there is one.
fn cut_short(
    stage: &Stage,
    stage_progress: &StageProgress,
    simulation: &Simulation,
    most_time: f64,
) -> Option<Reason> {
    let most = stage.most_arc_length?;
    if let Some(reason) = stage_progress.unjammed(&stage.until, simulation.state()) {
        return Some(reason);
    }
    let macro_state = simulation.state().macro_state();
    let arc_length = macro_state.arc_length - stage_progress.start.arc_length;
    let time = macro_state.time - stage_progress.start.time;
    (arc_length > most || time > most_time).then_some(Reason::TooLong { arc_length, time })
}

/// The density factor of a [`Rate`].
pub fn density_scaling(rate: &Rate) -> f64 {
    match rate {
        Rate::InertialNumber(_) => 1.0,
        Rate::StrainRate { density_scaling, .. } => *density_scaling,
    }
}
