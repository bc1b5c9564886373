//! Definition of a law of moments: resistance to rolling, to twisting, or to both.

use granum_simd::Real;

use super::constants::LawConstants;
use super::description::LawDescription;
use super::energy_channel::{EnergyChannel, LawEnergies};
use super::limits::MAX_MOMENT_HISTORY;
use super::normal::Normal;
use super::pair_properties::PairProperties;

/// Rotation of one grain of a contact relative to the other, in the frame of the contact: `w_i - w_j`, rad/s.
///
/// The relative spin is the same for every observer, including rotating ones, and opposite couples on the two grains do work
/// on it, whatever the radii.
#[derive(Clone, Copy)]
pub struct RelativeSpin<R> {
    /// Rolling: the components in the contact plane.
    pub rolling: [R; 2],
    /// Twisting: the component along the normal.
    pub twisting: R,
}

/// State of a contact according to a moment law.
#[derive(Clone, Copy)]
pub struct Moment<R: Real> {
    /// Elastic couple on grain j, N m; the opposite couple acts on i. Components in the contact plane, then along the
    /// normal.
    pub couple: [R; 3],
    /// Coefficient of the rolling dashpot, N m s; zero where none acts.
    pub dashpot: R,
    /// The same against twisting.
    pub twisting_dashpot: R,
    /// Where the couple is at its limit.
    pub at_limit: R::Mask,
    /// Work that the elastic couple took up in this step, J: the mean of the couples before and after the step times the relative
    /// rotation `dt * spin` (trapezoidal rule, error of second order in the step), positive where the contact absorbs energy. It
    /// equals the change of [`MomentLaw::energy`] plus `loss`, which the energy balance of a test assumes: a law that puts part of
    /// it into one of its [`MomentLaw::CHANNELS`] leaves that part out here. The work of the dashpots is not contained; granum
    /// computes it from `dashpot` and `twisting_dashpot`.
    pub work: R,
    /// The part of `work` that was dissipated, J: rolling or twisting at the limit, and energy that a changed stiffness no longer
    /// stores. Zero for a couple that is a spring of constant stiffness.
    pub loss: R,
    /// Contribution of the couple to the stiffness that limits the time step, as a tangential stiffness, N/m.
    pub step_stiffness: R,
}

impl<R: Real> Moment<R> {
    /// No couple.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = R::zero();
        Moment {
            couple: [zero; 3],
            dashpot: zero,
            twisting_dashpot: zero,
            at_limit: granum_simd::Mask::splat(false),
            work: zero,
            loss: zero,
            step_stiffness: zero,
        }
    }
}

/// A moment law: resistance to rolling, to twisting, or to both.
pub trait MomentLaw: Copy + Send + Sync + 'static {
    /// Name, label, help and parameters.
    const DESCRIPTION: LawDescription;
    /// Its constants for a pair, by name, declared with [`law_constants!`](crate::law_constants).
    type Constants<R: Real>: LawConstants<R>;
    /// Energies that it accounts for in addition to those of every moment law.
    const CHANNELS: &'static [EnergyChannel] = &[];
    /// False only for the law without moments.
    const ACTS: bool = true;
    /// Number of history columns used.
    const HISTORY: usize;
    /// Number of plane vectors at the beginning of the history; they rotate with the contact plane.
    const PLANE_VECTORS: usize;
    /// The constants of a pair that [`MomentLaw::update`] needs; `parameters` in the order of the description.
    fn prepare(pair: &PairProperties, parameters: &[f64]) -> Self::Constants<f64>;
    /// Advances the history (already rotated into the present contact plane, all zeros for a new contact) by a step of
    /// length `dt`, s. Where the friction load is zero the couple is zero. `energies` receives what the step puts into the
    /// channels of the law.
    fn update<R: Real>(
        constants: &Self::Constants<R>,
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Moment<R>;
    /// Energy stored by the couple, J.
    fn energy(constants: &Self::Constants<f64>, history: &[f64; MAX_MOMENT_HISTORY]) -> f64;
}
