//! No additional adhesion: grains interact by their contact alone.

use granum_simd::Real;

use crate::contact::law::constants::NoConstants;
use crate::contact::law::description::LawDescription;
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_ADHESION_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{AdhesionLaw, Attraction};

/// No adhesion in addition to that of the normal law.
#[derive(Clone, Copy, Debug)]
pub struct NoAdhesion;

impl AdhesionLaw for NoAdhesion {
    type Constants<R: Real> = NoConstants;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "none",
        label: "no additional attraction",
        help: "no force in addition to the contact law",
        parameters: &[],
    };
    const ACTS: bool = false;
    const HISTORY: usize = 0;

    fn prepare(_pair: &PairProperties, _parameters: &[f64]) -> NoConstants {
        NoConstants
    }

    #[inline(always)]
    fn update<R: Real>(
        _c: &NoConstants,
        _overlap: R,
        _touching: R::Mask,
        _history: &mut [R; MAX_ADHESION_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Attraction<R> {
        Attraction::none()
    }

    fn energy(_c: &NoConstants, _overlap: f64, _history: &[f64; MAX_ADHESION_HISTORY]) -> f64 {
        0.0
    }

    fn range(_c: &NoConstants) -> f64 {
        0.0
    }
}
