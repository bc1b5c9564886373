//! Rigid bodies of several pieces: two dimers that collide, compared with an independent integration of the same laws, conservation, the
//! stress of a packing at rest, and the same bits on any number of threads and after a restart.

use granum_core::assembly::{Assembly, Vector};
use granum_core::cell::Cell;
use granum_core::geometry::{cross, dot};
use granum_core::rotation::{IDENTITY, Quaternion, about, matrix, to_body, to_space};
use granum_dem::config::{AdhesionKind, ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::servo::CellControl;
use granum_dem::simulation::{
    Hardware, InitialBody, Properties, RigidShape, ShapePiece, Simulation, SimulationError,
};
use granum_shape::ShapeOfSpheres;

/// Inertia over mass of two spheres of diameter 1 at the distance 0.5, about their axis and across.
const INERTIA: Vector = [0.10625, 0.184375, 0.184375];
const MASS: f64 = 0.8835729338221;
const EDGE: f64 = 40.0;

/// Two spheres of diameter 1 at the distance 0.5 along the first axis.
fn dimer() -> RigidShape {
    let piece = |x: f64| ShapePiece { centre: [x, 0.0, 0.0], radius: 0.5 };
    RigidShape { pieces: vec![piece(-0.25), piece(0.25)], volume: MASS, inertia_over_mass: INERTIA }
}

/// Hertz with a spring that does not slip below the friction limit; modulus 1e4, Poisson's ratio 0.3, friction 0.3, density 1.
fn elastic() -> Properties {
    let material = Material::default().with(|m| {
        (m.youngs_modulus, m.poissons_ratio, m.friction, m.density) = (1e4, 0.3, 0.3, 1.0);
        m.interface_energy = 0.0;
    });
    Properties::new(material, ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.0))
}

fn sum(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] + b[k])
}

/// Spin of a dimer with an angular momentum.
fn spin_of(orientation: &Quaternion, momentum: &Vector) -> Vector {
    let rotation = matrix(orientation);
    let l = to_body(&rotation, momentum);
    to_space(&rotation, &std::array::from_fn(|k| l[k] / (MASS * INERTIA[k])))
}

/// Angular momentum of a body of an assembly about its centre.
fn momentum_of(assembly: &Assembly, k: usize) -> Vector {
    let body = &assembly.bodies[k];
    let Some(rigid) = body.rigid.map(|rigid| assembly.rigid[rigid as usize]) else {
        return body.spin.map(|w| 0.4 * body.mass * body.equivalent_radius.powi(2) * w);
    };
    let rotation = matrix(&rigid.orientation);
    let w = to_body(&rotation, &body.spin);
    to_space(&rotation, &std::array::from_fn(|k| rigid.inertia[k] * w[k]))
}

/// Kinetic energy of all bodies.
fn kinetic_energy(assembly: &Assembly) -> f64 {
    (0..assembly.bodies.len())
        .map(|k| {
            let body = &assembly.bodies[k];
            0.5 * (body.mass * dot(&body.velocity, &body.velocity)
                + dot(&momentum_of(assembly, k), &body.spin))
        })
        .sum()
}

/// Angular momentum of all bodies about the middle of the cell.
fn whole_momentum(assembly: &Assembly) -> Vector {
    (0..assembly.bodies.len()).fold([0.0; 3], |total, k| {
        let body = &assembly.bodies[k];
        let place = std::array::from_fn(|a| body.position[a] - 0.5 * EDGE);
        let orbital = cross(&place, &body.velocity).map(|x| body.mass * x);
        sum(sum(total, orbital), momentum_of(assembly, k))
    })
}

/// An impact of two dimers: the second is at `place`.
struct Impact {
    place: Vector,
    orientations: [Quaternion; 2],
    momenta: [Vector; 2],
    velocities: [Vector; 2],
    /// Velocity of the first after the impact, and the spins of both at t = 4.
    after: [Vector; 3],
    energies: [f64; 2],
    whole_momentum: Vector,
}

fn impacts() -> [Impact; 3] {
    let third = std::f64::consts::FRAC_PI_3;
    [
        Impact {
            place: [1.6, 0.35, 0.1],
            orientations: [IDENTITY, about(&[0.0, 0.0, 1.0], third)],
            momenta: [[0.0; 3]; 2],
            velocities: [[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]],
            after: [
                [-0.369649, -0.191952, -0.062289],
                [0.028373, -0.011928, -0.447578],
                [-0.013702, -0.013325, 0.720663],
            ],
            energies: [0.2208932335, 0.2150973],
            whole_momentum: [0.0, -0.044178646691, 0.154625263419],
        },
        Impact {
            place: [1.6, 0.35, 0.1],
            orientations: [about(&[0.0, 1.0, 1.0], 0.5), about(&[1.0, 2.0, 3.0], 1.0)],
            momenta: [[0.02, -0.03, 0.05], [0.0, 0.04, -0.02]],
            velocities: [[0.5, 0.1, 0.0], [-0.5, 0.0, 0.05]],
            after: [
                [-0.427133, -0.113052, -0.077258],
                [0.151867, -0.285616, 0.134565],
                [-0.075428, 0.350219, 0.104533],
            ],
            energies: [0.2474531787, 0.2163230],
            whole_momentum: [0.035462526342, -0.104864481396, 0.184625263417],
        },
        Impact {
            place: [0.05, 1.4, 0.1],
            orientations: [IDENTITY, about(&[0.0, 0.0, 1.0], 0.1)],
            momenta: [[0.0; 3]; 2],
            velocities: [[0.0, 0.5, 0.0], [0.0, -0.5, 0.0]],
            after: [
                [-0.031974, -0.240640, -0.061826],
                [0.013435, -0.095292, 0.986278],
                [0.005555, 0.094772, -1.015956],
            ],
            energies: [0.2208932335, 0.2199283],
            whole_momentum: [0.044178646691, 0.0, -0.022089323346],
        },
    ]
}

fn near(found: &[f64], golden: &[f64], tolerance: f64, what: &str) {
    for (a, b) in found.iter().zip(golden) {
        assert!((a - b).abs() < tolerance, "{what}: {found:?} for {golden:?}");
    }
}

/// The values come from an independent integration with steps of 7.8e-6 and 2e-6, extrapolated; those here, of one of 2e-5, begin a contact up to
/// a step too late.
#[test]
fn two_dimers_collide_as_in_an_independent_integration() {
    const STEP: f64 = 2e-5;
    for (number, impact) in impacts().iter().enumerate() {
        let middle = [0.5 * EDGE; 3];
        let bodies = [0, 1].map(|k| InitialBody {
            id: k as u64 + 1,
            position: if k == 0 { middle } else { sum(middle, impact.place) },
            orientation: impact.orientations[k],
            shape: 0,
            scale: 1.0,
        });
        let cell = Cell::cuboid([EDGE; 3]);
        let mut s = Simulation::of_bodies(cell, &[dimer()], &bodies, &[], elastic()).unwrap();
        s.set_velocities(
            &impact.velocities,
            &[0, 1].map(|k| spin_of(&impact.orientations[k], &impact.momenta[k])),
        );
        s.fix_time_step(Some(STEP));
        let before = s.assembly();
        let what = |part: &str| format!("impact {}: {part}", number + 1);
        near(&[kinetic_energy(&before)], &impact.energies[..1], 1e-9, &what("energy before"));
        near(&whole_momentum(&before), &impact.whole_momentum, 1e-9, &what("angular momentum before"));
        s.advance((4.0 / STEP).round() as u64).unwrap();
        let after = s.assembly();
        assert!(after.contacts.is_empty());
        near(&after.bodies[0].velocity, &impact.after[0], 8e-5, &what("velocity of the first"));
        near(&after.bodies[0].spin, &impact.after[1], 8e-5, &what("spin of the first"));
        near(&after.bodies[1].spin, &impact.after[2], 8e-5, &what("spin of the second"));
        near(&[kinetic_energy(&after)], &impact.energies[1..], 2e-5, &what("energy after"));
        near(&whole_momentum(&after), &impact.whole_momentum, 1e-9, &what("angular momentum after"));
        let whole = sum(impact.velocities[0], impact.velocities[1]);
        near(&sum(after.bodies[0].velocity, after.bodies[1].velocity), &whole, 1e-12, &what("momentum"));
    }
}

/// A loose sample of dimers and spheres in turns, at places of a lattice.
fn loose(count: usize) -> (Cell, Vec<InitialBody>) {
    let spacing = 1.6;
    let body = |k: usize| {
        let (x, y, z) = (k % count, k / count % count, k / count / count);
        let axis = [1.0 + k as f64 % 3.0, (k as f64 * 0.7).sin(), (k as f64 * 1.3).cos()];
        InitialBody {
            id: k as u64 + 1,
            position: [x, y, z].map(|n| (n as f64 + 0.5) * spacing),
            orientation: about(&axis, k as f64),
            shape: k % 4 / 3,
            scale: 1.0,
        }
    };
    (Cell::cuboid([spacing * count as f64; 3]), (0..count.pow(3)).map(body).collect())
}

/// A sample of three dimers to one sphere under isotropic pressure.
fn compressed(count: usize, threads: usize, steps: u64) -> Simulation {
    let (cell, bodies) = loose(count);
    let shapes = [dimer(), RigidShape::sphere(0.5)];
    let mut properties = elastic();
    properties.contact.damping = 0.3;
    let mut s = Simulation::of_bodies(cell, &shapes, &bodies, &[], properties).unwrap();
    s.set_hardware(Hardware { threads, ..Hardware::default() });
    s.expect_force(1.0);
    s.set_control(CellControl::isotropic(1.0, 0.2));
    s.set_global_damping(0.5);
    s.advance(steps).unwrap();
    s
}

#[test]
fn clumps_give_the_same_bits_on_threads_and_after_a_restart() {
    let one = compressed(6, 1, 3000);
    let three = compressed(6, 3, 3000);
    assert!(one.rebuilds() > 1 && one.state() == three.state());
    assert_eq!((one.state().grains(), one.state().pieces()), (216, 216 + 162));
    let bytes = compressed(6, 1, 1700).checkpoint("").unwrap();
    let (mut restored, _) = Simulation::restore(&bytes).unwrap();
    restored.advance(1300).unwrap();
    assert!(restored.state() == one.state());
    // Content with a checksum that fits, but altered: it is refused, or can be inspected and run.
    for at in (24..bytes.len()).step_by(211) {
        let mut forged = bytes.clone();
        forged[at] = forged[at].wrapping_add(77);
        let sum = crc32fast::hash(&forged[24..]);
        forged[20..24].copy_from_slice(&sum.to_le_bytes());
        if let Ok((mut s, _)) = Simulation::restore(&forged) {
            assert_eq!(s.assembly().pieces.len(), 378);
            let _ = s.advance(2);
        }
    }
    let mut damaged = bytes.clone();
    let last = damaged.len() - 3;
    damaged[last] ^= 1;
    assert!(Simulation::restore(&damaged).is_err());
}

/// At rest the stress with the branches of the bodies is symmetric; that with the branches of the pieces is not, and lower.
#[test]
fn the_stress_of_a_packing_at_rest_takes_the_branches_of_the_bodies() {
    let s = compressed(6, 1, 60_000);
    let assembly = s.assembly();
    let unbalanced = s.state().unbalanced_force();
    assert!(unbalanced < 2e-3, "{unbalanced}");
    let stress = |of: &dyn Fn(&granum_core::assembly::Contact) -> Vector| {
        let mut t = [[0.0; 3]; 3];
        for contact in &assembly.contacts {
            let (force, branch) = (contact.force(), of(contact));
            for r in 0..3 {
                for c in 0..3 {
                    t[r][c] -= force[r] * branch[c] / assembly.volume();
                }
            }
        }
        t
    };
    let of_bodies = stress(&|contact| assembly.branch_of_bodies(contact));
    let of_pieces = stress(&|contact| contact.branch);
    let p = s.state().mean_stress();
    let trace = |t: [[f64; 3]; 3]| (t[0][0] + t[1][1] + t[2][2]) / 3.0;
    assert!((p - 1.0).abs() < 0.01, "{p}");
    assert!((trace(of_bodies) / p - 1.0).abs() < 1e-9, "the engine sums the same branches");
    let share = trace(of_pieces) / p;
    assert!((0.8..0.97).contains(&share), "{share}");
    let skew = |t: [[f64; 3]; 3]| {
        (t[0][1] - t[1][0]).abs().max((t[1][2] - t[2][1]).abs()).max((t[2][0] - t[0][2]).abs())
    };
    assert!(skew(of_bodies) < 2e-4 * p, "{}", skew(of_bodies));
    assert!(skew(of_pieces) > 1e-3 * p, "{}", skew(of_pieces));
}

/// The work of the boundary is what the grains and contacts store and what friction takes: it belongs to the centres of the bodies, and the
/// rotation of clumps is part of their energy.
#[test]
fn the_energy_balance_of_clumps_closes() {
    for friction in [0.0, 0.3] {
        let (cell, bodies) = loose(5);
        let shapes = [dimer(), RigidShape::sphere(0.5)];
        let mut properties = elastic();
        properties.material.friction = friction;
        let mut s = Simulation::of_bodies(cell, &shapes, &bodies, &[], properties).unwrap();
        s.expect_force(1.0);
        s.set_time_step_factor(0.05);
        s.set_control(CellControl::isotropic(1.0, 0.2));
        s.advance(20_000).unwrap();
        let assembly = s.assembly();
        let contacts: f64 = assembly.contacts.iter().map(|contact| contact.normal_energy).sum();
        let (work, kinetic) = (assembly.energy.boundary_work, kinetic_energy(&assembly));
        let error = work - assembly.energy.accounted(kinetic + contacts);
        assert!(work > 1.0 && (friction == 0.0 || assembly.energy.mechanisms().friction > 1.0));
        assert!(error.abs() < 1e-3 * work, "friction {friction}: {error} of {work}");
    }
}

#[test]
fn what_clumps_cannot_do_is_refused_by_name() {
    let make = |shapes: &[RigidShape], bodies: &[InitialBody]| {
        Simulation::of_bodies(Cell::cuboid([4.0; 3]), shapes, bodies, &[], elastic())
            .err()
            .map(|e| e.to_string())
    };
    let body = InitialBody { id: 7, position: [1.0; 3], orientation: IDENTITY, shape: 0, scale: 1.0 };
    assert_eq!(make(&[dimer()], &[body]), None);
    let said = |shapes: &[RigidShape], bodies: &[InitialBody], text: &str| {
        let message = make(shapes, bodies).expect("refused");
        assert!(message.contains(text), "{message}");
    };
    said(&[dimer()], &[InitialBody { shape: 1, ..body }], "grain 7: its shape is number 1");
    said(&[dimer()], &[body, body], "its id occurs twice");
    said(&[dimer()], &[InitialBody { orientation: [0.0; 4], ..body }], "its orientation has no length");
    let mut long = dimer();
    long.pieces[1].centre[0] = 0.75;
    said(&[long], &[body], "it must be at least twice as thick");
    let mut wet = elastic();
    wet.contact.adhesion = AdhesionKind::CAPILLARY_BRIDGE_FILMS;
    let refused = Simulation::of_bodies(Cell::cuboid([4.0; 3]), &[dimer()], &[body], &[], wet);
    assert!(matches!(refused.err(), Some(SimulationError::LiquidOfClumps { .. })));
}

/// A packing of one shape without friction under isotropic pressure, E/p = 1e4, made from a gas of bodies.
fn frictionless(spheres: &[(Vector, f64)], edge: usize, start: f64) -> Simulation {
    let shape = ShapeOfSpheres::new(spheres).unwrap().shape;
    let spacing = 2.1 * shape.reach();
    let mut x = start;
    let mut next = || {
        x = (x * 997.0 + 0.618_f64).fract();
        2.0 * x - 1.0
    };
    let bodies: Vec<InitialBody> = (0..edge.pow(3))
        .map(|k| InitialBody {
            id: k as u64 + 1,
            position: [k % edge, k / edge % edge, k / edge / edge].map(|n| (n as f64 + 0.5) * spacing),
            orientation: about(&[next(), next(), next()], 3.0 * next()),
            shape: 0,
            scale: 1.0,
        })
        .collect();
    let mut properties = elastic();
    properties.material.friction = 0.0;
    properties.contact.damping = 0.3;
    let cell = Cell::cuboid([spacing * edge as f64; 3]);
    let mut s = Simulation::of_bodies(cell, &[shape], &bodies, &[], properties).unwrap();
    let fast = |next: &mut dyn FnMut() -> f64| -> Vec<Vector> {
        bodies.iter().map(|_| [0.7 * next(), 0.7 * next(), 0.7 * next()]).collect()
    };
    let (velocities, spins) = (fast(&mut next), fast(&mut next));
    s.set_velocities(&velocities, &spins);
    s.expect_force(1.0);
    s.set_control(CellControl::isotropic(1.0, 0.1));
    s.advance(40_000).unwrap();
    s.set_global_damping(0.3);
    s.advance(60_000).unwrap();
    s
}

/// Solid fraction, contacts a grain and neighbours a grain of packings of 150 bodies that were prepared without friction by an independent
/// program, one sample each; here the means of two samples of 125.
#[test]
fn frictionless_packings_are_as_dense_as_those_of_an_independent_program() {
    let row = |xs: &[f64]| -> Vec<(Vector, f64)> { xs.iter().map(|x| ([*x, 0.0, 0.0], 0.5)).collect() };
    let q = 0.25;
    let tetrapod = vec![([q, q, q], 0.5), ([q, -q, -q], 0.5), ([-q, q, -q], 0.5), ([-q, -q, q], 0.5)];
    for (name, spheres, golden) in [
        ("sphere", row(&[0.0]), [0.640, 6.55, 6.55]),
        ("dimer at half a diameter", row(&[-0.25, 0.25]), [0.699, 11.33, 8.51]),
        ("dimer at a diameter", row(&[-0.5, 0.5]), [0.635, 11.12, 8.52]),
        ("capsule of three", row(&[-0.5, 0.0, 0.5]), [0.681, 11.88, 9.29]),
        ("tetrapod", tetrapod, [0.691, 13.81, 8.27]),
    ] {
        let mut found = [0.0; 3];
        for start in [0.41, 0.73] {
            let s = frictionless(&spheres, 5, start);
            assert!(s.state().unbalanced_force() < 1e-6);
            let assembly = s.assembly();
            let a_grain = |count: usize| 2.0 * count as f64 / assembly.bodies.len() as f64;
            let of_sample = [
                s.state().solid_fraction(),
                a_grain(assembly.contacts.len()),
                a_grain(assembly.pairs_of_bodies().len()),
            ];
            println!("{name}: {of_sample:?}");
            (0..3).for_each(|k| found[k] += 0.5 * of_sample[k]);
        }
        println!("{name}: {found:?} for {golden:?}");
        near(&found[..1], &golden[..1], 0.012, name);
        near(&found[1..], &golden[1..], 0.6, name);
    }
}
