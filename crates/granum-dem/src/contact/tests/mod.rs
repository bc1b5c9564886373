//! Verification of every pair of laws, through the function that the engine uses.

mod energy;
mod friction;
mod lanes;
mod objectivity;
mod peeling;
mod rolling;
mod tables;
mod twisting;

use super::interaction::{Interaction, Kinematics, Memory, dot, interact};
use super::law;
use super::normal::{Dmt, Hertz, Hooke, Jkr, JkrDmt, Luding, RoughHertz};
use super::rolling::{ElasticPlasticRolling, ElasticPlasticTwisting, NoMoments};
use super::set::Compiled;
use super::tangential::{MindlinDeresiewicz, NoSlip, Peeling};
use crate::contact::constants::PairConstants;
use crate::contact::kind::{NormalKind, TangentialKind};
use crate::contact::law::{Description, MomentLaw, NormalLaw, NormalTraits, TangentialLaw};
use crate::contact::pair_properties::PairProperties;
use crate::material::Material;

/// Spheres of the default material, d = 0.1 mm, with an interface energy, J/m2.
fn spheres(interface_energy: f64) -> PairProperties {
    let material = Material { interface_energy, ..Material::default() };
    PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0)
}

/// A pair in a fixed direction whose approach and slip are prescribed.
struct Bench<N, T> {
    pair: PairProperties,
    constants: PairConstants<f64>,
    memory: Memory<f64>,
    laws: std::marker::PhantomData<(N, T)>,
}

const NORMAL: [f64; 3] = [0.267_261_241_912_424_4, 0.534_522_483_824_848_8, 0.801_783_725_737_273_2];
const FIRST: [f64; 3] = [0.872_871_560_943_969_5, 0.218_217_890_235_992_4, -0.436_435_780_471_984_7];
const SECOND: [f64; 3] = [-0.408_248_290_463_863, 0.816_496_580_927_726, -0.408_248_290_463_863];

impl<N: NormalLaw, T: TangentialLaw> Bench<N, T> {
    fn new(pair: PairProperties) -> Self {
        let constants = constants::<N, T, NoMoments>(&pair);
        Bench { pair, constants, memory: Memory::new(), laws: std::marker::PhantomData }
    }

    /// One step to an approach, with slip increments in two directions perpendicular to the normal.
    fn step(&mut self, approach: f64, slip: [f64; 2]) -> Interaction<f64> {
        let distance = self.pair.radius_sum - approach;
        let kinematics = Kinematics {
            branch: NORMAL.map(|n| n * distance),
            velocity: std::array::from_fn(|a| slip[0] * FIRST[a] + slip[1] * SECOND[a]),
            rolling: [0.0; 3],
            mean_spin: [0.0; 3],
            relative_spin: [0.0; 3],
        };
        interact(&Compiled::<N, T>::new(), &self.constants, &kinematics, 1.0, &mut self.memory)
    }
}

/// Tangential force along the two directions.
fn tangential(out: &Interaction<f64>) -> [f64; 2] {
    [dot(out.elastic, FIRST), dot(out.elastic, SECOND)]
}

/// The defaults of a law's parameters.
fn defaults(description: &Description) -> Vec<f64> {
    description.parameters.iter().map(|parameter| parameter.default).collect()
}

/// The constants of a pair for laws with their default parameters.
fn constants<N: NormalLaw, T: TangentialLaw, M: MomentLaw>(pair: &PairProperties) -> PairConstants<f64> {
    let [n, t, m] = [&N::DESCRIPTION, &T::DESCRIPTION, &M::DESCRIPTION].map(defaults);
    Compiled::<N, T, M>::constants(pair, [&n, &t, &m, &[]])
}

/// The traits of a normal law with a contact area and without adhesion.
const PLAIN: NormalTraits = NormalTraits { name: "hertz", contact_area: true, adhesive: false };

/// An operation on a pair of laws, compiled for each pair.
trait LawVisitor {
    /// What it returns.
    type Output;
    /// Executes it with the normal law `N` and the tangential law `T`.
    fn visit<N: NormalLaw, T: TangentialLaw>(self) -> Self::Output;
}

/// Every pair of laws that can be used together.
const ALL: [(NormalKind, TangentialKind); 13] = [
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

/// The pairs of laws that the engine compiles into loops of their own.
const COMPILED: [(NormalKind, TangentialKind); 5] = [
    (NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ),
    (NormalKind::HERTZ, TangentialKind::NO_SLIP),
    (NormalKind::JKR, TangentialKind::MINDLIN_DERESIEWICZ),
    (NormalKind::JKR, TangentialKind::NO_SLIP),
    (NormalKind::JKR, TangentialKind::PEELING),
];

/// Runs the visitor with the laws of these names, which must be among [`COMPILED`].
fn with_compiled_law<V: LawVisitor>(normal: NormalKind, tangential: TangentialKind, visitor: V) -> V::Output {
    match (normal.name(), tangential.name()) {
        ("hertz", "mindlin-deresiewicz") => visitor.visit::<Hertz, MindlinDeresiewicz>(),
        ("hertz", "no-slip") => visitor.visit::<Hertz, NoSlip>(),
        ("jkr", "mindlin-deresiewicz") => visitor.visit::<Jkr, MindlinDeresiewicz>(),
        ("jkr", "no-slip") => visitor.visit::<Jkr, NoSlip>(),
        ("jkr", "peeling") => visitor.visit::<Jkr, Peeling>(),
        other => panic!("{other:?}"),
    }
}

/// Runs the visitor with the laws of these names.
fn with_law<V: LawVisitor>(normal: NormalKind, tangential: TangentialKind, visitor: V) -> V::Output {
    match (normal.name(), tangential.name()) {
        ("hooke", "no-slip") => visitor.visit::<Hooke, NoSlip>(),
        ("dmt", "mindlin-deresiewicz") => visitor.visit::<Dmt, MindlinDeresiewicz>(),
        ("dmt", "no-slip") => visitor.visit::<Dmt, NoSlip>(),
        ("jkr-dmt", "mindlin-deresiewicz") => visitor.visit::<JkrDmt, MindlinDeresiewicz>(),
        ("jkr-dmt", "no-slip") => visitor.visit::<JkrDmt, NoSlip>(),
        ("rough-hertz", "mindlin-deresiewicz") => visitor.visit::<RoughHertz, MindlinDeresiewicz>(),
        ("rough-hertz", "no-slip") => visitor.visit::<RoughHertz, NoSlip>(),
        ("luding", "no-slip") => visitor.visit::<Luding, NoSlip>(),
        _ => with_compiled_law(normal, tangential, visitor),
    }
}

/// The list contains every pair of granum's laws that can be combined.
#[test]
fn no_pair_of_laws_is_left_out() {
    let sets = super::check::sets();
    for set in &sets {
        assert!(ALL.contains(&(set.normal, set.tangential)), "{:?} {:?}", set.normal, set.tangential);
    }
    assert_eq!(sets.iter().filter(|set| set.has_contact_only()).count(), ALL.len());
}

/// Runs a check for every pair of laws.
macro_rules! every_pair_of_laws {
    ($check:expr) => {
        for (normal, tangential) in $crate::contact::tests::ALL {
            $crate::contact::tests::with_law(normal, tangential, $check);
        }
    };
}
use every_pair_of_laws;
