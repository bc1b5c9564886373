//! The last step to a density that is asked for exactly.
//!
//! How dense a sample becomes depends on its procedure smoothly only on average: two trials whose frictions differ by a thousandth are two
//! samples, which scatter (by 0.01 in void ratio with 300 grains), and a search over procedures alone meets a density no better. A preparation that asks for more
//! ([`EXACTLY`]) therefore takes a trial that is looser than its target and makes this sample denser, until it has the density:
//!
//! - with a procedure of some friction the **friction is lowered** step by step while the servo holds the isotropic stress. Contacts slide, and the
//!   volume decreases as slowly as one likes;
//! - a procedure without friction, or one whose friction is used up, goes on with **cycles** of axial strain at constant mean stress, which end where the
//!   volume is reached.
//!
//! The relaxation with the final properties changes the density a little once more. What is still missing, with the change that the last
//! relaxation made, is the aim of the next round.

use super::procedure_search::{is_tried, looser};
use super::stages::{InPreparation, strain_cycles};
use super::state::{Aim, PhaseState};
use super::{
    MOST_TRIALS, PreparationError, PreparationState, Preparing, Procedure, SampleSpecification, StageFault,
    Trial, begin_relaxation, damp_globally,
};
use crate::config::Preparation;
use crate::loading::{self, Ending, Measure, Reason, Until};
use crate::observer::{Flow, Phase, SimulationObserver};

/// Largest tolerance of the solid fraction that asks for a density exactly.
const EXACTLY: f64 = 1e-3;
/// Trials that are looser than the target by at most so much in solid fraction are made denser; the last trial whatever it misses.
const NEAR: f64 = 0.008;
/// Most rounds of densification and relaxation of one trial.
const MOST_ROUNDS: u32 = 8;
/// Share of the missing solid fraction by which the first round stops short, since the relaxation may add to it.
const STOP_SHORT: f64 = 0.25;
/// Largest relative decrease of the friction between two checks, where much is missing, and the least, where little is.
const DECREASES: [f64; 2] = [0.1, 0.004];
/// The missing solid fraction from which on the friction decreases at the largest rate.
const MUCH: f64 = 0.01;
/// Friction below which there is none.
const NO_FRICTION: f64 = 1e-3;
/// Most checks of one round.
const MOST_CHECKS: u32 = 1000;
/// Most strain cycles of one round.
const MOST_CYCLES: u64 = 20;

/// True if the preparation searches for a procedure and asks for its density exactly.
fn is_exact(p: &Preparation) -> bool {
    p.friction.is_none() && p.target().is_some() && p.solid_fraction_tolerance <= EXACTLY
}

impl PreparationState {
    /// The position of the trial that is repeated, and then made denser, where a search ends without a density that is asked for exactly; `None` if none
    /// is looser, or that was done.
    pub(super) fn repeated(p: &Preparation, trials: &[Trial], target: f64) -> Option<f64> {
        let position = looser(trials, target).filter(|_| is_exact(p))?;
        let count = trials.iter().filter(|trial| (trial.position - position).abs() < 1e-6).count();
        (count < 2 && trials.len() < MOST_TRIALS + 2).then_some(position)
    }
}

impl Preparing {
    /// Makes a trial denser that has come to rest and is looser than a target that is asked for exactly; false if there is nothing to do.
    pub(super) fn densify(&mut self, specification: &SampleSpecification) -> Result<bool, PreparationError> {
        let p = &specification.preparation;
        let (Some(target), Some(procedure)) = (p.target(), self.progress.procedure) else { return Ok(false) };
        let reached = self.simulation.state().solid_fraction();
        let missing = target - reached;
        if !is_exact(p) || missing <= p.solid_fraction_tolerance {
            return Ok(false);
        }
        let aim = match self.progress.stage {
            PhaseState::Densified { aim } if aim.round < MOST_ROUNDS => {
                // What the relaxation added or took away, it will do again.
                let solid_fraction = (target - (reached - aim.solid_fraction)).max(reached);
                Aim { solid_fraction, round: aim.round + 1, ..aim }
            }
            PhaseState::Relaxation if missing <= NEAR || self.progress.is_last_trial() => {
                Aim { solid_fraction: target - STOP_SHORT * missing, round: 1, before: reached }
            }
            _ => return Ok(false),
        };
        let friction = procedure.friction;
        if friction > NO_FRICTION {
            self.lower_friction(specification, friction, aim)?;
        } else {
            self.cycle(specification, aim)?;
        }
        Ok(true)
    }

    fn lower_friction(
        &mut self,
        specification: &SampleSpecification,
        friction: f64,
        aim: Aim,
    ) -> Result<(), PreparationError> {
        let p = &specification.preparation;
        let (s, progress) = (&mut self.simulation, &mut self.progress);
        progress.count(s);
        s.set_properties(specification.properties().while_compacting(p, friction))?;
        begin_relaxation(s, p);
        progress.stage = PhaseState::Densification { friction, checks: 0, aim };
        Ok(())
    }

    /// Lowers the friction a little more, or lets the sample come to rest where its density is reached.
    pub(super) fn check_densification(
        &mut self,
        specification: &SampleSpecification,
    ) -> Result<(), PreparationError> {
        let p = &specification.preparation;
        let (s, progress) = (&mut self.simulation, &mut self.progress);
        let PhaseState::Densification { friction, checks, aim } = &mut progress.stage else { return Ok(()) };
        let missing = aim.solid_fraction - s.state().solid_fraction();
        let aim = *aim;
        if missing <= 0.0 {
            return self.settle_densified(specification, aim);
        }
        *checks += 1;
        if *friction <= NO_FRICTION || *checks > MOST_CHECKS {
            return self.cycle(specification, aim);
        }
        let [most, least] = DECREASES;
        *friction *= 1.0 - (most * missing / MUCH).clamp(least, most);
        let properties = specification.properties().while_compacting(p, *friction);
        s.set_properties(properties)?;
        Ok(())
    }

    /// The friction is used up: cycles of axial strain until the density is reached.
    fn cycle(&mut self, specification: &SampleSpecification, aim: Aim) -> Result<(), PreparationError> {
        let (s, progress) = (&mut self.simulation, &mut self.progress);
        progress.count(s);
        s.reset_phase(0.0);
        let strain = libm::log(aim.solid_fraction / s.state().solid_fraction());
        let properties = specification.properties().while_compacting(&specification.preparation, 0.0);
        s.set_properties(properties)?;
        let begun =
            loading::begin(&densifying(specification, strain), s).map_err(|error| fault(error.into()))?;
        progress.stage = PhaseState::DensifyingCycles { strain, aim, progress: Box::new(begun) };
        damp_globally(s, specification);
        Ok(())
    }

    /// Continues the cycles of a densification to their end, or until the observer stops it.
    pub(super) fn follow_densifying_cycles(
        &mut self,
        specification: &SampleSpecification,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Flow, PreparationError> {
        let (trial, steps, time) = (self.progress.trial(), self.progress.steps, self.progress.time);
        let PhaseState::DensifyingCycles { strain, aim, progress } = &mut self.progress.stage else {
            return Ok(Flow::Continue);
        };
        let mut observer = InPreparation { phase: Phase::Cycles, trial, steps, time, stage: None, observer };
        let stage = densifying(specification, *strain);
        let mut aim = *aim;
        match loading::follow(&stage, progress, &mut self.simulation, &mut observer)? {
            Ending::Stopped => return Ok(Flow::Stop),
            Ending::Complete(reason) if !reason.is_asked_for() => {
                return Err(fault(StageFault::CutShort(reason)));
            }
            // Cycles that did not get there in so many will not in more.
            Ending::Complete(Reason::End(Until::Reversals(_))) => aim.round = MOST_ROUNDS,
            Ending::Complete(_) => {}
        }
        self.settle_densified(specification, aim)?;
        Ok(Flow::Continue)
    }

    fn settle_densified(
        &mut self,
        specification: &SampleSpecification,
        aim: Aim,
    ) -> Result<(), PreparationError> {
        let stopped_at = self.simulation.state().solid_fraction();
        self.relax(specification, true)?;
        self.progress.stage = PhaseState::Densified { aim: Aim { solid_fraction: stopped_at, ..aim } };
        Ok(())
    }
}

impl PreparationState {
    /// True if no other procedure will be tried after the present one.
    fn is_last_trial(&self) -> bool {
        self.trials.len() + 1 >= MOST_TRIALS || is_tried(&self.trials, self.position)
    }
}

/// Strain cycles that end where the sample has been compressed by a volumetric strain.
fn densifying(specification: &SampleSpecification, strain: f64) -> loading::Stage {
    let p = &specification.preparation;
    let procedure = Procedure { friction: 0.0, mean_stress: p.mean_stress, cycles: MOST_CYCLES };
    let mut stage = strain_cycles(p, procedure);
    stage.until.insert(0, Until::Reaches { measure: Measure::VolumetricStrain, value: strain });
    stage
}

fn fault(fault: StageFault) -> PreparationError {
    PreparationError::Stage { number: 1, count: 1, name: "densification".into(), fault }
}
