//! Definition of a normal law.

use granum_simd::Real;

use super::constants::LawConstants;
use super::description::LawDescription;
use super::energy_channel::{EnergyChannel, LawEnergies};
use super::limits::MAX_NORMAL_HISTORY;
use super::pair_properties::PairProperties;

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
    const DESCRIPTION: LawDescription;
    /// Its constants for a pair, by name, declared with [`law_constants!`](crate::law_constants).
    type Constants<R: Real>: LawConstants<R>;
    /// Energies that it accounts for in addition to those of every normal law.
    const CHANNELS: &'static [EnergyChannel] = &[];
    /// True if contacts have an area.
    const CONTACT_AREA: bool = true;
    /// True if contacts carry tension.
    const ADHESIVE: bool = false;
    /// Number of history columns of a law with memory: scalars, which are the same for the pair (j, i) as for (i, j). They are
    /// stored while the pair touches.
    const HISTORY: usize = 0;
    /// The constants of a pair that [`NormalLaw::evaluate`] needs; `parameters` in the order of the description.
    fn prepare(pair: &PairProperties, parameters: &[f64]) -> Self::Constants<f64>;
    /// Force, contact radius, stiffness and friction load at an overlap, m; `touched` is true where the pair touched one
    /// step before. Where the pair does not touch, force, radius and load are zero.
    fn evaluate<R: Real>(constants: &Self::Constants<R>, overlap: R, touched: R::Mask) -> Normal<R>;
    /// A step to an overlap, and what it puts into the channels of the law. The history is all zeros for a new contact. The
    /// default, for a law without memory, calls [`NormalLaw::evaluate`], which for a law with memory gives the first loading.
    #[inline(always)]
    fn update<R: Real>(
        constants: &Self::Constants<R>,
        overlap: R,
        touched: R::Mask,
        _history: &mut [R; MAX_NORMAL_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Normal<R> {
        Self::evaluate(constants, overlap, touched)
    }
    /// A contact under a load, N, as an estimate before any contact exists: the initial time step is derived from it.
    fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64>;
    /// Energy of a touching pair relative to a separated one, J: the integral of N from zero overlap, minus the loss by
    /// formation of the contact that [`NormalLaw::losses`] returns.
    fn energy<R: Real>(constants: &Self::Constants<R>, overlap: R) -> R;
    /// The same for a contact with memory: the energy stored at its present overlap, J.
    #[inline(always)]
    fn stored<R: Real>(constants: &Self::Constants<R>, overlap: R, _history: &[R; MAX_NORMAL_HISTORY]) -> R {
        Self::energy(constants, overlap)
    }
    /// Energy lost when a contact forms and when it breaks, J: zero without adhesion.
    #[inline(always)]
    fn losses<R: Real>(_constants: &Self::Constants<R>) -> AdhesionLosses<R> {
        AdhesionLosses { made: R::zero(), broken: R::zero() }
    }
    /// Overlap below which a touching pair breaks, m (zero or negative).
    fn breaking_overlap(_constants: &Self::Constants<f64>) -> f64 {
        0.0
    }
}
