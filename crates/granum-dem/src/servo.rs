//! Servo control of the cell: it is strained at base rates, and strain rates are added that hold any number of combinations
//! of stresses at targets, which may change with time.
//!
//! A proportional-integral controller drives each controlled combination ([`Row`]) at
//! `rate = (target_rate + (e + integral(e dt) / (6 tau)) / tau) / (a K)` with the error `e = target - stress`. Its gain is
//! derived from the sample: K is the affine bulk modulus `sum(k_n D^2) / (9 V)` of the present contacts, an upper bound of
//! the true one, `a K` is the stiffness of the combination with respect to the strain rate that controls it ([`STIFFNESS`]),
//! and tau is a number of time steps, by default thirty. So short a time is sound because the cell strains all contacts at
//! once: nothing has to travel from a wall. (With 300 steps p fluctuates by 3 % rms in a test of 1000 grains at I = 1e-3,
//! with 100 by 1.1 %, with 50 by 0.5 %, with 20 by 0.2 %. Single stresses fluctuate more than their mean: with 30 steps the
//! lateral stresses of a drained triaxial test of 300 grains by 0.8 %; stages therefore use six.)
//!
//! The rate needed for a target that changes steadily is fed forward, and the integral adapts to the rest of it, so that the
//! stress does not lag behind.

use serde::{Deserialize, Serialize};

use crate::assembly::Matrix;

/// Components of stress and strain, in the order of all lists of six here.
pub const COMPONENTS: [&str; 6] = ["xx", "yy", "zz", "yz", "zx", "xy"];

/// Row and column of each component.
pub const PLACES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [2, 0], [0, 1]];

/// Estimated stiffness of each stress component with respect to its own strain, shear strains as angles, in affine bulk
/// moduli: that of an isotropic solid with a Poisson's ratio of zero, whose bulk modulus is the given one.
pub const STIFFNESS: [f64; 6] = [3.0, 3.0, 3.0, 1.5, 1.5, 1.5];

/// Default time constant of the servo, in time steps.
pub const RESPONSE: f64 = 30.0;

/// A combination of stresses that is held at a target, and the strain rate that controls it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Weights of the stress components, see [`COMPONENTS`].
    pub stress: [f64; 6],
    /// The weighted sum is divided by this.
    pub divisor: f64,
    /// Weights of the strain components, Pa, added to the stresses; zero for a combination of stresses alone.
    pub strain: [f64; 6],
    /// Target at [`CellControl::since`], Pa. Zero is a valid target.
    pub target: f64,
    /// Rate of change of the target, Pa/s.
    pub target_rate: f64,
    /// Strain rate per unit of the servo output.
    pub moves: Matrix,
    /// Stiffness of the combination with respect to `moves`, in affine bulk moduli.
    pub stiffness: f64,
}

impl Row {
    /// One stress component, controlled by its own strain rate.
    pub fn component(k: usize, target: f64) -> Row {
        let [r, c] = PLACES[k];
        let mut row =
            Row { stress: [0.0; 6], target, stiffness: STIFFNESS[k], ..Row::mean(target, [false; 3]) };
        row.stress[k] = 1.0;
        row.divisor = 1.0;
        row.moves[r][c] = if k < 3 { 1.0 } else { 0.5 };
        row.moves[c][r] = row.moves[r][c];
        row
    }

    /// The mean stress, controlled by some axes together.
    pub fn mean(target: f64, axes: [bool; 3]) -> Row {
        let mut moves = [[0.0; 3]; 3];
        for a in 0..3 {
            moves[a][a] = f64::from(u8::from(axes[a]));
        }
        Row {
            stress: MEAN,
            divisor: 3.0,
            strain: [0.0; 6],
            target,
            target_rate: 0.0,
            moves,
            stiffness: axes.iter().filter(|&&a| a).count().max(1) as f64,
        }
    }

    /// The value of the combination at a stress, Pa, and a strain.
    pub fn value(&self, stress: &Matrix, strain: &Matrix) -> f64 {
        let mut sum = 0.0;
        for (k, &weight) in self.stress.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            sum += weight * component(stress, k);
        }
        let mut value = sum / self.divisor;
        for (k, &weight) in self.strain.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            value += weight * strain_component(strain, k);
        }
        value
    }

    /// The target after a given time, s.
    pub fn aim(&self, elapsed: f64) -> f64 {
        if self.target_rate == 0.0 { self.target } else { self.target + self.target_rate * elapsed }
    }

    /// True if both hold the same combination by the same strain rates; the targets may differ.
    fn holds_as(&self, other: &Row) -> bool {
        (self.stress, self.strain, self.moves) == (other.stress, other.strain, other.moves)
            && (self.divisor, self.stiffness) == (other.divisor, other.stiffness)
    }

    /// True if it is the mean stress.
    pub(crate) fn is_mean(&self) -> bool {
        self.stress == MEAN && self.divisor == 3.0 && self.strain == [0.0; 6]
    }

    /// The stress component that it stands for, if it is a single one.
    pub(crate) fn single(&self) -> Option<usize> {
        let mut weights = (0..6).filter(|&k| self.stress[k] != 0.0);
        let first = weights.next()?;
        let plain = weights.next().is_none() && self.stress[first] == self.divisor && self.strain == [0.0; 6];
        plain.then_some(first)
    }
}

/// Weights of the mean stress.
const MEAN: [f64; 6] = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];

/// A component of a stress tensor; its two shear entries are averaged.
pub fn component(stress: &Matrix, k: usize) -> f64 {
    let [r, c] = PLACES[k];
    0.5 * (stress[r][c] + stress[c][r])
}

/// A component of a strain tensor; shear strains are angles, the sum of the two entries.
pub fn strain_component(strain: &Matrix, k: usize) -> f64 {
    let [r, c] = PLACES[k];
    if k < 3 { strain[r][c] } else { strain[r][c] + strain[c][r] }
}

/// The control of the cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellControl {
    /// Base strain rate of every component, 1/s, compression positive; the velocity gradient is minus this.
    pub rate: Matrix,
    /// Combinations of stresses that are controlled.
    pub rows: [Option<Row>; 6],
    /// Time at which targets begin to change, s.
    pub since: f64,
    /// Time over which base rates and the motion of targets grow from nothing, s.
    pub ease: f64,
    /// Bound on the rate that the servo adds to a component for one row, 1/s.
    pub rate_limit: f64,
    /// Time constant tau of the servo, in time steps.
    pub response: f64,
}

impl Default for CellControl {
    fn default() -> Self {
        CellControl {
            rate: [[0.0; 3]; 3],
            rows: [None; 6],
            since: 0.0,
            ease: 0.0,
            rate_limit: 0.0,
            response: RESPONSE,
        }
    }
}

impl CellControl {
    /// No component is strained.
    pub fn fixed() -> CellControl {
        CellControl::default()
    }

    /// All three axes servo-controlled to the same stress.
    pub fn isotropic(stress: f64, rate_limit: f64) -> CellControl {
        let mut control = CellControl { rate_limit, ..CellControl::default() };
        for a in 0..3 {
            control.rows[a] = Some(Row::component(a, stress));
        }
        control
    }

    /// Axis `axis` strained at `rate`, the other two at half that rate in the opposite direction while they control the mean
    /// stress.
    pub fn constant_mean_stress(axis: usize, rate: f64, target: f64, rate_limit: f64) -> CellControl {
        let mut control = CellControl { rate_limit, ..CellControl::default() };
        let mut axes = [true; 3];
        for a in 0..3 {
            control.rate[a][a] = if a == axis { rate } else { -0.5 * rate };
        }
        axes[axis] = false;
        control.rows[0] = Some(Row::mean(target, axes));
        control
    }

    /// The controlled combinations.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().flatten()
    }

    /// The time at full rate, s, in which the targets would have moved as far as they have at a time, s, of the state.
    pub fn progress(&self, time: f64) -> f64 {
        let elapsed = time - self.since;
        if self.ease > 0.0 {
            if elapsed < self.ease { 0.5 * elapsed * elapsed / self.ease } else { elapsed - 0.5 * self.ease }
        } else {
            elapsed
        }
    }

    /// The target of the mean stress at a given time, s, if the control has one.
    pub fn target_mean_stress(&self, time: f64) -> Option<f64> {
        let elapsed = self.progress(time);
        if let Some(row) = self.rows().find(|row| row.is_mean()) {
            return Some(row.aim(elapsed));
        }
        let single =
            |axis: usize| self.rows().find(|row| row.single() == Some(axis)).map(|row| row.aim(elapsed));
        match [0, 1, 2].map(single) {
            [Some(a), Some(b), Some(c)] => Some((a + b + c) / 3.0),
            _ => None,
        }
    }

    /// Reverses the base rates and the rates of the targets at a given time, s. A changing stress is reversed from its present
    /// value, even if its target was ahead of it.
    pub fn reverse(&mut self, time: f64, stress: &Matrix, strain: &Matrix) {
        self.since = time;
        self.rate = self.rate.map(|row| row.map(|x| -x));
        for row in self.rows.iter_mut().flatten().filter(|row| row.target_rate != 0.0) {
            row.target = row.value(stress, strain);
            row.target_rate = -row.target_rate;
        }
    }

    /// True if all its numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        let rows = self.rows().all(|row| {
            let lists = row.stress.iter().chain(&row.strain).chain(row.moves.iter().flatten());
            let numbers = [row.target, row.target_rate, row.divisor, row.stiffness];
            lists.chain(&numbers).all(|x| x.is_finite()) && row.divisor != 0.0 && row.stiffness != 0.0
        });
        rows && self.since.is_finite()
            && self.ease.is_finite()
            && self.response.is_finite()
            && self.response > 0.0
            && self.rate.iter().flatten().all(|x| x.is_finite())
    }

    /// Largest target stress, Pa.
    fn scale(&self, elapsed: f64) -> f64 {
        self.rows().fold(0.0, |m, row| m.max(row.aim(elapsed).abs()))
    }
}

/// Integrals of the stress errors of the rows, Pa.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Servo {
    integrals: [f64; 6],
}

/// The properties of the sample that the servo uses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ServoInput {
    pub(crate) stress: Matrix,
    pub(crate) strain: Matrix,
    /// Affine bulk modulus, Pa.
    pub(crate) bulk_modulus: f64,
    pub(crate) time: f64,
    pub(crate) dt: f64,
}

impl Servo {
    /// The servo of another control: combinations that both hold by the same strain rates keep their integrals, all others begin anew.
    pub(crate) fn carried(&self, before: &CellControl, after: &CellControl) -> Servo {
        let kept = |row: &Row| {
            let at = before.rows.iter().position(|old| old.is_some_and(|old| old.holds_as(row)))?;
            Some(self.integrals[at])
        };
        Servo { integrals: after.rows.map(|row| row.as_ref().and_then(kept).unwrap_or(0.0)) }
    }

    /// The velocity gradient L for the next step.
    pub(crate) fn gradient(&mut self, control: &CellControl, sample: &ServoInput) -> Matrix {
        let elapsed = control.progress(sample.time);
        // The share of the full rates at which it goes.
        let share =
            if control.ease > 0.0 { ((sample.time - control.since) / control.ease).min(1.0) } else { 1.0 };
        let aimed = control.scale(elapsed);
        // Without contacts there is no stiffness; the rate limit then decides, and this lower bound only keeps numbers
        // finite.
        let stiffness = sample.bulk_modulus.max(100.0 * aimed).max(1.0);
        let tau = control.response * sample.dt;
        // For a target of zero the present stress is the scale of the error.
        let scale = aimed.max(sample.stress.iter().flatten().fold(0.0, |m, s| m.max(s.abs())));
        let mut rate = control.rate;
        if share < 1.0 {
            rate = rate.map(|row| row.map(|x| share * x));
        }
        for (row, integral) in control.rows.iter().zip(&mut self.integrals) {
            let Some(row) = row else { continue };
            let law = Gain {
                gain: 1.0 / (row.stiffness * stiffness * tau),
                forward: share * row.target_rate / (row.stiffness * stiffness),
                tau,
                dt: sample.dt,
                limit: control.rate_limit,
            };
            let error = row.aim(elapsed) - row.value(&sample.stress, &sample.strain);
            let part = law.proportional_integral(error, scale, integral);
            for r in 0..3 {
                for c in 0..3 {
                    rate[r][c] += part * row.moves[r][c];
                }
            }
        }
        rate.map(|row| row.map(|x| -x))
    }
}

/// Relative error of the stress below which the integral is active.
const NEAR: f64 = 0.2;

/// Gain, feed-forward rate, time constant, time step and rate limit of a servo.
struct Gain {
    gain: f64,
    forward: f64,
    tau: f64,
    dt: f64,
    limit: f64,
}

impl Gain {
    /// Rate from the error and its integral. The integral is frozen while the rate is at its limit or the stress is still
    /// far from its target, which prevents windup during the approach.
    fn proportional_integral(&self, error: f64, scale: f64, integral: &mut f64) -> f64 {
        let next = *integral + error * self.dt / (6.0 * self.tau);
        let wanted = self.gain * (error + next) + self.forward;
        if wanted.abs() <= self.limit && error.abs() <= NEAR * scale {
            *integral = next;
            return wanted;
        }
        (self.gain * (error + *integral) + self.forward).clamp(-self.limit, self.limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(stress: Matrix, bulk_modulus: f64) -> ServoInput {
        ServoInput { stress, strain: [[0.0; 3]; 3], bulk_modulus, time: 0.0, dt: 1e-8 }
    }

    /// Under the servo, an elastic solid of modulus K reaches its target and stays there, whatever K is.
    #[test]
    fn settles_on_an_elastic_solid() {
        for modulus in [1e6, 1e8, 1e10] {
            let control = CellControl::isotropic(20e3, 1e3);
            let mut servo = Servo::default();
            let mut pressure = 0.0;
            let mut tail: f64 = 0.0;
            for step in 0..40_000 {
                let stress =
                    std::array::from_fn(|r| std::array::from_fn(|c| if r == c { pressure } else { 0.0 }));
                let sample = at(stress, modulus);
                let gradient = servo.gradient(&control, &sample);
                pressure -= modulus * (gradient[0][0] + gradient[1][1] + gradient[2][2]) * sample.dt;
                if step > 30_000 {
                    tail = tail.max((pressure - 20e3f64).abs());
                }
            }
            assert!(tail < 1.0, "modulus {modulus}: off by {tail} Pa");
        }
    }

    #[test]
    fn zero_is_a_target() {
        let control = CellControl::isotropic(0.0, 10.0);
        let mut stress = [[0.0; 3]; 3];
        stress[0][0] = 5e3;
        let gradient = Servo::default().gradient(&control, &at(stress, 1e8));
        assert!(gradient[0][0] > 0.0 && gradient[1][1] == 0.0);
    }

    #[test]
    fn constant_mean_stress_moves_two_axes_alike() {
        let control = CellControl::constant_mean_stress(0, 10.0, 20e3, 100.0);
        let stress = [[20e3, 0.0, 0.0], [0.0, 20e3, 0.0], [0.0, 0.0, 20e3]];
        let gradient = Servo::default().gradient(&control, &at(stress, 1e8));
        assert_eq!(gradient[0][0], -10.0);
        assert_eq!(gradient[1][1], gradient[2][2]);
        assert!((gradient[1][1] - 5.0).abs() < 1e-9);
        assert_eq!(control.target_mean_stress(3.0), Some(20e3));
        assert_eq!(CellControl::isotropic(5e3, 1.0).target_mean_stress(0.0), Some(5e3));
        assert_eq!(CellControl::fixed().target_mean_stress(0.0), None);
    }

    /// A shear stress is controlled by a symmetric shear rate, which causes no rotation.
    #[test]
    fn a_shear_stress_moves_a_symmetric_shear_rate() {
        let mut control = CellControl { rate_limit: 100.0, ..CellControl::fixed() };
        control.rows[0] = Some(Row::component(5, 1e3));
        let gradient = Servo::default().gradient(&control, &at([[0.0; 3]; 3], 1e8));
        assert!(gradient[0][1] < 0.0 && gradient[0][1] == gradient[1][0]);
        assert_eq!(gradient[0][0], 0.0);
    }

    #[test]
    fn turned_round_a_target_goes_back_from_where_it_is() {
        let mut control = CellControl { rate_limit: 1.0, ..CellControl::fixed() };
        control.rate[0][0] = 2.0;
        control.rows[0] = Some(Row { target_rate: 10.0, ..Row::component(1, 100.0) });
        let mut stress = [[0.0; 3]; 3];
        stress[1][1] = 128.0;
        control.reverse(3.0, &stress, &[[0.0; 3]; 3]);
        let row = control.rows[0].unwrap();
        assert_eq!(
            (control.rate[0][0], control.since, row.aim(0.0), row.aim(2.0)),
            (-2.0, 3.0, 128.0, 108.0)
        );
    }

    /// Rates grow from nothing, and targets move as far as the rates say.
    #[test]
    fn rates_and_targets_are_eased_in() {
        let mut control = CellControl { rate_limit: 1.0, since: 1.0, ease: 0.5, ..CellControl::fixed() };
        control.rate[0][0] = 2.0;
        let rate = |time: f64| {
            let sample = ServoInput { time, ..at([[0.0; 3]; 3], 1e8) };
            -Servo::default().gradient(&control, &sample)[0][0]
        };
        assert_eq!((rate(1.0), rate(1.25), rate(1.5), rate(4.0)), (0.0, 1.0, 2.0, 2.0));
        assert_eq!((control.progress(1.5), control.progress(3.0)), (0.25, 1.75));
    }
}
