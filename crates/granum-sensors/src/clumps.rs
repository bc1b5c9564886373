//! Small assemblies of grains of several pieces for the tests of the sensors.

use granum_core::assembly::{Assembly, Body, Contact, Piece, Quaternion, Rigid, Sphere, Vector};
use granum_core::cell::Cell;
use granum_core::rotation::{IDENTITY, about, matrix, to_space};
use granum_dem::config::{ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::servo::CellControl;
use granum_dem::simulation::{InitialBody, Properties, RigidShape, ShapePiece, Simulation};

/// A rigid grain of spheres of radius 0.5.
pub(crate) struct Clump<'a> {
    pub(crate) position: Vector,
    pub(crate) orientation: Quaternion,
    /// Principal moments of inertia.
    pub(crate) inertia: Vector,
    /// Centres of the pieces in the principal axes.
    pub(crate) centres: &'a [Vector],
}

/// Adds a clump of mass 1 and of the size of a sphere of radius 0.6.
pub(crate) fn push(assembly: &mut Assembly, clump: &Clump) {
    let Clump { position, orientation, inertia, centres } = *clump;
    let (body, rigid) = (assembly.bodies.len(), assembly.rigid.len() as u32);
    let rotation = matrix(&orientation);
    for centre in centres {
        let arm = to_space(&rotation, centre);
        let position = std::array::from_fn(|a| position[a] + arm[a]);
        assembly.pieces.push(Piece { body, position, radius: 0.5, arm });
    }
    assembly.rigid.push(Rigid { orientation, inertia });
    assembly.bodies.push(Body {
        id: body as u64 + 1,
        position,
        mass: 1.0,
        equivalent_radius: 0.6,
        rigid: Some(rigid),
        ..Body::default()
    });
}

/// A row of touching grains in a cell with edges of 10: two parallel dimers along x that touch at two places, a dimer along y, a sphere; and a
/// sphere apart. Contacts 0 and 1 of the first pair have the normal force 3 and 1 along y, the others 2 and -1 along x; 0 and 2 slide.
pub(crate) fn few() -> Assembly {
    let edges = [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
    let mut assembly = Assembly { cell: edges, ..Assembly::default() };
    let quarter = about(&[0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
    for (position, orientation) in
        [([2.0, 2.0, 2.0], IDENTITY), ([2.0, 3.0, 2.0], IDENTITY), ([3.5, 3.5, 2.0], quarter)]
    {
        let (inertia, centres) = ([0.1, 0.35, 0.35], &[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]);
        push(&mut assembly, &Clump { position, orientation, inertia, centres });
    }
    for (id, position) in [(4, [4.5, 4.0, 2.0]), (5, [8.0; 3])] {
        assembly.push_sphere(Sphere { id, position, radius: 0.5, mass: 1.0, ..Sphere::default() });
    }
    for (i, j, normal_force, sliding) in
        [(0, 2, 3.0, true), (1, 3, 1.0, false), (3, 4, 2.0, true), (5, 6, -1.0, false)]
    {
        let [from, to] = [i, j].map(|piece: usize| assembly.pieces[piece].position);
        // All touching pieces are at a distance of one.
        let branch: Vector = std::array::from_fn(|a| to[a] - from[a]);
        assembly.contacts.push(Contact {
            i,
            j,
            branch,
            normal: branch,
            normal_force,
            sliding,
            ..Contact::default()
        });
    }
    assembly
}

/// A loose sample of `edge^3` dimers, two spheres of diameter 1 at the distance 0.5, that begins to be compressed to a pressure of 1: modulus 1e4,
/// friction 0.3, density 1, without dashpots.
pub(crate) fn packing(edge: usize) -> Simulation {
    let piece = |x: f64| ShapePiece { centre: [x, 0.0, 0.0], radius: 0.5 };
    let inertia_over_mass = [0.10625, 0.184375, 0.184375];
    let dimer =
        RigidShape { pieces: vec![piece(-0.25), piece(0.25)], volume: 0.8835729338221, inertia_over_mass };
    let spacing = 1.6;
    let body = |k: usize| InitialBody {
        id: k as u64 + 1,
        position: [k % edge, k / edge % edge, k / edge / edge].map(|n| (n as f64 + 0.5) * spacing),
        orientation: about(&[1.0 + k as f64 % 3.0, (k as f64 * 0.7).sin(), (k as f64 * 1.3).cos()], k as f64),
        shape: 0,
        scale: 1.0,
    };
    let bodies: Vec<InitialBody> = (0..edge.pow(3)).map(body).collect();
    let material = Material::default().with(|m| {
        (m.youngs_modulus, m.poissons_ratio, m.friction, m.density) = (1e4, 0.3, 0.3, 1.0);
        m.interface_energy = 0.0;
    });
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.0);
    let cell = Cell::cuboid([spacing * edge as f64; 3]);
    let mut simulation =
        Simulation::of_bodies(cell, &[dimer], &bodies, &[], Properties::new(material, contact)).unwrap();
    simulation.expect_force(1.0);
    simulation.set_control(CellControl::isotropic(1.0, 0.2));
    simulation.set_global_damping(0.5);
    simulation
}
