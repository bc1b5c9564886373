//! No additional adhesion: grains interact by their contact alone.

use granum_simd::Real;

use crate::contact::description::Description;
use crate::contact::law::{AdhesionLaw, Attraction};
use crate::contact::limits::{LAW_CONSTANTS, MAX_ADHESION_HISTORY};
use crate::contact::pair_properties::PairProperties;

/// No adhesion in addition to that of the normal law.
#[derive(Clone, Copy, Debug)]
pub struct NoAdhesion;

impl AdhesionLaw for NoAdhesion {
    const DESCRIPTION: Description = Description {
        name: "none",
        label: "no additional attraction",
        help: "no force in addition to the contact law",
        parameters: &[],
    };
    const ACTS: bool = false;
    const HISTORY: usize = 0;

    fn prepare(_pair: &PairProperties, _parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        [0.0; LAW_CONSTANTS]
    }

    #[inline(always)]
    fn update<R: Real>(
        _c: &[R; LAW_CONSTANTS],
        _overlap: R,
        _touching: R::Mask,
        _history: &mut [R; MAX_ADHESION_HISTORY],
    ) -> Attraction<R> {
        Attraction::none()
    }

    fn energy(_c: &[f64; LAW_CONSTANTS], _overlap: f64, _history: &[f64; MAX_ADHESION_HISTORY]) -> f64 {
        0.0
    }

    fn range(_c: &[f64; LAW_CONSTANTS]) -> f64 {
        0.0
    }
}
