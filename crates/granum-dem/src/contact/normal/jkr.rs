//! Normal contact of adhesive elastic spheres (Johnson, Kendall and Roberts 1971).
//!
//! In units of the pull-off force `N_c = 3/2 pi Gamma R*`, of the contact radius at zero load
//! `a_0 = (9 pi Gamma R*^2 / 2 E*)^(1/3)` and of `d_0 = a_0^2 / R*` everything follows from `x = sqrt(a / a_0)`:
//! with `s = x^3`
//!
//! - overlap `alpha / d_0 = x^4 - 2/3 x`,
//! - force `N / N_c = 4 s (s - 1)`,
//! - stiffness `dN/dalpha = 2 E* a (6 s - 3) / (6 s - 1)`.
//!
//! A contact is made at zero overlap, where the force jumps to `-8/9 N_c`, and breaks under displacement
//! control at `-alpha_f = -0.27516 d_0`, where `N = -5/9 N_c` (Thornton and Yin 1991).

use granum_simd::{Mask, Real};

use super::hertz;
use crate::contact::law::description::LawDescription;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{AdhesionLosses, Normal, NormalLaw};
use crate::law_constants;

/// Johnson, Kendall and Roberts (1971).
#[derive(Clone, Copy, Debug)]
pub struct Jkr;

law_constants! {
    /// Constants of the contact of Johnson, Kendall and Roberts for a pair.
    pub struct JkrConstants<R> {
        /// `1 / d_0`, 1/m.
        pub inverse_length: R,
        /// `a_0^(1/2)`, m^(1/2).
        pub root_radius: R,
        /// `4 N_c`, N.
        pub four_pull_offs: R,
        /// `(2 E* a_0)^(1/2)`: the square root of a stiffness.
        pub root_stiffness: R,
        /// Energy lost when the contact forms, J.
        pub making_loss: R,
        /// Energy lost when it breaks, J.
        pub breaking_loss: R,
    }
}

/// Overlap at rupture over d_0: `-6^(-1/3) / 2`.
pub(super) const BREAK: f64 = -0.275_160_604_074_552_22;
/// Energies lost by the formation and by the breaking of a contact, over `N_c d_0`: `2/5 (2/3)^(4/3)` and `4/15 6^(-4/3)`.
const MAKE: f64 = 0.232_954_790_596_346_38;
const SPLIT: f64 = 0.024_458_720_362_182_42;
/// Smallest d_0 / R* used: far below any real value, so that without adhesion the law is that of Hertz.
pub(super) const LEAST_LENGTH: f64 = 1e-30;
/// Lower bound of the stiffness for the dashpot, as a fraction of `2 E* a`.
pub(super) const LEAST_STIFFNESS: f64 = 0.1;

/// Largest overlap over d_0 (about 2000 N_c) for which the rational function is used.
const RATIONAL_END: f64 = 64.0;
/// Numerator and denominator of `x(t)`, `t = sqrt(h - BREAK)`, lowest power first: a weighted minimax fit on `0 <= t <= 8`,
/// exact at t = 0, all terms positive. Its error in `N / max(N_c, |N|)` and in `x / x` is below 2.7e-14.
const NUMERATOR: [f64; 10] = [
    0.550_321_208_149_104_4,
    3.292_020_144_824_188,
    7.786_266_736_167_019,
    9.327_960_368_558_183,
    6.016_006_534_164_266,
    2.071_357_405_024_300_7,
    0.360_960_021_861_344_6,
    0.028_704_746_505_087_463,
    0.000_857_460_878_459_342_3,
    6.109_080_065_594_707e-6,
];
const DENOMINATOR: [f64; 10] = [
    1.0,
    4.633_991_442_585_774,
    8.507_643_506_540_542,
    7.812_223_829_428_341_5,
    3.774_926_853_000_524_6,
    0.941_897_207_505_706,
    0.113_173_245_029_888_22,
    0.005_709_923_724_856_943,
    0.000_091_174_507_397_229_55,
    1.936_640_979_881_158e-7,
];
/// Series of g in `g^4 = 1 + e g`, highest power of e first. It gives `x = h^(1/4) g(2/3 h^(-3/4))` to the last bits where
/// the rational function is not used.
const SERIES: [f64; 7] =
    [0.000_595_092_773_437_5, -0.001_953_125, 0.003_417_968_75, 0.0, -0.031_25, 0.25, 1.0];

/// A polynomial of degree nine, evaluated in the order with the shortest chain of dependent operations.
#[inline(always)]
fn polynomial<R: Real>(c: &[f64; 10], t: R, t2: R, t4: R, t8: R) -> R {
    let low = t2.mul_add(line(c, 2, t), line(c, 0, t));
    let high = t2.mul_add(line(c, 6, t), line(c, 4, t));
    t8.mul_add(line(c, 8, t), t4.mul_add(high, low))
}

#[inline(always)]
fn line<R: Real>(c: &[f64; 10], k: usize, t: R) -> R {
    t.mul_add(R::splat(c[k + 1]), R::splat(c[k]))
}

/// `x = sqrt(a / a_0)` on the stable branch, for an overlap h over d_0 of at least [`BREAK`].
///
/// The error of N over `max(N_c, |N|)` is below 4e-14 up to `h = 64` and a few bits beyond, except that x is ill-conditioned
/// close to the break: the rounding error of h there is amplified by `1 / (h - BREAK)^(1/2)`.
#[inline(always)]
pub(super) fn invert<R: Real>(h: R) -> R {
    let t2 = h - R::splat(BREAK);
    let t = t2.sqrt();
    let t4 = t2 * t2;
    let t8 = t4 * t4;
    let mut p = polynomial(&NUMERATOR, t, t2, t4, t8);
    let mut q = polynomial(&DENOMINATOR, t, t2, t4, t8);
    let far = h.gt(R::splat(RATIONAL_END));
    if far.any() {
        let root = h.abs().sqrt();
        let fourth = root.sqrt();
        let e = R::splat(2.0 / 3.0) / (root * fourth);
        let mut series = R::splat(SERIES[0]);
        for c in &SERIES[1..] {
            series = series.mul_add(e, R::splat(*c));
        }
        p = R::select(far, fourth * series, p);
        q = R::select(far, R::splat(1.0), q);
    }
    p / q
}

impl NormalLaw for Jkr {
    type Constants<R: Real> = JkrConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "jkr",
        label: "JKR",
        help: "adhesive: Johnson, Kendall and Roberts 1971",
        parameters: &[],
    };
    const ADHESIVE: bool = true;

    fn prepare(pair: &PairProperties, _parameters: &[f64]) -> JkrConstants<f64> {
        let (radius, modulus) = (pair.effective_radius, pair.effective_modulus);
        let wanted = 4.5 * std::f64::consts::PI * pair.interface_energy * radius * radius / modulus;
        let contact = granum_simd::cbrt(wanted).max(radius * LEAST_LENGTH.sqrt());
        let length = contact * contact / radius;
        // N_c = 3/2 pi Gamma R* = E* a_0^3 / (3 R*).
        let force = modulus * contact * length / 3.0;
        let [making_loss, breaking_loss] = match pair.interface_energy > 0.0 {
            true => [MAKE * force * length, SPLIT * force * length],
            false => [0.0; 2],
        };
        JkrConstants {
            inverse_length: 1.0 / length,
            root_radius: contact.sqrt(),
            four_pull_offs: 4.0 * force,
            root_stiffness: (2.0 * modulus * contact).sqrt(),
            making_loss,
            breaking_loss,
        }
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &JkrConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
        let one = R::splat(1.0);
        let h = overlap * c.inverse_length;
        let touching = overlap.gt(R::zero()) | (touched & h.ge(R::splat(BREAK)));
        let x = invert(h.max(R::splat(BREAK)));
        let s = x * x * x;
        // (6 s - 3) / (6 s - 1), which tends to minus infinity at the break.
        let slope = s.mul_add(R::splat(6.0), -one).max(R::splat(1e-12));
        let ratio = (one - R::splat(2.0) / slope).max(R::splat(LEAST_STIFFNESS));
        let root_stiffness = (c.root_stiffness * x * ratio.sqrt()).keep(touching);
        let root_radius = (c.root_radius * x).keep(touching);
        let scaled = s.mul_add(s, -s);
        Normal {
            force: (c.four_pull_offs * scaled).keep(touching),
            radius: root_radius * root_radius,
            tangential_measure: root_radius * root_radius,
            root_tangential_measure: root_radius,
            stiffness: root_stiffness * root_stiffness,
            root_stiffness,
            friction_load: (c.four_pull_offs * friction_load(s, scaled, touching)).keep(touching),
            touching,
        }
    }

    /// Without adhesion: contacts are created before anything is known about their loads.
    fn loaded(pair: &PairProperties, _parameters: &[f64], load: f64) -> Normal<f64> {
        hertz::under_load(pair, load)
    }

    /// `N_c d_0 (8/5 x^10 - 8/3 x^7 + 2/3 x^4)`: elastic energy minus the energy of the joined surfaces.
    #[inline(always)]
    fn energy<R: Real>(c: &JkrConstants<R>, overlap: R) -> R {
        let x = invert((overlap * c.inverse_length).max(R::splat(BREAK)));
        let s = x * x * x;
        let low = s * (R::splat(1.6) * s - R::splat(8.0 / 3.0)) + R::splat(2.0 / 3.0);
        let unit = R::splat(0.25) * c.four_pull_offs / c.inverse_length;
        unit * (s * x * low)
    }

    #[inline(always)]
    fn losses<R: Real>(c: &JkrConstants<R>) -> AdhesionLosses<R> {
        AdhesionLosses { made: c.making_loss, broken: c.breaking_loss }
    }

    fn breaking_overlap(c: &JkrConstants<f64>) -> f64 {
        BREAK / c.inverse_length
    }
}

/// `T_s / (4 mu N_c)` of Thornton (1991), given s and `N / 4 N_c`.
///
/// `T_s / mu` is `N + 2 N_c` for `N >= -0.3 N_c`. Below that it is the Hertz load of the zone in compression,
/// `N_1 (1 - (N_1 - N) / 3 N_1)^(3/2)`: with `N_1 = 4 s^2 N_c` this is `4 N_c (s - 1/3) sqrt(s (s - 1/3))`, and zero below
/// `s = 1/3`.
#[inline(always)]
fn friction_load<R: Real>(s: R, scaled: R, touching: R::Mask) -> R {
    let load = scaled + R::splat(0.5);
    let tensile = scaled.lt(R::splat(-0.075)) & touching;
    if !tensile.any() {
        return load;
    }
    let core = (s - R::splat(1.0 / 3.0)).max(R::zero());
    R::select(tensile, core * (s * core).sqrt(), load)
}
