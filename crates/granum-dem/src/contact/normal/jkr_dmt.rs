//! Normal contact of adhesive spheres between the limits of JKR and DMT: the closed form of Schwarz (2003, J. Colloid Interface
//! Sci. 261, 99-106), with the pull-off force of Maugis's theory (1992) as fitted by Carpick, Ogletree and Salmeron (1999, J.
//! Colloid Interface Sci. 211, 395-400).
//!
//! The interface energy Gamma, the separation z_0 of the surfaces at equilibrium and the size of the grains determine the position of
//! a pair between the two limits: with Tabor's parameter `mu_T = (R* Gamma^2 / E*^2 z_0^3)^(1/3)` and `lambda = 1.157 mu_T`
//!
//! `p = P_c / (pi Gamma R*) = 7/4 - 1/4 (4.04 lambda^1.4 - 1) / (4.04 lambda^1.4 + 1)`,
//!
//! from 2 (DMT, lambda = 0) to 3/2 (JKR, lambda infinite). With `w^2 = 6/p - 3`
//!
//! - force `N = ((4 E* a^3 / 3 R*)^(1/2) - w P_c^(1/2))^2 - P_c`,
//! - overlap `alpha = a^2/R* - (4 pi (2 - p) Gamma a / E*)^(1/2)`.
//!
//! The overlap has the form of JKR's, `alpha / d_0 = x^4 - 2/3 x` with `x = sqrt(a / a_0)`,
//! `a_0^3 = 9 pi (2 - p) Gamma R*^2 / E*` and `d_0 = a_0^2 / R*`, so that the same rational function inverts it. A contact is
//! made at zero overlap and breaks under displacement control at `-0.27516 d_0`. At p = 3/2 the normal force is exactly that of
//! JKR, at p = 2 that of DMT.
//!
//! Friction is limited by the load `F = N + P_c (1 + w^2)`, which is Thornton's `N + 2 N_c` for JKR and the elastic load for DMT.
//!
//! Against Maugis's exact solution the fit of the pull-off force is within 1.7 %, and the force at a given overlap of touching grains
//! up to 0.17 pi Gamma R* too low at lambda = 1, 0.05 at 3, and 0.5 to 0.7 at lambda from 0.3 down to 0.05.

use granum_simd::{Real, power};

use super::hertz;
use super::jkr::{BREAK, LEAST_LENGTH, LEAST_STIFFNESS, invert};
use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{AdhesionLosses, Normal, NormalLaw};
use crate::law_constants;

/// Schwarz (2003).
#[derive(Clone, Copy, Debug)]
pub struct JkrDmt;

law_constants! {
    /// Constants of a contact between JKR and DMT for a pair.
    pub struct JkrDmtConstants<R> {
        /// `1 / d_0`, 1/m.
        pub inverse_length: R,
        /// `a_0^(1/2)`, m^(1/2).
        pub root_radius: R,
        /// `4 E* a_0^3 / 3 R*`, N.
        pub elastic_force: R,
        /// `w P_c^(1/2)` over the root of that force.
        pub shift: R,
        /// `P_c`, N.
        pub pull_off: R,
        /// `d_0`, m; zero without adhesion.
        pub loss_length: R,
    }
}

/// Largest stiffness for the dashpot and the time step, over `2 E* a`: close to the break the derivative has no bound.
const MOST_STIFFNESS: f64 = 2.0;
/// `x` where the overlap is zero and where the contact breaks: `(2/3)^(1/3)` and `(1/6)^(1/3)`.
const MADE: f64 = 0.873_580_464_736_298_8;
const BROKEN: f64 = 0.550_321_208_149_104_4;

/// The pull-off force over `pi Gamma R*`.
fn pull_off(pair: &PairProperties, separation: f64) -> f64 {
    let adhesion = pair.interface_energy / pair.effective_modulus;
    let cube = pair.effective_radius * adhesion * adhesion / (separation * separation * separation);
    let lambda = 1.157 * granum_simd::cbrt(cube.max(1e-60));
    let q = 4.04 * power(lambda, 1.4);
    1.75 - 0.25 * (q - 1.0) / (q + 1.0)
}

/// The constants of a pair with a given pull-off force over `pi Gamma R*`.
fn constants(pair: &PairProperties, ratio: f64) -> JkrDmtConstants<f64> {
    let (radius, modulus) = (pair.effective_radius, pair.effective_modulus);
    let energy = std::f64::consts::PI * pair.interface_energy;
    let cube = 9.0 * (2.0 - ratio).max(0.0) * energy * radius * radius / modulus;
    // The lower bound is so small that it has no effect on a contact of DMT or of Hertz.
    let contact = granum_simd::cbrt(cube).max(radius * LEAST_LENGTH.sqrt());
    let length = contact * contact / radius;
    let elastic_force = 4.0 / 3.0 * modulus * contact * length;
    let pull_off = ratio * energy * radius;
    JkrDmtConstants {
        inverse_length: 1.0 / length,
        root_radius: contact.sqrt(),
        elastic_force,
        shift: ((6.0 / ratio - 3.0).max(0.0) * pull_off / elastic_force).sqrt(),
        pull_off,
        loss_length: if pair.interface_energy > 0.0 { length } else { 0.0 },
    }
}

/// `(int N dalpha + P_c alpha) / (F_0 d_0)` with `F_0 = 4 E* a_0^3 / 3 R*` from x = 0, where the contact radius is zero.
#[inline(always)]
fn primitive<R: Real>(x: R, q: R) -> R {
    let s = x * x * x;
    let square = R::splat(0.4).mul_add(s, -R::splat(8.0 / 7.0).mul_add(q, R::splat(2.0 / 21.0)));
    let line = s.mul_add(square, q * (q + R::splat(1.0 / 3.0)));
    x * s.mul_add(line, R::splat(-2.0 / 3.0) * q * q)
}

impl NormalLaw for JkrDmt {
    type Constants<R: Real> = JkrDmtConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "jkr-dmt",
        label: "JKR–DMT transition (Schwarz 2003)",
        help: "adhesive, between JKR and DMT by the size of the grains: Schwarz 2003, Carpick et al. 1999",
        parameters: &[LawParameter {
            key: "equilibrium_separation",
            unit: Unit::LENGTH,
            default: 4e-10,
            bounds: [1e-11, 1e-6],
            meaning: "Separation z_0 of the surfaces at equilibrium, about the range of the attraction: with the size of the \
                      grains it determines whether their adhesion is close to JKR or to DMT",
            without_area: false,
            mixing: Mixing::Arithmetic,
        }],
    };
    const ADHESIVE: bool = true;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> JkrDmtConstants<f64> {
        constants(pair, pull_off(pair, parameters[0]))
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &JkrDmtConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
        let one = R::splat(1.0);
        let h = overlap * c.inverse_length;
        let touching = overlap.gt(R::zero()) | (touched & h.ge(R::splat(BREAK)));
        let x = invert(h.max(R::splat(BREAK)));
        let s = x * x * x;
        // dN/dalpha = 2 E* a (6 s - 6 q) / (6 s - 1), and 2 E* a_0 is 3/2 of the elastic force over d_0.
        let slope = s.mul_add(R::splat(6.0), -one).max(R::splat(1e-12));
        let ratio = R::splat(-6.0).mul_add(c.shift, one) / slope + one;
        let ratio = ratio.max(R::splat(LEAST_STIFFNESS)).min(R::splat(MOST_STIFFNESS));
        let stiffness = (R::splat(1.5) * c.elastic_force * c.inverse_length * (x * x) * ratio).keep(touching);
        let root_radius = (c.root_radius * x).keep(touching);
        let shifted = s - c.shift;
        let elastic = c.elastic_force * (shifted * shifted);
        let load = (c.elastic_force * c.shift).mul_add(c.shift, elastic);
        Normal {
            force: (elastic - c.pull_off).keep(touching),
            radius: root_radius * root_radius,
            tangential_measure: root_radius * root_radius,
            root_tangential_measure: root_radius,
            stiffness,
            root_stiffness: stiffness.sqrt(),
            friction_load: load.keep(touching),
            touching,
        }
    }

    /// Without adhesion, as for JKR.
    fn loaded(pair: &PairProperties, _parameters: &[f64], load: f64) -> Normal<f64> {
        hertz::under_load(pair, load)
    }

    /// Elastic energy minus the energy of the joined surfaces.
    #[inline(always)]
    fn energy<R: Real>(c: &JkrDmtConstants<R>, overlap: R) -> R {
        let h = (overlap * c.inverse_length).max(R::splat(BREAK));
        let elastic = c.elastic_force * primitive(invert(h), c.shift);
        (elastic - c.pull_off * h) / c.inverse_length
    }

    #[inline(always)]
    fn losses<R: Real>(c: &JkrDmtConstants<R>) -> AdhesionLosses<R> {
        let made = c.elastic_force * primitive(R::splat(MADE), c.shift);
        let broken =
            c.pull_off.mul_add(R::splat(-BREAK), c.elastic_force * primitive(R::splat(BROKEN), c.shift));
        AdhesionLosses { made: -(c.loss_length * made), broken: c.loss_length * broken }
    }

    fn breaking_overlap(c: &JkrDmtConstants<f64>) -> f64 {
        BREAK / c.inverse_length
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Material;
    use crate::contact::normal::{Dmt, Hertz, Jkr};

    fn pair(interface_energy: f64, radius: f64) -> PairProperties {
        let material = Material { interface_energy, ..Material::default() };
        PairProperties::new((&material, radius), (&material, radius), 0.0)
    }

    fn near(found: f64, wanted: f64, within: f64) {
        assert!((found / wanted - 1.0).abs() < within, "{found:e} {wanted:e}");
    }

    /// Overlap, contact radius and force of spheres of 0.1 mm with 70 GPa, 0.3 and 0.05 J/m2, at two pull-off forces.
    #[test]
    fn forces_are_those_of_the_closed_form() {
        let table = [
            (
                1.6,
                [6.283_185_307_18e-6, -4.828_698_333_49e-10, -4.188_790_204_79e-6],
                [1.926_444_926_011_2e-15, 9.607_542_033_572_8e-16],
                [
                    (0.0, 1.598_445_162_673_7e-7, -5.759_586_531_581_3e-6),
                    (1e-9, 2.368_591_133_052_9e-7, 3.020_082_424_257_9e-6),
                    (5e-9, 4.071_587_425_169_2e-7, 8.579_994_013_893_1e-5),
                    (2e-8, 7.450_929_494_41e-7, 7.204_712_673_252_3e-4),
                ],
            ),
            (
                1.9,
                [7.461_282_552_28e-6, -1.916_270_203_56e-10, -6.937_683_776_68e-6],
                [1.911_275_438_818_1e-16, 1.224_095_213_403e-15],
                [
                    (0.0, 1.006_957_353_777_6e-7, -7.330_382_858_376_2e-6),
                    (1e-9, 1.980_398_470_063_9e-7, 9.844_137_658_015_3e-7),
                    (5e-9, 3.804_048_742_994_7e-7, 8.356_732_687_431_4e-5),
                    (2e-8, 7.261_046_971_493_9e-7, 7.181_622_462_668_4e-4),
                ],
            ),
        ];
        for (ratio, [pull_off, end, at_end], [made, broken], rows) in table {
            let c = constants(&pair(0.05, 5e-5), ratio);
            near(c.pull_off, pull_off, 1e-11);
            near(JkrDmt::breaking_overlap(&c), end, 1e-11);
            let inside = JkrDmt::breaking_overlap(&c) * (1.0 - 1e-12);
            near(JkrDmt::evaluate(&c, inside, true).force, at_end, 1e-5);
            let losses = JkrDmt::losses(&c);
            near(losses.made, made, 1e-11);
            near(losses.broken, broken, 1e-11);
            near(JkrDmt::energy(&c, 0.0), -made, 1e-9);
            for (overlap, radius, force) in rows {
                let n = JkrDmt::evaluate(&c, overlap, true);
                near(n.radius, radius, 1e-11);
                near(n.force, force, 1e-10);
            }
        }
    }

    /// Tabor's parameter decides: the pull-off force of three sizes of grains.
    #[test]
    fn large_grains_stick_as_jkr_and_small_ones_as_dmt() {
        for (radius, ratio) in
            [(5e-5, 1.598_384_603_753_8), (5e-6, 1.708_868_417_160_7), (5e-7, 1.838_767_743_868_4)]
        {
            near(pull_off(&pair(0.05, radius), 4e-10), ratio, 1e-12);
        }
        near(pull_off(&pair(0.6, 1.0), 4e-10), 1.5, 1e-3);
        near(pull_off(&pair(1e-6, 5e-7), 4e-10), 2.0, 1e-3);
    }

    /// Maugis (1992) with a constant attraction up to a radius m a: force over `pi Gamma R*`, and overlap over
    /// `(pi^2 Gamma^2 R* / K^2)^(1/3)`, `K = 4/3 E*`, at a contact radius over `(pi Gamma R*^2 / K)^(1/3)`.
    fn maugis(lambda: f64, a: f64) -> (f64, f64) {
        let parts = |m: f64| {
            let root = (m * m - 1.0).sqrt();
            (root, root.atan())
        };
        let excess = |m: f64| {
            let (root, angle) = parts(m);
            let inside = 0.5 * lambda * a * a * (root + (m * m - 2.0) * angle);
            inside + 4.0 / 3.0 * lambda * lambda * a * (root * angle - m + 1.0) - 1.0
        };
        let (mut low, mut high) = (1.0, 2.0);
        while excess(high) < 0.0 {
            high *= 2.0;
        }
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if excess(middle) < 0.0 { low = middle } else { high = middle }
        }
        let (root, angle) = parts(low);
        let force = a * a * a - lambda * a * a * (root + low * low * angle);
        (force, a * a - 4.0 / 3.0 * a * lambda * root)
    }

    /// Pull-off forces, and the largest difference of the forces of touching grains, as the documentation states them.
    #[test]
    fn the_closed_form_is_as_far_from_maugis_as_stated() {
        let p = pair(0.05, 5e-5);
        let stiffness = 4.0 / 3.0 * p.effective_modulus;
        let adhesion = std::f64::consts::PI * p.interface_energy;
        let unit = adhesion * p.effective_radius;
        let length = (adhesion * adhesion * p.effective_radius / (stiffness * stiffness)).cbrt();
        let range = (p.effective_radius * (p.interface_energy / p.effective_modulus).powi(2)).cbrt();
        for (lambda, pull_off, [least, most]) in [
            (0.05, 1.9814, [0.69, 0.72]),
            (0.3, 1.8156, [0.47, 0.50]),
            (1.0, 1.6007, [0.16, 0.18]),
            (3.0, 1.5168, [0.03, 0.05]),
        ] {
            let c = JkrDmt::prepare(&p, &[1.157 * range / lambda]);
            let states: Vec<(f64, f64)> = (1..800).map(|k| maugis(lambda, 0.005 * f64::from(k))).collect();
            let found = -states.iter().map(|state| state.0).fold(0.0, f64::min);
            near(found, pull_off, 1e-4);
            near(c.pull_off / unit, found, 0.017);
            let touching = states.iter().filter(|(_, overlap)| *overlap >= 0.0);
            let low = touching
                .map(|(force, overlap)| force - JkrDmt::evaluate(&c, overlap * length, true).force / unit);
            let largest = low.fold(0.0, f64::max);
            assert!((least..most).contains(&largest), "{lambda}: {largest}");
        }
    }

    #[test]
    fn the_limits_are_jkr_and_dmt() {
        let p = pair(0.05, 5e-5);
        let (own, jkr) = (constants(&p, 1.5), Jkr::prepare(&p, &[]));
        for overlap in [-4e-10, 0.0, 1e-9, 3e-8] {
            let (a, b) = (JkrDmt::evaluate(&own, overlap, true), Jkr::evaluate(&jkr, overlap, true));
            assert!((a.force - b.force).abs() < 1e-9 * 6e-6, "{overlap:e}");
            near(a.radius, b.radius, 1e-10);
            near(a.stiffness, b.stiffness, 1e-8);
            near(JkrDmt::energy(&own, overlap), Jkr::energy(&jkr, overlap), 1e-8);
            if overlap > 0.0 {
                near(a.friction_load, b.friction_load, 1e-10);
            }
        }
        let (made, broken) = (JkrDmt::losses(&own), Jkr::losses(&jkr));
        near(made.made, broken.made, 1e-10);
        near(made.broken, broken.broken, 1e-10);
        let (own, dmt) = (constants(&p, 2.0), Dmt::prepare(&p, &[]));
        for overlap in [1e-12, 1e-9, 3e-8] {
            let (a, b) = (JkrDmt::evaluate(&own, overlap, true), Dmt::evaluate(&dmt, overlap, true));
            assert!((a.force - b.force).abs() < 1e-10 * 8e-6, "{overlap:e}");
            near(a.friction_load, b.friction_load, 1e-10);
            near(a.stiffness, b.stiffness, 1e-10);
        }
        let (own, hertz) =
            (JkrDmt::prepare(&pair(0.0, 5e-5), &[4e-10]), Hertz::prepare(&pair(0.0, 5e-5), &[]));
        near(JkrDmt::evaluate(&own, 1e-8, true).force, Hertz::evaluate(&hertz, 1e-8, true).force, 1e-11);
        assert_eq!(JkrDmt::losses(&own).made + JkrDmt::losses(&own).broken, 0.0);
    }

    /// The force is the slope of the energy, and the stiffness that of the force.
    #[test]
    fn force_and_stiffness_are_derivatives() {
        for ratio in [1.55, 1.7, 1.95] {
            let c = constants(&pair(0.05, 5e-5), ratio);
            for overlap in [0.0, 1e-9, 2e-8] {
                let step = 1e-13;
                let force = |overlap: f64| JkrDmt::evaluate(&c, overlap, true).force;
                let n = JkrDmt::evaluate(&c, overlap, true);
                let wide = 1e-12;
                let energy = |overlap: f64| JkrDmt::energy(&c, overlap);
                let slope = (energy(overlap + wide) - energy(overlap - wide)) / (2.0 * wide);
                near(slope, n.force, 1e-4);
                near((force(overlap + step) - force(overlap - step)) / (2.0 * step), n.stiffness, 1e-4);
            }
        }
    }
}
