//! Loading paths: what is done to a sample. One file a path.

use crate::config::Rate;
use crate::preparation::{Flow, Phase, Progress};
use crate::servo::Control;
use crate::simulation::{Simulation, SimulationError};
use crate::state::State;

pub mod axisymmetric;

/// Most steps between two calls of the watcher.
const STRIDE: u64 = 500;

/// Deviator strain after which the servo is judged.
const START_UP: f64 = 0.005;

/// A loading path: a control of the cell, and a coordinate that grows along it.
pub trait Path {
    /// What drives the cell.
    fn control(&self, simulation: &Simulation) -> Control;
    /// How far along the path a state is (for a shear test the deviator strain).
    fn coordinate(&self, state: &State) -> f64;
    /// The coordinate at which the path ends.
    fn end(&self) -> f64;
    /// How fast the coordinate grows, 1/s, to within a factor of two.
    fn speed(&self, simulation: &Simulation) -> f64;
}

/// Who watches a test. Looking is by shared reference and cannot disturb the run.
pub trait Watcher {
    /// Coordinate at which to be called next; infinity for never.
    fn next_look(&self) -> f64;
    /// The coordinate has been reached.
    fn look(&mut self, simulation: &Simulation);
    /// Called every few hundred steps.
    fn progress(&mut self, progress: &Progress) -> Flow;
}

/// How a path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Its end was reached.
    Complete,
    /// The watcher stopped it; the simulation can go on from here.
    Stopped,
}

/// Sets a path's control and starts its phase.
pub fn start(path: &dyn Path, simulation: &mut Simulation) {
    simulation.reset_phase(START_UP);
    let control = path.control(simulation);
    simulation.set_control(control);
}

/// Follows a path that was started, from wherever the simulation stands, to its end.
pub fn follow(
    path: &dyn Path,
    simulation: &mut Simulation,
    watcher: &mut dyn Watcher,
) -> Result<Ending, SimulationError> {
    loop {
        let here = path.coordinate(simulation.state());
        while watcher.next_look() <= here {
            watcher.look(simulation);
        }
        if here >= path.end() {
            return Ok(Ending::Complete);
        }
        let (steps, time) = (simulation.state().step(), simulation.state().time());
        let progress = Progress { phase: Phase::Shear, trial: 1, steps, time, simulation };
        if watcher.progress(&progress) == Flow::Stop {
            return Ok(Ending::Stopped);
        }
        let goal = watcher.next_look().min(path.end());
        // A look falls on the first step at or beyond its coordinate, however the steps before were grouped.
        let per_step = 2.0 * path.speed(simulation) * simulation.state().time_step();
        let steps = ((goal - here) / per_step).floor().clamp(1.0, STRIDE as f64) as u64;
        simulation.advance(steps)?;
    }
}

/// The axial strain rate, 1/s, that a [`Rate`] means for a simulation at a mean stress, Pa.
pub fn strain_rate(rate: &Rate, simulation: &Simulation, mean_stress: f64) -> f64 {
    match rate {
        Rate::InertialNumber(number) => simulation.strain_rate(*number, mean_stress),
        Rate::StrainRate { strain_rate, .. } => *strain_rate,
    }
}

/// The factor on the density of the grains that a [`Rate`] asks for.
pub fn density_scaling(rate: &Rate) -> f64 {
    match rate {
        Rate::InertialNumber(_) => 1.0,
        Rate::StrainRate { density_scaling, .. } => *density_scaling,
    }
}
