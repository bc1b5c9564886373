//! Observers of a preparation or a test that need its state: recorders, probes, the display of stresses.
//!
//! There is one trait for following any work, [`Observer`], and whatever implements it follows a run as well: it receives
//! the progress and the events as owned data. [`SimulationObserver`] adds access to the state, which sensors need, whatever engine
//! computes it; every [`Observer`] is one.

use granum_core::ObservedState;
use granum_core::observer::{self, Event};
pub use granum_core::observer::{Flow, NoObserver, Observer};

use crate::loading::measure::Measure;
use crate::simulation::Simulation;

/// The phase of a preparation or test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Placing of the grains at random, before the first step.
    Placing,
    /// Isotropic compression.
    Compaction,
    /// Relaxation to equilibrium with the final properties.
    Relaxation,
    /// Isotropic compression or unloading of a sample to another mean stress.
    Consolidation,
    /// Strain cycles of a preparation.
    Cycles,
    /// A stage of a preparation, between its compaction and its relaxation.
    PreparationStage,
    /// The test of a sample: its loading path, stage by stage.
    Test,
}

impl Phase {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Placing => "placing of the grains",
            Phase::Compaction => "compaction",
            Phase::Relaxation => "relaxation",
            Phase::Consolidation => "consolidation",
            Phase::Cycles => "cycles",
            Phase::PreparationStage => "preparation stage",
            Phase::Test => "test",
        }
    }
}

/// The progress of a phase.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct SimulationProgress<'a> {
    /// The phase.
    pub phase: Phase,
    /// Number of the trial of the preparation, from 1.
    pub trial: usize,
    /// Name of the present stage of a test or of a preparation.
    pub stage: Option<&'a str>,
    /// The measure by which the states of the present stage of a test are spaced.
    pub measure: Option<Measure>,
    /// Axis (0 for x) about which the present stage is axisymmetric, so that its deviator stress q is the axial stress less the mean
    /// lateral one; `None` for a general stage, or where it is not known.
    pub axis: Option<usize>,
    /// Fraction of the phase that is complete, where it can be determined.
    pub fraction: Option<f64>,
    /// Steps since the start of the preparation, in all its trials, or of the path.
    pub steps: u64,
    /// Simulated time since then, s.
    pub time: f64,
    /// Grain-steps per second of wall time, once they have been measured.
    pub grain_steps_per_second: Option<f64>,
    /// What is computed, as it is now.
    pub state: &'a dyn ObservedState,
}

impl<'a> SimulationProgress<'a> {
    /// The progress of a phase.
    pub fn new(phase: Phase, steps: u64, time: f64, state: &'a dyn ObservedState) -> SimulationProgress<'a> {
        SimulationProgress {
            phase,
            trial: 1,
            stage: None,
            measure: None,
            axis: None,
            fraction: None,
            steps,
            time,
            grain_steps_per_second: None,
            state,
        }
    }

    /// The simulation, if it is granum's engine that computes.
    pub fn simulation(&self) -> Option<&'a Simulation> {
        self.state.as_any().downcast_ref()
    }

    /// The same progress as owned data, with the simulated time and, once it has been measured, the speed among its values.
    pub fn report(&self) -> observer::Progress {
        let mut report =
            observer::Progress::new(self.phase.name(), "steps", self.steps).fraction(self.fraction);
        report.part = self.stage.map(str::to_owned);
        report = report.with("time", self.time, "s");
        if self.trial > 1 {
            report = report.with("trial", self.trial as f64, "");
        }
        match self.grain_steps_per_second {
            Some(speed) => report.with("grain_steps_per_second", speed, "1/s"),
            None => report,
        }
    }
}

/// Work between two calls of [`SimulationObserver::progress`] that may take seconds.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub enum Work<'a> {
    /// Grains are placed at random for the initial state of a sample.
    Placing {
        /// Grains that have a place.
        placed: usize,
        /// Grains that need one.
        count: usize,
    },
    /// Steps are made; this is the progress so far.
    Steps(&'a SimulationProgress<'a>),
    /// Another program makes the steps; this is what it told last.
    Elsewhere(&'a observer::Progress),
}

impl Work<'_> {
    /// The same as owned data.
    pub fn report(&self) -> observer::Progress {
        match self {
            Work::Placing { placed, count } => {
                observer::Progress::new(Phase::Placing.name(), "grains", *placed as u64).out_of(*count as u64)
            }
            Work::Steps(progress) => progress.report(),
            Work::Elsewhere(progress) => (*progress).clone(),
        }
    }
}

/// Number of grain-steps (grains times steps) after which an observer is told of the work, unless it wants to be told at another number:
/// a tenth of a second on a usual computer.
pub const WORK_EVERY: u64 = 1_000_000;

/// Follows a preparation or a test. It has only a shared reference to the state, so that it can stop the run but cannot change
/// a result, and a run that was stopped is resumed with the same bits.
///
/// Every method has a default, so that an observer implements only the methods that it needs. Who does not need the state
/// implements [`Observer`], or gives a closure that takes a [`observer::Progress`] and returns a [`Flow`]; a closure that needs it
/// is an [`EachProgress`]. Several observers can be combined into one ([`SimulationObservers`]).
///
/// ```
/// use granum_dem::config::{ContactModel, Grains, Preparation};
/// use granum_dem::observer::{Flow, SimulationObserver, SimulationProgress};
/// use granum_dem::preparation::{PreparationError, SampleSpecification, prepare};
///
/// /// Stops once the grains fill two fifths of the cell.
/// #[derive(Default)]
/// struct UntilDense {
///     calls: usize,
/// }
///
/// impl SimulationObserver for UntilDense {
///     fn progress(&mut self, progress: &SimulationProgress) -> Flow {
///         self.calls += 1;
///         let dense = progress.state.solid_fraction() > 0.4;
///         if dense { Flow::Stop } else { Flow::Continue }
///     }
/// }
///
/// let (grains, contact) = (Grains::default().with(|grains| grains.count = 60), ContactModel::default());
/// let preparation = Preparation::default().with(|preparation| preparation.inertial_number = 1e-2);
/// let specification = SampleSpecification::new(&grains, &contact, &preparation);
/// let mut observer = UntilDense::default();
/// assert!(matches!(prepare(&specification, &mut observer), Err(PreparationError::Stopped { .. })));
/// assert!(observer.calls > 1);
/// ```
pub trait SimulationObserver {
    /// Called every few hundred steps; returns whether to continue or to stop.
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        let _ = progress;
        Flow::Continue
    }

    /// Called during work that may take seconds, between two calls of [`SimulationObserver::progress`], so that it can be shown and stopped;
    /// returns whether to continue. How often it is called is no part of a result: nothing is to be recorded here.
    fn work(&mut self, work: &Work) -> Flow {
        let _ = work;
        Flow::Continue
    }

    /// Number of grain-steps after which [`SimulationObserver::work`] is to be called.
    fn work_every(&self) -> u64 {
        WORK_EVERY
    }

    /// Called when a stage of a test starts, or is resumed from a checkpoint; stages are counted from 1.
    fn stage(&mut self, number: usize) {
        self.event(&Event::StageStarted { number });
    }

    /// Value of the measure that a stage records by at which [`SimulationObserver::observe`] is to be called next; infinity for never.
    fn next_observation(&self) -> f64 {
        f64::INFINITY
    }

    /// That value has been reached, at the first step at which it is.
    fn observe(&mut self, state: &dyn ObservedState) {
        let _ = state;
    }

    /// Something that the user should know and that does not end the run.
    fn warn(&mut self, text: &str) {
        self.event(&Event::Warning { text: text.to_owned() });
    }

    /// Called when something happened, as owned data; this includes stages and warnings unless the methods for these are
    /// implemented.
    fn event(&mut self, event: &Event) {
        let _ = event;
    }
}

/// Every observer of work follows runs: it receives the progress, also that of work between two checks, and the events, as owned data.
///
/// ```
/// use granum_core::observer::{Event, Observer};
/// use granum_dem::observer::SimulationObserver;
///
/// struct Warnings(Vec<Event>);
///
/// impl Observer for Warnings {
///     fn event(&mut self, event: &Event) {
///         self.0.push(event.clone());
///     }
/// }
///
/// let mut warnings = Warnings(Vec::new());
/// warnings.warn("the sample is loose");
/// assert_eq!(warnings.0, [Event::Warning { text: "the sample is loose".into() }]);
/// ```
impl<O: Observer + ?Sized> SimulationObserver for O {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        Observer::progress(self, &progress.report())
    }

    fn work(&mut self, work: &Work) -> Flow {
        Observer::progress(self, &work.report())
    }

    fn event(&mut self, event: &Event) {
        Observer::event(self, event);
    }
}

/// A closure that is called with each progress and its state, and can stop the run.
pub struct EachProgress<F>(pub F);

impl<F: FnMut(&SimulationProgress) -> Flow> SimulationObserver for EachProgress<F> {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        self.0(progress)
    }
}

/// Several observers as one: they are called one after the other, and the run stops if one of them requests it.
///
/// ```
/// use granum_core::observer::{Flow, NoObserver, Progress};
/// use granum_dem::observer::{SimulationObserver, SimulationObservers};
///
/// let mut calls = 0;
/// let mut counting = |_: &Progress| {
///     calls += 1;
///     Flow::Continue
/// };
/// let mut none = NoObserver;
/// let both = SimulationObservers(vec![&mut counting, &mut none]);
/// assert_eq!(both.next_observation(), f64::INFINITY);
/// ```
pub struct SimulationObservers<'a>(pub Vec<&'a mut dyn SimulationObserver>);

impl SimulationObserver for SimulationObservers<'_> {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        // Every observer is notified, also after one has requested the stop.
        self.0.iter_mut().fold(Flow::Continue, |flow, observer| flow.and(observer.progress(progress)))
    }

    fn work(&mut self, work: &Work) -> Flow {
        self.0.iter_mut().fold(Flow::Continue, |flow, observer| flow.and(observer.work(work)))
    }

    fn work_every(&self) -> u64 {
        self.0.iter().map(|observer| observer.work_every()).min().unwrap_or(WORK_EVERY)
    }

    fn stage(&mut self, number: usize) {
        self.0.iter_mut().for_each(|observer| observer.stage(number));
    }

    fn next_observation(&self) -> f64 {
        self.0.iter().map(|observer| observer.next_observation()).fold(f64::INFINITY, f64::min)
    }

    fn observe(&mut self, state: &dyn ObservedState) {
        let due = self.next_observation();
        for observer in &mut self.0 {
            if observer.next_observation() <= due {
                observer.observe(state);
            }
        }
    }

    fn warn(&mut self, text: &str) {
        for observer in &mut self.0 {
            observer.warn(text);
        }
    }

    fn event(&mut self, event: &Event) {
        self.0.iter_mut().for_each(|observer| observer.event(event));
    }
}
