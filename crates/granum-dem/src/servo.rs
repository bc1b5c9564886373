//! Servo control of the cell: each component follows a strain rate or a stress, or the mean stress is held by some
//! axes together while others are strained.
//!
//! A proportional-integral rule drives a servoed component at
//! `rate = base + (e + integral(e dt) / (6 tau)) / (n K tau)` with the stress error `e = target - stress`. Its gain
//! comes from the sample: K is the affine bulk modulus `sum(k_n D^2) / (9 V)` of the present contacts, an upper bound
//! of the true one, and tau is thirty time steps, so that nothing is left to tune. So short a time is sound because
//! the cell strains all contacts at once: nothing has to travel from a wall. (With 300 steps p wanders by 3 % rms in a
//! test of 1000 grains at I = 1e-3, with 100 by 1.1 %, with 50 by 0.5 %, with 20 by 0.2 %.)

use serde::{Deserialize, Serialize};

use crate::assembly::Matrix;

/// The mean stress held by some axes together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeanStress {
    /// Target of `p = (sigma_1 + sigma_2 + sigma_3) / 3`, Pa.
    pub target: f64,
    /// The axes that move for it, all by the same rate on top of their base rate.
    pub axes: [bool; 3],
}

/// Time constant of the servo, in time steps.
const RESPONSE: f64 = 30.0;

/// What drives the cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// Base strain rate of every component, 1/s, compression positive; the velocity gradient is minus this.
    pub rate: Matrix,
    /// Target stress of components that are servoed on their own, Pa. Zero is a value.
    pub stress: [[Option<f64>; 3]; 3],
    /// Mean stress held by some axes together.
    pub mean_stress: Option<MeanStress>,
    /// Bound on what the servo adds to a component's rate, 1/s.
    pub rate_limit: f64,
}

impl Control {
    /// Every component at rest.
    pub fn fixed() -> Control {
        Control::default()
    }

    /// All three axes servoed to the same stress.
    pub fn isotropic(stress: f64, rate_limit: f64) -> Control {
        let mut control = Control { rate_limit, ..Control::default() };
        for a in 0..3 {
            control.stress[a][a] = Some(stress);
        }
        control
    }

    /// Axis `axis` strained at `rate`, the other two following half as fast the other way and holding the mean stress.
    pub fn constant_mean_stress(axis: usize, rate: f64, target: f64, rate_limit: f64) -> Control {
        let mut control = Control { rate_limit, ..Control::default() };
        let mut axes = [true; 3];
        for a in 0..3 {
            control.rate[a][a] = if a == axis { rate } else { -0.5 * rate };
        }
        axes[axis] = false;
        control.mean_stress = Some(MeanStress { target, axes });
        control
    }

    /// Largest stress that is aimed at, Pa.
    fn scale(&self) -> f64 {
        let single = self.stress.iter().flatten().flatten().fold(0.0f64, |m, s| m.max(s.abs()));
        self.mean_stress.map_or(single, |m| single.max(m.target.abs()))
    }
}

/// Integrals of the stress errors, Pa s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Servo {
    components: Matrix,
    mean: f64,
}

/// What the servo knows of the sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) stress: Matrix,
    /// Affine bulk modulus, Pa.
    pub(crate) bulk_modulus: f64,
    pub(crate) dt: f64,
}

impl Servo {
    /// The velocity gradient L for the next step.
    pub(crate) fn gradient(&mut self, control: &Control, sample: &Sample) -> Matrix {
        // Without contacts there is no stiffness; the rate limit then decides, and this only keeps numbers finite.
        let stiffness = sample.bulk_modulus.max(100.0 * control.scale()).max(1.0);
        let tau = RESPONSE * sample.dt;
        let gain = |axes: f64| Gain {
            gain: 1.0 / (axes * stiffness * tau),
            tau,
            dt: sample.dt,
            limit: control.rate_limit,
        };
        // For a target of zero the present stress is the measure of what is near.
        let scale = control.scale().max(sample.stress.iter().flatten().fold(0.0, |m, s| m.max(s.abs())));
        let mut rate = control.rate;
        let servoed = (0..3).filter(|&a| control.stress[a][a].is_some()).count().max(1) as f64;
        for r in 0..3 {
            for c in r..3 {
                let Some(target) = control.stress[r][c] else { continue };
                let stress = 0.5 * (sample.stress[r][c] + sample.stress[c][r]);
                let part =
                    proportional_integral(target - stress, scale, &gain(servoed), &mut self.components[r][c]);
                rate[r][c] += part;
                if c > r {
                    rate[c][r] += part;
                }
            }
        }
        if let Some(mean) = control.mean_stress {
            let pressure = (sample.stress[0][0] + sample.stress[1][1] + sample.stress[2][2]) / 3.0;
            let moving = mean.axes.iter().filter(|&&a| a).count().max(1) as f64;
            let part = proportional_integral(mean.target - pressure, scale, &gain(moving), &mut self.mean);
            for a in 0..3 {
                if mean.axes[a] {
                    rate[a][a] += part;
                }
            }
        }
        rate.map(|row| row.map(|x| -x))
    }
}

/// Rate from error and its integral. The integral stands still while the rate is at its limit or the stress still far
/// from its target, so it cannot wind up on the way there.
fn proportional_integral(error: f64, scale: f64, law: &Gain, integral: &mut f64) -> f64 {
    let next = *integral + error * law.dt / (6.0 * law.tau);
    let wanted = law.gain * (error + next);
    if wanted.abs() <= law.limit && error.abs() <= NEAR * scale {
        *integral = next;
        return wanted;
    }
    (law.gain * (error + *integral)).clamp(-law.limit, law.limit)
}

/// Relative error of the stress within which the integral works.
const NEAR: f64 = 0.2;

/// Gain, time constant, time step and rate limit of a servo.
struct Gain {
    gain: f64,
    tau: f64,
    dt: f64,
    limit: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An elastic solid of modulus K under the servo comes to its target and stays, whatever K is.
    #[test]
    fn settles_on_an_elastic_solid() {
        for modulus in [1e6, 1e8, 1e10] {
            let control = Control::isotropic(20e3, 1e3);
            let mut servo = Servo::default();
            let mut pressure = 0.0;
            let dt = 1e-8;
            let mut tail: f64 = 0.0;
            for step in 0..40_000 {
                let stress =
                    std::array::from_fn(|r| std::array::from_fn(|c| if r == c { pressure } else { 0.0 }));
                let sample = Sample { stress, bulk_modulus: modulus, dt };
                let gradient = servo.gradient(&control, &sample);
                pressure -= modulus * (gradient[0][0] + gradient[1][1] + gradient[2][2]) * dt;
                if step > 30_000 {
                    tail = tail.max((pressure - 20e3f64).abs());
                }
            }
            assert!(tail < 1.0, "modulus {modulus}: off by {tail} Pa");
        }
    }

    #[test]
    fn zero_is_a_target() {
        let control = Control::isotropic(0.0, 10.0);
        let mut stress = [[0.0; 3]; 3];
        stress[0][0] = 5e3;
        let sample = Sample { stress, bulk_modulus: 1e8, dt: 1e-8 };
        let gradient = Servo::default().gradient(&control, &sample);
        assert!(gradient[0][0] > 0.0 && gradient[1][1] == 0.0);
    }

    #[test]
    fn constant_mean_stress_moves_two_axes_alike() {
        let control = Control::constant_mean_stress(0, 10.0, 20e3, 100.0);
        let sample = Sample {
            stress: [[20e3, 0.0, 0.0], [0.0, 20e3, 0.0], [0.0, 0.0, 20e3]],
            bulk_modulus: 1e8,
            dt: 1e-8,
        };
        let gradient = Servo::default().gradient(&control, &sample);
        assert_eq!(gradient[0][0], -10.0);
        assert_eq!(gradient[1][1], gradient[2][2]);
        assert!((gradient[1][1] - 5.0).abs() < 1e-9);
    }
}
