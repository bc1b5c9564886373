//! No moments: grains roll and twist on each other freely.

use granum_simd::Real;

use crate::contact::law::constants::NoConstants;
use crate::contact::law::description::LawDescription;
use crate::contact::law::energy_channel::LawEnergies;
use crate::contact::law::limits::MAX_MOMENT_HISTORY;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Moment, MomentLaw, Normal, RelativeSpin};

/// Free rolling.
#[derive(Clone, Copy, Debug)]
pub struct NoMoments;

impl MomentLaw for NoMoments {
    type Constants<R: Real> = NoConstants;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "none",
        label: "free rolling",
        help: "contacts resist neither rolling nor twisting",
        parameters: &[],
    };
    const ACTS: bool = false;
    const HISTORY: usize = 0;
    const PLANE_VECTORS: usize = 0;

    fn prepare(_pair: &PairProperties, _parameters: &[f64]) -> NoConstants {
        NoConstants
    }

    #[inline(always)]
    fn update<R: Real>(
        _c: &NoConstants,
        _normal: &Normal<R>,
        _spin: RelativeSpin<R>,
        _dt: R,
        _history: &mut [R; MAX_MOMENT_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Moment<R> {
        Moment::none()
    }

    fn energy(_c: &NoConstants, _history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        0.0
    }
}
