//! Energy channels that laws of a caller declare, in the engine.

use granum_core::RegistrationError;
use granum_dem::Isa;
use granum_dem::assembly::EnergyBalance;
use granum_dem::config::{AdhesionKind, ContactModel, NormalKind, RollingKind, TangentialKind};
use granum_dem::contact::adhesion::CapillaryBridge;
use granum_dem::contact::choice::registry::Laws;
use granum_dem::contact::rolling::ElasticPlasticRolling;
use granum_dem::contact::tangential::NoSlip;
use granum_dem::contact::{
    AdhesionLaw, Attraction, EnergyChannel, LawDescription, LawEnergies, MAX_ADHESION_HISTORY, MAX_HISTORY,
    MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY, Moment, MomentLaw, Normal, NormalLaw, NormalTraits,
    PairProperties, RelativeSpin, Tangential, TangentialLaw,
};
use granum_dem::law_constants;
use granum_dem::simulation::{Hardware, Properties, Simulation};
use granum_simd::Real;

use crate::common;

/// A spring whose asperities are crushed: with the largest overlap m the force is `N = k alpha^2 / m`, the contact stores
/// `k alpha^3 / 3 m`, and `k m^2 / 6` is lost while m grows.
#[derive(Clone, Copy)]
struct Crushed;

law_constants! {
    /// Constants of a crushed contact.
    pub struct CrushedConstants<R> {
        /// k, N/m.
        stiffness: R,
        sixth: SixthOfStiffness<R>,
    }
}
law_constants! {
    /// One number, to have a struct in a struct.
    pub struct SixthOfStiffness<R> {
        /// k/6, N/m.
        value: R,
    }
}

const CRUSHED: usize = 0;
const STORED: usize = 1;

impl NormalLaw for Crushed {
    const DESCRIPTION: LawDescription = LawDescription::new("crushed", "crushed", "crushed asperities", &[]);
    type Constants<R: Real> = CrushedConstants<R>;
    const CHANNELS: &'static [EnergyChannel] = &[
        EnergyChannel::dissipated("crushing_loss", "crushing", "energy lost where asperities are crushed"),
        EnergyChannel::stored("twin_energy", "twin", "energy stored again, to have a second channel"),
    ];
    const CONTACT_AREA: bool = false;
    const HISTORY: usize = 1;

    fn prepare(_pair: &PairProperties, _parameters: &[f64]) -> CrushedConstants<f64> {
        CrushedConstants { stiffness: 2e4, sixth: SixthOfStiffness { value: 2e4 / 6.0 } }
    }
    fn evaluate<R: Real>(c: &CrushedConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
        let (history, energies) = (&mut [R::zero(); MAX_NORMAL_HISTORY], &mut [R::zero(); 2]);
        Crushed::update(c, overlap, touched, history, energies)
    }
    #[inline(always)]
    fn update<R: Real>(
        c: &CrushedConstants<R>,
        overlap: R,
        _touched: R::Mask,
        history: &mut [R; MAX_NORMAL_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Normal<R> {
        let alpha = overlap.max(R::zero());
        let before = history[0];
        let most = before.max(alpha);
        history[0] = most;
        energies[CRUSHED] = c.sixth.value * (most * most - before * before);
        energies[STORED] = R::splat(2.0) * energies[CRUSHED];
        let touching = alpha.gt(R::zero());
        let share = alpha / most.max(R::splat(1e-200));
        let stiffness = (R::splat(2.0) * c.stiffness * share).keep(touching);
        let force = c.stiffness * alpha * share;
        Normal {
            force,
            radius: R::zero(),
            stiffness,
            root_stiffness: stiffness.sqrt(),
            tangential_measure: stiffness,
            root_tangential_measure: stiffness.sqrt(),
            friction_load: force,
            touching,
        }
    }
    fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
        let c = Self::prepare(pair, parameters);
        Self::evaluate(&c, load / c.stiffness, true)
    }
    fn energy<R: Real>(c: &CrushedConstants<R>, overlap: R) -> R {
        let alpha = overlap.max(R::zero());
        R::splat(2.0) * c.sixth.value * alpha * alpha
    }
    fn stored<R: Real>(c: &CrushedConstants<R>, overlap: R, history: &[R; MAX_NORMAL_HISTORY]) -> R {
        let alpha = overlap.max(R::zero());
        let most = history[0].max(alpha).max(R::splat(1e-200));
        R::splat(2.0) * c.sixth.value * alpha * alpha * (alpha / most)
    }
}

/// granum's law, which puts the loss that it reports into a channel as well.
#[derive(Clone, Copy)]
struct Sliding;

impl TangentialLaw for Sliding {
    const DESCRIPTION: LawDescription =
        LawDescription::new("sliding", "sliding", "no-slip with a channel", NoSlip::DESCRIPTION.parameters);
    type Constants<R: Real> = <NoSlip as TangentialLaw>::Constants<R>;
    const CHANNELS: &'static [EnergyChannel] =
        &[EnergyChannel::dissipated("second_friction_loss", "friction", "energy lost by friction")];
    const HISTORY: usize = NoSlip::HISTORY;
    const PLANE_VECTORS: usize = NoSlip::PLANE_VECTORS;

    fn prepare(pair: &PairProperties, normal: &NormalTraits, parameters: &[f64]) -> Self::Constants<f64> {
        NoSlip::prepare(pair, normal, parameters)
    }
    fn stiffness<R: Real>(c: &Self::Constants<R>, normal: &Normal<R>) -> R {
        NoSlip::stiffness(c, normal)
    }
    #[inline(always)]
    fn update<R: Real>(
        c: &Self::Constants<R>,
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Tangential<R> {
        let out = NoSlip::update(c, normal, increment, history, energies);
        energies[0] = out.friction_loss;
        out
    }
}

/// The same for rolling.
#[derive(Clone, Copy)]
struct Rolling;

impl MomentLaw for Rolling {
    const DESCRIPTION: LawDescription = LawDescription::new(
        "rolling",
        "rolling",
        "elastic-plastic with a channel",
        ElasticPlasticRolling::DESCRIPTION.parameters,
    );
    type Constants<R: Real> = <ElasticPlasticRolling as MomentLaw>::Constants<R>;
    const CHANNELS: &'static [EnergyChannel] =
        &[EnergyChannel::dissipated("second_rolling_loss", "rolling", "energy lost by rolling")];
    const HISTORY: usize = ElasticPlasticRolling::HISTORY;
    const PLANE_VECTORS: usize = ElasticPlasticRolling::PLANE_VECTORS;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> Self::Constants<f64> {
        ElasticPlasticRolling::prepare(pair, parameters)
    }
    #[inline(always)]
    fn update<R: Real>(
        c: &Self::Constants<R>,
        normal: &Normal<R>,
        spin: RelativeSpin<R>,
        dt: R,
        history: &mut [R; MAX_MOMENT_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Moment<R> {
        let out = ElasticPlasticRolling::update(c, normal, spin, dt, history, energies);
        energies[0] = out.loss;
        out
    }
    fn energy(c: &Self::Constants<f64>, history: &[f64; MAX_MOMENT_HISTORY]) -> f64 {
        ElasticPlasticRolling::energy(c, history)
    }
}

/// The same for liquid bridges.
#[derive(Clone, Copy)]
struct Bridges;

impl AdhesionLaw for Bridges {
    const DESCRIPTION: LawDescription = LawDescription::new(
        "bridges",
        "bridges",
        "bridges with a channel",
        CapillaryBridge::DESCRIPTION.parameters,
    );
    type Constants<R: Real> = <CapillaryBridge as AdhesionLaw>::Constants<R>;
    const CHANNELS: &'static [EnergyChannel] =
        &[EnergyChannel::dissipated("second_rupture_loss", "rupture", "energy lost by ruptures")];
    const BEGINS_AT_TOUCH: bool = true;
    const HISTORY: usize = CapillaryBridge::HISTORY;

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> Self::Constants<f64> {
        CapillaryBridge::prepare(pair, parameters)
    }
    #[inline(always)]
    fn update<R: Real>(
        c: &Self::Constants<R>,
        overlap: R,
        touching: R::Mask,
        history: &mut [R; MAX_ADHESION_HISTORY],
        energies: &mut LawEnergies<R>,
    ) -> Attraction<R> {
        let out = CapillaryBridge::update(c, overlap, touching, history, energies);
        energies[0] = out.loss;
        out
    }
    fn energy(c: &Self::Constants<f64>, overlap: f64, history: &[f64; MAX_ADHESION_HISTORY]) -> f64 {
        CapillaryBridge::energy(c, overlap, history)
    }
    fn range(c: &Self::Constants<f64>) -> f64 {
        CapillaryBridge::range(c)
    }
}

fn all_four() -> ContactModel {
    let (normal, tangential) = (NormalKind::new(&Crushed), TangentialKind::new(&Sliding));
    let mut contact = ContactModel::new(normal, tangential, 0.1);
    contact.rolling = RollingKind::new(&Rolling);
    contact.adhesion = AdhesionKind::new(&Bridges);
    contact.parameters.set("bridge_volume", 1e-3).unwrap();
    contact
}

/// Grains that are pressed together and pulled apart.
fn sheared(hardware: Hardware) -> Simulation {
    let mut s = common::compressed(120, 0.2, Properties::new(super::plain(), all_four()), 1500, hardware);
    s.reset_phase(0.0);
    further(&mut s);
    s
}

fn further(s: &mut Simulation) {
    let mut control = common::growing(-2e4);
    control.rate[0][1] = 2e4;
    s.set_control(control);
    s.advance(400).unwrap();
    s.set_control(common::growing(2e4));
    s.advance(400).unwrap();
}

/// What a law puts into its channel is summed as its losses are, for laws of every kind, and does not depend on threads and
/// instruction sets.
#[test]
fn every_kind_of_law_has_channels() {
    let near = |found: f64, wanted: f64| {
        assert!(wanted > 0.0 && (found / wanted - 1.0).abs() < 1e-9, "{found:e} {wanted:e}");
    };
    let s = sheared(Hardware::default());
    let e = s.assembly().energy;
    near(e.channel("second_friction_loss"), e.friction);
    near(e.channel("second_rolling_loss"), e.rolling);
    near(e.channel("second_rupture_loss"), e.attraction_loss);
    near(e.channel("twin_energy"), 2.0 * e.channel("crushing_loss"));
    assert_eq!(e.channels.len(), 5);
    for (threads, isa) in [(2, Isa::detect()), (1, Isa::Portable)] {
        assert!(sheared(Hardware { threads, isa }).state() == s.state(), "{threads} threads, {isa:?}");
    }
}

/// The work of compression is stored or lost, with what is lost by crushing.
#[test]
fn the_balance_includes_the_channel() {
    let contact = ContactModel::new(NormalKind::new(&Crushed), TangentialKind::NO_SLIP, 0.1);
    let properties = Properties::new(super::plain(), contact);
    let mut s = common::compressed(150, 0.0, properties, 1500, Hardware::default());
    let sum = |e: &EnergyBalance| e.tangential_work + e.damping + e.channel("crushing_loss");
    s.reset_phase(0.0);
    let start: f64 = super::stored(&s.assembly())[..2].iter().sum();
    s.set_control(common::growing(-5e3));
    s.advance(1500).unwrap();
    let a = s.assembly();
    let end: f64 = super::stored(&a)[..2].iter().sum();
    let (work, e) = (a.energy.boundary_work, &a.energy);
    let gap = (work - (end - start) - sum(e)) / work;
    assert!(gap.abs() < 5e-3, "{gap}: {e:?}");
    assert!(e.channel("crushing_loss") > 0.05 * work, "{e:?}");
}

/// A checkpoint keeps all channels, and the run goes on to the same bits.
#[test]
fn a_checkpoint_keeps_the_channels() {
    let laws = Laws::standard().with(NormalKind::new(&Crushed)).unwrap();
    let laws = laws.with(TangentialKind::new(&Sliding)).unwrap().with(RollingKind::new(&Rolling)).unwrap();
    let laws = laws.with(AdhesionKind::new(&Bridges)).unwrap();
    let mut s = sheared(Hardware::default());
    let bytes = s.checkpoint("").unwrap();
    let mut restored = Simulation::restore_among(&bytes, &laws).unwrap().0;
    assert_eq!(restored.assembly().energy, s.assembly().energy);
    further(&mut s);
    further(&mut restored);
    assert_eq!(restored.assembly().energy, s.assembly().energy);
    assert!(restored.state() == s.state());
    let keys: Vec<&str> = laws.channels().iter().map(|channel| channel.key).collect();
    assert!(keys.contains(&"crushing_loss") && keys[0] == "plastic_loss");
}

/// Hertz's law with channels that it cannot have.
macro_rules! refused {
    ($name:ident, $channel:expr) => {
        #[derive(Clone, Copy)]
        struct $name;
        impl NormalLaw for $name {
            const DESCRIPTION: LawDescription = LawDescription::new(stringify!($name), "", "", &[]);
            type Constants<R: Real> = CrushedConstants<R>;
            const CHANNELS: &'static [EnergyChannel] = &[$channel];
            fn prepare(pair: &PairProperties, parameters: &[f64]) -> CrushedConstants<f64> {
                Crushed::prepare(pair, parameters)
            }
            fn evaluate<R: Real>(c: &CrushedConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
                Crushed::evaluate(c, overlap, touched)
            }
            fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
                Crushed::loaded(pair, parameters, load)
            }
            fn energy<R: Real>(c: &CrushedConstants<R>, overlap: R) -> R {
                Crushed::energy(c, overlap)
            }
        }
    };
}
refused!(SameKey, EnergyChannel::dissipated("plastic_loss", "other", "energy of another meaning"));
refused!(TakenKey, EnergyChannel::dissipated("friction_loss", "friction", "energy lost by friction"));
refused!(BadKey, EnergyChannel::stored("fracture_loss", "fracture", "energy that is stored"));

#[test]
fn channels_with_bad_keys_are_refused() {
    let refused = |law: NormalKind| Laws::standard().with(law).unwrap_err();
    for (law, key) in
        [(NormalKind::new(&SameKey), "plastic_loss"), (NormalKind::new(&TakenKey), "friction_loss")]
    {
        let (what, name) = ("normal law", law.name());
        assert_eq!(refused(law), RegistrationError::key_taken(what, name, "energy channel", key));
    }
    let error = refused(NormalKind::new(&BadKey));
    assert!(matches!(&error, RegistrationError::Key { key, .. } if key == "fracture_loss"), "{error}");
    assert!(error.to_string().contains("\"energy\" where it is stored"), "{error}");
}
