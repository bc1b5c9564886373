//! The stiffness of a state: how its stress changes with a further strain.

use granum_core::geometry::Matrix;
use granum_core::observer::Flow;
use granum_dem::servo::{CellControl, PLACES, component};
use granum_dem::simulation::Simulation;
use granum_run::stiffness::{self, Probing, Tensor};

use crate::controls::Controls;
use crate::error::PointError;
use crate::increment::Pace;
use crate::straining::{relax, strain};
use crate::surrogate_model::SurrogateModel;
use crate::surrogate_state::SurrogateState;

/// Strain of the single step from which the affine stiffness follows.
const AFFINE_STRAIN: f64 = 1e-7;

/// How a stiffness is found. The chapter on finite elements has a table of cost and error. Of a surrogate there are probes and the secant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Tangent {
    /// The stiffness of the network of contacts if every grain follows the strain of the cell (Walton 1987): the cheapest one, and an
    /// upper bound of the others.
    Affine,
    /// The elastic stiffness, with the motion of the grains and without sliding ([`granum_run::stiffness`]).
    Elastic,
    /// Central differences of the answers to strains of this size in each of six directions: what [`crate::MaterialPoint::advance`] does
    /// next, half of it loading and half unloading.
    Probes {
        /// Size of the strains, shear strains as angles.
        strain: f64,
    },
    /// The secant that is kept up along the path of the state ([`crate::State::secant`]): it costs nothing.
    Secant,
}

impl Tangent {
    /// Numbers that tell two kinds apart.
    pub(crate) fn key(&self) -> [u64; 2] {
        match self {
            Tangent::Affine => [0, 0],
            Tangent::Elastic => [1, 0],
            Tangent::Probes { strain } => [2, strain.to_bits()],
            Tangent::Secant => [3, 0],
        }
    }
}

/// The affine stiffness in the axes of the cell, Pa: from the stress after a single step.
pub(crate) fn affine(simulation: &Simulation) -> Result<Tensor, PointError> {
    let strained = |direction: &Matrix, sign: f64| -> Result<Matrix, PointError> {
        let mut copy = simulation.clone();
        let mut control = CellControl::fixed();
        let rate = sign * AFFINE_STRAIN / copy.state().time_step();
        control.rate = direction.map(|row| row.map(|x| rate * x));
        copy.set_control(control);
        copy.advance(1)?;
        Ok(copy.state().stress())
    };
    columns(2.0 * AFFINE_STRAIN, strained)
}

/// The elastic stiffness in the axes of the cell, Pa.
pub(crate) fn elastic(simulation: &Simulation) -> Result<Tensor, PointError> {
    Ok(stiffness::measure(simulation, &Probing::default())?.tensor)
}

/// Central differences of the answers to strains of a size, in the axes of the cell, Pa.
pub(crate) fn probed(
    simulation: &Simulation,
    size: f64,
    least_mean_stress: f64,
    controls: &Controls,
) -> Result<Tensor, PointError> {
    check_size(size)?;
    let strained = |direction: &Matrix, sign: f64| -> Result<Matrix, PointError> {
        let mut copy = simulation.clone();
        let by = direction.map(|row| row.map(|x| sign * size * x));
        strain(&mut copy, &by, Pace::OfControls, least_mean_stress, controls, &mut |_| Flow::Continue)?;
        Ok(relax(&mut copy, controls)?.mean)
    };
    columns(2.0 * size, strained)
}

/// The same of a surrogate.
pub(crate) fn probed_surrogate(
    model: &SurrogateModel,
    state: &SurrogateState,
    size: f64,
) -> Result<Tensor, PointError> {
    check_size(size)?;
    let by = |direction: &Matrix, sign: f64| direction.map(|row| row.map(|x| sign * size * x));
    let strains: Vec<Matrix> =
        directions().iter().flat_map(|direction| [by(direction, 1.0), by(direction, -1.0)]).collect();
    let stresses = model.stresses(state, &strains)?;
    let mut tensor = Tensor::default();
    for (j, pair) in stresses.chunks_exact(2).enumerate() {
        put_column(&mut tensor, j, &pair[0], &pair[1], 2.0 * size);
    }
    Ok(tensor)
}

/// Refuses probes that are too small or too large for a difference.
fn check_size(size: f64) -> Result<(), PointError> {
    if (1e-9..=1e-2).contains(&size) {
        return Ok(());
    }
    Err(PointError::Control { name: "strain of the probes", value: size, wanted: "from 1e-9 to 0.01" })
}

/// The six directions of strain.
fn directions() -> [Matrix; 6] {
    PLACES.map(|[r, c]| {
        let mut direction = [[0.0; 3]; 3];
        direction[r][c] += 0.5;
        direction[c][r] += 0.5;
        direction
    })
}

/// A column of a tensor: the difference of two stresses over a strain.
fn put_column(tensor: &mut Tensor, column: usize, forward: &Matrix, backward: &Matrix, strain: f64) {
    for row in 0..6 {
        tensor.0[row][column] = (component(forward, row) - component(backward, row)) / strain;
    }
}

/// The tensor whose columns are differences of stresses over a strain: forward minus backward in each of the six directions.
fn columns(
    strain: f64,
    strained: impl Fn(&Matrix, f64) -> Result<Matrix, PointError>,
) -> Result<Tensor, PointError> {
    let mut tensor = Tensor::default();
    for (j, direction) in directions().iter().enumerate() {
        let (forward, backward) = (strained(direction, 1.0)?, strained(direction, -1.0)?);
        put_column(&mut tensor, j, &forward, &backward, strain);
    }
    Ok(tensor)
}
