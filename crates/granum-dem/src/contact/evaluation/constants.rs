//! The constants of a pair, or of eight pairs side by side.

use granum_simd::{Real, Twice};

use crate::contact::law::limits::LAW_CONSTANTS;

/// The constants of a pair, or of eight.
#[derive(Clone, Copy)]
pub struct PairConstants<R> {
    /// R_i + R_j, m.
    pub radius_sum: R,
    /// Its reciprocal, 1/m.
    pub inverse_radius_sum: R,
    /// 2 zeta sqrt(m*): multiplied by the square root of a stiffness it gives a dashpot coefficient.
    pub damping: R,
    /// Constants of the normal law.
    pub normal: [R; LAW_CONSTANTS],
    /// Constants of the tangential law.
    pub tangential: [R; LAW_CONSTANTS],
    /// Constants of the moment law.
    pub rolling: [R; LAW_CONSTANTS],
    /// Constants of the adhesion law.
    pub adhesion: [R; LAW_CONSTANTS],
}

impl PairConstants<f64> {
    /// Number of values of [`PairConstants::to_array`].
    pub const COUNT: usize = Self::WITHOUT_ADHESION + LAW_CONSTANTS;
    /// Number of values, from the first, that are used without an adhesion law.
    pub const WITHOUT_ADHESION: usize = Self::WITHOUT_MOMENTS + LAW_CONSTANTS;
    /// Number of values, from the first, that are used without a moment law and without an adhesion law.
    pub const WITHOUT_MOMENTS: usize = 3 + 2 * LAW_CONSTANTS;

    /// Number of values, from the first, that are used for a set with or without a moment law, and with or without an adhesion
    /// law.
    #[inline(always)]
    pub fn kept(moments: bool, adhesion: bool) -> usize {
        match (moments, adhesion) {
            (_, true) => Self::COUNT,
            (true, false) => Self::WITHOUT_ADHESION,
            (false, false) => Self::WITHOUT_MOMENTS,
        }
    }

    /// The values as an array.
    pub fn to_array(&self) -> [f64; Self::COUNT] {
        let mut out = [0.0; Self::COUNT];
        [out[0], out[1], out[2]] = [self.radius_sum, self.inverse_radius_sum, self.damping];
        let laws = [&self.normal, &self.tangential, &self.rolling, &self.adhesion];
        for (to, from) in out[3..].chunks_mut(LAW_CONSTANTS).zip(laws) {
            to.copy_from_slice(from);
        }
        out
    }

    /// The same constants in every lane.
    #[inline(always)]
    pub fn splat<R: Real>(&self) -> PairConstants<R> {
        let all = self.to_array();
        PairConstants::from_columns(
            Self::COUNT,
            #[inline(always)]
            |c| R::splat(all[c]),
        )
    }
}

impl<R: Copy> PairConstants<R> {
    /// From a function that gives column `c` of [`PairConstants::to_array`]; it is called for the first `kept` columns only, see
    /// [`PairConstants::kept`].
    #[inline(always)]
    pub fn from_columns(kept: usize, column: impl Fn(usize) -> R) -> Self {
        let [rolling, adhesion] = [PairConstants::WITHOUT_MOMENTS, PairConstants::WITHOUT_ADHESION];
        PairConstants {
            radius_sum: column(0),
            inverse_radius_sum: column(1),
            damping: column(2),
            normal: std::array::from_fn(|c| column(3 + c)),
            tangential: std::array::from_fn(|c| column(3 + LAW_CONSTANTS + c)),
            rolling: std::array::from_fn(|c| column(if rolling < kept { rolling + c } else { 0 })),
            adhesion: std::array::from_fn(|c| column(if adhesion < kept { adhesion + c } else { 0 })),
        }
    }
    /// The constants of two pairs side by side.
    #[inline(always)]
    pub fn beside(&self, other: &Self) -> PairConstants<Twice<R>> {
        PairConstants {
            radius_sum: Twice(self.radius_sum, other.radius_sum),
            inverse_radius_sum: Twice(self.inverse_radius_sum, other.inverse_radius_sum),
            damping: Twice(self.damping, other.damping),
            normal: std::array::from_fn(|c| Twice(self.normal[c], other.normal[c])),
            tangential: std::array::from_fn(|c| Twice(self.tangential[c], other.tangential[c])),
            rolling: std::array::from_fn(|c| Twice(self.rolling[c], other.rolling[c])),
            adhesion: std::array::from_fn(|c| Twice(self.adhesion[c], other.adhesion[c])),
        }
    }
}
