//! Definition of an adhesion law in addition to the contact laws.

use granum_simd::Real;

use super::constants::LawConstants;
use super::description::LawDescription;
use super::energy_channel::{EnergyChannel, LawEnergies};
use super::limits::MAX_ADHESION_HISTORY;
use super::normal::NormalTraits;
use super::pair_properties::PairProperties;

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
/// let (mut history, mut energies) = ([0.0; 4], [0.0; 2]);
/// let touching = CapillaryBridge::update(&constants, 1e-9, true, &mut history, &mut energies);
/// let apart = CapillaryBridge::update(&constants, -1e-6, false, &mut history, &mut energies);
/// assert!(apart.acting && 0.0 < apart.force && apart.force < touching.force);
/// ```
pub trait AdhesionLaw: Copy + Send + Sync + 'static {
    /// Name, label, help and parameters.
    const DESCRIPTION: LawDescription;
    /// Its constants for a pair, by name, declared with [`law_constants!`](crate::law_constants).
    type Constants<R: Real>: LawConstants<R>;
    /// Energies that it accounts for in addition to those of every adhesion law.
    const CHANNELS: &'static [EnergyChannel] = &[];
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
    fn prepare(pair: &PairProperties, parameters: &[f64]) -> Self::Constants<f64>;
    /// Force, stiffness and loss at an overlap, m (negative for a separated pair), and whether the pair touches. The history is
    /// all zeros for a pair on which the law did not act in the previous step. `energies` receives what the step puts into the
    /// channels of the law; it is zero for pairs on which the law neither acts nor did so in the previous step.
    fn update<R: Real>(
        constants: &Self::Constants<R>,
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Attraction<R>;
    /// Volume of the liquid on a grain of a given radius, m, at the start, m3; `parameters` of the grain's own material, in the order
    /// of the description. Only for a law that shares liquid, as the two functions below.
    fn film(_radius: f64, _parameters: &[f64]) -> f64 {
        0.0
    }
    /// Largest volume of liquid that a bridge takes from the films of its grains, m3.
    fn largest_bridge(_constants: &Self::Constants<f64>) -> f64 {
        0.0
    }
    /// The history of a new bridge with this volume of liquid, m3; all zeros if the volume is too small for a bridge.
    fn bridge(_constants: &Self::Constants<f64>, _volume: f64) -> [f64; MAX_ADHESION_HISTORY] {
        [0.0; MAX_ADHESION_HISTORY]
    }
    /// Energy of the attraction at an overlap, J: minus the work that it has done since it began to act, less the losses that
    /// [`Attraction::loss`] reported.
    fn energy(constants: &Self::Constants<f64>, overlap: f64, history: &[f64; MAX_ADHESION_HISTORY]) -> f64;
    /// Largest distance of the surfaces at which the law acts, m.
    fn range(constants: &Self::Constants<f64>) -> f64;
}
