//! A user-defined contact law with a parameter, a memory and an energy channel: spheres on an elastic foundation (Winkler), whose
//! pressure at each point is proportional to the local displacement, with asperities that are crushed by the first loading.
//!
//! With the foundation modulus `kappa E*/R*` and `K = pi kappa E*`, first loading has the force `N = K alpha^2` (Johnson 1985, section
//! 4.3). Below the largest overlap m so far it is `N = K alpha^3 / m`: the contact stores `K alpha^4 / 4 m`, and of the work
//! `K m^3 / 3` of first loading, `K m^3 / 12` has been lost where asperities were crushed.

use granum::law::*;
use granum::prelude::*;

#[derive(Clone, Copy)]
struct CrushedFoundation;

law_constants! {
    /// What is prepared for a pair.
    pub struct CrushedFoundationConstants<R> {
        /// `K = pi kappa E*`, Pa.
        modulus: R,
        /// `2 R*`, m.
        diameter: R,
    }
}

/// What is remembered: the largest overlap, m.
const LARGEST: usize = 0;
/// The place of the energy lost by crushing among the channels.
const CRUSHING: usize = 0;

impl NormalLaw for CrushedFoundation {
    const DESCRIPTION: LawDescription = LawDescription::new(
        "crushed-foundation",
        "elastic foundation that is crushed",
        "spheres on an elastic foundation (Winkler) with asperities that are crushed by the first loading",
        &[LawParameter::new(
            "foundation_modulus",
            Unit::NUMBER,
            1.0,
            [0.01, 100.0],
            "Modulus of the foundation over E*/R*",
        )],
    );
    type Constants<R: Real> = CrushedFoundationConstants<R>;
    const CHANNELS: &'static [EnergyChannel] = &[EnergyChannel::dissipated(
        "crushing_loss",
        "crushed asperities",
        "energy lost where asperities are crushed",
    )];
    const HISTORY: usize = 1;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> CrushedFoundationConstants<f64> {
        let modulus = std::f64::consts::PI * parameters[0] * pair.effective_modulus;
        CrushedFoundationConstants { modulus, diameter: 2.0 * pair.effective_radius }
    }

    /// First loading.
    #[inline(always)]
    fn evaluate<R: Real>(c: &CrushedFoundationConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
        let (zero, energies) = (R::zero(), &mut [R::zero(); 2]);
        Self::update(c, overlap, touched, &mut [zero; MAX_NORMAL_HISTORY], energies)
    }

    #[inline(always)]
    fn update<R: Real>(
        c: &CrushedFoundationConstants<R>,
        overlap: R,
        _touched: R::Mask,
        history: &mut [R; MAX_NORMAL_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Normal<R> {
        let (alpha, before) = (overlap.max(R::zero()), history[LARGEST]);
        let largest = before.max(alpha);
        history[LARGEST] = largest;
        let cube = |x: R| x * x * x;
        energies[CRUSHING] = c.modulus * (cube(largest) - cube(before)) * R::splat(1.0 / 12.0);
        let share = alpha / largest.max(R::splat(1e-200));
        let force = c.modulus * alpha * alpha * share;
        let stiffness = R::splat(3.0) * c.modulus * alpha * share;
        let radius = (c.diameter * alpha).sqrt();
        Normal {
            force,
            radius,
            stiffness,
            root_stiffness: stiffness.sqrt(),
            tangential_measure: radius,
            root_tangential_measure: radius.sqrt(),
            friction_load: force,
            touching: alpha.gt(R::zero()),
        }
    }

    fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
        let c = Self::prepare(pair, parameters);
        Self::evaluate(&c, (load / c.modulus).sqrt(), true)
    }

    /// What first loading stores.
    fn energy<R: Real>(c: &CrushedFoundationConstants<R>, overlap: R) -> R {
        let alpha = overlap.max(R::zero());
        R::splat(0.25) * c.modulus * alpha * alpha * alpha
    }

    fn stored<R: Real>(
        c: &CrushedFoundationConstants<R>,
        overlap: R,
        history: &[R; MAX_NORMAL_HISTORY],
    ) -> R {
        let alpha = overlap.max(R::zero());
        let share = alpha / history[LARGEST].max(R::splat(1e-200));
        R::splat(0.25) * c.modulus * alpha * alpha * alpha * share
    }
}

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Case files that are read with this registry can refer to the law by its name, and its energy channel is a column of their series.
    let registry = Registry::standard().with_law(NormalKind::new(&CrushedFoundation))?;
    let case = registry.parse_case(
        "grains.count = 150\ngrains.material.interface_energy = 0\ncontact.normal = \"crushed-foundation\"\n\
         contact.tangential = \"no-slip\"\npreparation.solid_fraction = \"none\"\npreparation.unbalanced_force = 0.01\n\
         shear.deviator_strain = 0.03\nshear.inertial_number = 0.005\nrecording.states = 6",
        "case",
    )?;
    let test = Laboratory::here().with_registry(registry).test(&case)?;
    let [ratio, work, crushing] =
        test.record.series.select(["stress_ratio", "boundary_work", "crushing_loss"])?;
    println!("q/p: {ratio:.3?}");
    assert!(ratio.iter().any(|ratio| *ratio > 0.3));
    let share = crushing[crushing.len() - 1] / work[work.len() - 1];
    println!("{:.1} % of the work crushed asperities", 100.0 * share);
    assert!(share > 0.01);
    // What the law puts into its channel is a part of the energy balance: without it the gap would be as large as this share.
    let gap = test.about.quality.iter().find(|flag| flag.name == "energy_gap").map_or(1.0, |flag| flag.value);
    println!("gap of the energy balance: {:.2} %", 100.0 * gap);
    assert!(gap < 0.3 * share && gap < 0.01);
    Ok(())
}
