//! The force that pulls a sphere off a grain of several pieces, against the direction: at a seam two contacts hold it.

use granum_core::cell::Cell;
use granum_core::rotation::IDENTITY;
use granum_dem::config::{ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::simulation::{InitialBody, Properties, RigidShape, Simulation};
use granum_shape::ShapeOfSpheres;

type Vector = [f64; 3];

/// Largest force that holds a sphere of diameter 1 at spheres of diameter 1 on the first axis, in a direction at an angle to it, over the
/// pull-off force of two spheres after Johnson, Kendall and Roberts (1971), `3/2 pi Gamma R*`.
fn pull_off(places: &[f64], angle: f64) -> f64 {
    const ENERGY: f64 = 0.05;
    let spheres: Vec<(Vector, f64)> = places.iter().map(|x| ([*x, 0.0, 0.0], 0.5)).collect();
    let grain = match places {
        [_] => RigidShape::sphere(0.5),
        _ => ShapeOfSpheres::new(&spheres).unwrap().shape,
    };
    let direction = [angle.cos(), angle.sin(), 0.0];
    // The distance at which the nearest piece is pressed in by 0.001.
    let touching = 0.999;
    let distance = (places.iter())
        .map(|x| {
            let (along, across) = (x * direction[0], x * direction[1]);
            along + (touching * touching - across * across).sqrt()
        })
        .fold(0.0, f64::max);
    let middle = [10.0; 3];
    let body = |id: u64, distance: f64, shape: usize| InitialBody {
        id,
        position: [0, 1, 2].map(|a| middle[a] + distance * direction[a]),
        orientation: IDENTITY,
        shape,
        scale: 1.0,
    };
    let material = Material::default().with(|m| {
        (m.youngs_modulus, m.poissons_ratio, m.friction, m.density) = (1e4, 0.3, 0.0, 1.0);
        m.interface_energy = ENERGY;
    });
    let contact = ContactModel::new(NormalKind::JKR, TangentialKind::NO_SLIP, 0.0);
    let properties = Properties::new(material, contact);
    let shapes = [grain, RigidShape::sphere(0.5)];
    let bodies = [body(1, 0.0, 0), body(2, distance, 1)];
    let mut s = Simulation::of_bodies(Cell::cuboid([20.0; 3]), &shapes, &bodies, &[], properties).unwrap();
    s.fix_time_step(Some(1e-5));
    let mut largest = 0.0f64;
    loop {
        // The grain is held, and the sphere is drawn away without turning.
        s.set_velocities(&[[0.0; 3], direction.map(|x| 0.02 * x)], &[[0.0; 3], [0.0; 3]]);
        s.advance(1).unwrap();
        let assembly = s.assembly();
        if assembly.contacts.is_empty() {
            break;
        }
        let force = assembly.bodies[1].force;
        largest = largest.max(-(0..3).map(|a| force[a] * direction[a]).sum::<f64>());
    }
    largest / (1.5 * std::f64::consts::PI * ENERGY * 0.25)
}

#[test]
fn two_pieces_hold_at_a_seam() {
    let single = pull_off(&[0.0], 0.3);
    assert!((single - 1.0).abs() < 2e-3, "{single}");
    let dimer = [-0.25, 0.25];
    let end = pull_off(&dimer, 0.0);
    assert!((end - 1.0).abs() < 2e-3, "{end}");
    // Both contacts at the angle chi to the direction: 2 cos(chi), sin(chi) = c/2D.
    let seam = pull_off(&dimer, std::f64::consts::FRAC_PI_2);
    let golden = 2.0 * (1.0f64 - 0.25 * 0.25).sqrt();
    assert!((seam / golden - 1.0).abs() < 5e-3, "{seam} {golden}");
    // A degree beside the seam only one of them holds at a time.
    let beside = pull_off(&dimer, std::f64::consts::FRAC_PI_2 - 0.02);
    assert!(beside < 1.2, "{beside}");
}

/// Where one piece holds, its force is along the line of the two centres: in the direction of the pull it is the cosine of the angle between
/// them of the pull-off force.
#[test]
fn one_piece_holds_along_the_line_of_centres() {
    for (places, nearest, degrees) in [
        (&[-0.25, 0.25][..], 0.25, 30.0f64),
        (&[-0.25, 0.25], 0.25, 60.0),
        (&[-0.25, 0.25], 0.25, 80.0),
        (&[-0.5, 0.0, 0.5], 0.5, 60.0),
        (&[-0.5, 0.0, 0.5], 0.0, 85.0),
    ] {
        let across = nearest * degrees.to_radians().sin();
        let golden = (1.0 - across * across).sqrt();
        let found = pull_off(places, degrees.to_radians());
        assert!((found / golden - 1.0).abs() < 3e-3, "{degrees} degrees: {found} {golden}");
    }
}
