use granum_core::cell::Cell;
use granum_dem::config::{ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::simulation::{InitialSphere, Properties, Simulation};

use super::*;

/// A lattice of spheres of 0.1 mm, E = 70 GPa, nu = 0.3, with an overlap of 1e-4 of the diameter; a basis in cubes of one edge.
fn lattice(n: u64, edge: f64, basis: &[[f64; 3]], contact: ContactModel) -> Simulation {
    let material = Material::default().with(|material| {
        material.interface_energy = 0.0;
        material.friction = 0.3;
    });
    let mut spheres = Vec::new();
    for cube in 0..n * n * n {
        let corner = [cube % n, cube / n % n, cube / (n * n)];
        for offset in basis {
            let position = std::array::from_fn(|a| (corner[a] as f64 + offset[a] + 0.25) * edge);
            spheres.push(InitialSphere { id: spheres.len() as u64 + 1, position, radius: 5e-5 });
        }
    }
    let cell = Cell::cuboid([n as f64 * edge; 3]);
    Simulation::new(cell, &spheres, Properties::new(material, contact)).unwrap()
}

const NEIGHBOUR: f64 = 1e-4 * (1.0 - 1e-4);

fn simple_cubic(contact: ContactModel) -> Simulation {
    lattice(3, NEIGHBOUR, &[[0.0; 3]], contact)
}

fn face_centred(contact: ContactModel) -> Simulation {
    let basis = [[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];
    lattice(2, NEIGHBOUR * 2f64.sqrt(), &basis, contact)
}

fn assert_cubic(found: &Stiffness, [c11, c12, c44]: [f64; 3], tolerance: f64) {
    assert!(found.settled, "{found:?}");
    for i in 0..6 {
        for j in 0..6 {
            let exact = match (i < 3 && j < 3, i == j) {
                (true, true) => c11,
                (true, false) => c12,
                (false, true) => c44,
                (false, false) => 0.0,
            };
            for tensor in [&found.tensor, &found.affine] {
                let value = tensor.0[i][j];
                assert!((value - exact).abs() < tolerance * c11, "{i} {j}: {value} {exact}");
            }
        }
    }
}

/// Lattices under a prestress p with a length L between neighbours: SC `C11 = k_n / L`, `C12 = p`, `C44 = k_t / 2L - p`; FCC
/// `C11 = sqrt(2) (k_n + k_t) / L - p/2`, `C12 = (k_n - k_t) / (sqrt(2) L) + 5/4 p`, `C44 = (k_n + k_t) / (sqrt(2) L) - 3/4 p`.
/// By symmetry the motion of the grains is affine, so that the affine tensor is the same. The tangential law gives different
/// forces for increasing and for decreasing normal forces; the relative difference, of the order of strain over overlap, is
/// visible in the face-centred lattice with the default strain, a thousandth of the overlap, and negligible with a smaller
/// strain.
#[test]
fn lattices_have_their_analytic_stiffness() {
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    // Smaller strains lose digits: the overlap is a difference of positions.
    let tiny = Probing { strain: 1e-8, ..Probing::default() };
    for (probing, tolerance) in [(tiny, 5e-6), (Probing::default(), 5e-5)] {
        let found = measure(&simple_cubic(contact), &probing).unwrap();
        assert_cubic(&found, [3.846538340e8, 2.564615463e4, 1.583612333e8], tolerance);
        let found = measure(&face_centred(contact), &probing).unwrap();
        assert_cubic(&found, [9.919321617e8, 4.808914254e7, 4.959298122e8], tolerance);
    }
}

/// With large strains contacts of small friction slide, unless they are kept from it.
#[test]
fn only_without_sliding_is_a_large_probe_elastic() {
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let large = Probing { strain: 5e-5, ..Probing::default() };
    let shear = |probing: &Probing| {
        let mut lattice = simple_cubic(contact);
        let mut properties = lattice.properties().clone();
        properties.material.friction = 0.05;
        lattice.set_properties(properties).unwrap();
        measure(&lattice, probing).unwrap().tensor.0[5][5] / 1.583612333e8
    };
    assert!((shear(&large) - 1.0).abs() < 0.01, "{}", shear(&large));
    let sliding = shear(&Probing { elastic: false, ..large });
    // Each tangential force, k_t gamma L / 2 = 7.9e-5 N, is limited to 0.05 x 2.56e-4 N = 1.28e-5 N.
    assert!((sliding - 0.162).abs() < 0.01, "{sliding}");
}

/// Measuring changes nothing of the simulation.
#[test]
fn the_simulation_goes_on_with_the_same_bits() {
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let mut measured = face_centred(contact);
    let mut alone = measured.clone();
    measure(&measured, &Probing { most_blocks: 2, ..Probing::default() }).unwrap();
    for simulation in [&mut measured, &mut alone] {
        simulation.advance(50).unwrap();
    }
    assert_eq!(measured.assembly(), alone.assembly());
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let loose = lattice(3, 1.1e-4, &[[0.0; 3]], contact);
    let error = measure(&loose, &Probing::default()).unwrap_err().to_string();
    assert!(error.contains("carries no load"), "{error}");
    let far = Probing { strain: 0.1, ..Probing::default() };
    let error = measure(&simple_cubic(contact), &far).unwrap_err().to_string();
    assert_eq!(error, "the strain of a probe is 1e-1; it must be from 1e-10 to 0.01");
    let error =
        degradation(&simple_cubic(contact), &[1e-4, 1e-5], &Probing::default()).unwrap_err().to_string();
    assert!(error.contains("above the one before"), "{error}");
}
