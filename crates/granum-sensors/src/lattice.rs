//! Simple assemblies for the tests of the sensors.

use granum_core::assembly::{Assembly, Contact, Matrix, Sphere, Vector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Simple cubic lattice of n^3 spheres of diameter d, strained so that neighbours are at a distance of d (1 - strain).
pub(crate) fn simple_cubic(n: usize, d: f64, strain: f64, force: f64) -> Assembly {
    let spacing = d * (1.0 - strain);
    build(n, spacing, &[[0.0; 3]], d, spacing, force)
}

/// Face-centred cubic lattice of 4 n^3 spheres.
pub(crate) fn face_centred_cubic(n: usize, d: f64, strain: f64, force: f64) -> Assembly {
    let neighbour = d * (1.0 - strain);
    let basis = [[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];
    build(n, neighbour * 2f64.sqrt(), &basis, d, neighbour, force)
}

fn build(n: usize, edge: f64, basis: &[Vector], d: f64, neighbour: f64, force: f64) -> Assembly {
    let mut grains = Vec::new();
    for cell in 0..n * n * n {
        let corner = [cell % n, cell / n % n, cell / (n * n)];
        for offset in basis {
            grains.push(Sphere {
                id: grains.len() as u64 + 1,
                position: std::array::from_fn(|a| (corner[a] as f64 + offset[a] + 0.25) * edge),
                radius: 0.5 * d,
                mass: 1e-9,
                ..Default::default()
            });
        }
    }
    let length = n as f64 * edge;
    let mut contacts = Vec::new();
    for i in 0..grains.len() {
        for j in i + 1..grains.len() {
            let branch: Vector = std::array::from_fn(|a| {
                let x = grains[j].position[a] - grains[i].position[a];
                x - length * (x / length).round()
            });
            let distance = branch.iter().map(|x| x * x).sum::<f64>().sqrt();
            if distance < neighbour * (1.0 + 1e-6) {
                contacts.push(Contact {
                    i,
                    j,
                    branch,
                    normal: branch.map(|x| x / distance),
                    approach: d - distance,
                    normal_force: force,
                    ..Default::default()
                });
            }
        }
    }
    Assembly { cell: diagonal(length), contacts, ..Default::default() }.with_spheres(grains)
}

fn diagonal(length: f64) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { length } else { 0.0 }))
}

/// Contacts with random isotropic normals and random forces between grains of random radii.
pub(crate) fn random_contacts(count: usize, seed: u64) -> Assembly {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = move || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let grains: Vec<Sphere> = (0..count)
        .map(|k| Sphere {
            id: k as u64 + 1,
            position: std::array::from_fn(|_| uniform()),
            velocity: std::array::from_fn(|_| uniform() - 0.5),
            radius: 0.02 + 0.03 * uniform(),
            mass: 1e-3,
            ..Default::default()
        })
        .collect();
    let contacts = (0..3 * count)
        .map(|k| {
            let i = k % count;
            let j = (k + 1 + k / count) % count;
            let normal = direction(&mut uniform);
            let other = direction(&mut uniform);
            let along: f64 = (0..3).map(|a| other[a] * normal[a]).sum();
            let distance = grains[i].radius + grains[j].radius;
            let normal_force = 4.0 * uniform() - 0.5;
            Contact {
                i,
                j,
                branch: normal.map(|x| x * distance),
                normal,
                normal_force,
                tangential_force: std::array::from_fn(|a| 0.3 * (other[a] - along * normal[a])),
                sliding: uniform() < 0.2,
                ..Default::default()
            }
        })
        .collect();
    Assembly { cell: diagonal(1.0), contacts, ..Default::default() }.with_spheres(grains)
}

/// A direction, uniform on the sphere.
fn direction(uniform: &mut impl FnMut() -> f64) -> Vector {
    let cosine = 2.0 * uniform() - 1.0;
    let azimuth = 2.0 * std::f64::consts::PI * uniform();
    let sine = (1.0 - cosine * cosine).sqrt();
    [cosine, sine * azimuth.cos(), sine * azimuth.sin()]
}

/// Rotation matrix about an axis (Rodrigues).
pub(crate) fn rotation(axis: Vector, angle: f64) -> Matrix {
    let norm = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z] = axis.map(|v| v / norm);
    let (s, c) = angle.sin_cos();
    let v = 1.0 - c;
    [
        [c + x * x * v, x * y * v - z * s, x * z * v + y * s],
        [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
        [z * x * v - y * s, z * y * v + x * s, c + z * z * v],
    ]
}

/// The whole assembly, rotated.
pub(crate) fn rotated(assembly: &Assembly, q: &Matrix) -> Assembly {
    let turn = |v: Vector| std::array::from_fn(|i| (0..3).map(|j| q[i][j] * v[j]).sum());
    let mut out = assembly.clone();
    out.cell =
        std::array::from_fn(|i| std::array::from_fn(|k| (0..3).map(|j| q[i][j] * assembly.cell[j][k]).sum()));
    for grain in &mut out.bodies {
        grain.position = turn(grain.position);
        grain.velocity = turn(grain.velocity);
    }
    for contact in &mut out.contacts {
        contact.branch = turn(contact.branch);
        contact.normal = turn(contact.normal);
        contact.tangential_force = turn(contact.tangential_force);
    }
    out
}

/// `q t q^T`.
pub(crate) fn conjugate(q: &Matrix, t: &Matrix) -> Matrix {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            (0..3).flat_map(|k| (0..3).map(move |l| (k, l))).map(|(k, l)| q[i][k] * t[k][l] * q[j][l]).sum()
        })
    })
}
