//! No moments: grains roll and twist on each other freely.

use granum_simd::Real;

use crate::contact::description::Description;
use crate::contact::law::{Moment, MomentLaw, Normal, RelativeSpin};
use crate::contact::limits::{LAW_CONSTANTS, MAX_MOMENT_HISTORY};
use crate::contact::pair_properties::PairProperties;

/// Free rolling.
#[derive(Clone, Copy, Debug)]
pub struct NoMoments;

impl MomentLaw for NoMoments {
    const DESCRIPTION: Description = Description {
        name: "none",
        label: "free rolling",
        help: "contacts resist neither rolling nor twisting",
        parameters: &[],
    };
    const ACTS: bool = false;
    const HISTORY: usize = 0;
    const PLANE_VECTORS: usize = 0;

    fn prepare(_pair: &PairProperties, _parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        [0.0; LAW_CONSTANTS]
    }

    #[inline(always)]
    fn update<R: Real>(
        _c: &[R; LAW_CONSTANTS],
        _normal: &Normal<R>,
        _spin: RelativeSpin<R>,
        _dt: R,
        _history: &mut [R; MAX_MOMENT_HISTORY],
    ) -> Moment<R> {
        Moment::none()
    }

    fn energy(_c: &[f64; LAW_CONSTANTS], _history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        0.0
    }
}
