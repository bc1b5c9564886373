//! Making a sample: a gas from a seed, isotropic compression, relaxation with the final properties.
//!
//! 1. **Gas**: grains at random without overlap ([`crate::gas`]).
//! 2. **Compaction**: all axes servoed to the target mean stress with the preparation's friction and interface energy;
//!    the strain rate is bounded by an inertial number, a tenfold one while hardly any load is carried.
//! 3. **Relaxation**: the final friction and interface energy take over (contacts keep their history), the servo
//!    holds the stress until the unbalanced force is small.
//!
//! A little global damping of the fluctuating velocities works in all three and is off in every test after them.
//!
//! A target solid fraction is met by searching the preparation friction: less friction packs denser. Each trial
//! is a whole preparation from the same seed.

use crate::config::{Contact, Grains, Material, Preparation};
use crate::gas::{GasError, gas};
use crate::servo::Control;
use crate::simulation::{Hardware, Properties, Simulation, SimulationError};

/// Steps between two looks at a phase's end, and between two calls of the observer.
const LOOK_EVERY: u64 = 500;
/// Fraction of the target stress below which grains hardly carry load.
const LOADED: f64 = 0.02;
/// Rate limit before load is carried, as a multiple of the one after.
const GAS_SPEED: f64 = 10.0;
/// Rate of global damping over the frequency sqrt(k/m) of a contact at the target stress.
const FADING: f64 = 0.005;
/// Most trials of the preparation friction.
const MOST_TRIALS: usize = 8;

/// Which part of a preparation or test runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Isotropic compression.
    Compaction,
    /// Coming to rest with the final properties.
    Relaxation,
    /// The loading path.
    Shear,
}

impl Phase {
    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Compaction => "compaction",
            Phase::Relaxation => "relaxation",
            Phase::Shear => "shear",
        }
    }
}

/// What an observer may do: go on or stop cleanly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Go on.
    Continue,
    /// Stop here.
    Stop,
}

/// What a running phase tells its observer. Looking cannot disturb: everything is by shared reference.
pub struct Progress<'a> {
    /// Which phase.
    pub phase: Phase,
    /// Which trial of the preparation friction, from 1.
    pub trial: usize,
    /// The simulation.
    pub simulation: &'a Simulation,
}

/// One trial of the preparation friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Coefficient of friction while compacting.
    pub friction: f64,
    /// Solid fraction that came of it.
    pub solid_fraction: f64,
}

/// A sample and how it was come by.
pub struct Sample {
    /// The simulation, at rest at the target stress with the final properties.
    pub simulation: Simulation,
    /// Every trial of the preparation friction; the last one made the sample.
    pub trials: Vec<Trial>,
    /// Steps of all trials together.
    pub steps: u64,
    /// Unbalanced force at the end.
    pub unbalanced_force: f64,
    /// True if the unbalanced force and the stress came within their bounds before the limit of steps.
    pub settled: bool,
    /// True if the target solid fraction was met (also when none was asked for).
    pub solid_fraction_met: bool,
}

/// Why there is no sample.
#[derive(Debug, thiserror::Error)]
pub enum PreparationError {
    /// The gas is too dense.
    #[error(transparent)]
    Gas(#[from] GasError),
    /// The engine failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The observer stopped it.
    #[error("stopped during {}", phase.name())]
    Stopped {
        /// Where.
        phase: Phase,
    },
    /// The stress was never reached.
    #[error(
        "compaction stalled after {steps} steps at p = {mean_stress:.1} Pa and solid fraction {solid_fraction:.4}, target {target} Pa; \
         a lower preparation.inertial_number or a shorter numerics.time_step_factor may help"
    )]
    Stalled {
        /// Steps made.
        steps: u64,
        /// Mean stress reached, Pa.
        mean_stress: f64,
        /// Solid fraction reached.
        solid_fraction: f64,
        /// Target, Pa.
        target: f64,
    },
}

/// What a preparation needs to know.
#[derive(Clone, Debug)]
pub struct Recipe<'a> {
    /// Grains with their final properties.
    pub grains: &'a Grains,
    /// Contact law.
    pub contact: &'a Contact,
    /// How to prepare.
    pub preparation: &'a Preparation,
    /// Time step factor.
    pub time_step_factor: f64,
    /// What runs it.
    pub hardware: Hardware,
}

/// Makes a sample; the observer is called every few hundred steps.
pub fn prepare(
    recipe: &Recipe,
    observer: &mut dyn FnMut(&Progress) -> Flow,
) -> Result<Sample, PreparationError> {
    let p = recipe.preparation;
    let Some(target) = p.solid_fraction else {
        let friction = p.friction.unwrap_or(recipe.grains.material.friction);
        return prepare_with(recipe, friction, 1, observer);
    };
    if let Some(friction) = p.friction {
        let mut sample = prepare_with(recipe, friction, 1, observer)?;
        sample.solid_fraction_met =
            (sample.trials[0].solid_fraction - target).abs() <= p.solid_fraction_tolerance;
        return Ok(sample);
    }
    let mut trials: Vec<Trial> = Vec::new();
    let mut steps = 0;
    loop {
        let friction = next_friction(&trials, target);
        let mut sample = prepare_with(recipe, friction, trials.len() + 1, observer)?;
        let trial = sample.trials[0];
        trials.push(trial);
        steps += sample.steps;
        let met = (trial.solid_fraction - target).abs() <= p.solid_fraction_tolerance;
        let exhausted = trials.len() >= MOST_TRIALS || (trials.len() >= 2 && repeats(&trials));
        if met || exhausted {
            sample.trials = trials;
            sample.steps = steps;
            sample.solid_fraction_met = met;
            return Ok(sample);
        }
    }
}

/// True if the search came back to a friction it has tried (a bound was hit).
fn repeats(trials: &[Trial]) -> bool {
    let last = trials[trials.len() - 1].friction;
    trials[..trials.len() - 1].iter().any(|t| (t.friction - last).abs() < 1e-6)
}

/// The next friction to try: from what monodisperse Hertz spheres usually do at first, then a secant through the two nearest trials.
fn next_friction(trials: &[Trial], target: f64) -> f64 {
    const USUAL: [(f64, f64); 6] =
        [(0.0, 0.633), (0.06, 0.613), (0.1, 0.605), (0.2, 0.588), (0.3, 0.578), (1.0, 0.55)];
    let usual = |x: f64| interpolate(&USUAL.map(|(f, s)| (s, f)), x);
    match trials {
        [] => usual(target),
        [only] => {
            // The usual curve, shifted to go through the first trial.
            let shift = only.solid_fraction - interpolate(&USUAL, only.friction);
            usual(target - shift)
        }
        _ => {
            let mut near: Vec<&Trial> = trials.iter().collect();
            near.sort_by(|a, b| {
                (a.solid_fraction - target).abs().total_cmp(&(b.solid_fraction - target).abs())
            });
            let (a, b) = (near[0], near[1]);
            let slope = (b.friction - a.friction) / (b.solid_fraction - a.solid_fraction);
            let step = slope * (target - a.solid_fraction);
            let bound = 0.1 + 0.5 * a.friction;
            let step = if step.is_finite() { step.clamp(-bound, bound) } else { 0.01 };
            (a.friction + step).clamp(0.0, 2.0)
        }
    }
}

/// Linear interpolation in a table sorted by its first column either way, constant beyond its ends.
fn interpolate(table: &[(f64, f64)], x: f64) -> f64 {
    let (first, last) = (table[0], table[table.len() - 1]);
    let rising = last.0 > first.0;
    if (x <= first.0) == rising {
        return first.1;
    }
    if (x >= last.0) == rising {
        return last.1;
    }
    table
        .windows(2)
        .find(|w| (x - w[0].0) * (x - w[1].0) <= 0.0)
        .map_or(last.1, |w| w[0].1 + (w[1].1 - w[0].1) * (x - w[0].0) / (w[1].0 - w[0].0))
}

/// One preparation with a given friction.
fn prepare_with(
    recipe: &Recipe,
    friction: f64,
    trial: usize,
    observer: &mut dyn FnMut(&Progress) -> Flow,
) -> Result<Sample, PreparationError> {
    let p = recipe.preparation;
    let material = recipe.grains.material;
    let compacting = Material { friction, interface_energy: p.interface_energy, ..material };
    let (cell, sites) = gas(recipe.grains, p.initial_solid_fraction, p.seed)?;
    let mut s = Simulation::new(cell, &sites, Properties { material: compacting, contact: *recipe.contact })?;
    s.set_hardware(recipe.hardware);
    s.set_time_step_factor(recipe.time_step_factor);
    s.expect_force(p.mean_stress * recipe.grains.diameter.powi(2));
    fade(&mut s, recipe);
    compact(&mut s, p, trial, observer)?;
    let compaction = s.state().step();
    s.set_properties(Properties { material, contact: *recipe.contact })?;
    let settled = relax(&mut s, p, trial, observer)?;
    let steps = compaction + s.state().step();
    let unbalanced_force = s.state().unbalanced_force();
    let solid_fraction = s.state().solid_fraction();
    finish(&mut s, p);
    Ok(Sample {
        simulation: s,
        trials: vec![Trial { friction, solid_fraction }],
        steps,
        unbalanced_force,
        settled,
        solid_fraction_met: true,
    })
}

/// Global damping, slow against the vibrations of a contact.
fn fade(s: &mut Simulation, recipe: &Recipe) {
    s.set_fading(FADING * recipe.time_step_factor / s.state().time_step());
}

/// The sample stands by for a test: no global damping, the servo holds its stress.
fn finish(s: &mut Simulation, p: &Preparation) {
    s.set_fading(0.0);
    s.set_control(Control::isotropic(p.mean_stress, s.strain_rate(p.inertial_number, p.mean_stress)));
    s.reset_phase(0.0);
}

/// Brings a packing that another program made, or another law, to rest at the recipe's mean stress with the recipe's
/// properties. No friction is searched and no gas made.
pub fn settle(
    mut simulation: Simulation,
    recipe: &Recipe,
    observer: &mut dyn FnMut(&Progress) -> Flow,
) -> Result<Sample, PreparationError> {
    let p = recipe.preparation;
    let s = &mut simulation;
    s.set_hardware(recipe.hardware);
    s.set_time_step_factor(recipe.time_step_factor);
    s.expect_force(p.mean_stress * s.mean_diameter().powi(2));
    fade(s, recipe);
    let settled = relax(s, p, 1, observer)?;
    let steps = s.state().step();
    let unbalanced_force = s.state().unbalanced_force();
    finish(s, p);
    Ok(Sample { simulation, trials: Vec::new(), steps, unbalanced_force, settled, solid_fraction_met: true })
}

/// Compresses until the stress is met and calm.
fn compact(
    s: &mut Simulation,
    p: &Preparation,
    trial: usize,
    observer: &mut dyn FnMut(&Progress) -> Flow,
) -> Result<(), PreparationError> {
    let slow = s.strain_rate(p.inertial_number, p.mean_stress);
    s.set_control(Control::isotropic(p.mean_stress, GAS_SPEED * slow));
    // Twenty times the strain from the gas to a dense packing at the slow rate.
    let limit = (20.0 * 0.3 / (slow * s.state().time_step())) as u64 + 200_000;
    let mut loaded = false;
    let mut calm = 0;
    while s.state().step() < limit {
        s.advance(LOOK_EVERY)?;
        look(s, Phase::Compaction, trial, observer)?;
        let ratio = s.state().mean_stress() / p.mean_stress;
        if !loaded && ratio > LOADED {
            loaded = true;
            s.set_rate_limit(slow);
        }
        let near = (ratio - 1.0).abs() < 0.02 && s.state().unbalanced_force() < 10.0 * p.unbalanced_force;
        calm = if near { calm + 1 } else { 0 };
        if calm >= 3 {
            return Ok(());
        }
    }
    Err(PreparationError::Stalled {
        steps: s.state().step(),
        mean_stress: s.state().mean_stress(),
        solid_fraction: s.state().solid_fraction(),
        target: p.mean_stress,
    })
}

/// Holds the stress until the sample is at rest; false if it does not come to rest within its limit.
fn relax(
    s: &mut Simulation,
    p: &Preparation,
    trial: usize,
    observer: &mut dyn FnMut(&Progress) -> Flow,
) -> Result<bool, PreparationError> {
    const LIMIT: u64 = 400_000;
    let slow = s.strain_rate(p.inertial_number, p.mean_stress);
    s.set_control(Control::isotropic(p.mean_stress, slow));
    s.reset_phase(0.0);
    let mut calm = 0;
    while s.state().step() < LIMIT {
        s.advance(LOOK_EVERY)?;
        look(s, Phase::Relaxation, trial, observer)?;
        let ratio = s.state().mean_stress() / p.mean_stress;
        let near = (ratio - 1.0).abs() < 0.005 && s.state().unbalanced_force() < p.unbalanced_force;
        calm = if near { calm + 1 } else { 0 };
        if calm >= 3 {
            return Ok(true);
        }
    }
    Ok(false)
}

fn look(
    s: &Simulation,
    phase: Phase,
    trial: usize,
    observer: &mut dyn FnMut(&Progress) -> Flow,
) -> Result<(), PreparationError> {
    match observer(&Progress { phase, trial, simulation: s }) {
        Flow::Continue => Ok(()),
        Flow::Stop => Err(PreparationError::Stopped { phase }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_runs_both_ways() {
        let up = [(0.0, 1.0), (1.0, 3.0)];
        let down = [(1.0, 3.0), (0.0, 1.0)];
        for table in [&up, &down] {
            assert_eq!(interpolate(table, -1.0), 1.0);
            assert_eq!(interpolate(table, 0.5), 2.0);
            assert_eq!(interpolate(table, 2.0), 3.0);
        }
    }

    #[test]
    fn the_search_converges_on_a_smooth_curve() {
        let answer = |friction: f64| 0.63 - 0.3 * friction + 0.4 * friction * friction;
        let mut trials = Vec::new();
        for _ in 0..5 {
            let friction = next_friction(&trials, 0.61);
            trials.push(Trial { friction, solid_fraction: answer(friction) });
        }
        let best = trials.iter().map(|t| (t.solid_fraction - 0.61).abs()).fold(1.0, f64::min);
        assert!(best < 1e-4, "{trials:?}");
    }
}
