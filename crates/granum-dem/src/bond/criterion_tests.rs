//! Bonds are judged alike one by one and eight at a time, on every instruction set, and none ruptures that is not judged.

use granum_core::cell::Cell;
use granum_simd::{Isa, Kernel, Lanes, dispatch};

use super::bonding::Bonding;
use super::bonds::column::ARMS;
use super::law::additive::sum_of_ratios;
use super::law::bond_law::{BondLaw, BondLoads, BondShape, BondStiffness, Criterion, Eight, LIMITS};
use super::law::kind::BondKind;
use super::law::parallel::stresses_over_strengths;
use crate::config::{ContactModel, Material};
use crate::properties::Properties;
use crate::simulation::{InitialSphere, Simulation};

struct Evaluate<'a>(Criterion, &'a BondLoads, &'a [Eight; LIMITS]);

impl Kernel for Evaluate<'_> {
    type Output = [Eight; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Eight; 2] {
        let Evaluate(criterion, of, limits) = self;
        let loads = [L::load(&of.tension), L::load(&of.shear), L::load(&of.bending), L::load(&of.twisting)];
        let limits = limits.map(
            #[inline(always)]
            |row| L::load(&row),
        );
        let ratios = match criterion {
            Criterion::Additive => sum_of_ratios(loads, limits),
            _ => stresses_over_strengths(loads, limits),
        };
        let mut out = [[0.0; 8]; 2];
        ratios[0].store(&mut out[0]);
        ratios[1].store(&mut out[1]);
        out
    }
}

#[test]
fn eight_bonds_are_judged_as_their_law_judges() {
    let mut x = 0.3f64;
    let mut next = || {
        x = (x * 997.0 + 0.618).fract();
        x
    };
    for kind in BondKind::OWN {
        let law: &dyn BondLaw = kind.law();
        for _ in 0..200 {
            let mut eight =
                |scale: f64, shift: f64| -> Eight { std::array::from_fn(|_| scale * (next() - shift)) };
            let loads = BondLoads {
                tension: eight(1.0, 0.5),
                shear: eight(1.0, 0.0),
                bending: eight(0.1, 0.0),
                twisting: eight(0.1, 0.0),
            };
            let limits: [Eight; LIMITS] = std::array::from_fn(|_| eight(2.0, 0.0));
            for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
                let found = dispatch(isa, Evaluate(law.criterion(), &loads, &limits));
                assert_eq!(found, law.utilisation(&loads, &limits), "{kind} {isa:?}");
            }
        }
    }
}

/// Energy of a bond under loads, J, without that of compression.
fn stored(k: &BondStiffness, [tension, shear, bending, twisting]: [f64; 4]) -> f64 {
    let of = |load: f64, stiffness: f64| 0.5 * load * load / stiffness;
    of(tension.max(0.0), k.normal) + of(shear, k.shear) + of(bending, k.bending) + of(twisting, k.twisting)
}

/// The largest of the two ratios of a bond.
fn ratio(law: &dyn BondLaw, limits: &[f64; LIMITS], [tension, shear, bending, twisting]: [f64; 4]) -> f64 {
    let loads = BondLoads {
        tension: [tension; 8],
        shear: [shear; 8],
        bending: [bending; 8],
        twisting: [twisting; 8],
    };
    let [by_tension, by_shear] = law.utilisation(&loads, &limits.map(|limit| [limit; 8]));
    by_tension[0].max(by_shear[0])
}

/// The loads of a bond that just ruptures, in a direction: by bisection, since the ratios are not linear in the loads.
fn at_rupture(law: &dyn BondLaw, limits: &[f64; LIMITS], direction: [f64; 4]) -> Option<[f64; 4]> {
    let scaled = |factor: f64| direction.map(|x| factor * x);
    let [mut holds, mut ruptures] = [0.0, 1e12];
    if ratio(law, limits, scaled(ruptures)) < 1.0 {
        return None;
    }
    for _ in 0..120 {
        let middle = 0.5 * (holds + ruptures);
        if ratio(law, limits, scaled(middle)) < 1.0 { holds = middle } else { ruptures = middle }
    }
    Some(scaled(ruptures))
}

#[test]
fn a_bond_that_ruptures_has_stored_the_least_energy_of_its_law() {
    let mut x = 0.7f64;
    let mut next = || {
        x = (x * 997.0 + 0.618).fract();
        x
    };
    let shape = BondShape { radius: 20e-6, length: 0.1e-3 };
    for kind in BondKind::OWN {
        let law: &dyn BondLaw = kind.law();
        let parameters: Vec<f64> = law.description().parameters.iter().map(|p| p.default).collect();
        let named = |name: &str| law.description().parameters.iter().position(|p| p.key == name);
        let mut nearest = f64::INFINITY;
        for _ in 0..4000 {
            let mut values = parameters.clone();
            let ranges = [("tensile_strength", 20e6), ("cohesion", 20e6), ("friction_angle", 1.2)];
            for (name, largest) in ranges {
                if let Some(k) = named(name) {
                    values[k] = largest * next();
                }
            }
            let (stiffness, limits) = (law.stiffness(&shape, &values), law.limits(&shape, &values, 1.0));
            let least = law.least_energy_at_rupture(&stiffness, &limits);
            assert!(least > 0.0 && least.is_finite(), "{kind} {values:?}");
            let force = 1e-3 * (next() - 0.4);
            let direction = [force, 1e-3 * next(), 20e-9 * next(), 20e-9 * next()];
            let Some(loads) = at_rupture(law, &limits, direction) else { continue };
            let stored = stored(&stiffness, loads);
            assert!(stored >= least * (1.0 - 1e-9), "{kind} {values:?} {loads:?}: {stored:e} < {least:e}");
            nearest = nearest.min(stored / least);
        }
        // The bound is not idle: some rupture little above it.
        assert!(nearest < 1.5, "{kind} {nearest}");
    }
}

/// Arms of pieces of two sizes: in the proportion of their radii, or alike.
#[test]
fn bonds_are_attached_where_pieces_touch_or_halfway() {
    use super::bonding::BondAttachment::{Contact, Middle};
    assert_eq!(Contact.arms(3.0, [1.0, 2.0]), [1.0, 2.0]);
    assert_eq!(Contact.arms(4.5, [1.0, 2.0]), [1.5, 3.0]);
    assert_eq!(Middle.arms(3.0, [1.0, 2.0]), [1.5, 1.5]);
    assert_eq!(Contact.arms(2.1, [1.0; 2]), Middle.arms(2.1, [1.0; 2]));
    // The same in a simulation: radii of 1 mm and 0.5 mm, 1.5 mm apart.
    let sphere = |id, x, radius| InitialSphere { id, position: [x, 5e-3, 5e-3], radius };
    let material = Material { interface_energy: 0.0, ..Material::default() };
    let properties = Properties::new(material, ContactModel::default());
    let spheres = [sphere(1, 3e-3, 1e-3), sphere(2, 4.5e-3, 0.5e-3)];
    for (attachment, golden) in [(Contact, [1e-3, 0.5e-3]), (Middle, [0.75e-3; 2])] {
        let mut s = Simulation::new(Cell::cuboid([10e-3; 3]), &spheres, properties.clone()).unwrap();
        s.bond(&Bonding::default().with(|bonding| bonding.attachment = attachment)).unwrap();
        let columns = s.integrator.state.bonds.columns_of(0);
        let arms = [ARMS, ARMS + 1].map(|at| columns[at].0[0]);
        assert!(arms.iter().zip(golden).all(|(arm, golden)| (arm - golden).abs() < 1e-15), "{arms:?}");
    }
}
