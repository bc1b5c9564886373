//! Liquid bridges between wet grains that share the liquid of films on the grains.
//!
//! The bridges follow the law of [`super::capillary_bridge`], each with a volume V of its own. A grain starts with a film
//! whose volume is a parameter times that of the grain. A bridge forms where grains touch: both films give equal volumes of
//! liquid, at most what the drier grain has, up to a largest bridge volume. When the bridge ruptures, each grain receives one
//! half of its liquid. Liquid is neither lost nor created, but is transported from grain to grain. Where the films do not
//! suffice for a bridge of `1e-6 R_e^3`, the contact stays dry until they have received more liquid.
//!
//! With the contact angle theta of the material the force at touch is `F_0 = 2 pi R_e gamma cos(theta)` for any volume; the
//! volume determines how fast the force decreases with the gap and at which gap the bridge ruptures. At a liquid content W
//! (volume of liquid over that of solid) and Z bridges per grain, the mean of `V/R^3` of equal grains is at most
//! `8 pi W / 3 Z`.

use granum_simd::{Mask, Real};

use super::capillary_bridge::{
    CONTACT_ANGLE, RUPTURE_COEFFICIENT, SURFACE_TENSION, energy_at, force_at_touch, per_gap, pull,
    rupture_distance,
};
use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_ADHESION_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{AdhesionLaw, Attraction, NormalTraits};
use crate::law_constants;

/// Bridges of Willett et al. (2000) with liquid from films on the grains.
#[derive(Clone, Copy, Debug)]
pub struct CapillaryBridgeFilms;

law_constants! {
    /// Constants of bridges that share liquid films, for a pair.
    pub struct CapillaryBridgeFilmsConstants<R> {
        /// `F_0`, N.
        pub force_at_touch: R,
        /// `R_e`, m.
        pub radius: R,
        /// Contact angle theta, rad.
        pub contact_angle: R,
        /// Coefficient c of the rupture distance.
        pub rupture_coefficient: R,
        /// Largest volume of a bridge over `R_e^3`.
        pub largest_volume: R,
    }
}

/// Columns of the history. Volume, m3.
const VOLUME: usize = 0;
/// `(R_e/V)^(1/2) / 2`, 1/m.
const PER_GAP: usize = 1;
/// `S_c`, m.
const RUPTURE: usize = 2;

/// Smallest volume of a bridge over `R_e^3`: the formula was tried down to that.
const SMALLEST: f64 = 1e-6;

impl AdhesionLaw for CapillaryBridgeFilms {
    type Constants<R: Real> = CapillaryBridgeFilmsConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "capillary-bridge-films",
        label: "capillary bridges that share liquid films",
        help: "liquid bridges that take their liquid from films on the grains and return it when they rupture",
        parameters: &[
            SURFACE_TENSION,
            CONTACT_ANGLE,
            LawParameter {
                key: "liquid_content",
                unit: Unit::NUMBER,
                default: 0.01,
                bounds: [0.0, 0.3],
                meaning: "Volume of the liquid on a grain at the start over the volume of the grain",
                without_area: false,
                mixing: Mixing::Geometric,
            },
            LawParameter {
                key: "largest_bridge_volume",
                unit: Unit::NUMBER,
                default: 0.02,
                bounds: [SMALLEST, 0.1],
                meaning: "Largest volume of a bridge over the cube of R_e = 2 R_i R_j / (R_i + R_j), where the films \
                          have that much liquid",
                without_area: false,
                mixing: Mixing::Geometric,
            },
            RUPTURE_COEFFICIENT,
        ],
    };
    const BEGINS_AT_TOUCH: bool = true;
    const SHARES_LIQUID: bool = true;
    const HISTORY: usize = 3;

    fn goes_with(normal: &NormalTraits) -> Result<(), &'static str> {
        normal.without_adhesion()
    }

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> CapillaryBridgeFilmsConstants<f64> {
        let [tension, angle, largest, coefficient] =
            [parameters[0], parameters[1], parameters[3], parameters[4]];
        let radius = 2.0 * pair.effective_radius;
        CapillaryBridgeFilmsConstants {
            force_at_touch: force_at_touch(radius, tension, angle),
            radius,
            contact_angle: angle,
            rupture_coefficient: coefficient,
            largest_volume: largest,
        }
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &CapillaryBridgeFilmsConstants<R>,
        overlap: R,
        _touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Attraction<R> {
        let gap = (-overlap).max(R::zero());
        let before = history[VOLUME].gt(R::zero());
        let acting = before & gap.lt(history[RUPTURE]);
        let (force, stiffness) = pull(c.force_at_touch, history[PER_GAP], gap, acting);
        // A bridge that ruptured in an earlier step has no history but its liquid, which is to be returned.
        let ruptured = before & !acting & history[RUPTURE].gt(R::zero());
        let mut loss = R::zero();
        if ruptured.any() {
            loss = energy_at(c.force_at_touch, history[PER_GAP], history[RUPTURE]).keep(ruptured);
        }
        Attraction { force, stiffness, acting, loss }
    }

    fn film(radius: f64, parameters: &[f64]) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * parameters[2] * radius * radius * radius
    }

    fn largest_bridge(c: &CapillaryBridgeFilmsConstants<f64>) -> f64 {
        c.largest_volume * c.radius * c.radius * c.radius
    }

    fn bridge(c: &CapillaryBridgeFilmsConstants<f64>, volume: f64) -> [f64; MAX_ADHESION_HISTORY] {
        let relative = volume / (c.radius * c.radius * c.radius);
        let mut history = [0.0; MAX_ADHESION_HISTORY];
        if relative >= SMALLEST {
            history[VOLUME] = volume;
            history[PER_GAP] = per_gap(c.radius, relative);
            history[RUPTURE] = rupture_distance(c.radius, c.contact_angle, c.rupture_coefficient, relative);
        }
        history
    }

    fn energy(
        c: &CapillaryBridgeFilmsConstants<f64>,
        overlap: f64,
        history: &[f64; MAX_ADHESION_HISTORY],
    ) -> f64 {
        if history[VOLUME] == 0.0 {
            return 0.0;
        }
        if overlap >= 0.0 {
            -c.force_at_touch * overlap
        } else {
            energy_at(c.force_at_touch, history[PER_GAP], -overlap)
        }
    }

    fn range(c: &CapillaryBridgeFilmsConstants<f64>) -> f64 {
        rupture_distance(c.radius, c.contact_angle, c.rupture_coefficient, c.largest_volume)
    }
}

#[cfg(test)]
mod tests {
    use super::super::CapillaryBridge;
    use super::*;
    use crate::config::Material;
    use crate::contact::law::limits::LAW_CHANNELS;

    const R: f64 = 50e-6;

    fn pair() -> PairProperties {
        PairProperties::new((&Material::default(), R), (&Material::default(), R), 0.0)
    }

    /// A bridge has the force, rupture, energies and losses of the law of constant volume with the same volume, at every gap.
    #[test]
    fn a_bridge_is_one_of_constant_volume() {
        for (relative, angle, coefficient) in [(1e-3, 0.0, 0.1), (1e-2, 0.349, 0.1), (0.05, 0.7, 0.0)] {
            let constant = CapillaryBridge::prepare(&pair(), &[0.072, angle, relative, coefficient]);
            let c = CapillaryBridgeFilms::prepare(&pair(), &[0.072, angle, 0.01, 0.1, coefficient]);
            let mut history = CapillaryBridgeFilms::bridge(&c, relative * R * R * R);
            let range = CapillaryBridge::range(&constant);
            assert!((history[RUPTURE] / range - 1.0).abs() < 1e-14);
            assert!(CapillaryBridgeFilms::range(&c) > range);
            for gap in [-1e-7, 0.0, 1e-8, 1e-6, 0.999 * range] {
                let one = CapillaryBridge::update(
                    &constant,
                    -gap,
                    false,
                    &mut [1.0, 0.0, 0.0, 0.0],
                    &mut [0.0; LAW_CHANNELS],
                );
                let out =
                    CapillaryBridgeFilms::update(&c, -gap, false, &mut { history }, &mut [0.0; LAW_CHANNELS]);
                assert!(out.acting && (out.force / one.force - 1.0).abs() < 1e-13, "{gap:e}");
                assert!((out.stiffness - one.stiffness).abs() <= 1e-13 * one.stiffness);
                let energies = [
                    CapillaryBridge::energy(&constant, -gap, &[1.0, 0.0, 0.0, 0.0]),
                    CapillaryBridgeFilms::energy(&c, -gap, &history),
                ];
                assert!((energies[1] - energies[0]).abs() <= 1e-12 * energies[0].abs(), "{energies:?}");
            }
            let one = CapillaryBridge::update(
                &constant,
                -1.001 * range,
                false,
                &mut [1.0, 0.0, 0.0, 0.0],
                &mut [0.0; LAW_CHANNELS],
            );
            let out = CapillaryBridgeFilms::update(
                &c,
                -1.001 * range,
                false,
                &mut history,
                &mut [0.0; LAW_CHANNELS],
            );
            assert!(!out.acting && (out.loss / one.loss - 1.0).abs() < 1e-12);
            // What it held can still be returned.
            assert_eq!(history[VOLUME], relative * R * R * R);
        }
    }

    #[test]
    fn without_liquid_there_is_no_bridge() {
        let c = CapillaryBridgeFilms::prepare(&pair(), &[0.072, 0.0, 0.01, 0.02, 0.1]);
        assert_eq!(CapillaryBridgeFilms::bridge(&c, 0.9e-6 * R * R * R), [0.0; MAX_ADHESION_HISTORY]);
        let none = CapillaryBridgeFilms::update(
            &c,
            1e-8,
            true,
            &mut [0.0; MAX_ADHESION_HISTORY],
            &mut [0.0; LAW_CHANNELS],
        );
        assert!(!none.acting && none.force == 0.0 && none.loss == 0.0);
        // A hundredth of the volume of the grain.
        let film = CapillaryBridgeFilms::film(R, &[0.072, 0.0, 0.01, 0.02, 0.1]);
        assert!((film / (0.01 * 4.0 / 3.0 * std::f64::consts::PI * R * R * R) - 1.0).abs() < 1e-15);
    }
}
