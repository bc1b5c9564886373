//! Contact laws: a normal law and a tangential law, composed by generics.
//!
//! A law is written once over [`Real`] and runs on one pair (`f64`) or on eight side by side. To add one: a
//! file here with its formula and tests, its kind in [`crate::config`] and its line in [`registry`].
//! [`interaction`] holds what all laws share: kinematics, rotation of the history, damping.

use granum_simd::{Real, Twice};

use crate::config::Material;

pub mod frame;
pub mod hertz;
pub mod impact;
pub mod interaction;
pub mod jkr;
pub mod mindlin_deresiewicz;
pub mod no_slip;
pub mod pair;
pub mod peeling;
pub mod refined;
pub mod registry;

#[cfg(test)]
mod tests;

use interaction::Memory;

/// Most columns of history that a tangential law may keep.
pub const MAX_HISTORY: usize = 10;
/// Number of constants that a law may prepare for a pair.
pub const LAW_CONSTANTS: usize = 6;

/// Properties of a pair of spheres (section 1 of the theory chapter of the book).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairProperties {
    /// R_i + R_j, m.
    pub radius_sum: f64,
    /// R* = R_i R_j / (R_i + R_j), m.
    pub effective_radius: f64,
    /// m* = m_i m_j / (m_i + m_j), kg.
    pub effective_mass: f64,
    /// E*, Pa: 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j.
    pub effective_modulus: f64,
    /// G*, Pa: 1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j.
    pub effective_shear_modulus: f64,
    /// Coefficient of friction mu.
    pub friction: f64,
    /// Interface energy Gamma (work of adhesion per area), J/m2.
    pub interface_energy: f64,
    /// Fraction zeta of critical damping.
    pub damping: f64,
}

impl PairProperties {
    /// Those of two spheres of given material and radius, m, with dashpots of a fraction of critical damping.
    ///
    /// Friction and interface energy of unlike materials are the geometric means of the two.
    pub fn new(i: (&Material, f64), j: (&Material, f64), damping: f64) -> Self {
        let compliance = |m: &Material| (1.0 - m.poissons_ratio * m.poissons_ratio) / m.youngs_modulus;
        let shear_compliance =
            |m: &Material| (2.0 - m.poissons_ratio) * 2.0 * (1.0 + m.poissons_ratio) / m.youngs_modulus;
        let mass = |(m, r): (&Material, f64)| m.density * 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
        PairProperties {
            radius_sum: i.1 + j.1,
            effective_radius: i.1 * j.1 / (i.1 + j.1),
            effective_mass: mass(i) * mass(j) / (mass(i) + mass(j)),
            effective_modulus: 1.0 / (compliance(i.0) + compliance(j.0)),
            effective_shear_modulus: 1.0 / (shear_compliance(i.0) + shear_compliance(j.0)),
            friction: (i.0.friction * j.0.friction).sqrt(),
            interface_energy: (i.0.interface_energy * j.0.interface_energy).sqrt(),
            damping,
        }
    }
}

/// What a normal law says of a contact.
#[derive(Clone, Copy)]
pub struct Normal<R: Real> {
    /// Elastic normal force N, compression positive, N.
    pub force: R,
    /// Radius a of the contact area, m.
    pub radius: R,
    /// Stiffness for the dashpot, N/m: dN/dalpha, kept positive by the law.
    pub stiffness: R,
    /// Root of the stiffness.
    pub root_stiffness: R,
    /// Root of the radius of the contact area.
    pub root_radius: R,
    /// Load F such that the tangential force is limited to mu F, N: N itself without adhesion.
    pub friction_load: R,
    /// Where the pair touches.
    pub touching: R::Mask,
}

/// A normal law.
pub trait NormalLaw: Copy + Send + Sync + 'static {
    /// The constants of a pair that [`NormalLaw::evaluate`] wants.
    fn prepare(pair: &PairProperties) -> [f64; LAW_CONSTANTS];
    /// Force, contact radius, stiffness and friction load at an approach, m, given whether the pair touched a step before.
    /// Where the pair does not touch, force, radius and load are zero.
    fn evaluate<R: Real>(constants: &[R; LAW_CONSTANTS], approach: R, touched: R::Mask) -> Normal<R>;
    /// Energy of a touching pair over that of one apart, J: the integral of N from zero approach, less what
    /// [`NormalLaw::making_loss`] says.
    fn energy(constants: &[f64; LAW_CONSTANTS], approach: f64) -> f64;
    /// Energy lost when a contact is made, J: no force gives back what the surfaces release.
    fn making_loss<R: Real>(constants: &[R; LAW_CONSTANTS]) -> R;
    /// Energy lost when a contact breaks, J: the energy at the approach of rupture.
    fn breaking_loss<R: Real>(constants: &[R; LAW_CONSTANTS]) -> R;
    /// Approach below which a touching pair breaks, m (zero or negative).
    fn breaking_approach(constants: &[f64; LAW_CONSTANTS]) -> f64;
}

/// What a tangential law says of a contact.
#[derive(Clone, Copy)]
pub struct Tangential<R: Real> {
    /// Elastic tangential force T on grain i, N, by its components in the frame of the contact.
    pub force: [R; 2],
    /// Stiffness for the dashpot and for the time step, N/m: 8 G* a.
    pub stiffness: R,
    /// Root of the stiffness.
    pub root_stiffness: R,
    /// Where the force stands at the friction limit.
    pub sliding: R::Mask,
    /// Energy lost to sliding in this step, J.
    pub friction_loss: R,
    /// Energy lost in this step below the friction limit, J: in the zone of slip of the contact area, or where the
    /// law drops what a changed radius no longer holds. Without what `forgets` marks.
    pub micro_slip_loss: R,
    /// Where the law forgot a part of its history and, with it, the energy that [`TangentialLaw::forgotten`] says.
    pub forgets: R::Mask,
}

/// A tangential law.
pub trait TangentialLaw: Copy + Send + Sync + 'static {
    /// Columns of history used. The first two are always the tangential force T on grain i, by its components in the
    /// [`frame::Frame`] of the normal.
    const HISTORY: usize;
    /// How many plane vectors lead the history (columns 0..2 the first, ...); they turn with the contact plane, and
    /// change as [`TangentialLaw::swap_sides`] says when the grains of a pair change sides.
    const PLANE_VECTORS: usize;
    /// True for a law that forgets parts of its history which store energy.
    const FORGETS: bool = false;
    /// The constants of a pair that [`TangentialLaw::update`] wants.
    fn prepare(pair: &PairProperties) -> [f64; LAW_CONSTANTS];
    /// Advances the history (already turned into the present contact plane, all zeros for a new contact) by an
    /// increment of tangential displacement of grain j's surface relative to grain i's, m. Where the friction load is
    /// zero the force is zero.
    fn update<R: Real>(
        constants: &[R; LAW_CONSTANTS],
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
    ) -> Tangential<R>;
    /// Energy lost where a step forgot a part of the history, J, from the history before that step and the stiffness
    /// 8 G* a, N/m. Rare, and so not a part of [`TangentialLaw::update`].
    #[inline(always)]
    fn forgotten<R: Real>(_constants: &[R; LAW_CONSTANTS], _stiffness: R, _history: &[R; MAX_HISTORY]) -> R {
        R::zero()
    }
    /// Energy that the tangential displacement stores, J, given the stiffness 8 G* a, N/m: `T^2 / 2 k` without slip.
    fn energy(_constants: &[f64; LAW_CONSTANTS], stiffness: f64, history: &[f64; MAX_HISTORY]) -> f64 {
        let square = history[0] * history[0] + history[1] * history[1];
        if stiffness > 0.0 { 0.5 * square / stiffness } else { 0.0 }
    }
    /// Rewrites a memory for the pair (j, i) instead of (i, j): the normal and every remembered vector are reversed
    /// in space.
    fn swap_sides(memory: &mut Memory<f64>) {
        for v in 0..Self::PLANE_VECTORS {
            let vector = [memory.history[2 * v], memory.history[2 * v + 1]];
            memory.history[2 * v..2 * v + 2].copy_from_slice(&frame::swap_sides(memory.normal, vector));
        }
        memory.normal = memory.normal.map(|x| -x);
    }
    /// The tangential force T on grain i that a memory holds, N, given its unit normal and history.
    #[inline(always)]
    fn force<R: Real>(normal: [R; 3], history: &[R; MAX_HISTORY]) -> [R; 3] {
        frame::Frame::of(normal).vector([history[0], history[1]])
    }
}

/// The constants of a pair, or of eight.
#[derive(Clone, Copy)]
pub struct PairConstants<R> {
    /// R_i + R_j, m.
    pub radius_sum: R,
    /// Its reciprocal, 1/m.
    pub inverse_radius_sum: R,
    /// 2 zeta sqrt(m*): times the root of a stiffness it is a dashpot coefficient.
    pub damping: R,
    /// 16 G*, Pa: times the radius it is twice the tangential stiffness.
    pub sixteen_shear_moduli: R,
    /// Those of the normal law.
    pub normal: [R; LAW_CONSTANTS],
    /// Those of the tangential law.
    pub tangential: [R; LAW_CONSTANTS],
}

impl PairConstants<f64> {
    /// Number of values of [`PairConstants::to_array`].
    pub const COUNT: usize = 4 + 2 * LAW_CONSTANTS;

    /// The constants of a pair for two laws.
    pub fn new<N: NormalLaw, T: TangentialLaw>(pair: &PairProperties) -> Self {
        PairConstants {
            radius_sum: pair.radius_sum,
            inverse_radius_sum: 1.0 / pair.radius_sum,
            damping: 2.0 * pair.damping * pair.effective_mass.sqrt(),
            sixteen_shear_moduli: 16.0 * pair.effective_shear_modulus,
            normal: N::prepare(pair),
            tangential: T::prepare(pair),
        }
    }

    /// The values in a row.
    pub fn to_array(&self) -> [f64; Self::COUNT] {
        let mut out = [0.0; Self::COUNT];
        out[0] = self.radius_sum;
        out[1] = self.inverse_radius_sum;
        out[2] = self.damping;
        out[3] = self.sixteen_shear_moduli;
        out[4..4 + LAW_CONSTANTS].copy_from_slice(&self.normal);
        out[4 + LAW_CONSTANTS..].copy_from_slice(&self.tangential);
        out
    }

    /// The same constants in every lane.
    #[inline(always)]
    pub fn splat<R: Real>(&self) -> PairConstants<R> {
        PairConstants::from_columns(|c| R::splat(self.to_array()[c]))
    }
}

impl<R: Copy> PairConstants<R> {
    /// From a function that gives column `c` of [`PairConstants::to_array`].
    #[inline(always)]
    pub fn from_columns(column: impl Fn(usize) -> R) -> Self {
        PairConstants {
            radius_sum: column(0),
            inverse_radius_sum: column(1),
            damping: column(2),
            sixteen_shear_moduli: column(3),
            normal: std::array::from_fn(|c| column(4 + c)),
            tangential: std::array::from_fn(|c| column(4 + LAW_CONSTANTS + c)),
        }
    }
    /// Those of two pairs side by side.
    #[inline(always)]
    pub fn beside(&self, other: &Self) -> PairConstants<Twice<R>> {
        PairConstants {
            radius_sum: Twice(self.radius_sum, other.radius_sum),
            inverse_radius_sum: Twice(self.inverse_radius_sum, other.inverse_radius_sum),
            damping: Twice(self.damping, other.damping),
            sixteen_shear_moduli: Twice(self.sixteen_shear_moduli, other.sixteen_shear_moduli),
            normal: std::array::from_fn(|c| Twice(self.normal[c], other.normal[c])),
            tangential: std::array::from_fn(|c| Twice(self.tangential[c], other.tangential[c])),
        }
    }
}
