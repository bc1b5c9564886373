//! Preparation of a sample: random insertion from a seed, isotropic compression, relaxation with the final properties.
//!
//! 1. **Random insertion**: grains at random positions without overlap ([`crate::random_insertion`]).
//! 2. **Compaction**: all axes are servo-controlled to the mean stress of the compaction, with the friction and interface energy of
//!    the preparation; the strain rate is bounded by an inertial number, which is ten times larger while the grains carry hardly
//!    any load. This stress is the target mean stress unless the preparation prescribes a smaller one, which makes looser samples.
//! 3. **Stages**, if there are any: first strain cycles at constant mean stress ([`Preparation::cycles`]), which make the sample
//!    denser, then any loading paths ([`SampleSpecification::stages`]), with the properties of the compaction.
//! 4. **Relaxation**: the final friction and interface energy are set (contacts keep their history), and the servo holds
//!    the stress until the unbalanced force is small. All three axes are brought to the target mean stress: an anisotropic
//!    stress that the stages left is lost, while the density and the fabric that they made remain.
//!
//! A slight global damping of the fluctuating velocities acts in all of them and is switched off in every test after them.
//!
//! A target solid fraction is met by searching for the procedure ([`Procedure`]): with less friction the sample becomes denser, and
//! beyond that with strain cycles; with the friction of the grains it becomes looser, and beyond that with a smaller stress of the
//! compaction. Each trial is a complete preparation from the same seed. A density that is asked for exactly, with a tolerance of 0.001
//! or less, is reached from a trial that is looser, whose sample is then made denser by lowering the friction or by strain cycles.
//!
//! A packing that was made elsewhere replaces the random insertion if it is loose ([`is_loose`]): it is then compacted and
//! relaxed by the same rules, and every trial starts from it again. A packing that carries its load is only brought to rest.
//!
//! A finished sample is brought to another mean stress by a **consolidation**: all axes are servo-controlled to that stress,
//! with the final properties, until the sample is at rest again.
//!
//! A preparation is a [`Preparing`] that advances in short series of steps. None of its state is on the stack, so that it
//! can be saved at any check and resumed.

mod densifying;
mod density_measure;
mod error;
mod next_trial;
mod placed_sample;
mod procedure_search;
mod progress;
mod specification;
mod stages;
mod state;

pub use self::density_measure::DensityMeasure;
pub use self::error::{PreparationError, StageFault};
pub use self::next_trial::NextTrial;
use self::placed_sample::{PlacedSample, place};
pub use self::procedure_search::Procedure;
use self::procedure_search::{Line, closer, repeats};
pub use self::progress::{Sample, Trial};
pub use self::specification::SampleSpecification;
use self::state::PhaseState;
pub use self::state::PreparationState;
use crate::config::Preparation;
use crate::observer::NoObserver;
pub use crate::observer::{Flow, Phase, SimulationObserver, SimulationProgress};
use crate::random_insertion::InsertionError;
use crate::servo::CellControl;
use crate::simulation::Simulation;
use crate::simulation_error::SimulationError;
use crate::slices;

/// Number of steps between two checks for the end of a phase, and between two calls of the observer.
const CHECK_EVERY: u64 = 500;
/// Fraction of the target stress below which the grains hardly carry load.
const LOADED: f64 = 0.02;
/// Rate limit before load is carried, as a multiple of the limit afterwards.
const LOOSE_COMPRESSION: f64 = 10.0;
/// Rate of global damping relative to the frequency sqrt(k/m) of a contact at the target stress.
const GLOBAL_DAMPING: f64 = 0.005;
/// Largest number of trials for the procedure of the preparation.
const MOST_TRIALS: usize = 8;
/// Number of checks in a row that must find the goal of a phase reached.
const CHECKS_TO_CONVERGE: u32 = 3;
/// Largest number of steps of the relaxation.
const MOST_RELAXATION_STEPS: u64 = 400_000;
/// Fraction of the target stress below which a packing is loose.
const LOOSE_BELOW: f64 = 0.5;

/// A preparation in progress: the simulation and the progress within the specification. Both can be saved
/// ([`Simulation::checkpoint`], serde) and resumed, with the same bits at the end as without the interruption.
pub struct Preparing {
    /// The simulation of the grains.
    pub simulation: Simulation,
    /// The progress.
    pub progress: PreparationState,
}

/// True if a packing is loose: it carries less than half of the target mean stress, and is less dense than the target solid
/// fraction, if there is one. It is then compacted like the grains of a random insertion.
pub fn is_loose(packing: &Simulation, p: &Preparation) -> bool {
    let state = packing.state();
    let carries = state.mean_stress() >= LOOSE_BELOW * p.mean_stress;
    let below = |target: f64| state.solid_fraction() < target - p.solid_fraction_tolerance;
    !carries && p.target().is_none_or(below)
}

/// Result of [`Preparing::go_on`].
pub enum PreparationOutcome {
    /// The finished sample.
    Sample(Box<Sample>),
    /// The initial packing is needed again, for the next trial ([`Preparing::compacting`]).
    Again(NextTrial),
    /// The observer stopped it; it can be continued from here.
    Stopped(Box<Preparing>),
}

/// Prepares a sample; the observer is called every few hundred steps.
///
/// # Errors
/// As for [`Preparing::go_on`], and [`PreparationError::Stopped`] if the observer stops it.
pub fn prepare(
    specification: &SampleSpecification,
    observer: &mut dyn SimulationObserver,
) -> Result<Sample, PreparationError> {
    complete(Preparing::followed(specification, observer)?, specification, observer)
}

/// Brings a packing that was made by another program, or with another contact law, to rest at the mean stress of the specification
/// with its properties. There is no search for a friction and no random insertion.
///
/// # Errors
/// As for [`prepare`].
pub fn settle(
    simulation: Simulation,
    specification: &SampleSpecification,
    observer: &mut dyn SimulationObserver,
) -> Result<Sample, PreparationError> {
    complete(Preparing::settling(simulation, specification), specification, observer)
}

fn complete(
    preparing: Preparing,
    specification: &SampleSpecification,
    observer: &mut dyn SimulationObserver,
) -> Result<Sample, PreparationError> {
    match preparing.go_on(specification, observer)? {
        PreparationOutcome::Sample(sample) => Ok(*sample),
        PreparationOutcome::Stopped(at) => Err(PreparationError::Stopped { phase: at.progress.phase() }),
        // Only the compaction of a packing requires its initial state again, and no caller of this function starts one.
        PreparationOutcome::Again(_) => Err(PreparationError::Stopped { phase: Phase::Compaction }),
    }
}

impl Preparing {
    /// The start: the random insertion, and the first friction for its compaction.
    ///
    /// # Errors
    /// If the initial state is too dense, or the laws cannot be combined.
    pub fn new(specification: &SampleSpecification) -> Result<Preparing, PreparationError> {
        Preparing::followed(specification, &mut NoObserver)
    }

    /// As [`Preparing::new`], with an observer that is told of the placing of the grains and can stop it.
    ///
    /// # Errors
    /// As for [`Preparing::new`]; [`PreparationError::Stopped`] if the observer stops it. Nothing is then left to be continued.
    pub fn followed(
        specification: &SampleSpecification,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Preparing, PreparationError> {
        let placed = place(specification, observer)?;
        Preparing::trial(specification, NextTrial::first(specification), &placed)
    }

    /// The start of the relaxation of a packing, see [`settle`].
    pub fn settling(simulation: Simulation, specification: &SampleSpecification) -> Preparing {
        Preparing::resting(simulation, specification, PhaseState::Relaxation)
    }

    /// The start of the consolidation of a sample to the mean stress of the specification, which differs from its own. At the end
    /// the sample is at rest there, as after [`settle`], or the limit of steps was reached.
    pub fn consolidating(simulation: Simulation, specification: &SampleSpecification) -> Preparing {
        let mut preparing = Preparing::resting(simulation, specification, PhaseState::Relaxation);
        let (s, p) = (&preparing.simulation, &specification.preparation);
        let limit = most_steps(s, s.strain_rate(p.inertial_number, p.mean_stress));
        preparing.progress.stage = PhaseState::Consolidation { limit: limit + MOST_RELAXATION_STEPS };
        preparing
    }

    fn resting(
        mut simulation: Simulation,
        specification: &SampleSpecification,
        stage: PhaseState,
    ) -> Preparing {
        let p = &specification.preparation;
        let s = &mut simulation;
        s.set_time_step_factor(specification.time_step_factor);
        s.expect_force(p.mean_stress * s.mean_diameter().powi(2));
        damp_globally(s, specification);
        begin_relaxation(s, p);
        let progress = PreparationState {
            trials: Vec::new(),
            steps: 0,
            time: 0.0,
            procedure: None,
            position: 0.0,
            stage,
            converged_checks: 0,
            packing: true,
        };
        Preparing { simulation, progress }
    }

    /// The start of the compaction of a loose packing, which has the [`NextTrial::properties`] of the trial.
    pub fn compacting(
        simulation: Simulation,
        specification: &SampleSpecification,
        next: NextTrial,
    ) -> Preparing {
        let diameter = simulation.mean_diameter();
        let loaded = simulation.state().mean_stress() > LOADED * next.procedure.mean_stress;
        let mut preparing = Preparing::compaction(simulation, specification, next, diameter);
        preparing.progress.packing = true;
        if let (true, PhaseState::Compaction { slow, loaded, .. }) = (loaded, &mut preparing.progress.stage) {
            *loaded = true;
            preparing.simulation.set_rate_limit(*slow);
        }
        preparing
    }

    /// The initial state of a trial, ready to be compacted.
    fn trial(
        specification: &SampleSpecification,
        next: NextTrial,
        placed: &PlacedSample,
    ) -> Result<Preparing, PreparationError> {
        let s = placed.simulation(next.properties(specification))?;
        let diameter = specification.grains.mean_diameter().map_err(InsertionError::from)?;
        Ok(Preparing::compaction(s, specification, next, diameter))
    }

    /// Grains that do not carry the stress yet, ready to be compacted.
    fn compaction(
        mut s: Simulation,
        specification: &SampleSpecification,
        next: NextTrial,
        diameter: f64,
    ) -> Preparing {
        let p = &specification.preparation;
        let NextTrial { procedure, position, trials, steps, time } = next;
        s.set_time_step_factor(specification.time_step_factor);
        s.expect_force(p.mean_stress * diameter.powi(2));
        damp_globally(&mut s, specification);
        let slow = s.strain_rate(p.inertial_number, procedure.mean_stress);
        s.set_control(CellControl::isotropic(procedure.mean_stress, LOOSE_COMPRESSION * slow));
        let stage = PhaseState::Compaction { slow, limit: most_steps(&s, slow), loaded: false };
        let progress = PreparationState {
            trials,
            steps,
            time,
            procedure: Some(procedure),
            position,
            stage,
            converged_checks: 0,
            packing: false,
        };
        Preparing { simulation: s, progress }
    }

    /// Continues until there is a sample or the observer stops it. The specification must be the one that the preparation was
    /// started with, except for the hardware.
    ///
    /// # Errors
    /// [`PreparationError`], but never [`PreparationError::Stopped`].
    pub fn go_on(
        mut self,
        specification: &SampleSpecification,
        observer: &mut dyn SimulationObserver,
    ) -> Result<PreparationOutcome, PreparationError> {
        self.simulation.set_hardware(specification.hardware);
        loop {
            if matches!(self.progress.stage, PhaseState::Loading { .. }) {
                match self.follow_stage(specification, observer)? {
                    Flow::Continue => continue,
                    Flow::Stop => return Ok(PreparationOutcome::Stopped(Box::new(self))),
                }
            }
            if matches!(self.progress.stage, PhaseState::DensifyingCycles { .. }) {
                match self.follow_densifying_cycles(specification, observer)? {
                    Flow::Continue => continue,
                    Flow::Stop => return Ok(PreparationOutcome::Stopped(Box::new(self))),
                }
            }
            let settled = match self.rested() {
                // It was stopped between two trials.
                Some(settled) => Some(settled),
                None => match self.advance_to_check(observer)? {
                    Flow::Continue => self.check(specification)?,
                    Flow::Stop => return Ok(PreparationOutcome::Stopped(Box::new(self))),
                },
            };
            let Some(settled) = settled else { continue };
            if self.densify(specification)? {
                continue;
            }
            let (trials, next) = self.end_trial(specification);
            let Some(next) = next else {
                return Ok(PreparationOutcome::Sample(Box::new(self.sample(specification, trials, settled))));
            };
            if self.progress.packing {
                return Ok(PreparationOutcome::Again(next));
            }
            let placed = match place(specification, observer) {
                Err(PreparationError::Stopped { .. }) => {
                    return Ok(PreparationOutcome::Stopped(Box::new(self)));
                }
                placed => placed?,
            };
            // Memory may not hold two large simulations.
            drop(self);
            self = Preparing::trial(specification, next, &placed)?;
            self.simulation.set_hardware(specification.hardware);
        }
    }

    /// Advances to the next check, at a multiple of [`CHECK_EVERY`] steps, unless the observer stops it before.
    fn advance_to_check(&mut self, observer: &mut dyn SimulationObserver) -> Result<Flow, SimulationError> {
        let since = self.simulation.state().step() % CHECK_EVERY;
        // After a stop between two checks it goes on to the next one.
        if since == 0 && observer.progress(&self.progress()) == Flow::Stop {
            return Ok(Flow::Stop);
        }
        let Preparing { simulation, progress } = self;
        let left = CHECK_EVERY - since;
        slices::advance(simulation, &[], left, observer, |simulation| progress.progress(simulation))
    }

    /// Checks the present phase, and begins the next one if it is over; for a sample that is complete, whether it has come to rest.
    fn check(&mut self, specification: &SampleSpecification) -> Result<Option<bool>, PreparationError> {
        self.check_overlap(specification)?;
        match self.progress.stage {
            PhaseState::Compaction { .. } => self.check_compaction(specification)?,
            PhaseState::Densification { .. } => self.check_densification(specification)?,
            // Executed by themselves.
            PhaseState::Loading { .. } | PhaseState::DensifyingCycles { .. } => {}
            PhaseState::Relaxation | PhaseState::Densified { .. } | PhaseState::Consolidation { .. } => {
                return Ok(self.check_relaxation(&specification.preparation));
            }
        }
        Ok(None)
    }

    /// Refuses a state in which grains overlap too far.
    fn check_overlap(&self, specification: &SampleSpecification) -> Result<(), PreparationError> {
        let limit = specification.largest_overlap;
        let overlap = self.simulation.state().largest_overlap();
        if overlap > limit {
            return Err(PreparationError::Overlap { phase: self.progress.phase(), overlap, limit });
        }
        Ok(())
    }

    fn progress(&self) -> SimulationProgress<'_> {
        self.progress.progress(&self.simulation)
    }

    /// Reduces the rate once load is carried; starts the stages or the relaxation once the stress is reached and steady.
    fn check_compaction(&mut self, specification: &SampleSpecification) -> Result<(), PreparationError> {
        let p = &specification.preparation;
        let (s, progress) = (&mut self.simulation, &mut self.progress);
        let Some(procedure) = progress.procedure else { return Ok(()) };
        let PhaseState::Compaction { slow, limit, loaded } = &mut progress.stage else { return Ok(()) };
        let ratio = s.state().mean_stress() / procedure.mean_stress;
        if !*loaded && ratio > LOADED {
            *loaded = true;
            s.set_rate_limit(*slow);
        }
        let near = (ratio - 1.0).abs() < 0.02 && s.state().unbalanced_force() < 10.0 * p.unbalanced_force;
        progress.converged_checks = if near { progress.converged_checks + 1 } else { 0 };
        let step = s.state().step();
        if progress.converged_checks < CHECKS_TO_CONVERGE {
            if step < *limit {
                return Ok(());
            }
            return Err(PreparationError::Stalled {
                steps: step,
                mean_stress: s.state().mean_stress(),
                solid_fraction: s.state().solid_fraction(),
                target: procedure.mean_stress,
                time_step: s.state().time_step(),
            });
        }
        self.begin_stage(specification, 0)
    }

    /// Starts the relaxation with the final properties, after stages or right after the compaction.
    fn relax(
        &mut self,
        specification: &SampleSpecification,
        after_stages: bool,
    ) -> Result<(), PreparationError> {
        let (s, progress) = (&mut self.simulation, &mut self.progress);
        progress.count(s);
        s.set_properties(specification.properties())?;
        if after_stages {
            // The last stage may have had another density and with it another time step.
            damp_globally(s, specification);
        }
        begin_relaxation(s, &specification.preparation);
        progress.stage = PhaseState::Relaxation;
        Ok(())
    }

    /// Checks whether the sample has come to rest; `None` as long as this is not decided.
    fn check_relaxation(&mut self, p: &Preparation) -> Option<bool> {
        let state = self.simulation.state();
        let ratio = state.mean_stress() / p.mean_stress;
        let near = (ratio - 1.0).abs() < 0.005 && state.unbalanced_force() < p.unbalanced_force;
        self.progress.converged_checks = if near { self.progress.converged_checks + 1 } else { 0 };
        self.rested()
    }

    /// Whether the checks so far found the sample at rest; `None` as long as this is not decided.
    fn rested(&self) -> Option<bool> {
        let limit = match self.progress.stage {
            PhaseState::Relaxation | PhaseState::Densified { .. } => MOST_RELAXATION_STEPS,
            PhaseState::Consolidation { limit } => limit,
            PhaseState::Compaction { .. }
            | PhaseState::Loading { .. }
            | PhaseState::Densification { .. }
            | PhaseState::DensifyingCycles { .. } => return None,
        };
        if self.progress.converged_checks >= CHECKS_TO_CONVERGE {
            return Some(true);
        }
        (self.simulation.state().step() >= limit).then_some(false)
    }

    /// The trials up to the present one, which has ended, and the next one if its target is not met.
    fn end_trial(&self, specification: &SampleSpecification) -> (Vec<Trial>, Option<NextTrial>) {
        let (p, progress) = (&specification.preparation, &self.progress);
        let mut trials = progress.trials.clone();
        let Some(procedure) = progress.procedure else { return (trials, None) };
        let reached = self.simulation.state().solid_fraction();
        let solid_fraction = match progress.stage {
            // What the procedure gave is what the search goes on with.
            PhaseState::Densified { aim } if !self.meets_target(p) => aim.before,
            _ => reached,
        };
        trials.push(Trial { solid_fraction, ..procedure.trial(progress.position) });
        let Some(target) = p.target().filter(|_| !self.meets_target(p)) else { return (trials, None) };
        let over = p.friction.is_some() || trials.len() >= MOST_TRIALS || repeats(&trials);
        let line = Line::new(p, specification.grains.mean_friction());
        // A search that ends without the target repeats the trial that came closest.
        let next = if !over {
            Some(line.next(&trials, target))
        } else {
            PreparationState::repeated(p, &trials, target).or_else(|| closer(&trials, target))
        };
        let state = self.simulation.state();
        let (steps, time) = (progress.steps + state.step(), progress.time + state.time());
        let next = next.map(|position| NextTrial {
            procedure: line.procedure(position),
            position,
            trials: trials.clone(),
            steps,
            time,
        });
        (trials, next)
    }

    /// True if the solid fraction is that of the target, if there is one and grains were compacted.
    fn meets_target(&self, p: &Preparation) -> bool {
        let reached = self.simulation.state().solid_fraction();
        let missed = |target: f64| (reached - target).abs() > p.solid_fraction_tolerance;
        self.progress.procedure.is_none() || !p.target().is_some_and(missed)
    }

    /// The finished sample.
    fn sample(self, specification: &SampleSpecification, trials: Vec<Trial>, settled: bool) -> Sample {
        let p = &specification.preparation;
        let solid_fraction_met = self.meets_target(p);
        let Preparing { mut simulation, progress } = self;
        let densified = matches!(progress.stage, PhaseState::Densified { .. });
        let state = simulation.state();
        let unbalanced_force = state.unbalanced_force();
        let steps = progress.steps + state.step();
        let time = progress.time + state.time();
        finish(&mut simulation, p);
        Sample { simulation, trials, steps, time, unbalanced_force, settled, solid_fraction_met, densified }
    }
}

/// Twenty times the number of steps that the strain from a loose random state to a dense packing takes at a rate, 1/s, plus
/// a constant.
fn most_steps(s: &Simulation, rate: f64) -> u64 {
    (20.0 * 0.3 / (rate * s.state().time_step())) as u64 + 200_000
}

/// Sets the global damping, which is slow compared with the vibrations of a contact.
fn damp_globally(s: &mut Simulation, specification: &SampleSpecification) {
    s.set_global_damping(GLOBAL_DAMPING * specification.time_step_factor / s.state().time_step());
}

/// The servo holds the stress while the sample comes to rest with its final properties.
fn begin_relaxation(s: &mut Simulation, p: &Preparation) {
    s.set_control(CellControl::isotropic(p.mean_stress, s.strain_rate(p.inertial_number, p.mean_stress)));
    s.reset_phase(0.0);
}

/// Makes the sample ready for a test: no global damping, the servo holds its stress.
fn finish(s: &mut Simulation, p: &Preparation) {
    s.set_global_damping(0.0);
    begin_relaxation(s, p);
}

#[cfg(test)]
mod densifying_tests;
#[cfg(test)]
mod stage_tests;
#[cfg(test)]
mod tests;
