//! The control of a stage: the drive of each component of the cell, and the constraints between components.
//!
//! It is the general control of element tests, `M deps + N dsigma = v` (the `*ObeyRestrictions` of Niemunis'
//! IncrementalDriver). Each component has a prescribed strain rate or stress or is left free; each constraint prescribes a
//! combination of strain rates or of stresses. Together they must give six equations for the six strain rates. The equations
//! are solved once, with an estimated stiffness of the sample ([`STIFFNESS`]): this gives the base rates, and for each
//! controlled stress the strain rates by which the servo moves it, which change no other controlled stress and no prescribed
//! strain rate.

use super::control_error::ControlError;
use serde::{Deserialize, Serialize};

use super::equations::{Equation, decouple, dot, inverse, resistance};
use super::reference_stress::reference_stress;
use crate::assembly::Matrix;
use crate::servo::{self, COMPONENTS, PLACES, Row, STIFFNESS};
use crate::simulation::Simulation;

/// Rate of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Speed {
    /// Inertial number of a unit strain rate, at the mean stress at the start of the stage unless another is given, Pa. Where the
    /// sample carries no stress then, it is at the largest stress that the stage brings it to.
    InertialNumber {
        /// Inertial number I.
        number: f64,
        /// Mean stress, Pa.
        at: Option<f64>,
    },
    /// Strain rate, 1/s.
    StrainRate(f64),
}

/// Where a ramp ends. All ramps of a stage begin with it, are linear in time, and end together ([`Control::ramp_time`]).
///
/// ```
/// use granum_dem::loading::Ramp;
///
/// assert_eq!(Ramp::To(3.0).change(1.0), 2.0);
/// assert_eq!(Ramp::By(3.0).change(1.0), 3.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ramp {
    /// At this value.
    To(f64),
    /// This much above the value at the start of the stage.
    By(f64),
}

impl Ramp {
    /// The change of a value that is `from` at the start of the stage.
    pub fn change(self, from: f64) -> f64 {
        match self {
            Ramp::To(value) => value - from,
            Ramp::By(change) => change,
        }
    }
}

/// A stress that is held constant or changed at a given rate.
///
/// ```
/// use granum_dem::loading::{Ramp, Target};
///
/// let held = Target::held(100e3);
/// let rising = Target::held(100e3).moving(1e3);
/// let ramp = Target::ramp(Ramp::To(200e3));
/// assert_eq!((held.value, rising.rate, ramp.value), (Some(100e3), 1e3, None));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Target {
    /// Its value at the start of the stage, Pa; `None`: the value that the stress of the sample has then.
    pub value: Option<f64>,
    /// Its rate of change, Pa/s.
    pub rate: f64,
    /// The end of a ramp, Pa, in place of a rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ramp: Option<Ramp>,
}

impl Target {
    /// The stress at the start of the stage.
    pub fn current() -> Target {
        Target::default()
    }

    /// A value, Pa.
    pub fn held(value: f64) -> Target {
        Target { value: Some(value), ..Target::default() }
    }

    /// The same moving at a rate, Pa/s.
    pub fn moving(self, rate: f64) -> Target {
        Target { rate, ..self }
    }

    /// A linear change from the stress at the start of the stage to the end of a ramp.
    pub fn ramp(ramp: Ramp) -> Target {
        Target { ramp: Some(ramp), ..Target::default() }
    }

    /// The magnitude to which the stress is brought, Pa, in a sample that carries none when the stage begins.
    fn end(&self) -> f64 {
        let from = self.value.unwrap_or(0.0);
        let to = match self.ramp {
            Some(Ramp::To(value)) => value,
            Some(Ramp::By(change)) => from + change,
            None => from,
        };
        to.abs()
    }
}

/// The drive of one component of the cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drive {
    /// It is not strained.
    #[default]
    Fixed,
    /// It is strained at this multiple of the speed of the stage, compression positive; shear strains are angles.
    Rate(f64),
    /// It is strained linearly in time to the end of a ramp.
    Ramp(Ramp),
    /// Its stress is held constant or changed at a given rate.
    Stress(Target),
    /// It follows from the constraints.
    Free,
}

/// A combination of components that is prescribed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Constraint {
    /// Weights of the strains; in combination with stresses they have the unit Pa.
    pub strain: [f64; 6],
    /// Weights of the stresses.
    pub stress: [f64; 6],
    /// Value at which the combination of stresses (and strains, if any) is held. Without stresses only the rate is used: the
    /// combination of strain rates has this multiple of the speed of the stage.
    pub target: Target,
    /// The strain rates by which this constraint is controlled, where they are not to be derived from the other equations.
    /// Every component must then have its own base rate.
    pub moves: Option<[f64; 6]>,
}

/// How shear rates deform the cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kinematics {
    /// The velocity gradient is symmetric: there is no rotation.
    #[default]
    PureShear,
    /// A shear rate is a single entry of the velocity gradient, in the row of its first index: xy moves grains along x in
    /// proportion to y.
    SimpleShear,
}

/// The control of the cell in a stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// Unit of all strain rates.
    pub speed: Speed,
    /// The drive of each component, see [`COMPONENTS`].
    pub components: [Drive; 6],
    /// Constraints between them.
    pub constraints: [Option<Constraint>; 6],
    /// How shear rates deform the cell.
    pub kinematics: Kinematics,
    /// Bound on the strain rate that the servo adds for one controlled stress, as a multiple of the speed.
    pub servo_limit: f64,
    /// Time constant of the servo, in time steps.
    pub response: f64,
    /// True if strain rates and the rates of targets increase from zero at the start of the stage and at every reversal, over a
    /// quarter of the time `d sqrt(rho / p)` in which grains move under p. With a sudden change the controlled stresses would
    /// jump.
    pub eases: bool,
}

/// Fraction of the inertial time of the grains in which rates increase from zero.
pub const EASE: f64 = 0.25;

/// Default time constant of the servo of a stage, in time steps.
pub const RESPONSE: f64 = 6.0;

/// Bound on the strain rate that the servo adds where the cell is strained anyway, as a multiple of the speed.
pub const SERVO_LIMIT: f64 = 30.0;

/// Ratio of the stiffness of a sample, by which the duration of a ramp of stress is chosen, to the estimate of the servo, which
/// assumes affine motion and is therefore too stiff.
pub const YIELDING: f64 = 0.25;

/// Shortest duration of a ramp, in inertial times of the grains: a faster change is not quasi-static, however small it is.
pub const SHORTEST_RAMP: f64 = 4.0;

impl Default for Control {
    fn default() -> Self {
        Control {
            speed: Speed::InertialNumber { number: 1e-3, at: None },
            components: [Drive::Fixed; 6],
            constraints: [None; 6],
            kinematics: Kinematics::PureShear,
            servo_limit: SERVO_LIMIT,
            response: RESPONSE,
            eases: true,
        }
    }
}

impl Control {
    /// The control of a stage whose components have these drives.
    pub fn new(speed: Speed, components: [Drive; 6]) -> Control {
        Control { speed, components, ..Control::default() }
    }

    /// The same with one more constraint; a seventh is ignored.
    pub fn with(mut self, constraint: Constraint) -> Control {
        if let Some(free) = self.constraints.iter_mut().find(|place| place.is_none()) {
            *free = Some(constraint);
        }
        self
    }

    /// True if some component has a prescribed strain rate other than zero.
    pub fn is_strained(&self) -> bool {
        self.components.iter().any(|drive| match drive {
            Drive::Rate(rate) => *rate != 0.0,
            Drive::Ramp(_) => true,
            _ => false,
        })
    }

    /// The stresses that are held or moved.
    fn targets(&self) -> impl Iterator<Item = &Target> {
        let of_components = self.components.iter().filter_map(|drive| match drive {
            Drive::Stress(target) => Some(target),
            _ => None,
        });
        let held = |constraint: &&Constraint| constraint.stress != [0.0; 6];
        of_components
            .chain(self.constraints.iter().flatten().filter(held).map(|constraint| &constraint.target))
    }

    /// The stress by which its speed and the stiffness of a sample are judged, Pa.
    pub(super) fn reference_stress(&self, simulation: &Simulation) -> f64 {
        let asked = self.targets().map(Target::end).fold(0.0, f64::max);
        reference_stress(asked, simulation)
    }

    /// True if a strain or a stress follows a ramp.
    pub fn has_ramp(&self) -> bool {
        self.components.iter().any(|drive| matches!(drive, Drive::Ramp(_)))
            || self.targets().any(|target| target.ramp.is_some())
    }

    /// True if the target of a controlled stress changes.
    pub fn moves_a_stress(&self) -> bool {
        self.targets().any(|target| target.rate != 0.0 || target.ramp.is_some())
    }

    /// The duration, s, of the ramps of the control for a simulation; `None` without a ramp. The fastest strain proceeds at the
    /// speed of the stage; for stresses the strain is estimated from the stiffness of the contacts.
    pub fn ramp_time(&self, simulation: &Simulation) -> Option<f64> {
        let state = simulation.state();
        let (stress, strain) = (state.stress(), state.strain());
        let shortest = SHORTEST_RAMP * inertial_time(simulation);
        let rate = self.strain_rate(simulation);
        self.ramp_duration(rate, &stress, &strain, modulus(self, simulation)).map(|time| time.max(shortest))
    }

    fn ramp_duration(&self, rate: f64, stress: &Matrix, strain: &Matrix, modulus: f64) -> Option<f64> {
        if !self.has_ramp() {
            return None;
        }
        let mut longest = 0.0f64;
        let mut stressed = |row: &Row, target: &Target| {
            let Some(ramp) = target.ramp else { return };
            let change = ramp.change(target.value.unwrap_or_else(|| row.value(stress, strain)));
            let stiffness = resistance(row, modulus).iter().fold(0.0f64, |m, x| m.max(x.abs()));
            longest = longest.max(change.abs() / (YIELDING * stiffness * modulus * rate));
        };
        for (k, drive) in self.components.iter().enumerate() {
            if let Drive::Stress(target) = drive {
                stressed(&Row::component(k, 0.0), target);
            }
        }
        for constraint in self.constraints.iter().flatten().filter(|c| c.stress != [0.0; 6]) {
            stressed(&constraint.row(), &constraint.target);
        }
        for (k, drive) in self.components.iter().enumerate() {
            if let Drive::Ramp(ramp) = drive {
                longest = longest.max(ramp.change(servo::strain_component(strain, k)).abs() / rate);
            }
        }
        Some(longest)
    }

    /// The strain rate that corresponds to a rate of one, 1/s, for a simulation.
    pub fn strain_rate(&self, simulation: &Simulation) -> f64 {
        match self.speed {
            Speed::InertialNumber { number, at } => {
                simulation.strain_rate(number, at.unwrap_or_else(|| self.reference_stress(simulation)))
            }
            Speed::StrainRate(rate) => rate,
        }
    }

    /// Checks that the equations determine the strain rates for any sample.
    ///
    /// # Errors
    /// [`ControlError`].
    pub fn check(&self) -> Result<(), ControlError> {
        self.solve(1.0, &[[0.0; 3]; 3], &[[0.0; 3]; 3], 1e8, Some(1.0)).map(|_| ())
    }

    /// The control of the cell of a simulation from the present state on.
    ///
    /// # Errors
    /// [`ControlError`] if the equations do not determine the strain rates, or the strain rate is not positive.
    pub fn begin(&self, simulation: &Simulation) -> Result<servo::CellControl, ControlError> {
        let rate = self.strain_rate(simulation);
        if !(rate > 0.0 && rate.is_finite()) {
            return Err(ControlError::Speed(rate));
        }
        let state = simulation.state();
        let ramp = self.ramp_time(simulation);
        let modulus = modulus(self, simulation);
        let mut control = self.solve(rate, &state.stress(), &state.strain(), modulus, ramp)?;
        control.since = state.time();
        control.ease = if self.eases { EASE * inertial_time(simulation) } else { 0.0 };
        Ok(control)
    }

    /// The control of the cell for a speed of one, for a program that solves for the strain rates itself: base strain rates and
    /// the bound on those of the servo are multiples of the speed. `modulus`, Pa, is the bulk modulus by which constraints on strains
    /// and stresses are weighted. The target of a stress that is held at its value at the start of the stage is NaN.
    ///
    /// ```
    /// use granum_dem::loading::{Control, Drive, Speed, Target};
    ///
    /// let (held, fixed) = (Drive::Stress(Target::current()), Drive::Fixed);
    /// let control = Control::new(Speed::StrainRate(5.0), [Drive::Rate(1.0), held, fixed, fixed, fixed, fixed]);
    /// let cell = control.per_speed(1e8)?;
    /// assert_eq!(cell.rate[0][0], 1.0);
    /// assert!(cell.rows().all(|row| row.target.is_nan() && row.stress[1] == 1.0));
    /// # Ok::<(), granum_dem::loading::ControlError>(())
    /// ```
    ///
    /// # Errors
    /// [`ControlError`] if the equations do not determine the strain rates.
    pub fn per_speed(&self, modulus: f64) -> Result<servo::CellControl, ControlError> {
        self.solve(1.0, &[[f64::NAN; 3]; 3], &[[0.0; 3]; 3], modulus, None)
    }

    fn solve(
        &self,
        rate: f64,
        stress: &Matrix,
        strain: &Matrix,
        modulus: f64,
        ramp_time: Option<f64>,
    ) -> Result<servo::CellControl, ControlError> {
        let per_time = |change: f64| change / ramp_time.unwrap_or(f64::INFINITY);
        let held = |mut row: Row, target: &Target| {
            row.target = target.value.unwrap_or_else(|| row.value(stress, strain));
            row.target_rate = target.ramp.map_or(target.rate, |ramp| per_time(ramp.change(row.target)));
            row
        };
        let mut equations = Vec::new();
        let mut rows: Vec<(Row, [f64; 6])> = Vec::new();
        for (k, drive) in self.components.iter().enumerate() {
            let name = COMPONENTS[k].to_string();
            let mut weights = [0.0; 6];
            weights[k] = 1.0;
            match drive {
                Drive::Free => {}
                Drive::Fixed => equations.push(Equation { name, weights, rate: 0.0, row: None }),
                Drive::Rate(factor) => {
                    equations.push(Equation { name, weights, rate: factor * rate, row: None });
                }
                Drive::Ramp(ramp) => {
                    let rate = per_time(ramp.change(servo::strain_component(strain, k)));
                    equations.push(Equation { name, weights, rate, row: None });
                }
                Drive::Stress(target) => {
                    weights[k] = STIFFNESS[k];
                    let row = Some(held(Row::component(k, 0.0), target));
                    equations.push(Equation { name, weights, rate: 0.0, row });
                }
            }
        }
        for (number, constraint) in self.constraints.iter().flatten().enumerate() {
            let name = format!("constraint {}", number + 1);
            if constraint.stress == [0.0; 6] {
                let rate = constraint.target.rate * rate;
                equations.push(Equation { name, weights: constraint.strain, rate, row: None });
                continue;
            }
            let row = held(constraint.row(), &constraint.target);
            match constraint.moves {
                Some(moves) => rows.push((row, moves)),
                None => {
                    let weights = resistance(&row, modulus);
                    equations.push(Equation { name, weights, rate: 0.0, row: Some(row) });
                }
            }
        }
        if equations.len() != 6 {
            let names: Vec<_> = equations.iter().map(|equation| equation.name.as_str()).collect();
            return Err(ControlError::Count { found: equations.len(), what: names.join(", ") });
        }
        let inverse = inverse(&equations)?;
        let mut base = [0.0; 6];
        for (column, equation) in equations.iter().enumerate() {
            let direction: [f64; 6] = std::array::from_fn(|k| inverse[k][column]);
            match equation.row {
                // The weights of the equations are in bulk moduli; three of them correspond to a unit strain rate.
                Some(row) => rows.push((row, direction.map(|x| 3.0 * x))),
                None => {
                    for k in 0..6 {
                        base[k] += direction[k] * equation.rate;
                    }
                }
            }
        }
        decouple(&mut rows, modulus)?;
        let mut control = servo::CellControl {
            rate: self.gradient(&base),
            rate_limit: self.servo_limit * rate,
            response: self.response,
            ..servo::CellControl::default()
        };
        for (place, (mut row, moves)) in control.rows.iter_mut().zip(rows) {
            row.stiffness = dot(&resistance(&row, modulus), &moves);
            row.moves = self.gradient(&moves);
            *place = Some(row);
        }
        Ok(control)
    }

    /// The strain rates of the six components as a velocity gradient.
    fn gradient(&self, rates: &[f64; 6]) -> Matrix {
        let mut matrix = [[0.0; 3]; 3];
        for (k, [r, c]) in PLACES.into_iter().enumerate() {
            match (k < 3, self.kinematics) {
                (true, _) | (_, Kinematics::SimpleShear) => matrix[r][c] = rates[k],
                (false, Kinematics::PureShear) => {
                    matrix[r][c] = 0.5 * rates[k];
                    matrix[c][r] = matrix[r][c];
                }
            }
        }
        matrix
    }
}

/// The same weights with zero in place of minus zero, which a case file does not distinguish.
fn without_minus_zero(weights: [f64; 6]) -> [f64; 6] {
    weights.map(|weight| weight + 0.0)
}

impl Constraint {
    /// The mean stress, controlled through the components that are free.
    pub fn mean_stress(target: Target) -> Constraint {
        Constraint { stress: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], target, ..Constraint::default() }
    }

    /// A combination of stresses.
    pub fn stresses(stress: [f64; 6], target: Target) -> Constraint {
        Constraint { stress: without_minus_zero(stress), target, ..Constraint::default() }
    }

    /// A combination of strain rates, as a multiple of the speed of the stage.
    pub fn strains(strain: [f64; 6], rate: f64) -> Constraint {
        let target = Target::current().moving(rate);
        Constraint { strain: without_minus_zero(strain), target, ..Constraint::default() }
    }

    /// The same with given strain rates by which it is controlled.
    pub fn moving(self, moves: [f64; 6]) -> Constraint {
        Constraint { moves: Some(moves), ..self }
    }

    /// The controlled combination. The mean stress counts as such, not as the sum of three stresses.
    fn row(&self) -> Row {
        let mean = self.stress == [1.0, 1.0, 1.0, 0.0, 0.0, 0.0] && self.strain == [0.0; 6];
        Row {
            stress: self.stress,
            strain: self.strain,
            divisor: if mean { 3.0 } else { 1.0 },
            ..Row::mean(0.0, [false; 3])
        }
    }
}

/// The time `d sqrt(rho / p)`, s, in which grains move under the mean stress, the reciprocal of the strain rate at an inertial number
/// of one. It is at most ten thousand time steps, so that it remains finite for a sample with almost no stress.
fn inertial_time(simulation: &Simulation) -> f64 {
    let state = simulation.state();
    let rate = simulation.strain_rate(1.0, state.mean_stress().max(0.0));
    (1.0 / rate).min(1e4 * state.time_step())
}

/// The bulk modulus by which equations are scaled, Pa; without contacts it is estimated from the stress.
fn modulus(control: &Control, simulation: &Simulation) -> f64 {
    simulation.state().bulk_modulus().max(100.0 * control.reference_stress(simulation)).max(1.0)
}

#[cfg(test)]
#[path = "control_tests.rs"]
mod tests;
