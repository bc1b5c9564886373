//! Definition of a tangential law.

use granum_simd::Real;

use super::constants::LawConstants;
use super::description::LawDescription;
use super::energy_channel::{EnergyChannel, LawEnergies};
use super::limits::MAX_HISTORY;
use super::normal::{Normal, NormalTraits};
use super::pair_properties::PairProperties;

/// State of a contact according to a tangential law.
#[derive(Clone, Copy)]
pub struct Tangential<R: Real> {
    /// Elastic tangential force T on grain i, N, by its components in the frame of the contact.
    pub force: [R; 2],
    /// Stiffness for the dashpot, N/m.
    pub stiffness: R,
    /// Square root of the stiffness.
    pub root_stiffness: R,
    /// Where the force is at the friction limit.
    pub sliding: R::Mask,
    /// Energy lost to sliding in this step, J.
    pub friction_loss: R,
    /// Energy lost in this step below the friction limit, J: in the slip zone of the contact area, or where the law releases
    /// what a changed stiffness no longer stores. It does not include the energy of the histories marked by `discards`.
    pub micro_slip_loss: R,
    /// Where the law discarded a part of its history and, with it, the energy that [`TangentialLaw::discarded`] returns.
    pub discards: R::Mask,
}

/// A tangential law.
pub trait TangentialLaw: Copy + Send + Sync + 'static {
    /// Name, label, help and parameters.
    const DESCRIPTION: LawDescription;
    /// Its constants for a pair, by name, declared with [`law_constants!`](crate::law_constants).
    type Constants<R: Real>: LawConstants<R>;
    /// Energies that it accounts for in addition to those of every tangential law.
    const CHANNELS: &'static [EnergyChannel] = &[];
    /// Number of history columns used. The first two are always the tangential force T on grain i, by its components in the
    /// [`ContactFrame`](crate::contact::evaluation::frame::ContactFrame) of the normal.
    const HISTORY: usize;
    /// Number of plane vectors at the beginning of the history (the first in columns 0..2, ...); they rotate with the
    /// contact plane, and change as described at
    /// [`swap_sides`](crate::contact::evaluation::frame::swap_sides) when the grains of a pair change roles.
    const PLANE_VECTORS: usize;
    /// True for a law that discards parts of its history that store energy.
    const DISCARDS: bool = false;
    /// Rejects a normal law that this law cannot be combined with. The message states what is wrong, as a continuation of
    /// `contact.tangential = "..."`; the normal laws that are right are added to it.
    ///
    /// # Errors
    /// The reason.
    fn goes_with(_normal: &NormalTraits) -> Result<(), &'static str> {
        Ok(())
    }
    /// The constants of a pair that [`TangentialLaw::update`] needs; `parameters` in the order of the description.
    fn prepare(pair: &PairProperties, normal: &NormalTraits, parameters: &[f64]) -> Self::Constants<f64>;
    /// Stiffness of a contact that has neither slipped nor peeled, N/m, for the stored energy and the time step.
    fn stiffness<R: Real>(constants: &Self::Constants<R>, normal: &Normal<R>) -> R;
    /// Stiffness for the time step, N/m: at least a third of the normal stiffness, since below that value the spinning of
    /// the grains is no longer their fastest mode of oscillation.
    #[inline(always)]
    fn step_stiffness<R: Real>(constants: &Self::Constants<R>, normal: &Normal<R>) -> R {
        Self::stiffness(constants, normal)
    }
    /// Advances the history (already rotated into the present contact plane, all zeros for a new contact) by an increment of
    /// tangential displacement of the surface of grain j relative to that of grain i, m. Where the friction load is zero the
    /// force is zero. `energies` receives what the step puts into the channels of the law; it counts where the pair touches.
    fn update<R: Real>(
        constants: &Self::Constants<R>,
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Tangential<R>;
    /// Energy lost where a step discarded a part of the history, J, from the history before that step and the stiffness that
    /// [`Tangential::stiffness`] had. It is rarely needed and therefore not a part of [`TangentialLaw::update`].
    #[inline(always)]
    fn discarded<R: Real>(_constants: &Self::Constants<R>, _stiffness: R, _history: &[R; MAX_HISTORY]) -> R {
        R::zero()
    }
    /// Energy stored by the tangential displacement, J, given [`TangentialLaw::stiffness`]: `T^2 / 2 k` without slip.
    #[inline(always)]
    fn energy<R: Real>(_constants: &Self::Constants<R>, stiffness: R, history: &[R; MAX_HISTORY]) -> R {
        let square = history[0] * history[0] + history[1] * history[1];
        (R::splat(0.5) * square / stiffness).keep(stiffness.gt(R::zero()))
    }
}
