//! Probes of a state: small strains in each component, and the stresses that answer.

use granum_core::assembly::Matrix;
use granum_dem::servo::{self, CellControl};
use granum_dem::simulation::{Properties, Simulation, SimulationError};

use super::tensor::Tensor;

/// Coefficient of friction on copies whose contacts must not slide. It is far above any ratio of tangential to normal force, and
/// small enough for laws with micro-slip, in which terms of the size of friction times normal force cancel.
pub const FROZEN: f64 = 10.0;

/// How a stiffness is measured.
///
/// ```
/// use granum_run::stiffness::Probing;
///
/// let probing = Probing { elastic: false, ..Probing::default() };
/// assert_eq!(probing.strain, 1e-7);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probing {
    /// Size of each strain, shear strains as angles.
    pub strain: f64,
    /// True to keep contacts from sliding.
    pub elastic: bool,
    /// Steps in which the strain is applied.
    pub steps: u64,
    /// Relative change of the response over [`Probing::block`] steps below which it counts as settled.
    pub tolerance: f64,
    /// Steps of relaxation between two checks of the stress.
    pub block: u64,
    /// Largest number of blocks of relaxation.
    pub most_blocks: u64,
}

impl Default for Probing {
    fn default() -> Self {
        Probing { strain: 1e-7, elastic: true, steps: 100, tolerance: 1e-4, block: 500, most_blocks: 100 }
    }
}

/// A stiffness that cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StiffnessError {
    /// The sample carries no load.
    #[error(
        "the sample carries no load (mean stress {0:e} Pa); a stiffness is measured under a positive mean stress"
    )]
    Unloaded(f64),
    /// An option is not possible.
    #[error("the {name} of a probe is {value:e}; it must be {wanted}")]
    Option {
        /// The option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The permitted values.
        wanted: &'static str,
    },
    /// A copy failed.
    #[error("while the stiffness was measured: {0}")]
    Simulation(#[from] SimulationError),
}

/// The measured stiffness of a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stiffness {
    /// The stiffness after relaxation.
    pub tensor: Tensor,
    /// The stiffness of grains that follow the strain of the cell.
    pub affine: Tensor,
    /// Stress of the state at rest, Pa.
    pub stress: Matrix,
    /// Largest relative change of a response in its last block of relaxation.
    pub unsettled: f64,
    /// True if every response settled within [`Probing::most_blocks`].
    pub settled: bool,
}

/// Measures the stiffness of a state, on copies of it.
///
/// ```
/// use granum_dem::cell::Cell;
/// use granum_dem::config::{ContactModel, Material, NormalKind, TangentialKind};
/// use granum_dem::simulation::{InitialSphere, Properties, Simulation};
/// use granum_run::stiffness::{Probing, measure};
///
/// // A simple cubic lattice: C11 = k_n / L.
/// let length = 1e-4 * (1.0 - 1e-4);
/// let sphere = |k: u64| {
///     let place = [k % 3, k / 3 % 3, k / 9].map(|n| (n as f64 + 0.5) * length);
///     InitialSphere { id: k + 1, position: place, radius: 5e-5 }
/// };
/// let spheres: Vec<InitialSphere> = (0..27).map(sphere).collect();
/// let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
/// let properties = Properties::new(Material::default(), contact);
/// let lattice = Simulation::new(Cell::cuboid([3.0 * length; 3]), &spheres, properties)?;
/// let found = measure(&lattice, &Probing::default())?;
/// assert!((found.tensor.0[0][0] / 3.84653834e8 - 1.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`StiffnessError`] if the sample carries no load, an option is out of bounds, or a copy fails.
pub fn measure(simulation: &Simulation, probing: &Probing) -> Result<Stiffness, StiffnessError> {
    probing.check()?;
    let base = at_rest(simulation, probing)?;
    let mut found = Stiffness { stress: base.state().stress(), settled: true, ..Stiffness::default() };
    for j in 0..6 {
        let [affine, response] = column(&base, j, probing, &mut found)?;
        for i in 0..6 {
            found.affine.0[i][j] = affine[i];
            found.tensor.0[i][j] = response[i];
        }
    }
    Ok(found)
}

impl Probing {
    pub(super) fn check(&self) -> Result<(), StiffnessError> {
        let within = |name, value: f64, [low, high]: [f64; 2], wanted| match (low..=high).contains(&value) {
            true => Ok(()),
            false => Err(StiffnessError::Option { name, value, wanted }),
        };
        within("strain", self.strain, [1e-10, 1e-2], "from 1e-10 to 0.01")?;
        within("number of steps", self.steps as f64, [1.0, 1e9], "from 1 to 1e9")?;
        within("number of steps of a block", self.block as f64, [1.0, 1e9], "from 1 to 1e9")?;
        within("number of blocks", self.most_blocks as f64, [1.0, 1e9], "from 1 to 1e9")?;
        within("tolerance", self.tolerance, [1e-12, 1.0], "from 1e-12 to 1")
    }
}

/// A copy at rest in a fixed cell, with friction raised if nothing may slide.
pub(super) fn at_rest(simulation: &Simulation, probing: &Probing) -> Result<Simulation, StiffnessError> {
    let mut copy = simulation.clone();
    if probing.elastic {
        copy.set_properties(without_sliding(copy.properties()))?;
    }
    let time_step = copy.state().time_step();
    copy.fix_time_step(Some(time_step));
    copy.set_global_damping(DAMPING / time_step);
    copy.set_control(CellControl::fixed());
    copy.reset_phase(0.0);
    let mut before = copy.state().stress();
    for _ in 0..probing.most_blocks {
        copy.advance(probing.block)?;
        let now = copy.state().stress();
        // A hundredth of the change that the strain will cause is small enough, since it is common to both directions.
        let enough = 0.01 * probing.strain * copy.state().bulk_modulus();
        if largest(&difference(&now, &before)) < enough {
            break;
        }
        before = now;
    }
    let p = copy.state().mean_stress();
    if p.is_nan() || p <= 0.0 {
        return Err(StiffnessError::Unloaded(p));
    }
    Ok(copy)
}

/// Global damping per step: slow compared with the vibrations of a contact, as in a preparation, and fast enough that a sample
/// about ten grains wide is close to critical damping.
const DAMPING: f64 = 0.02;

/// The same properties with a coefficient of friction so large that no contact slides.
fn without_sliding(properties: &Properties) -> Properties {
    let mut frozen = properties.clone();
    frozen.material.friction = FROZEN;
    frozen.mixture.components.iter_mut().for_each(|component| component.material.friction = FROZEN);
    frozen.mixture.pairs.iter_mut().for_each(|rule| rule.friction = None);
    frozen
}

/// The affine response and the relaxed one to strain component j, Pa.
fn column(
    base: &Simulation,
    j: usize,
    probing: &Probing,
    found: &mut Stiffness,
) -> Result<[[f64; 6]; 2], StiffnessError> {
    let mut affine = [base.clone(), base.clone()];
    strain_both(&mut affine, j, probing.strain, 1)?;
    let mut copies = [base.clone(), base.clone()];
    strain_both(&mut copies, j, probing.strain, probing.steps)?;
    let mut before = response(&copies, j);
    let mut change = f64::INFINITY;
    for _ in 0..probing.most_blocks {
        for copy in &mut copies {
            copy.advance(probing.block)?;
        }
        let now = response(&copies, j);
        let size = now.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        let moved = (0..6).fold(0.0f64, |moved, k| moved.max((now[k] - before[k]).abs()));
        before = now;
        change = if size > 0.0 { moved / size } else { 0.0 };
        if change < probing.tolerance {
            break;
        }
    }
    found.unsettled = found.unsettled.max(change);
    found.settled &= change < probing.tolerance;
    Ok([response(&affine, j), before])
}

/// Strains one copy forward and the other backward, and holds their cells.
fn strain_both(
    copies: &mut [Simulation; 2],
    j: usize,
    strain: f64,
    steps: u64,
) -> Result<(), SimulationError> {
    let [r, c] = servo::PLACES[j];
    for (copy, sign) in copies.iter_mut().zip([1.0, -1.0]) {
        let mut control = CellControl::fixed();
        let rate = sign * strain / (steps as f64 * copy.state().time_step());
        control.rate[r][c] += 0.5 * rate;
        control.rate[c][r] += 0.5 * rate;
        copy.set_control(control);
        copy.advance(steps)?;
        copy.set_control(CellControl::fixed());
    }
    Ok(())
}

/// Difference of the stresses of the two copies over that of their strains, by components, Pa.
fn response([forward, backward]: &[Simulation; 2], j: usize) -> [f64; 6] {
    let stress = difference(&forward.state().stress(), &backward.state().stress());
    let strain = servo::strain_component(&forward.state().strain(), j)
        - servo::strain_component(&backward.state().strain(), j);
    std::array::from_fn(|k| servo::component(&stress, k) / strain)
}

pub(super) fn difference(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] - b[i][j]))
}

pub(super) fn largest(t: &Matrix) -> f64 {
    t.iter().flatten().fold(0.0, |size, x| size.max(x.abs()))
}
