//! Straining a live cell by an increment of logarithmic strain.
//!
//! The increment is carried out in pieces of [`PIECE`] steps with a constant velocity gradient. The engine multiplies the edges of the
//! cell by `1 + L dt` in every step; with `L dt = exp(-e / n) - 1` the n steps of a strain e multiply it by `exp(-e)` to rounding, so
//! that the cell does not depend on how a path is cut, nor on the number of its steps.

use granum_core::geometry::Matrix;
use granum_core::observer::Flow;
use granum_dem::invariants;
use granum_dem::servo::CellControl;
use granum_dem::simulation::Simulation;

use crate::controls::Controls;
use crate::error::PointError;
use crate::increment::Pace;
use crate::matrix_functions::exponential_minus_one;

/// Steps with one velocity gradient and one time step.
const PIECE: u64 = 64;
/// Steps between two values of the stress that is averaged.
const SAMPLE_EVERY: u64 = 10;
/// Smallest distance of two opposite faces of the cell in mean diameters: in a thinner one a grain would meet its own images.
const THINNEST: f64 = 3.0;

/// Stress, averaged, and its standard deviation by components, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AveragedStress {
    pub(crate) mean: Matrix,
    pub(crate) deviation: Matrix,
}

/// Strains a simulation and lets it relax; the strain is in the axes of the cell. The watcher is told the share that is done and can
/// stop it.
///
/// # Errors
/// [`PointError`]; the simulation is then of no use.
pub(crate) fn strain(
    simulation: &mut Simulation,
    strain: &Matrix,
    pace: Pace,
    least_mean_stress: f64,
    controls: &Controls,
    watch: &mut dyn FnMut(f64) -> Flow,
) -> Result<(), PointError> {
    let size = invariants::length(strain);
    let mut left = *strain;
    // Share of the strain that is left.
    let mut share = 1.0;
    let mut made = 0u64;
    while share > 0.0 {
        simulation.fix_time_step(None);
        let time_step = simulation.state().time_step();
        simulation.fix_time_step(Some(time_step));
        let pressure = simulation.state().mean_stress().max(least_mean_stress);
        let rate = match pace {
            Pace::OfControls => simulation.strain_rate(controls.inertial_number, pressure),
            Pace::InertialNumber(number) => simulation.strain_rate(number, pressure),
            Pace::Duration(time) => size / time,
        };
        let needed = share * size / (rate * time_step);
        let total = made as f64 + needed;
        if total.is_nan() || total > controls.most_steps as f64 {
            return Err(PointError::TooLong { needed: total, limit: controls.most_steps });
        }
        let steps = (needed.ceil() as u64).max(1);
        let piece = steps.min(PIECE);
        let is_last = piece == steps;
        let part = if is_last { 1.0 } else { piece as f64 / needed };
        let of_piece = left.map(|row| row.map(|x| part * x));
        follow_piece(simulation, &of_piece, piece, time_step)?;
        made += piece;
        if is_last {
            break;
        }
        for r in 0..3 {
            for c in 0..3 {
                left[r][c] -= of_piece[r][c];
            }
        }
        share *= 1.0 - part;
        if watch(1.0 - share) == Flow::Stop {
            return Err(PointError::Stopped);
        }
    }
    Ok(())
}

/// Some steps with one velocity gradient.
fn follow_piece(
    simulation: &mut Simulation,
    strain: &Matrix,
    steps: u64,
    time_step: f64,
) -> Result<(), PointError> {
    let each = strain.map(|row| row.map(|x| -x / steps as f64));
    let gradient = exponential_minus_one(&each);
    let mut control = CellControl::fixed();
    control.rate = gradient.map(|row| row.map(|x| -x / time_step));
    simulation.set_control(control);
    Ok(simulation.advance(steps)?)
}

/// Holds the cell for the relaxation of the controls, and averages the stress over its last steps.
///
/// # Errors
/// [`PointError`] if the engine fails, or the cell or the overlaps leave what the theory permits.
pub(crate) fn relax(simulation: &mut Simulation, controls: &Controls) -> Result<AveragedStress, PointError> {
    simulation.set_control(CellControl::fixed());
    simulation.fix_time_step(None);
    let time_step = simulation.state().time_step();
    simulation.fix_time_step(Some(time_step));
    let window = controls.averaging.min(controls.relaxation);
    simulation.advance(controls.relaxation - window)?;
    let mut stresses = Vec::new();
    let mut left = window;
    while left > 0 {
        let steps = left.min(SAMPLE_EVERY);
        simulation.advance(steps)?;
        left -= steps;
        stresses.push(simulation.state().stress());
    }
    if stresses.is_empty() {
        stresses.push(simulation.state().stress());
    }
    check(simulation, controls)?;
    Ok(averaged(&stresses))
}

/// Mean and standard deviation of a list of stresses that is not empty.
fn averaged(stresses: &[Matrix]) -> AveragedStress {
    let count = stresses.len() as f64;
    let mean: Matrix = std::array::from_fn(|r| {
        std::array::from_fn(|c| stresses.iter().map(|stress| stress[r][c]).sum::<f64>() / count)
    });
    let deviation = std::array::from_fn(|r| {
        std::array::from_fn(|c| {
            let squares = stresses.iter().map(|stress| (stress[r][c] - mean[r][c]).powi(2));
            (squares.sum::<f64>() / count).sqrt()
        })
    });
    AveragedStress { mean, deviation }
}

/// Refuses a cell that is too thin and overlaps that are too large.
fn check(simulation: &Simulation, controls: &Controls) -> Result<(), PointError> {
    let thinnest = simulation.state().cell().heights().into_iter().fold(f64::INFINITY, f64::min);
    let heights = thinnest / simulation.mean_diameter();
    if heights < THINNEST {
        return Err(PointError::Thin { heights, limit: THINNEST });
    }
    let overlap = simulation.state().largest_overlap();
    if overlap > controls.largest_overlap {
        return Err(PointError::TooDeep { overlap, limit: controls.largest_overlap });
    }
    Ok(())
}
