//! Elastic-plastic adhesive contact with linear branches (Luding 2008, Granular Matter 10, 235-246).
//!
//! The history of a contact contains its largest overlap m. With the stiffnesses `k_1` of first loading, `k_p` of the hardest
//! unloading and `k_c` of cohesion, and the overlap `m_p = k_p/(k_p - k_1) phi_f 2 R*` beyond which the unloading stiffness no
//! longer increases,
//!
//! - unloading stiffness `k_2 = k_1 + (k_p - k_1) min(m, m_p)/m_p`, plastic overlap `d_0 = (1 - k_1/k_2) min(m, m_p)`,
//! - force `N = k_2 (alpha - d_0)`, which is `k_1 alpha` at first loading up to m_p,
//! - but at least `-k_c alpha`. Where this bound applies, m is reduced so that both expressions agree:
//!   `s m^2 - s alpha m - (k_1 + k_c) alpha = 0` with `s = (k_p - k_1)/m_p`. (Codes that adjust m with the stiffness of the
//!   previous step converge to this for small steps.)
//!
//! The pair touches where `alpha > 0`; the force vanishes continuously at `alpha = 0`, and the history is discarded with the contact.
//!
//! The energy `N^2/2 k_2`, which is recovered when the force is brought to zero, is stored; the rest of the work `int N dalpha`,
//! by the trapezoidal rule over a step, is lost by plastic deformation, also on the cohesive branch. Friction is limited by the
//! load `F = N + k_c alpha`, as in the paper. The tangential stiffness is a fraction of `k_2`, which is also the stiffness for
//! the dashpot and for the time step.

use granum_simd::{Mask, Real};

use super::hooke::NORMAL_STIFFNESS;
use crate::contact::law::description::{LawDescription, LawParameter, Mixing, Unit};
use crate::contact::law::energy_channel::{EnergyChannel, LawEnergies};
use crate::contact::law::limits::{LAW_CHANNELS, MAX_NORMAL_HISTORY};
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{Normal, NormalLaw};
use crate::law_constants;

/// Luding (2008).
#[derive(Clone, Copy, Debug)]
pub struct Luding;

law_constants! {
    /// Constants of the elastic-plastic contact of Luding for a pair.
    pub struct LudingConstants<R> {
        /// `k_1`, N/m.
        pub first_loading: R,
        /// `k_p - k_1`, N/m.
        pub hardening: R,
        /// `k_c`, N/m.
        pub cohesion: R,
        /// `m_p`, m.
        pub plastic_limit: R,
        /// `(k_1 + k_c) / s`, m.
        pub shrinking: R,
        /// `1 / m_p`, 1/m.
        pub inverse_plastic_limit: R,
    }
}

/// Columns of the history: largest overlap, overlap and force of the last step.
const MOST: usize = 0;
const BEFORE: usize = 1;
const FORCE: usize = 2;

/// Place of the energy lost by plastic deformation among the channels.
const PLASTIC: usize = 0;

fn constants(first: f64, hardest: f64, cohesion: f64, largest: f64) -> LudingConstants<f64> {
    LudingConstants {
        first_loading: first,
        hardening: hardest - first,
        cohesion,
        plastic_limit: largest,
        shrinking: (first + cohesion) * largest / (hardest - first),
        inverse_plastic_limit: 1.0 / largest,
    }
}

/// Stiffness `k_2` and the force that it gives at an overlap, with the largest overlap m.
#[inline(always)]
fn elastic<R: Real>(c: &LudingConstants<R>, overlap: R, most: R) -> [R; 2] {
    let most = most.min(c.plastic_limit);
    let harder = c.hardening * (most * c.inverse_plastic_limit);
    let stiffness = c.first_loading + harder;
    // k_2 d_0 = (k_2 - k_1) m.
    [stiffness, stiffness.mul_add(overlap, -(harder * most))]
}

impl NormalLaw for Luding {
    type Constants<R: Real> = LudingConstants<R>;
    const DESCRIPTION: LawDescription = LawDescription {
        name: "luding",
        label: "elastic-plastic with cohesion (Luding 2008)",
        help: "elastic-plastic and adhesive, linear, with memory of the largest overlap: Luding 2008",
        parameters: &[
            NORMAL_STIFFNESS,
            LawParameter {
                key: "unloading_ratio",
                unit: Unit::NUMBER,
                default: 5.0,
                bounds: [1.001, 1000.0],
                meaning: "Stiffness k_p of the hardest unloading over that of first loading, contact.normal_stiffness",
                without_area: false,
                mixing: Mixing::Geometric,
            },
            LawParameter {
                key: "cohesion_ratio",
                unit: Unit::NUMBER,
                default: 0.2,
                bounds: [0.0, 1000.0],
                meaning: "Stiffness k_c of the branch of cohesion over that of first loading; 0 for no cohesion",
                without_area: false,
                mixing: Mixing::Geometric,
            },
            LawParameter {
                key: "plasticity_depth",
                unit: Unit::NUMBER,
                default: 0.05,
                bounds: [1e-6, 0.5],
                meaning: "Plastic overlap phi_f beyond which contacts are elastic, over 2 R_i R_j / (R_i + R_j)",
                without_area: false,
                mixing: Mixing::Geometric,
            },
        ],
    };
    const CONTACT_AREA: bool = false;
    const ADHESIVE: bool = true;
    const CHANNELS: &'static [EnergyChannel] = &[EnergyChannel::dissipated(
        "plastic_loss",
        "plastic deformation",
        "energy lost by plastic deformation of contacts",
    )
    .measured_by("plasticity")];
    const HISTORY: usize = 3;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> LudingConstants<f64> {
        let [first, ratio, cohesion, depth] = [parameters[0], parameters[1], parameters[2], parameters[3]];
        let largest = ratio / (ratio - 1.0) * depth * 2.0 * pair.effective_radius;
        constants(first, first * ratio, first * cohesion, largest)
    }

    /// The first loading.
    #[inline(always)]
    fn evaluate<R: Real>(c: &LudingConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
        let energies = &mut [R::zero(); LAW_CHANNELS];
        Luding::update(c, overlap, touched, &mut [R::zero(); MAX_NORMAL_HISTORY], energies)
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &LudingConstants<R>,
        overlap: R,
        _touched: R::Mask,
        history: &mut [R; MAX_NORMAL_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Normal<R> {
        let (zero, half) = (R::zero(), R::splat(0.5));
        let alpha = overlap.max(zero);
        let touching = alpha.gt(zero);
        let most = history[MOST].max(alpha);
        let [mut stiffness, mut force] = elastic(c, alpha, most);
        let mut kept = most;
        let least = -(c.cohesion * alpha);
        let cohesive = force.lt(least) & touching;
        if cohesive.any() {
            let middle = half * alpha;
            let shrunk = middle + middle.mul_add(middle, c.shrinking * alpha).sqrt();
            kept = R::select(cohesive, shrunk.min(most), most);
            stiffness = R::select(cohesive, elastic(c, alpha, kept)[0], stiffness);
            force = R::select(cohesive, least, force);
        }
        let (force, stiffness) = (force.keep(touching), stiffness.keep(touching));
        let work = half * (history[FORCE] + force) * (alpha - history[BEFORE]);
        let stiffness_before = elastic(c, history[BEFORE], history[MOST])[0];
        let stored_before = half * history[FORCE] * history[FORCE] / stiffness_before;
        let stored = half * force * force / stiffness.max(c.first_loading);
        energies[PLASTIC] = work - (stored - stored_before);
        (history[MOST], history[BEFORE], history[FORCE]) = (kept, alpha, force);
        let root_stiffness = stiffness.sqrt();
        Normal {
            force,
            radius: zero,
            stiffness,
            root_stiffness,
            tangential_measure: stiffness,
            root_tangential_measure: root_stiffness,
            friction_load: c.cohesion.mul_add(alpha, force).max(zero),
            touching,
        }
    }

    fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
        let c = Self::prepare(pair, parameters);
        let load = load.max(f64::MIN_POSITIVE);
        let soft = load / c.first_loading;
        // Beyond m_p with k_p from d_0.
        let hard = (load + c.hardening * c.plastic_limit) / (c.first_loading + c.hardening);
        Self::evaluate(&c, if soft < c.plastic_limit { soft } else { hard }, true)
    }

    /// Energy stored in the first loading.
    #[inline(always)]
    fn energy<R: Real>(c: &LudingConstants<R>, overlap: R) -> R {
        let n = Self::evaluate(c, overlap, R::Mask::splat(true));
        (R::splat(0.5) * n.force * n.force / n.stiffness).keep(n.touching)
    }

    /// `N^2 / 2 k_2`.
    #[inline(always)]
    fn stored<R: Real>(c: &LudingConstants<R>, _overlap: R, history: &[R; MAX_NORMAL_HISTORY]) -> R {
        let [stiffness, _] = elastic(c, history[BEFORE], history[MOST]);
        R::splat(0.5) * history[FORCE] * history[FORCE] / stiffness
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ContactModel, Material, NormalKind, TangentialKind};
    use crate::contact::impact::collision::collide;

    fn near(found: f64, wanted: f64) {
        assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
    }

    /// k_1 = 1, k_p = 5, k_c = 1, m_p = 0.0625: overlap, force, largest overlap.
    #[test]
    fn a_path_is_that_of_the_paper() {
        let c = constants(1.0, 5.0, 1.0, 0.0625);
        let mut history = [0.0; MAX_NORMAL_HISTORY];
        for (overlap, force, most) in [
            (0.04, 0.04, 0.04),
            (0.02, -0.02, 0.036_925_824),
            (0.01, -0.01, 0.023_371_173_1),
            (0.03, 0.03, 0.03),
            (0.08, 0.15, 0.08),
            (0.05, 0.0, 0.08),
            (0.02, -0.02, 0.036_925_824),
            (0.005, -0.005, 0.015_247_548_8),
            (0.012, 0.008_830_901_9, 0.015_247_548_8),
        ] {
            let n = Luding::update(&c, overlap, true, &mut history, &mut [0.0; LAW_CHANNELS]);
            near(n.force, force);
            near(history[MOST], most);
            near(n.friction_load, force + overlap);
            // The contact at rest is the same.
            let again = Luding::update(&c, overlap, true, &mut { history }, &mut [0.0; LAW_CHANNELS]);
            near(again.force, force);
        }
        let n = Luding::update(&c, -0.001, true, &mut history, &mut [0.0; LAW_CHANNELS]);
        assert!(!n.touching && n.force == 0.0 && n.stiffness == 0.0);
        // k_2, d_0 and the overlap at which cohesion begins, for m = 0.04.
        let [stiffness, at_zero] = elastic(&c, 0.0, 0.04);
        near(stiffness, 3.56);
        near(-at_zero / stiffness, 0.028_764_044_943_8);
        near((stiffness - 1.0) / (stiffness + 1.0) * 0.04, 0.022_456_140_350_9);
    }

    /// Loading, unloading into cohesion, reloading and separation: the work is stored or lost, and no loss is negative.
    #[test]
    fn work_is_stored_or_lost() {
        let c = constants(1.0, 5.0, 1.0, 0.0625);
        let mut history = [0.0; MAX_NORMAL_HISTORY];
        let (mut work, mut lost, mut before) = (0.0, 0.0, (0.0, 0.0));
        let steps = 20_000;
        for [from, to] in [[0.0, 0.05], [0.05, 0.01], [0.01, 0.09], [0.09, 0.04], [0.04, -1e-4]] {
            for k in 1..=steps {
                let overlap: f64 = from + (to - from) * f64::from(k) / f64::from(steps);
                let mut energies = [0.0; LAW_CHANNELS];
                let n = Luding::update(&c, overlap, true, &mut history, &mut energies);
                let loss = energies[PLASTIC];
                let alpha = overlap.max(0.0);
                work += 0.5 * (n.force + before.1) * (alpha - before.0);
                before = (alpha, n.force);
                lost += loss;
                assert!(loss > -1e-11, "{overlap}: {loss:e}");
                let stored = Luding::stored(&c, overlap, &history);
                assert!((work - lost - stored).abs() < 1e-12, "{overlap}: {work} {lost} {stored}");
            }
        }
        assert!(history[FORCE] == 0.0 && (work / lost - 1.0).abs() < 1e-12 && lost > 1e-3, "{work} {lost}");
        // First loading to m_p: k_1 m^2/2 of work, of which N^2/2 k_p is stored.
        let stored = Luding::energy(&c, 0.0625);
        near(stored, 0.5 * 0.0625 * 0.0625 / 5.0);
    }

    /// Without cohesion the restitution of a contact that stays below m_p is (k_1/k_2)^(1/2); above it grows with the speed.
    #[test]
    fn restitution_falls_to_that_of_the_stiffnesses() {
        let mut contact = ContactModel::new(NormalKind::new(&Luding), TangentialKind::NO_SLIP, 0.0);
        for (key, value) in [
            ("normal_stiffness", 2e4),
            ("unloading_ratio", 4.0),
            ("cohesion_ratio", 0.0),
            ("plasticity_depth", 1e-3),
        ] {
            contact.parameters.set(key, value).unwrap();
        }
        let (diameter, material) = (1e-4, Material::default());
        let pair = PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0);
        let largest = 4.0 / 3.0 * 1e-3 * 2.0 * pair.effective_radius;
        let share = 0.5;
        let speed = share * largest * (2e4 / pair.effective_mass).sqrt();
        let impact = collide(&contact, &material, diameter, speed, 0.0).unwrap();
        let expected = (1.0 / (1.0 + 3.0 * share)).sqrt();
        assert!((impact.restitution / expected - 1.0).abs() < 1e-3, "{} {expected}", impact.restitution);
    }
}
