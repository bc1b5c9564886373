//! Verification of every pair of laws, through the function that the engine runs.

mod energy;
mod friction;
mod lanes;
mod objectivity;
mod peeling;
mod tables;

use super::interaction::{Interaction, Kinematics, Memory, dot, interact};
use super::{NormalLaw, PairConstants, PairProperties, TangentialLaw};
use crate::config::Material;

/// Spheres of the default material, d = 0.1 mm, with an interface energy, J/m2.
fn spheres(interface_energy: f64) -> PairProperties {
    let material = Material { interface_energy, ..Material::default() };
    PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0)
}

/// A pair held in place in a fixed direction, its surfaces moved by hand.
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
        let constants = PairConstants::new::<N, T>(&pair);
        Bench { pair, constants, memory: Memory::new(), laws: std::marker::PhantomData }
    }

    /// One step to an approach, with increments along two directions across the normal.
    fn step(&mut self, approach: f64, slip: [f64; 2]) -> Interaction<f64> {
        let distance = self.pair.radius_sum - approach;
        let kinematics = Kinematics {
            branch: NORMAL.map(|n| n * distance),
            velocity: std::array::from_fn(|a| slip[0] * FIRST[a] + slip[1] * SECOND[a]),
            rolling: [0.0; 3],
            mean_spin: [0.0; 3],
        };
        interact::<f64, N, T>(&self.constants, &kinematics, 1.0, &mut self.memory)
    }
}

/// Tangential force along the two directions.
fn tangential(out: &Interaction<f64>) -> [f64; 2] {
    [dot(out.elastic, FIRST), dot(out.elastic, SECOND)]
}

/// Runs a check for every pair of laws.
macro_rules! every_pair_of_laws {
    ($check:expr) => {
        for (normal, tangential) in crate::contact::registry::ALL {
            crate::contact::registry::with_law(normal, tangential, $check);
        }
    };
}
use every_pair_of_laws;
