//! Normal contact of adhesive elastic spheres (Johnson, Kendall and Roberts 1971).
//!
//! In units of the pull-off force `N_c = 3/2 pi Gamma R*`, of the contact radius at zero load
//! `a_0 = (9 pi Gamma R*^2 / 2 E*)^(1/3)` and of `d_0 = a_0^2 / R*` everything follows from `x = sqrt(a / a_0)`:
//! with `s = x^3`
//!
//! - approach `alpha / d_0 = x^4 - 2/3 x`,
//! - force `N / N_c = 4 s (s - 1)`,
//! - stiffness `dN/dalpha = 2 E* a (6 s - 3) / (6 s - 1)`.
//!
//! A contact is made at zero approach, where the force jumps to `-8/9 N_c`, and breaks under displacement
//! control at `-alpha_f = -0.27516 d_0`, where `N = -5/9 N_c` (Thornton and Yin 1991).

use granum_simd::Real;

use super::{LAW_CONSTANTS, Normal, NormalLaw, PairProperties};

/// Johnson, Kendall and Roberts (1971).
#[derive(Clone, Copy, Debug)]
pub struct Jkr;

const INVERSE_LENGTH: usize = 0;
const RADIUS: usize = 1;
const FOUR_FORCES: usize = 2;
const STIFFNESS: usize = 3;
const LOSS: usize = 4;

/// Approach of rupture over d_0: `-6^(-1/3) / 2`.
const BREAK: f64 = -0.275_160_604_074_552_22;
/// Energy lost in one make and break over `N_c d_0`.
const MAKE_BREAK_LOSS: f64 = 0.257_413_510_958_529;
/// Smallest d_0 / R* used: far below any real one, so that without adhesion the law is Hertz's.
const LEAST_LENGTH: f64 = 1e-30;
/// Share of `2 E* a` below which the stiffness for the dashpot does not fall.
const LEAST_STIFFNESS: f64 = 0.1;

/// `x = sqrt(a / a_0)` at an approach over d_0, on the stable branch.
#[inline(always)]
fn invert<R: Real>(h: R) -> R {
    let t = (h - R::splat(BREAK)).max(R::zero()).sqrt();
    let p = R::splat(0.067_571_638_377_7)
        .mul_add(t, R::splat(0.753_029_431_438))
        .mul_add(t, R::splat(1.651_322_164_30))
        .mul_add(t, R::splat(0.816_496_488_430));
    let q = R::splat(0.067_593_080_918_3)
        .mul_add(t, R::splat(0.770_890_302_157))
        .mul_add(t, R::splat(1.797_770_481_59))
        .mul_add(t, R::splat(1.0));
    let mut x = (t * p / q + R::splat(0.302_853_432_138_690)).sqrt();
    for _ in 0..2 {
        let cube = x * x * x;
        let slope = cube.mul_add(R::splat(4.0), R::splat(-2.0 / 3.0));
        let rest = x.mul_add(cube - R::splat(2.0 / 3.0), -h);
        let safe = R::select(slope.gt(R::splat(1e-9)), slope, R::splat(f64::INFINITY));
        x = x - rest / safe;
    }
    x
}

impl NormalLaw for Jkr {
    fn prepare(pair: &PairProperties) -> [f64; LAW_CONSTANTS] {
        let (radius, modulus) = (pair.effective_radius, pair.effective_modulus);
        let wanted = 4.5 * std::f64::consts::PI * pair.interface_energy * radius * radius / modulus;
        let contact = granum_simd::cbrt(wanted).max(radius * LEAST_LENGTH.sqrt());
        let length = contact * contact / radius;
        // N_c = 3/2 pi Gamma R* = E* a_0^3 / (3 R*).
        let force = modulus * contact * length / 3.0;
        let mut c = [0.0; LAW_CONSTANTS];
        c[INVERSE_LENGTH] = 1.0 / length;
        c[RADIUS] = contact;
        c[FOUR_FORCES] = 4.0 * force;
        c[STIFFNESS] = 2.0 * modulus * contact;
        c[LOSS] = if pair.interface_energy > 0.0 { MAKE_BREAK_LOSS * force * length } else { 0.0 };
        c
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &[R; LAW_CONSTANTS], approach: R, touched: R::Mask) -> Normal<R> {
        let one = R::splat(1.0);
        let third = R::splat(1.0 / 3.0);
        let h = approach * c[INVERSE_LENGTH];
        let touching = approach.gt(R::zero()) | (touched & h.ge(R::splat(BREAK)));
        let x = invert(h);
        let square = x * x;
        let s = x * square;
        let force = c[FOUR_FORCES] * (s * (s - one));
        // k_n / 2 E* a = (6 s - 3) / (6 s - 1), falling to minus infinity at s = 1/6.
        let slope = s.mul_add(R::splat(6.0), -one).max(R::splat(1e-12));
        let ratio = (one - R::splat(2.0) / slope).max(R::splat(LEAST_STIFFNESS));
        // Thornton (1991): T_s / mu = N + 2 N_c above -0.3 N_c, below it the Hertz load of the compressive zone,
        // N_1 (1 - (N_1 - N) / 3 N_1)^(3/2), which is 4 N_c (s - 1/3) sqrt(s (s - 1/3)).
        let core = (s - third).max(R::zero());
        let zone = c[FOUR_FORCES] * core * (s * core).sqrt();
        let shifted = c[FOUR_FORCES].mul_add(R::splat(0.5), force);
        let tensile = force.lt(c[FOUR_FORCES] * R::splat(-0.075));
        Normal {
            force: force.keep(touching),
            radius: (c[RADIUS] * square).keep(touching),
            stiffness: (c[STIFFNESS] * square * ratio).keep(touching),
            friction_load: R::select(tensile, zone, shifted).keep(touching),
            touching,
        }
    }

    /// `N_c d_0 (8/5 x^10 - 8/3 x^7 + 2/3 x^4)`, less its value at zero approach.
    fn energy(c: &[f64; LAW_CONSTANTS], approach: f64) -> f64 {
        let primitive = |x: f64| {
            let s = x * x * x;
            s * x * (s * (1.6 * s - 8.0 / 3.0) + 2.0 / 3.0)
        };
        let unit = 0.25 * c[FOUR_FORCES] / c[INVERSE_LENGTH];
        unit * (primitive(invert(approach * c[INVERSE_LENGTH])) - primitive(granum_simd::cbrt(2.0 / 3.0)))
    }

    #[inline(always)]
    fn breaking_loss<R: Real>(c: &[R; LAW_CONSTANTS]) -> R {
        c[LOSS]
    }

    fn breaking_approach(c: &[f64; LAW_CONSTANTS]) -> f64 {
        BREAK / c[INVERSE_LENGTH]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Material;

    /// Approach over d_0, contact radius over a_0, force over N_c: 40-digit roots of the equations.
    #[allow(clippy::excessive_precision)]
    const TABLE: [(f64, f64, f64); 12] = [
        (-0.27, 0.362384558497366075, -0.682241526588583842),
        (-0.2, 0.537268343598665388, -0.954894842218966163),
        (-0.132283420997349956, 0.629960524947436582, -1.0),
        (-0.1, 0.66654407488631669, -0.99219218622140964),
        (0.0, 0.763142828368887912, -0.888888888888888889),
        (0.1, 0.844095943140854638, -0.69637571125091343),
        (1.0 / 3.0, 1.0, 0.0),
        (0.5, 1.09424624133001203, 0.662292895022718152),
        (1.0, 1.3299736417598827, 3.27484759556083434),
        (5.0, 2.45873056413851008, 44.0341138513440469),
        (20.0, 4.62973592590624544, 357.096580751186898),
        (100.0, 10.1054078066621161, 3999.33100932636162),
    ];

    #[test]
    fn follows_the_table() {
        let material = Material::default();
        let pair = PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0);
        let c = Jkr::prepare(&pair);
        for (h, radius, force) in TABLE {
            let n = Jkr::evaluate(&c, h / c[INVERSE_LENGTH], true);
            assert!((n.radius / c[RADIUS] / radius - 1.0).abs() < 1e-12, "radius at {h}");
            let error = 4.0 * n.force / c[FOUR_FORCES] - force;
            assert!(error.abs() < 1e-12 * force.abs().max(1.0), "force at {h}: {error}");
        }
    }
}
