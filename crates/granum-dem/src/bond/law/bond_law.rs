//! What a law of bonds is: the stiffness of a beam between two pieces, and the loads under which it ruptures.

use std::fmt::Debug;

use granum_simd::LANES;

use crate::contact::LawDescription;

/// Number of constants with which the rupture of a bond is judged.
pub const LIMITS: usize = 6;

/// A number of each of eight bonds.
pub type Eight = [f64; LANES];

/// The cylinder that a bond is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondShape {
    /// Radius r_b, m.
    pub radius: f64,
    /// Length l, m: the distance of the centres of its pieces when it was made.
    pub length: f64,
}

impl BondShape {
    /// Area of the cross section, `pi r_b^2`, m2.
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.radius * self.radius
    }

    /// Second moment of area I, `pi/4 r_b^4`, m4; the polar one J is twice as large.
    pub fn second_moment(&self) -> f64 {
        0.25 * std::f64::consts::PI * self.radius.powi(4)
    }

    /// Volume `A l`, m3.
    pub fn volume(&self) -> f64 {
        self.area() * self.length
    }
}

/// The four stiffnesses of a bond.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BondStiffness {
    /// Force over stretch, N/m.
    pub normal: f64,
    /// Force over shear displacement, N/m.
    pub shear: f64,
    /// Couple over bending angle, N m.
    pub bending: f64,
    /// Couple over angle of twist, N m.
    pub twisting: f64,
}

/// The loads that eight bonds carry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BondLoads {
    /// Tension, N: negative where the bond is compressed.
    pub tension: Eight,
    /// Magnitude of the shear force, N.
    pub shear: Eight,
    /// Magnitude of the bending couple, N m.
    pub bending: Eight,
    /// Magnitude of the twisting couple, N m.
    pub twisting: Eight,
}

/// A criterion of granum's own laws, which the engine evaluates for eight bonds at once in place of asking [`BondLaw::utilisation`]. Its formula
/// stands in the file of the law, once for one bond and for eight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Criterion {
    /// The law is asked.
    #[default]
    OfLaw,
    /// Stresses at the edge of a cylinder over its strengths, as of parallel bonds.
    MohrCoulomb,
    /// Loads over their limits, added up.
    Additive,
}

/// The ratios of eight bonds by a formula for one: of the loads tension, shear, bending and twist and the constants of the law.
pub(super) fn each_of_eight(
    loads: &BondLoads,
    limits: &[Eight; LIMITS],
    of: fn([f64; 4], [f64; LIMITS]) -> [f64; 2],
) -> [Eight; 2] {
    let mut ratios = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        let of_one = [&loads.tension, &loads.shear, &loads.bending, &loads.twisting].map(|load| load[lane]);
        [ratios[0][lane], ratios[1][lane]] = of(of_one, limits.map(|row| row[lane]));
    }
    ratios
}

/// The least energy, J, of springs whose loads, each times a weight, add up to a limit: with pairs of stiffness k and weight w
/// `limit^2 / (2 sum of w^2 k)`, by the inequality of Cauchy and Schwarz.
pub(super) fn least_energy(limit: f64, springs: &[[f64; 2]]) -> f64 {
    let compliance: f64 = springs.iter().map(|[stiffness, weight]| weight * weight * stiffness).sum();
    let energy = 0.5 * limit * limit / compliance;
    // Without any limit, or with numbers beyond those that a computer has, nothing can be said.
    if limit > 0.0 && !energy.is_nan() { energy } else { 0.0 }
}

/// A law of bonds, in a file of its own. The engine turns the frames of bonds, multiplies by the stiffnesses, keeps the energies and takes
/// ruptured bonds away; a law says how stiff and how strong a bond is.
///
/// ```
/// use granum_dem::bond::{BondLaw, BondLoads, BondShape, BondStiffness, Eight, LIMITS};
/// use granum_dem::contact::{LawDescription, LawParameter, Unit};
///
/// /// A thread: it carries tension alone, up to a strength.
/// #[derive(Debug)]
/// struct Thread;
///
/// const PARAMETERS: &[LawParameter] = &[
///     LawParameter::new("modulus", Unit::STRESS, 1e9, [1.0, f64::INFINITY], "Modulus of the thread."),
///     LawParameter::new("tensile_strength", Unit::STRESS, 1e6, [0.0, f64::INFINITY], "Stress that tears it."),
/// ];
///
/// impl BondLaw for Thread {
///     fn description(&self) -> &'static LawDescription {
///         const { &LawDescription::new("thread", "thread", "a thread that tears", PARAMETERS) }
///     }
///     fn stiffness(&self, shape: &BondShape, parameters: &[f64]) -> BondStiffness {
///         let normal = parameters[0] * shape.area() / shape.length;
///         BondStiffness { normal, ..BondStiffness::default() }
///     }
///     fn limits(&self, shape: &BondShape, parameters: &[f64], strength: f64) -> [f64; LIMITS] {
///         [parameters[1] * strength * shape.area(), 0.0, 0.0, 0.0, 0.0, 0.0]
///     }
///     fn utilisation(&self, loads: &BondLoads, limits: &[Eight; LIMITS]) -> [Eight; 2] {
///         [std::array::from_fn(|lane| loads.tension[lane] / limits[0][lane]), [0.0; 8]]
///     }
/// }
/// ```
pub trait BondLaw: Debug + Send + Sync {
    /// Its name, help and parameters, of which every `[[bond]]` of a case can give values.
    fn description(&self) -> &'static LawDescription;
    /// The stiffnesses of a bond, from the values of the parameters in the order of the description. A stiffness in tension of zero is
    /// refused.
    fn stiffness(&self, shape: &BondShape, parameters: &[f64]) -> BondStiffness;
    /// What [`BondLaw::utilisation`] needs of a bond. Strengths are those of the parameters times `strength`, the bond's own factor.
    fn limits(&self, shape: &BondShape, parameters: &[f64], strength: f64) -> [f64; LIMITS];
    /// How near eight bonds are to rupture by tension and by shear: a bond ruptures where one of the two reaches one, and the larger names
    /// how. Only sums, products, quotients, square roots and comparisons may be used, so that results have the same bits everywhere.
    fn utilisation(&self, loads: &BondLoads, limits: &[Eight; LIMITS]) -> [Eight; 2];
    /// An energy, J, that a bond which ruptures has at least stored, not counting what is stored in compression: `F_n^2 / 2 k_n` in tension,
    /// `F_s^2 / 2 k_s`, `M_b^2 / 2 k_b` and `M_t^2 / 2 k_t`. Bonds that have stored less are not judged. With zero every bond is judged in every
    /// step.
    fn least_energy_at_rupture(&self, _stiffness: &BondStiffness, _limits: &[f64; LIMITS]) -> f64 {
        0.0
    }
    /// The criterion, if it is one that the engine evaluates itself.
    fn criterion(&self) -> Criterion {
        Criterion::OfLaw
    }
}
