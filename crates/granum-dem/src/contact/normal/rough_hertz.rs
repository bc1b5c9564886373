//! Normal contact of elastic spheres with rough surfaces (Otsubo, O'Sullivan, Hanley and Sim 2017, Geotechnique 67, 452-459): the
//! asperities are pressed flat before the spheres deform.
//!
//! With the rms roughness of both surfaces together, `S = (S_i^2 + S_j^2)^(1/2)`, and the loads `N_1 = S E* (2 R* S)^(1/2)` and
//! `N_2 = 100 N_1`, a contact passes through three stages; in `t = alpha / S` and `g = N / N_1`
//!
//! - asperities: `g = (t / t_1)^c` up to g = 1,
//! - transition: `g = 100 ((t - 0.82) / (t_2 - 0.82))^b` up to g = 100,
//! - Hertz's contact of the spheres, moved by the compression of the asperities: `g = 4/3 2^(-1/2) (t - 2.06)^(3/2)`.
//!
//! The displacements 0.82 S and 1.24 S of the asperities are those of Greenwood and Tripp's contact as the authors use it. That force
//! and stiffness are continuous where the stages meet determines `t_1 = 2.109319`, `t_2 = 24.467024`, `c = 2.589795` and
//! `b = 1.583010`: the curve is the same for all contacts.
//!
//! Normal and tangential stiffness are reduced in the same ratio: the radius that the tangential laws use is that of the smooth
//! contact of equal normal stiffness, `a = k_n / 2 E*`. The contact is elastic, without memory; it starts at alpha = 0.

use granum_simd::{Mask, Real, power};

use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Normal, NormalLaw};
use crate::law_constants;

/// Otsubo et al. (2017).
#[derive(Clone, Copy, Debug)]
pub struct RoughHertz;

law_constants! {
    /// Constants of the contact of rough spheres for a pair.
    pub struct RoughHertzConstants<R> {
        /// `1 / S`, 1/m.
        pub inverse_roughness: R,
        /// `N_1`, N.
        pub rough_force: R,
        /// `1 / 2 E*`, 1/Pa.
        pub compliance: R,
        /// `(1 / 2 E*)^(1/2)`.
        pub root_compliance: R,
    }
}

/// Smallest S / R* used: far below any real value, so that smooth spheres follow Hertz's law.
const LEAST_LENGTH: f64 = 1e-30;

const FIRST_END: f64 = 2.109_318_870_100_697_3;
const SECOND_END: f64 = 24.467_023_732_785_823;
/// Displacement at which the transition would start from zero, and by which Hertz's curve is moved, over S.
const SECOND_START: f64 = 0.82;
const THIRD_START: f64 = 2.06;
const FIRST_POWER: f64 = 2.589_795_495_330_664;
const SECOND_POWER: f64 = 1.583_009_685_810_189;
const SECOND_FORCE: f64 = 100.0;
/// `4/3 2^(-1/2)`.
const HERTZ: f64 = 0.942_809_041_582_063_4;
/// Overlap below which there is no force, over S.
const LEAST: f64 = 1e-30;

/// Force over N_1 and its derivative by t.
#[inline(always)]
fn curve<R: Real>(t: R) -> [R; 2] {
    let beyond = (t - R::splat(THIRD_START)).max(R::zero());
    let root = R::splat(HERTZ) * beyond.sqrt();
    let (hertz, hertz_slope) = (root * beyond, R::splat(1.5) * root);
    let rough = t.lt(R::splat(SECOND_END));
    if !rough.any() {
        return [hertz, hertz_slope];
    }
    let first = t.lt(R::splat(FIRST_END));
    let exponent = R::select(first, R::splat(FIRST_POWER), R::splat(SECOND_POWER));
    let from = R::select(first, t, t - R::splat(SECOND_START)).max(R::splat(LEAST));
    let over = R::select(first, R::splat(1.0 / FIRST_END), R::splat(1.0 / (SECOND_END - SECOND_START)));
    let scale = R::select(first, R::splat(1.0), R::splat(SECOND_FORCE));
    let force = scale * power((from * over).min(R::splat(1.0)), exponent);
    let slope = exponent * force / from;
    [R::select(rough, force, hertz), R::select(rough, slope, hertz_slope)]
}

/// Integral of the force over N_1 from t = 0.
#[inline(always)]
fn work<R: Real>(t: R) -> R {
    // Just below the ends, where the curve is still that of the stage.
    let below = |t: f64| t * (1.0 - 1e-15);
    let [first_end, _, _] = primitives(below(FIRST_END));
    let [_, second_start, _] = primitives(FIRST_END);
    let [_, second_end, _] = primitives(below(SECOND_END));
    let [_, _, third_start] = primitives(SECOND_END);
    let before_third = first_end + second_end - second_start;
    let [first, second, third] = primitives(t);
    let second = R::splat(first_end) + second - R::splat(second_start);
    let third = R::splat(before_third) + third - R::splat(third_start);
    R::select(t.lt(R::splat(FIRST_END)), first, R::select(t.lt(R::splat(SECOND_END)), second, third))
}

/// A primitive of the force of each stage; only that of the stage to which t belongs has a meaning.
#[inline(always)]
fn primitives<R: Real>(t: R) -> [R; 3] {
    let [force, _] = curve(t);
    [
        t * force / R::splat(FIRST_POWER + 1.0),
        (t - R::splat(SECOND_START)) * force / R::splat(SECOND_POWER + 1.0),
        R::splat(0.4) * (t - R::splat(THIRD_START)) * force,
    ]
}

impl NormalLaw for RoughHertz {
    type Constants<R: Real> = RoughHertzConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "rough-hertz",
        label: "Hertz with rough surfaces (Otsubo et al. 2017)",
        help: "elastic spheres with rough surfaces, softer than Hertz under small loads: Otsubo et al. 2017",
        parameters: &[LawParameter {
            key: "roughness",
            unit: Unit::LENGTH,
            default: 1e-7,
            bounds: [0.0, 1e-4],
            meaning: "Root mean square roughness S_q of the surface of a grain; that of a contact is (S_i^2 + S_j^2)^(1/2)",
            without_area: false,
            mixing: Mixing::Quadratic,
        }],
    };

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> RoughHertzConstants<f64> {
        let (radius, modulus) = (pair.effective_radius, pair.effective_modulus);
        // The root of the mean square of the two sides.
        let length = (parameters[0] * std::f64::consts::SQRT_2).max(LEAST_LENGTH * radius);
        let compliance = 0.5 / modulus;
        RoughHertzConstants {
            inverse_roughness: 1.0 / length,
            rough_force: length * modulus * (2.0 * radius * length).sqrt(),
            compliance,
            root_compliance: compliance.sqrt(),
        }
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &RoughHertzConstants<R>, overlap: R, _touched: R::Mask) -> Normal<R> {
        let alpha = overlap.max(R::zero());
        let touching = alpha.gt(R::zero());
        let [force, slope] = curve(alpha * c.inverse_roughness);
        let force = (c.rough_force * force).keep(touching);
        let stiffness = (c.rough_force * c.inverse_roughness * slope).keep(touching);
        let root_stiffness = stiffness.sqrt();
        let radius = c.compliance * stiffness;
        Normal {
            force,
            radius,
            stiffness,
            root_stiffness,
            tangential_measure: radius,
            root_tangential_measure: c.root_compliance * root_stiffness,
            friction_load: force,
            touching,
        }
    }

    fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
        let c = Self::prepare(pair, parameters);
        let g = load / c.rough_force;
        let t = if g < 1.0 {
            FIRST_END * power(g.max(LEAST), 1.0 / FIRST_POWER)
        } else if g < SECOND_FORCE {
            SECOND_START + (SECOND_END - SECOND_START) * power(g / SECOND_FORCE, 1.0 / SECOND_POWER)
        } else {
            let root = granum_simd::cbrt(g / HERTZ);
            THIRD_START + root * root
        };
        Self::evaluate(&c, t / c.inverse_roughness, true)
    }

    /// The integral of the force.
    #[inline(always)]
    fn energy<R: Real>(c: &RoughHertzConstants<R>, overlap: R) -> R {
        let touching = overlap.gt(R::zero());
        (c.rough_force / c.inverse_roughness * work(overlap * c.inverse_roughness)).keep(touching)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Material;
    use crate::contact::normal::Hertz;

    fn pair() -> PairProperties {
        let material = Material { interface_energy: 0.0, ..Material::default() };
        PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0)
    }

    fn near(found: f64, wanted: f64, within: f64) {
        assert!((found / wanted - 1.0).abs() < within, "{found:e} {wanted:e}");
    }

    /// t, N/N_1, k_n S/N_1, and the work over N_1 S.
    #[test]
    fn the_curve_is_that_of_the_paper() {
        let table = [
            (0.1, 3.721_708_866_546_92e-4, 9.638_464_857_515_41e-3, 1.036_746_764_930_72e-5),
            (1.0, 0.144_723_111_933_696, 0.374_803_263_356_123, 4.031_514_110_537_53e-2),
            (5.0, 6.436_156_343_692_12, 2.437_439_672_596_49, 10.503_854_838_103_8),
            (20.0, 71.789_392_506_124_5, 5.925_094_039_396_48, 533.156_720_666_359),
            (100.0, 913.826_795_251_218, 13.995_713_629_536_7, 35_819.369_370_258_9),
        ];
        let roughness = 1e-7;
        let c = RoughHertz::prepare(&pair(), &[roughness / std::f64::consts::SQRT_2]);
        let unit = roughness * pair().effective_modulus * (2.0 * pair().effective_radius * roughness).sqrt();
        for (t, force, slope, energy) in table {
            let n = RoughHertz::evaluate(&c, t * roughness, true);
            near(n.force, unit * force, 1e-12);
            near(n.stiffness, unit / roughness * slope, 1e-12);
            near(RoughHertz::energy(&c, t * roughness), unit * roughness * energy, 1e-12);
            near(n.radius, n.stiffness / (2.0 * pair().effective_modulus), 1e-12);
            near(n.root_tangential_measure * n.root_tangential_measure, n.radius, 1e-12);
        }
    }

    /// Force and stiffness have no jump where the stages meet.
    #[test]
    fn the_stages_join() {
        for end in [FIRST_END, SECOND_END] {
            let ([a, b], [c, d]) = (curve(end * (1.0 - 1e-13)), curve(end * (1.0 + 1e-13)));
            near(a, c, 1e-11);
            near(b, d, 1e-11);
            near(work(end * (1.0 - 1e-13)), work(end * (1.0 + 1e-13)), 1e-11);
        }
    }

    /// Under 20 kPa the normal stiffness is 0.78, 0.30 and 0.15 of Hertz's with 10, 100 and 500 nm of roughness; smooth, it is
    /// Hertz's.
    #[test]
    fn rough_contacts_are_softer() {
        let load = 2e-4;
        let hertz = Hertz::loaded(&pair(), &[], load);
        for (roughness, share) in [(1e-8, 0.781), (1e-7, 0.296), (5e-7, 0.1506)] {
            let n = RoughHertz::loaded(&pair(), &[roughness / std::f64::consts::SQRT_2], load);
            near(n.force, load, 1e-11);
            near(n.stiffness / hertz.stiffness, share, 2e-3);
        }
        let (smooth, hertz) = (RoughHertz::prepare(&pair(), &[0.0]), Hertz::prepare(&pair(), &[]));
        for overlap in [1e-12, 1e-8] {
            let (a, b) =
                (RoughHertz::evaluate(&smooth, overlap, true), Hertz::evaluate(&hertz, overlap, true));
            near(a.force, b.force, 1e-12);
            near(a.radius, b.radius, 1e-12);
            near(RoughHertz::energy(&smooth, overlap), Hertz::energy(&hertz, overlap), 1e-12);
        }
        let rough = RoughHertz::prepare(&pair(), &[1e-7]);
        assert!(!RoughHertz::evaluate(&rough, -1e-9, true).touching);
        assert_eq!(RoughHertz::evaluate(&rough, -1e-9, true).stiffness, 0.0);
        assert_eq!(RoughHertz::energy(&rough, -1e-9), 0.0);
    }
}
