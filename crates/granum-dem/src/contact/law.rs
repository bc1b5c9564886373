//! Definition of a contact law: a normal law, a tangential law, and a moment law.
//!
//! A law is written once over [`Real`] and runs on one pair (`f64`), on eight side by side or on two times eight. It defines
//! its name, its parameters, its constants for a pair, its history and its stiffness.

use granum_simd::Real;

use super::description::Description;
use super::frame;
use super::memory::Memory;
use crate::contact::limits::{
    LAW_CONSTANTS, MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};
use crate::contact::pair_properties::PairProperties;

/// Properties of the normal law that the other laws of a set depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalTraits {
    /// Its name.
    pub name: &'static str,
    /// True if contacts have an area, whose radius is [`Normal::radius`].
    pub contact_area: bool,
    /// True if contacts carry tension.
    pub adhesive: bool,
}

impl NormalTraits {
    /// Whether an additional attraction can be combined with this law: not if the law itself includes adhesion.
    ///
    /// # Errors
    /// The reason, as a continuation of the name of the adhesion law.
    pub fn without_adhesion(&self) -> Result<(), &'static str> {
        if self.adhesive {
            return Err("adds to a normal law without adhesion");
        }
        Ok(())
    }
}

/// State of a contact according to a normal law.
#[derive(Clone, Copy)]
pub struct Normal<R: Real> {
    /// Elastic normal force N, compression positive, N.
    pub force: R,
    /// Radius a of the contact area, m; zero for a law without one.
    pub radius: R,
    /// Stiffness for the dashpot, N/m: the derivative of N with respect to the overlap, kept positive by the law.
    pub stiffness: R,
    /// Square root of the stiffness.
    pub root_stiffness: R,
    /// The quantity that the tangential stiffness is proportional to: the radius of the contact area, m, or for a law
    /// without one the stiffness, N/m.
    pub tangential_measure: R,
    /// Its square root.
    pub root_tangential_measure: R,
    /// Load F such that the tangential force is limited to mu F, N: equal to N without adhesion.
    pub friction_load: R,
    /// Where the pair touches.
    pub touching: R::Mask,
}

impl<R: Real> Normal<R> {
    /// Its numbers in the order of its fields.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [R; 7] {
        [
            self.force,
            self.radius,
            self.stiffness,
            self.root_stiffness,
            self.tangential_measure,
            self.root_tangential_measure,
            self.friction_load,
        ]
    }

    /// The contact of these numbers.
    #[inline(always)]
    pub(crate) fn from_numbers(numbers: [R; 7], touching: R::Mask) -> Self {
        let [
            force,
            radius,
            stiffness,
            root_stiffness,
            tangential_measure,
            root_tangential_measure,
            friction_load,
        ] = numbers;
        Normal {
            force,
            radius,
            stiffness,
            root_stiffness,
            tangential_measure,
            root_tangential_measure,
            friction_load,
            touching,
        }
    }

    /// A pair that does not touch.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = R::zero();
        Normal {
            force: zero,
            radius: zero,
            stiffness: zero,
            root_stiffness: zero,
            tangential_measure: zero,
            root_tangential_measure: zero,
            friction_load: zero,
            touching: granum_simd::Mask::splat(false),
        }
    }
}

/// Energy that no force returns when a contact forms or breaks, J.
#[derive(Clone, Copy)]
pub struct AdhesionLosses<R> {
    /// Energy lost when a contact forms.
    pub made: R,
    /// Energy lost when it breaks: the energy at the overlap of rupture.
    pub broken: R,
}

/// A normal law.
///
/// ```
/// use granum_dem::contact::normal::Hertz;
/// use granum_dem::contact::{NormalLaw, PairProperties};
/// use granum_dem::config::Material;
///
/// let sphere = (&Material::default(), 5e-5);
/// let pair = PairProperties::new(sphere, sphere, 0.1);
/// let constants = Hertz::prepare(&pair, &[]);
/// let contact = Hertz::evaluate(&constants, 1e-8, true);
/// assert!((contact.radius - (pair.effective_radius * 1e-8).sqrt()).abs() < 1e-15);
/// ```
pub trait NormalLaw: Copy + Send + Sync + 'static {
    /// Name, label, help and parameters.
    const DESCRIPTION: Description;
    /// True if contacts have an area.
    const CONTACT_AREA: bool = true;
    /// True if contacts carry tension.
    const ADHESIVE: bool = false;
    /// Number of history columns of a law with memory: scalars, which are the same for the pair (j, i) as for (i, j). They are
    /// stored while the pair touches.
    const HISTORY: usize = 0;
    /// The constants of a pair that [`NormalLaw::evaluate`] needs; `parameters` in the order of the description.
    fn prepare(pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS];
    /// Force, contact radius, stiffness and friction load at an overlap, m; `touched` is true where the pair touched one
    /// step before. Where the pair does not touch, force, radius and load are zero.
    fn evaluate<R: Real>(constants: &[R; LAW_CONSTANTS], overlap: R, touched: R::Mask) -> Normal<R>;
    /// A step to an overlap, and the energy lost in it by plastic deformation, J. The history is all zeros for a new contact. The
    /// default, for a law without memory, calls [`NormalLaw::evaluate`], which for a law with memory gives the first loading.
    #[inline(always)]
    fn update<R: Real>(
        constants: &[R; LAW_CONSTANTS],
        overlap: R,
        touched: R::Mask,
        _history: &mut [R; MAX_NORMAL_HISTORY],
    ) -> (Normal<R>, R) {
        (Self::evaluate(constants, overlap, touched), R::zero())
    }
    /// A contact under a load, N, as an estimate before any contact exists: the initial time step is derived from it.
    fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64>;
    /// Energy of a touching pair relative to a separated one, J: the integral of N from zero overlap, minus the loss by
    /// formation of the contact that [`NormalLaw::losses`] returns.
    fn energy<R: Real>(constants: &[R; LAW_CONSTANTS], overlap: R) -> R;
    /// The same for a contact with memory: the energy stored at its present overlap, J.
    #[inline(always)]
    fn stored<R: Real>(constants: &[R; LAW_CONSTANTS], overlap: R, _history: &[R; MAX_NORMAL_HISTORY]) -> R {
        Self::energy(constants, overlap)
    }
    /// Energy lost when a contact forms and when it breaks, J: zero without adhesion.
    #[inline(always)]
    fn losses<R: Real>(_constants: &[R; LAW_CONSTANTS]) -> AdhesionLosses<R> {
        AdhesionLosses { made: R::zero(), broken: R::zero() }
    }
    /// Overlap below which a touching pair breaks, m (zero or negative).
    fn breaking_overlap(_constants: &[f64; LAW_CONSTANTS]) -> f64 {
        0.0
    }
}

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
    const DESCRIPTION: Description;
    /// Number of history columns used. The first two are always the tangential force T on grain i, by its components in the
    /// [`frame::Frame`] of the normal.
    const HISTORY: usize;
    /// Number of plane vectors at the beginning of the history (the first in columns 0..2, ...); they rotate with the
    /// contact plane, and change as described at [`swap_sides`] when the grains of a pair change roles.
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
    fn prepare(pair: &PairProperties, normal: &NormalTraits, parameters: &[f64]) -> [f64; LAW_CONSTANTS];
    /// Stiffness of a contact that has neither slipped nor peeled, N/m, for the stored energy and the time step.
    fn stiffness<R: Real>(constants: &[R; LAW_CONSTANTS], normal: &Normal<R>) -> R;
    /// Stiffness for the time step, N/m: at least a third of the normal stiffness, since below that value the spinning of
    /// the grains is no longer their fastest mode of oscillation.
    #[inline(always)]
    fn step_stiffness<R: Real>(constants: &[R; LAW_CONSTANTS], normal: &Normal<R>) -> R {
        Self::stiffness(constants, normal)
    }
    /// Advances the history (already rotated into the present contact plane, all zeros for a new contact) by an increment of
    /// tangential displacement of the surface of grain j relative to that of grain i, m. Where the friction load is zero the
    /// force is zero.
    fn update<R: Real>(
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
    ) -> Tangential<R>;
    /// Energy lost where a step discarded a part of the history, J, from the history before that step and the stiffness that
    /// [`Tangential::stiffness`] had. It is rarely needed and therefore not a part of [`TangentialLaw::update`].
    #[inline(always)]
    fn discarded<R: Real>(_constants: &[R; LAW_CONSTANTS], _stiffness: R, _history: &[R; MAX_HISTORY]) -> R {
        R::zero()
    }
    /// Energy stored by the tangential displacement, J, given [`TangentialLaw::stiffness`]: `T^2 / 2 k` without slip.
    #[inline(always)]
    fn energy<R: Real>(_constants: &[R; LAW_CONSTANTS], stiffness: R, history: &[R; MAX_HISTORY]) -> R {
        let square = history[0] * history[0] + history[1] * history[1];
        (R::splat(0.5) * square / stiffness).keep(stiffness.gt(R::zero()))
    }
}

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
    /// Work of the elastic couple in this step, positive where energy is absorbed, J.
    pub work: R,
    /// The part of it that was dissipated, J: rolling at the limit, and energy that a changed stiffness no longer stores.
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
    const DESCRIPTION: Description;
    /// False only for the law without moments.
    const ACTS: bool = true;
    /// Number of history columns used.
    const HISTORY: usize;
    /// Number of plane vectors at the beginning of the history; they rotate with the contact plane.
    const PLANE_VECTORS: usize;
    /// The constants of a pair that [`MomentLaw::update`] needs; `parameters` in the order of the description.
    fn prepare(pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS];
    /// Advances the history (already rotated into the present contact plane, all zeros for a new contact) by a step of
    /// length `dt`, s. Where the friction load is zero the couple is zero.
    fn update<R: Real>(
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
    ) -> Moment<R>;
    /// Energy stored by the couple, J.
    fn energy(constants: &[f64; LAW_CONSTANTS], history: &[f64; MAX_MOMENT_HISTORY]) -> f64;
}

/// State of a pair according to an adhesion law.
#[derive(Clone, Copy)]
pub struct Attraction<R: Real> {
    /// Attractive force along the line of the centres, N; negative where it is repulsive.
    pub force: R,
    /// Absolute value of its derivative with respect to the distance, N/m, for the time step.
    pub stiffness: R,
    /// Whether the law acts on the pair; its history is stored only if it does.
    pub acting: R::Mask,
    /// Energy lost in this step, J, because the attraction begins or ends with a jump of its energy.
    pub loss: R,
}

impl<R: Real> Attraction<R> {
    /// No attraction.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = R::zero();
        Attraction { force: zero, stiffness: zero, acting: granum_simd::Mask::splat(false), loss: zero }
    }
}

/// An adhesion law in addition to the contact laws: an attraction along the line of centres, between grains that touch and
/// between grains whose surfaces are at most [`AdhesionLaw::range`] apart.
///
/// ```
/// use granum_dem::config::Material;
/// use granum_dem::contact::adhesion::CapillaryBridge;
/// use granum_dem::contact::{AdhesionLaw, PairProperties};
///
/// let sphere = (&Material::default(), 5e-5);
/// let pair = PairProperties::new(sphere, sphere, 0.1);
/// let constants = CapillaryBridge::prepare(&pair, &[0.072, 0.0, 0.01, 0.1]);
/// let mut history = [0.0; 4];
/// let touching = CapillaryBridge::update(&constants, 1e-9, true, &mut history);
/// let apart = CapillaryBridge::update(&constants, -1e-6, false, &mut history);
/// assert!(apart.acting && 0.0 < apart.force && apart.force < touching.force);
/// ```
pub trait AdhesionLaw: Copy + Send + Sync + 'static {
    /// Name, label, help and parameters.
    const DESCRIPTION: Description;
    /// False only for the law without a force.
    const ACTS: bool = true;
    /// True for a law that begins to act only on grains that touch, such as a liquid bridge. A separated pair on which it does not
    /// act is then not evaluated until the grains may touch.
    const BEGINS_AT_TOUCH: bool = false;
    /// True for a law of bridges whose liquid comes from films on the grains and returns to them. The first column of the history is
    /// then the volume of the liquid in the bridge, m3, and zero without a bridge. At the end of a step the engine makes a
    /// bridge ([`AdhesionLaw::bridge`]) between grains that touch and have liquid, and returns the liquid of the bridges on
    /// which the law has ceased to act; [`AdhesionLaw::update`] leaves the first column as it is.
    const SHARES_LIQUID: bool = false;
    /// Number of history columns: scalars, which are the same for the pair (j, i) as for (i, j). They are stored while the law
    /// acts.
    const HISTORY: usize;
    /// Refuses a normal law with which it cannot be combined: what is wrong, as a continuation of
    /// `contact.adhesion = "..."`.
    ///
    /// # Errors
    /// The reason.
    fn goes_with(_normal: &NormalTraits) -> Result<(), &'static str> {
        Ok(())
    }
    /// The constants of a pair that [`AdhesionLaw::update`] needs; `parameters` in the order of the description.
    fn prepare(pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS];
    /// Force, stiffness and loss at an overlap, m (negative for a separated pair), and whether the pair touches. The history is
    /// all zeros for a pair on which the law did not act in the previous step.
    fn update<R: Real>(
        constants: &[R; LAW_CONSTANTS],
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
    ) -> Attraction<R>;
    /// Volume of the liquid on a grain of a given radius, m, at the start, m3; `parameters` of the grain's own material, in the order
    /// of the description. Only for a law that shares liquid, as the two functions below.
    fn film(_radius: f64, _parameters: &[f64]) -> f64 {
        0.0
    }
    /// Largest volume of liquid that a bridge takes from the films of its grains, m3.
    fn largest_bridge(_constants: &[f64; LAW_CONSTANTS]) -> f64 {
        0.0
    }
    /// The history of a new bridge with this volume of liquid, m3; all zeros if the volume is too small for a bridge.
    fn bridge(_constants: &[f64; LAW_CONSTANTS], _volume: f64) -> [f64; MAX_ADHESION_HISTORY] {
        [0.0; MAX_ADHESION_HISTORY]
    }
    /// Energy of the attraction at an overlap, J: minus the work that it has done since it began to act, less the losses that
    /// [`Attraction::loss`] reported.
    fn energy(constants: &[f64; LAW_CONSTANTS], overlap: f64, history: &[f64; MAX_ADHESION_HISTORY]) -> f64;
    /// Largest distance of the surfaces at which the law acts, m.
    fn range(constants: &[f64; LAW_CONSTANTS]) -> f64;
}

/// Rewrites the plane vectors at the beginning of a history for the pair (j, i) instead of (i, j): every stored vector is
/// reversed in space, and so is the normal.
pub fn swap_sides(normal: [f64; 3], vectors: usize, history: &mut [f64]) {
    for v in 0..vectors {
        let vector = [history[2 * v], history[2 * v + 1]];
        history[2 * v..2 * v + 2].copy_from_slice(&frame::swap_sides(normal, vector));
    }
}

/// The tangential force T on grain i stored in a contact history, N.
pub fn tangential_force(memory: &Memory<f64>) -> [f64; 3] {
    frame::Frame::of(memory.normal).vector([memory.history[0], memory.history[1]])
}
