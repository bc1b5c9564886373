//! Verification of every pair of laws, through the function that the engine uses.

mod energy;
mod friction;
mod lanes;
mod objectivity;
mod observed;
mod peeling;
mod rolling;
mod rounding;
mod spring_dashpot_slider;
mod tables;
mod twisting;

use crate::contact::choice::contact_model::ContactModel;
use crate::contact::choice::kind::{NormalKind, TangentialKind};
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::interaction::{Interaction, PairMotion, interact};
use crate::contact::evaluation::memory::Memory;
use crate::contact::evaluation::set::Compiled;
use crate::contact::law::description::LawDescription;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::law::{MomentLaw, NormalLaw, NormalTraits, TangentialLaw};
use crate::contact::normal::{Hertz, Jkr};
use crate::contact::rolling::{ElasticPlasticRolling, ElasticPlasticTwisting, SpringDashpotSlider};
use crate::contact::slot::columns::One;
use crate::contact::slot::slots::{Open, Slots};
use crate::contact::tangential::{MindlinDeresiewicz, NoSlip, Peeling};
use crate::material::Material;
use granum_simd::Isa;
use granum_simd::vectors::dot;

/// Spheres of the default material, d = 0.1 mm, with an interface energy, J/m2.
fn spheres(interface_energy: f64) -> PairProperties {
    let material = Material { interface_energy, ..Material::default() };
    PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0)
}

/// A pair in a fixed direction whose overlap and slip are prescribed, with laws called through their slots.
struct Bench {
    contact: ContactModel,
    slots: Slots,
    pair: PairProperties,
    constants: PairConstants<f64>,
    memory: Memory<f64>,
}

const NORMAL: [f64; 3] = [0.267_261_241_912_424_4, 0.534_522_483_824_848_8, 0.801_783_725_737_273_2];
const FIRST: [f64; 3] = [0.872_871_560_943_969_5, 0.218_217_890_235_992_4, -0.436_435_780_471_984_7];
const SECOND: [f64; 3] = [-0.408_248_290_463_863, 0.816_496_580_927_726, -0.408_248_290_463_863];

impl Bench {
    fn new((normal, tangential): LawPair, pair: PairProperties) -> Self {
        let contact = ContactModel::new(normal, tangential, 0.0);
        let (slots, constants) = (Slots::new(&contact, Isa::Portable), contact.constants(&pair));
        Bench { contact, slots, pair, constants, memory: Memory::new() }
    }

    /// One step to an overlap, with slip increments in two directions perpendicular to the normal.
    fn step(&mut self, overlap: f64, slip: [f64; 2]) -> Interaction<f64> {
        let distance = self.pair.radius_sum - overlap;
        let kinematics = PairMotion {
            branch: NORMAL.map(|n| n * distance),
            velocity: std::array::from_fn(|a| slip[0] * FIRST[a] + slip[1] * SECOND[a]),
            rolling: [0.0; 3],
            mean_spin: [0.0; 3],
            relative_spin: [0.0; 3],
        };
        self.interact(&kinematics, 1.0)
    }

    /// One step with any motion.
    fn interact(&mut self, kinematics: &PairMotion<f64>, dt: f64) -> Interaction<f64> {
        interact(&Open::<One>::new(&self.slots), &self.constants, kinematics, dt, &mut self.memory)
    }

    /// The load that friction acts on at an overlap, N.
    fn friction_load(&self, overlap: f64) -> f64 {
        self.contact.normal_contact(&self.constants, overlap).friction_load
    }
}

/// Tangential force along the two directions.
fn tangential(out: &Interaction<f64>) -> [f64; 2] {
    [dot(out.elastic, FIRST), dot(out.elastic, SECOND)]
}

/// The defaults of a law's parameters.
fn defaults(description: &LawDescription) -> Vec<f64> {
    description.parameters.iter().map(|parameter| parameter.default).collect()
}

/// The constants of a pair for laws with their default parameters.
fn constants<N: NormalLaw, T: TangentialLaw, M: MomentLaw>(pair: &PairProperties) -> PairConstants<f64> {
    let [n, t, m] = [&N::DESCRIPTION, &T::DESCRIPTION, &M::DESCRIPTION].map(defaults);
    Compiled::<N, T, M>::constants(pair, [&n, &t, &m, &[]])
}

/// The traits of a normal law with a contact area and without adhesion.
const PLAIN: NormalTraits = NormalTraits { name: "hertz", contact_area: true, adhesive: false };

/// A normal law and a tangential law.
type LawPair = (NormalKind, TangentialKind);

/// Every pair of laws that can be used together.
const ALL: [LawPair; 13] = [
    (NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ),
    (NormalKind::HERTZ, TangentialKind::NO_SLIP),
    (NormalKind::JKR, TangentialKind::MINDLIN_DERESIEWICZ),
    (NormalKind::JKR, TangentialKind::NO_SLIP),
    (NormalKind::JKR, TangentialKind::PEELING),
    (NormalKind::HOOKE, TangentialKind::NO_SLIP),
    (NormalKind::DMT, TangentialKind::MINDLIN_DERESIEWICZ),
    (NormalKind::DMT, TangentialKind::NO_SLIP),
    (NormalKind::JKR_DMT, TangentialKind::MINDLIN_DERESIEWICZ),
    (NormalKind::JKR_DMT, TangentialKind::NO_SLIP),
    (NormalKind::ROUGH_HERTZ, TangentialKind::MINDLIN_DERESIEWICZ),
    (NormalKind::ROUGH_HERTZ, TangentialKind::NO_SLIP),
    (NormalKind::LUDING, TangentialKind::NO_SLIP),
];

/// The list contains every pair of granum's laws that can be combined.
#[test]
fn no_pair_of_laws_is_left_out() {
    let sets = crate::contact::choice::check::sets();
    for set in &sets {
        assert!(ALL.contains(&(set.normal, set.tangential)), "{:?} {:?}", set.normal, set.tangential);
    }
    assert_eq!(sets.iter().filter(|set| set.has_contact_only()).count(), ALL.len());
}
