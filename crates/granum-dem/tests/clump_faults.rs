//! What users of other programs ran into with grains of several spheres: each fault is one test.

use granum_core::cell::Cell;
use granum_core::rotation::{IDENTITY, about, matrix, to_space};
use granum_dem::config::{ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::servo::CellControl;
use granum_dem::simulation::{InitialBody, Properties, Simulation};
use granum_shape::ShapeOfSpheres;

type Vector = [f64; 3];

/// Spheres of diameter 1 in a row.
fn row(places: &[f64]) -> ShapeOfSpheres {
    let spheres: Vec<(Vector, f64)> = places.iter().map(|x| ([*x, 0.0, 0.0], 0.5)).collect();
    ShapeOfSpheres::new(&spheres).unwrap()
}

fn properties(normal: NormalKind, modulus: f64, density: f64, damping: f64) -> Properties {
    let material = Material::default().with(|m| {
        (m.youngs_modulus, m.poissons_ratio, m.friction, m.density) = (modulus, 0.3, 0.3, density);
        m.interface_energy = 0.0;
    });
    Properties::new(material, ContactModel::new(normal, TangentialKind::NO_SLIP, damping))
}

fn body(id: u64, position: Vector) -> InitialBody {
    InitialBody { id, position, orientation: IDENTITY, shape: 0, scale: 1.0 }
}

/// An absolute threshold takes the inertia of a small grain for zero: one collision in SI and in units of the diameter must agree.
#[test]
fn small_grains_turn_as_large_ones() {
    let orientations = |length: f64, density: f64, stress: f64| {
        let unit = (stress / density).sqrt();
        let shape = row(&[-0.25, 0.25]).shape.scaled(length);
        let place = |x: Vector| x.map(|x| length * (20.0 + x));
        let bodies = [body(1, place([0.0; 3])), body(2, place([1.6, 0.35, 0.1]))];
        let bodies = [bodies[0], InitialBody { orientation: about(&[0.0, 0.0, 1.0], 1.0), ..bodies[1] }];
        let cell = Cell::cuboid([40.0 * length; 3]);
        let properties = properties(NormalKind::HERTZ, 1e4 * stress, density, 0.0);
        let mut s = Simulation::of_bodies(cell, &[shape], &bodies, &[], properties).unwrap();
        s.set_velocities(&[[0.5 * unit, 0.0, 0.0], [-0.5 * unit, 0.0, 0.0]], &[]);
        s.fix_time_step(Some(1e-4 * length / unit));
        s.advance(20_000).unwrap();
        let assembly = s.assembly();
        [0, 1].map(|k| assembly.rigid[assembly.bodies[k].rigid.unwrap() as usize].orientation)
    };
    let (large, small) = (orientations(1.0, 1.0, 1.0), orientations(2e-4, 2650.0, 1e6));
    for k in 0..2 {
        for c in 0..4 {
            assert!((large[k][c] - small[k][c]).abs() < 1e-9, "{large:?} {small:?}");
        }
    }
    assert!((large[0][3]).abs() > 0.05, "it turned: {large:?}");
}

/// The velocity of a sheared cell belongs to the centre of a body: its pieces keep their distance, and a free body does not turn.
#[test]
fn a_free_body_is_not_turned_by_a_sheared_cell() {
    let shape = row(&[-0.5, 0.5]).shape;
    // Along axis 2, across the upper face.
    let upright = about(&[0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
    let bodies = [InitialBody { orientation: upright, ..body(1, [5.0, 9.9, 5.0]) }];
    let properties = properties(NormalKind::HERTZ, 1e4, 1.0, 0.0);
    let mut s = Simulation::of_bodies(Cell::cuboid([10.0; 3]), &[shape], &bodies, &[], properties).unwrap();
    let mut control = CellControl::fixed();
    control.rate[0][1] = -0.1;
    s.set_control(control);
    s.fix_time_step(Some(1e-3));
    s.advance(10_000).unwrap();
    assert!((s.state().strain()[0][1] + 1.0).abs() < 1e-3, "{:?}", s.state().strain());
    let assembly = s.assembly();
    let rigid = assembly.rigid[assembly.bodies[0].rigid.unwrap() as usize];
    let axis = to_space(&matrix(&rigid.orientation), &[1.0, 0.0, 0.0]);
    assert!(axis[0].abs() < 1e-12 && (axis[1].abs() - 1.0).abs() < 1e-12, "{axis:?}");
    assert_eq!(assembly.bodies[0].spin, [0.0; 3]);
}

/// A sum over pieces counts twice what they share.
#[test]
fn mass_and_energy_are_those_of_the_union() {
    let of = |places: &[f64], spin: Vector| {
        let cell = Cell::cuboid([20.0; 3]);
        let properties = properties(NormalKind::HERTZ, 1e4, 1.0, 0.0);
        let bodies = [body(1, [10.0; 3])];
        let mut s = Simulation::of_bodies(cell, &[row(places).shape], &bodies, &[], properties).unwrap();
        s.set_velocities(&[[0.0; 3]], &[spin]);
        let assembly = s.assembly();
        let body = &assembly.bodies[0];
        let inertia = assembly.rigid[body.rigid.unwrap() as usize].inertia;
        let energy: f64 = (0..3).map(|k| 0.5 * inertia[k] * body.spin[k] * body.spin[k]).sum();
        (body.mass, energy)
    };
    let (mass, _) = of(&[-0.5, 0.0, 0.5], [0.0; 3]);
    assert!((mass - 1.2435470920).abs() < 1e-9, "{mass}");
    let (_, energy) = of(&[-0.5, 0.5], [0.0, 1.0, 0.0]);
    assert!((energy - 0.1832595715).abs() < 1e-9, "{energy}");
}

/// Positions that are many cells away are taken into the cell at once.
#[test]
fn a_grain_a_million_cells_away_costs_nothing() {
    let edge = 10.0;
    let place = |far: f64| [5.0 + far * edge, 9.9, 5.0];
    let positions = [0.0, 1_700_000.0].map(|far| {
        let properties = properties(NormalKind::HERTZ, 1e4, 1.0, 0.0);
        let cell = Cell::cuboid([edge; 3]);
        let bodies = [body(1, place(far))];
        let s = Simulation::of_bodies(cell, &[row(&[-0.5, 0.5]).shape], &bodies, &[], properties).unwrap();
        s.assembly().bodies[0].position
    });
    for a in 0..3 {
        assert!((positions[0][a] - positions[1][a]).abs() < 1e-8, "{positions:?}");
    }
}

/// Dashpots act at contacts, with the masses of the bodies: two dimers that meet side on, in two contacts, are damped by the factor
/// `sqrt(2)` more than the damping of one contact says.
#[test]
fn two_contacts_of_two_bodies_are_damped_more_than_one() {
    let restitution = |zeta: f64| (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
    for (across, share) in [(0.0, 2.0f64.sqrt()), (std::f64::consts::FRAC_PI_2, 1.0)] {
        let mut properties = properties(NormalKind::HOOKE, 1e4, 1.0, 0.1);
        properties.contact.parameters.set("normal_stiffness", 1e3).unwrap();
        // The second dimer lies beside the first, or comes with its end to the middle of a sphere of it.
        let apart = if across == 0.0 { 1.3 } else { 1.8 };
        let first = body(1, [9.5, 10.0, 10.0]);
        let second = InitialBody {
            orientation: about(&[0.0, 0.0, 1.0], across),
            ..body(2, [9.5, 10.0 + apart, 10.0])
        };
        let shapes = [row(&[-0.5, 0.5]).shape, row(&[0.0]).shape];
        let bodies = if across == 0.0 {
            [first, second]
        } else {
            // Two spheres in line with each other: one contact through both centres.
            [
                InitialBody { orientation: about(&[0.0, 0.0, 1.0], across), ..first },
                InitialBody { position: [9.5, 12.3, 10.0], ..second },
            ]
        };
        let mut s =
            Simulation::of_bodies(Cell::cuboid([20.0; 3]), &shapes, &bodies, &[], properties).unwrap();
        s.set_velocities(&[[0.0, 0.5, 0.0], [0.0, -0.5, 0.0]], &[]);
        s.fix_time_step(Some(1e-4));
        s.advance(30_000).unwrap();
        let assembly = s.assembly();
        assert!(assembly.contacts.is_empty());
        let relative = assembly.bodies[1].velocity[1] - assembly.bodies[0].velocity[1];
        let golden = restitution(0.1 * share);
        assert!((relative - golden).abs() < 2e-3, "{relative} {golden}");
    }
}

/// A grain that is as long as the cell is thick would touch its own image, which no contact is looked for with.
#[test]
fn a_cell_that_becomes_thinner_than_a_grain_is_refused() {
    let shape = row(&[-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5]).shape;
    let bodies = [body(1, [4.0; 3]), body(2, [4.0, 6.5, 4.0])];
    let cell = Cell::cuboid([8.1; 3]);
    let mut s =
        Simulation::of_bodies(cell, &[shape], &bodies, &[], properties(NormalKind::HERTZ, 1e4, 1.0, 0.1))
            .unwrap();
    let mut control = CellControl::fixed();
    control.rate[1][1] = 0.1;
    s.set_control(control);
    s.set_velocities(&[[0.0, 0.0, 0.3], [0.0; 3]], &[]);
    s.fix_time_step(Some(1e-3));
    let error = s.advance(20_000).unwrap_err().to_string();
    assert!(error.contains("would touch itself across the cell"), "{error}");
}
