//! The time step of bonded packings against their largest frequency.

use crate::samples::*;
use granum_core::assembly::{Assembly, Vector};
use granum_core::geometry::{cross, dot};
use granum_dem::bond::{BondKind, BondRadius, BondShape, BondStiffness, Bonding};
use granum_dem::simulation::Hardware;

/// The time step against the largest frequency of a bonded packing, from its stiffness and masses: central differences are stable up to
/// `dt omega = 2`. The formula of the step is one by analogy with that of contacts.
#[test]
fn the_time_step_is_stable_for_a_bonded_packing() {
    for share in [0.3, 1.0] {
        let mut s = compressed(300, 100e3, Hardware::default());
        let bonding = Bonding::default().with(|bonding| {
            (bonding.radius, bonding.largest_gap) = (BondRadius::Share(share), 0.05);
            // So stiff that contacts hardly matter.
            bonding.parameters.insert("modulus".into(), 1e12);
        });
        s.bond(&bonding).unwrap();
        let dt = s.state().time_step();
        let assembly = s.assembly();
        let fraction = dt * largest_frequency(&assembly, 1e12);
        assert!((0.4..1.6).contains(&fraction), "radius {share}: dt omega = {fraction}");
    }
}

/// The largest frequency, rad/s, of the small vibrations of spheres that are joined by parallel bonds of a modulus, Pa: by iteration.
fn largest_frequency(assembly: &Assembly, modulus: f64) -> f64 {
    let count = assembly.bodies.len();
    let law = BondKind::PARALLEL.law();
    let stiffness: Vec<BondStiffness> = assembly
        .bonds
        .iter()
        .map(|bond| {
            let shape = BondShape { radius: bond.radius, length: bond.length };
            law.stiffness(&shape, &[modulus, 0.25, 0.0])
        })
        .collect();
    let along = |x: Vector, n: Vector| -> Vector {
        let part = dot(&x, &n);
        n.map(|k| k * part)
    };
    // Forces and couples over masses and moments for displacements and rotations.
    let apply = |moved: &[[Vector; 2]]| -> Vec<[Vector; 2]> {
        let mut out = vec![[[0.0; 3]; 2]; count];
        for (bond, k) in assembly.bonds.iter().zip(&stiffness) {
            let (i, j, n) = (bond.i, bond.j, bond.normal);
            let radii = [i, j].map(|grain| assembly.bodies[grain].equivalent_radius);
            let length = dot(&bond.branch, &bond.branch).sqrt() / (radii[0] + radii[1]);
            let levers = [n.map(|x| x * length * radii[0]), n.map(|x| -x * length * radii[1])];
            let turned = [cross(&moved[i][1], &levers[0]), cross(&moved[j][1], &levers[1])];
            let u: Vector =
                std::array::from_fn(|a| moved[j][0][a] + turned[1][a] - moved[i][0][a] - turned[0][a]);
            let phi: Vector = std::array::from_fn(|a| moved[j][1][a] - moved[i][1][a]);
            let (un, pn) = (along(u, n), along(phi, n));
            let force: Vector = std::array::from_fn(|a| k.normal * un[a] + k.shear * (u[a] - un[a]));
            let couple: Vector = std::array::from_fn(|a| k.twisting * pn[a] + k.bending * (phi[a] - pn[a]));
            for (grain, lever, sign) in [(i, levers[0], -1.0), (j, levers[1], 1.0)] {
                let turning = cross(&lever, &force);
                let body = &assembly.bodies[grain];
                let moment = 0.4 * body.mass * body.equivalent_radius.powi(2);
                for a in 0..3 {
                    out[grain][0][a] += sign * force[a] / body.mass;
                    out[grain][1][a] += sign * (couple[a] + turning[a]) / moment;
                }
            }
        }
        out
    };
    let mut moved: Vec<[Vector; 2]> = (0..count)
        .map(|k| {
            let wave = |a: usize| (1.3 * k as f64 + a as f64).sin();
            // Rotations of the order of displacements over the radius.
            [[wave(0), wave(1), wave(2)], [wave(3), wave(4), wave(5)].map(|x| 1e4 * x)]
        })
        .collect();
    let mut square = 0.0;
    for _ in 0..400 {
        let next = apply(&moved);
        let size = |of: &[[Vector; 2]]| {
            let grains = of.iter().zip(&assembly.bodies);
            let energy = |([x, w], body): (&[Vector; 2], &granum_core::assembly::Body)| {
                body.mass * (dot(x, x) + 0.4 * body.equivalent_radius.powi(2) * dot(w, w))
            };
            grains.map(energy).sum::<f64>().sqrt()
        };
        square = size(&next) / size(&moved);
        let scale = 1.0 / size(&next);
        moved = next.into_iter().map(|grain| grain.map(|x| x.map(|k| k * scale))).collect();
    }
    square.sqrt()
}
