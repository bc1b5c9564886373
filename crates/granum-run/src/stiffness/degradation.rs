//! The decrease of the shear modulus with the strain.

use granum_core::assembly::Matrix;
use granum_core::{Column, Table};
use granum_dem::invariants::{axial_deviator, mean};
use granum_dem::servo::CellControl;
use granum_dem::simulation::Simulation;

use super::probing::{Probing, StiffnessError, at_rest, difference, largest};

/// Highest strain rate between the states at rest, as an inertial number.
const INERTIAL_NUMBER: f64 = 1e-4;

/// A point of the curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Degradation {
    /// Deviatoric strain `eps_q` from the state at rest.
    pub strain: f64,
    /// Secant shear modulus `(q - q_0) / (3 eps_q)`, Pa.
    pub shear_modulus: f64,
    /// Mean stress, Pa.
    pub mean_stress: f64,
    /// True if the stress came to rest at the strain.
    pub settled: bool,
}

/// The secant shear modulus over the strain in a compression along x at constant volume with the friction of the sample,
/// on a copy of it: at each strain the grains come to rest, so that the curve is that of a static test, whatever the rate.
///
/// The deviatoric strains must be positive and increase.
///
/// # Errors
/// As [`super::measure`].
pub fn degradation(
    simulation: &Simulation,
    strains: &[f64],
    probing: &Probing,
) -> Result<Vec<Degradation>, StiffnessError> {
    probing.check()?;
    let mut last = 0.0;
    for strain in strains {
        let is_next = *strain > last && *strain <= 0.5;
        if !is_next {
            let wanted = "above the one before and at most 0.5";
            return Err(StiffnessError::Option { name: "list of strains", value: *strain, wanted });
        }
        last = *strain;
    }
    let smallest = strains.first().copied().unwrap_or(probing.strain);
    let probing = Probing { elastic: false, strain: smallest.min(1e-2), ..*probing };
    let mut copy = at_rest(simulation, &probing)?;
    let start = copy.state().stress();
    let fastest = copy.strain_rate(INERTIAL_NUMBER, mean(&start)) * copy.state().time_step();
    let mut curve = Vec::new();
    let mut reached = 0.0;
    for strain in strains {
        let steps = ((strain - reached) / fastest).ceil().max(probing.steps as f64);
        let rate = (strain - reached) / (steps * copy.state().time_step());
        let mut control = CellControl::fixed();
        for (axis, part) in [1.0, -0.5, -0.5].into_iter().enumerate() {
            control.rate[axis][axis] = part * rate;
        }
        copy.set_control(control);
        copy.advance(steps as u64)?;
        copy.set_control(CellControl::fixed());
        let settled = settle(&mut copy, &start, &probing)?;
        let stress = copy.state().stress();
        reached = 2.0 / 3.0 * copy.state().deviator_strain();
        curve.push(Degradation {
            strain: reached,
            shear_modulus: axial_deviator(&difference(&stress, &start)) / (3.0 * reached),
            mean_stress: mean(&stress),
            settled,
        });
    }
    Ok(curve)
}

/// The curve as a table: `strain`, `secant_shear_modulus`, the same over its first value as `relative_shear_modulus`,
/// `mean_stress` and `settled` (1 or 0).
pub fn degradation_table(curve: &[Degradation]) -> Table {
    let first = curve.first().map_or(1.0, |point| point.shear_modulus);
    let column = |name: &str, unit: &str, value: fn(&Degradation) -> f64| {
        Column::new(name, unit, curve.iter().map(value).collect())
    };
    let relative = curve.iter().map(|point| point.shear_modulus / first).collect();
    let columns = vec![
        column("strain", "", |point| point.strain),
        column("secant_shear_modulus", "Pa", |point| point.shear_modulus),
        Column::new("relative_shear_modulus", "", relative),
        column("mean_stress", "Pa", |point| point.mean_stress),
        column("settled", "", |point| f64::from(u8::from(point.settled))),
    ];
    // All columns have one value for each point, so that this cannot fail.
    Table::new(columns).unwrap_or_default()
}

/// Lets the stress come to rest; true if it did.
fn settle(copy: &mut Simulation, start: &Matrix, probing: &Probing) -> Result<bool, StiffnessError> {
    let mut before = copy.state().stress();
    for _ in 0..probing.most_blocks {
        copy.advance(probing.block)?;
        let now = copy.state().stress();
        let moved = largest(&difference(&now, &before));
        // Sliding contacts settle more slowly than elastic ones: the tolerance is 1e-3, larger than that of a stiffness tensor.
        if moved < 1e-3 * largest(&difference(&now, start)) {
            return Ok(true);
        }
        before = now;
    }
    Ok(false)
}
