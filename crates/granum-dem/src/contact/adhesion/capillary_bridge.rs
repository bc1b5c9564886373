//! Liquid bridges of constant volume between wet grains: the closed form of Willett, Adams, Johnson and Seville (2000),
//! Langmuir 16, 9396-9405.
//!
//! With the radius `R_e = 2 R_i R_j / (R_i + R_j)` (Derjaguin), the surface tension gamma, the contact angle theta, the volume V
//! of the bridge, the gap `S = max(0, -alpha)` between the surfaces and `S+ = (S/2) (R_e/V)^(1/2)`, the attractive force of the
//! bridge is
//!
//! `F = 2 pi R_e gamma cos(theta) / (1 + 2.1 S+ + 10 S+^2)`.
//!
//! A bridge forms where the grains touch, and ruptures at the gap `S_c = R_e (1 + theta/2) (v^(1/3) + c v^(2/3))`, `v = V/R_e^3`,
//! with `c` = 0.1 according to Willett et al.; `c` = 0 is the rupture distance of Lian, Thornton and Adams (1993), J. Colloid
//! Interface Sci. 161, 138-147. The volume divided by `R_e^3` is a parameter: liquid is neither exchanged between bridges nor
//! lost. ([`super::CapillaryBridgeFilms`] has bridges whose liquid comes from films on the grains.)
//!
//! Between formation and rupture the bridge is elastic. Its energy, which is zero when the surfaces just touch, is
//! `2 F_0 (V/R_e)^(1/2) (2/D) (arctan((20 S+ + 2.1)/D) - arctan(2.1/D))` with `F_0 = F(0)` and `D = 35.59^(1/2)`, and
//! `-F_0 alpha` where the grains overlap. The energy at `S_c` is lost when the bridge ruptures. Friction is limited by the load
//! of the contact without the bridge.
//!
//! Against the solution of the Young-Laplace equation the closed form is 4 to 35 % too strong at touch (v from 1e-4 to 0.05, theta
//! from 0 to 40 degrees), and too weak far apart; other programs use it as well.

use granum_simd::Real;

use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::elementary::{arctan, arctan_of, cosine};
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_ADHESION_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{AdhesionLaw, Attraction, NormalTraits};
use crate::law_constants;

/// Bridges of Willett et al. (2000).
#[derive(Clone, Copy, Debug)]
pub struct CapillaryBridge;

law_constants! {
    /// Constants of bridges of constant volume for a pair.
    pub struct CapillaryBridgeConstants<R> {
        /// `F_0`, N.
        pub force_at_touch: R,
        /// `(R_e/V)^(1/2) / 2`, 1/m: multiplied by the gap it gives S+.
        pub per_gap: R,
        /// `S_c`, m.
        pub rupture_distance: R,
        /// Energy of the bridge at `S_c`, J.
        pub energy_at_rupture: R,
    }
}

/// Column of the history: one where there is a bridge.
const BRIDGED: usize = 0;

const LINEAR: f64 = 2.1;
const SQUARE: f64 = 10.0;

/// Surface tension of the liquid.
pub(super) const SURFACE_TENSION: LawParameter = LawParameter {
    key: "surface_tension",
    unit: Unit::STIFFNESS,
    default: 0.072,
    bounds: [0.0, 10.0],
    meaning: "Surface tension gamma of the liquid of the bridges",
    without_area: false,
    mixing: Mixing::Geometric,
};
/// Contact angle of the liquid.
pub(super) const CONTACT_ANGLE: LawParameter = LawParameter {
    key: "contact_angle",
    unit: Unit::ANGLE,
    default: 0.0,
    bounds: [0.0, 1.5],
    meaning: "Contact angle theta of the liquid on the grains",
    without_area: false,
    mixing: Mixing::Cosine,
};
/// The coefficient c of the rupture distance.
pub(super) const RUPTURE_COEFFICIENT: LawParameter = LawParameter {
    key: "rupture_coefficient",
    unit: Unit::NUMBER,
    default: 0.1,
    bounds: [0.0, 1.0],
    meaning: "Coefficient c of the rupture distance R_e (1 + theta/2) (v^(1/3) + c v^(2/3)), v = V/R_e^3: 0.1 of \
              Willett et al. 2000, 0 of Lian et al. 1993",
    without_area: false,
    mixing: Mixing::Arithmetic,
};

/// Force of a bridge between grains that touch, N; `radius` is `R_e`, m.
pub(super) fn force_at_touch(radius: f64, tension: f64, angle: f64) -> f64 {
    2.0 * std::f64::consts::PI * radius * tension * cosine(angle)
}

/// `(R_e/V)^(1/2) / 2`, 1/m, for `v = V/R_e^3`: multiplied by the gap it gives S+.
pub(super) fn per_gap(radius: f64, v: f64) -> f64 {
    0.5 / (radius * v.sqrt())
}

/// `S_c`, m, for `v = V/R_e^3`.
pub(super) fn rupture_distance(radius: f64, angle: f64, coefficient: f64, v: f64) -> f64 {
    let root = granum_simd::cbrt(v);
    radius * (1.0 + 0.5 * angle) * (root + coefficient * root * root)
}

/// Energy of a bridge, J, that has a force at touch, N, at a gap, m; zero at touch.
#[inline(always)]
pub(super) fn energy_at<R: Real>(force: R, per_gap: R, gap: R) -> R {
    let root = (4.0 * SQUARE - LINEAR * LINEAR).sqrt();
    let (linear, twice) = (R::splat(LINEAR), R::splat(2.0 * SQUARE));
    let angle = arctan_of((twice * (per_gap * gap) + linear) / R::splat(root));
    force / per_gap * R::splat(2.0 / root) * (angle - R::splat(arctan(LINEAR / root)))
}

/// Force of a bridge, N, and the absolute value of its derivative, N/m, at a gap, m, of zero or more. Where the grains overlap
/// the force is constant, and the value at touch is used for the time step.
#[inline(always)]
pub(super) fn pull<R: Real>(force: R, per_gap: R, gap: R, acting: R::Mask) -> (R, R) {
    let plus = per_gap * gap;
    let one = R::splat(1.0);
    let share = one / plus.mul_add(plus.mul_add(R::splat(SQUARE), R::splat(LINEAR)), one);
    let force = (force * share).keep(acting);
    let slope = plus.mul_add(R::splat(2.0 * SQUARE), R::splat(LINEAR)) * per_gap;
    (force, force * share * slope)
}

impl AdhesionLaw for CapillaryBridge {
    type Constants<R: Real> = CapillaryBridgeConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "capillary-bridge",
        label: "capillary bridges (Willett et al. 2000)",
        help: "liquid bridges of constant volume that form when grains touch: Willett et al. 2000",
        parameters: &[
            SURFACE_TENSION,
            CONTACT_ANGLE,
            LawParameter {
                key: "bridge_volume",
                unit: Unit::NUMBER,
                default: 0.01,
                bounds: [1e-6, 0.1],
                meaning: "Volume of a bridge over the cube of R_e = 2 R_i R_j / (R_i + R_j)",
                without_area: false,
                mixing: Mixing::Geometric,
            },
            RUPTURE_COEFFICIENT,
        ],
    };
    const BEGINS_AT_TOUCH: bool = true;
    const HISTORY: usize = 1;

    fn goes_with(normal: &NormalTraits) -> Result<(), &'static str> {
        normal.without_adhesion()
    }

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> CapillaryBridgeConstants<f64> {
        let [tension, angle, volume, coefficient] =
            [parameters[0], parameters[1], parameters[2], parameters[3]];
        let radius = 2.0 * pair.effective_radius;
        let force_at_touch = force_at_touch(radius, tension, angle);
        let per_gap = per_gap(radius, volume);
        let rupture_distance = rupture_distance(radius, angle, coefficient, volume);
        let energy_at_rupture = energy_at(force_at_touch, per_gap, rupture_distance);
        CapillaryBridgeConstants { force_at_touch, per_gap, rupture_distance, energy_at_rupture }
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &CapillaryBridgeConstants<R>,
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Attraction<R> {
        let zero = R::zero();
        let gap = (-overlap).max(zero);
        let before = history[BRIDGED].gt(zero);
        let acting = (before | touching) & gap.lt(c.rupture_distance);
        let (force, stiffness) = pull(c.force_at_touch, c.per_gap, gap, acting);
        history[BRIDGED] = R::splat(1.0).keep(acting);
        Attraction { force, stiffness, acting, loss: c.energy_at_rupture.keep(before & !acting) }
    }

    fn energy(c: &CapillaryBridgeConstants<f64>, overlap: f64, history: &[f64; MAX_ADHESION_HISTORY]) -> f64 {
        if history[BRIDGED] == 0.0 {
            return 0.0;
        }
        if overlap >= 0.0 {
            -c.force_at_touch * overlap
        } else {
            energy_at(c.force_at_touch, c.per_gap, -overlap)
        }
    }

    fn range(c: &CapillaryBridgeConstants<f64>) -> f64 {
        c.rupture_distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Material;
    use crate::contact::law::limits::LAW_CHANNELS;

    const RADIUS: f64 = 50e-6;
    const TENSION: f64 = 0.072;

    fn constants(volume: f64, degrees: f64) -> CapillaryBridgeConstants<f64> {
        with_coefficient(volume, degrees, 0.1)
    }

    fn with_coefficient(volume: f64, degrees: f64, coefficient: f64) -> CapillaryBridgeConstants<f64> {
        let sphere = (&Material::default(), RADIUS);
        let pair = PairProperties::new(sphere, sphere, 0.0);
        let relative = volume / RADIUS.powi(3);
        CapillaryBridge::prepare(&pair, &[TENSION, degrees.to_radians(), relative, coefficient])
    }

    fn force(c: &CapillaryBridgeConstants<f64>, gap: f64) -> f64 {
        let mut history = [1.0, 0.0, 0.0, 0.0];
        CapillaryBridge::update(c, -gap, gap <= 0.0, &mut history, &mut [0.0; LAW_CHANNELS]).force
    }

    /// Spheres of 0.1 mm with bridges of water: gap, force.
    #[test]
    fn forces_are_those_of_the_closed_form() {
        let c = constants(1.25e-16, 0.0);
        let table = [
            (0.0, 2.2619467106e-5),
            (1e-7, 2.1013844806e-5),
            (1e-6, 8.4905413751e-6),
            (2.5e-6, 2.5386049516e-6),
            (5e-6, 7.7145856230e-7),
        ];
        for (gap, wanted) in table {
            assert!((force(&c, gap) / wanted - 1.0).abs() < 1e-10, "{gap:e}: {:e}", force(&c, gap));
        }
        let c = constants(1.25e-15, 20.0);
        assert!((force(&c, 1e-6) / 1.6225455210e-5 - 1.0).abs() < 1e-10);
        // Overlapping grains are pulled as strongly as grains that just touch.
        assert_eq!(force(&c, -1e-7), force(&c, 0.0));
    }

    /// A bridge between spheres of radius 1 as the Young-Laplace equation has it, with filling angle beta, contact angle and mean
    /// curvature H: half its length, its volume and `F / (2 pi gamma)`. The force, `C = r / (1 + r'^2)^(1/2) + H r^2`, is the same in
    /// each section, which gives the slope `r'` of the surface by the radius r.
    fn meniscus(beta: f64, angle: f64, curvature: f64) -> Option<[f64; 3]> {
        const PARTS: i32 = 400;
        let edge = beta.sin();
        let force = edge * (beta + angle).sin() + curvature * edge * edge;
        let root = (1.0 + 4.0 * curvature * force).sqrt();
        let neck = 2.0 * force / (1.0 + root);
        let width = (edge - neck).sqrt();
        let (mut half, mut volume) = (0.0, 0.0);
        for k in 0..PARTS {
            // With r = neck + t^2 the integrand has no pole at the neck.
            let t = (f64::from(k) + 0.5) / f64::from(PARTS) * width;
            let r = neck + t * t;
            let slope = ((r / (force - curvature * r * r)).powi(2) - 1.0).sqrt();
            let part = 2.0 * t / slope * width / f64::from(PARTS);
            half += part;
            volume += std::f64::consts::PI * r * r * part;
        }
        let cap = std::f64::consts::PI / 3.0 * (1.0 - beta.cos()).powi(2) * (2.0 + beta.cos());
        (half.is_finite() && volume.is_finite()).then_some([half, 2.0 * (volume - cap), force])
    }

    /// The force over `2 pi gamma R` of a bridge of this filling angle, and its volume, between spheres that touch. The curvature is
    /// that with which the bridge is as long as the gap between the rings where it ends.
    fn bridge_at_touch(beta: f64, angle: f64) -> (f64, f64) {
        let excess = |curvature: f64| {
            let found = meniscus(beta, angle, curvature).map(|found| found[0] - (1.0 - beta.cos()));
            // Where the curvature is too large there is no surface at all.
            found.unwrap_or(f64::NEG_INFINITY)
        };
        // Without curvature the bridge is too long, and from there it becomes shorter.
        let (mut low, mut high) = (0.0, 1e5);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if excess(middle) > 0.0 { low = middle } else { high = middle }
        }
        let [_, volume, force] = meniscus(beta, angle, low).unwrap();
        (force, volume)
    }

    #[test]
    fn at_touch_the_closed_form_is_as_far_from_young_and_laplace_as_stated() {
        for (v, degrees, excess) in [
            (1e-4, 0.0, 0.0369),
            (1e-3, 0.0, 0.0682),
            (1e-2, 20.0, 0.1476),
            (5e-2, 0.0, 0.2142),
            (5e-2, 40.0, 0.3479),
        ] {
            let angle = f64::to_radians(degrees);
            let (mut low, mut high) = (0.02, 0.6);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if bridge_at_touch(middle, angle).1 < v { low = middle } else { high = middle }
            }
            let (exact, volume) = bridge_at_touch(low, angle);
            assert!((volume / v - 1.0).abs() < 1e-6, "{volume:e}");
            let c = constants(v * RADIUS.powi(3), degrees);
            let found = force(&c, 0.0) / (2.0 * std::f64::consts::PI * RADIUS * TENSION) / exact - 1.0;
            assert!((found - excess).abs() < 1e-3, "v = {v}, {degrees} degrees: {found}");
        }
    }

    /// The energy at rupture, and the gap of it: `S_c` = 0.101 R and 0.258497 R.
    #[test]
    fn rupture_is_where_the_paper_has_it() {
        for (volume, degrees, gap, lost) in
            [(1.25e-16, 0.0, 5.05e-6, 2.5390747506e-11), (1.25e-15, 20.0, 1.2924857339e-5, 7.2828768396e-11)]
        {
            let c = constants(volume, degrees);
            assert!(
                (CapillaryBridge::range(&c) / gap - 1.0).abs() < 1e-9,
                "{:e}",
                CapillaryBridge::range(&c)
            );
            assert!((c.energy_at_rupture / lost - 1.0).abs() < 1e-9, "{:e}", c.energy_at_rupture);
            assert_eq!(force(&c, 1.001 * gap), 0.0);
            assert!(force(&c, 0.999 * gap) > 0.0);
        }
    }

    /// Lian, Thornton and Adams (1993): `(1 + theta/2) V^(1/3)`, over R: 0.1, 0.253045 and 0.497 for three bridges.
    #[test]
    fn rupture_without_the_second_term_is_that_of_lian() {
        for (relative, degrees, gap) in [(1e-3, 0.0, 0.1), (1e-2, 20.0, 0.253_045), (5e-2, 40.0, 0.497)] {
            let c = with_coefficient(relative * RADIUS.powi(3), degrees, 0.0);
            let exact = (1.0 + 0.5 * f64::to_radians(degrees)) * relative.cbrt();
            assert!((CapillaryBridge::range(&c) / RADIUS - exact).abs() < 1e-14);
            assert!((exact - gap).abs() < 1e-6, "{exact}");
            assert_eq!(force(&c, 1.001 * gap * RADIUS), 0.0);
            assert!(force(&c, 0.999 * gap * RADIUS) > 0.0);
        }
    }

    /// The force is the slope of the energy, and the stiffness that of the force.
    #[test]
    fn force_and_stiffness_are_derivatives() {
        let c = constants(1.25e-15, 20.0);
        let history = [1.0, 0.0, 0.0, 0.0];
        for gap in [-1e-7, 1e-8, 5e-7, 2e-6, 1e-5] {
            let step = 1e-11;
            let energy = |gap: f64| CapillaryBridge::energy(&c, -gap, &history);
            let slope = (energy(gap + step) - energy(gap - step)) / (2.0 * step);
            assert!((slope / force(&c, gap) - 1.0).abs() < 1e-4, "{gap:e}: {slope:e}");
            let falls = (force(&c, gap - step) - force(&c, gap + step)) / (2.0 * step);
            let out = CapillaryBridge::update(&c, -gap, false, &mut { history }, &mut [0.0; LAW_CHANNELS]);
            let expected = if gap < 0.0 { 0.0 } else { out.stiffness };
            assert!((falls - expected).abs() <= 1e-3 * expected, "{gap:e}: {falls:e} {expected:e}");
        }
    }

    /// Grains that approach without touching have no bridge, and after a rupture a bridge forms again only at touch.
    #[test]
    fn bridges_form_at_touch_and_remember() {
        let c = constants(1.25e-15, 0.0);
        let mut history = [0.0; MAX_ADHESION_HISTORY];
        let mut at = |overlap: f64| {
            CapillaryBridge::update(&c, overlap, overlap > 0.0, &mut history, &mut [0.0; LAW_CHANNELS])
        };
        assert!(!at(-1e-6).acting && at(-1e-6).force == 0.0);
        assert!(at(1e-8).acting);
        assert!(at(-5e-6).force > 0.0);
        let ruptured = at(-2e-5);
        assert!(!ruptured.acting && ruptured.loss == c.energy_at_rupture);
        assert!(at(-5e-6).force == 0.0 && at(-5e-6).loss == 0.0);
    }
}
