//! Stress and fabric, each computed in two independent ways.

use std::sync::OnceLock;

use granum_core::assembly::{Assembly, Matrix};
use granum_sensors::{column_index, measure_row};

use super::sample::{compress, mapped, properties, sample};

/// The sample at ten states between deviator strains of 0.02 and 0.04.
fn sheared() -> &'static [Assembly] {
    static STATES: OnceLock<Vec<Assembly>> = OnceLock::new();
    STATES.get_or_init(|| {
        let mut s = sample().clone();
        compress(&mut s, 0, 2e-3);
        let mut states = Vec::new();
        while states.len() < 10 {
            s.advance(400).unwrap();
            if s.state().deviator_strain() > 0.02 + 0.002 * states.len() as f64 {
                states.push(s.assembly());
            }
        }
        states
    })
}

fn value(assembly: &Assembly, column: &str) -> f64 {
    measure_row(assembly)[column_index(column).unwrap()]
}

/// Without tangential forces, every component of the stress is the derivative of the stored energy with respect to an affine
/// strain, a computation that uses no forces.
#[test]
fn stress_is_the_derivative_of_the_energy() {
    let smooth = properties(0.0, 0.0);
    let assembly = &sheared()[0];
    let identity = |r: usize, c: usize| f64::from(u8::from(r == c));
    let at_rest =
        mapped(assembly, &std::array::from_fn(|r| std::array::from_fn(|c| identity(r, c))), smooth.clone());
    let stress = at_rest.state().stress();
    let (p, volume) = (at_rest.state().mean_stress(), assembly.volume());
    let step = 1e-8;
    let mut worst = 0.0f64;
    for i in 0..3 {
        for j in i..3 {
            let energy = |e: f64| -> f64 {
                let map: Matrix = std::array::from_fn(|r| {
                    std::array::from_fn(|c| {
                        let part = 0.5 * (identity(r, i) * identity(c, j) + identity(r, j) * identity(c, i));
                        identity(r, c) - e * part
                    })
                });
                mapped(assembly, &map, smooth.clone())
                    .assembly()
                    .contacts
                    .iter()
                    .map(|c| c.normal_energy)
                    .sum()
            };
            let derivative = (energy(step) - energy(-step)) / (2.0 * step * volume);
            worst = worst.max((derivative - stress[i][j]).abs() / p);
        }
    }
    println!("stress from the energy: off by {worst:.1e} of p");
    assert!(worst < 1e-5, "{worst}");
}

/// The work that the energy balance sums over the contacts equals the integral of `V sigma : d eps`.
#[test]
fn boundary_work_is_stress_times_strain() {
    let mut s = sample().clone();
    compress(&mut s, 0, 2e-3);
    let (mut work, mut before) = (0.0, s.assembly());
    while s.state().deviator_strain() < 0.01 {
        s.advance(10).unwrap();
        let now = s.assembly();
        let stress = |a: &Assembly| granum_sensors::Observation::new(a).stress.tensor();
        let (a, b) = (stress(&before), stress(&now));
        for k in 0..3 {
            let mean = 0.5 * (a[k][k] * before.volume() + b[k][k] * now.volume());
            work += mean * (now.strain[k][k] - before.strain[k][k]);
        }
        before = now;
    }
    let ratio = work / s.state().energy().boundary_work;
    println!("integral of stress and strain over the boundary work: {ratio:.5}");
    assert!((ratio - 1.0).abs() < 5e-3, "{ratio}");
}

/// Contacts, coordination number and fabric follow from the centres of the grains alone, with all pairs and periodic images.
#[test]
fn fabric_from_the_centres() {
    for a in &sheared()[..3] {
        let edges: Vec<f64> = (0..3).map(|k| a.cell[k][k]).collect();
        let (mut count, mut sum) = (0, [0.0; 9]);
        for (n, g) in a.pieces.iter().enumerate() {
            for h in &a.pieces[n + 1..] {
                for image in 0..27 {
                    let shift = [image % 3, image / 3 % 3, image / 9].map(|s| f64::from(s) - 1.0);
                    let l: [f64; 3] =
                        std::array::from_fn(|k| h.position[k] + shift[k] * edges[k] - g.position[k]);
                    let square: f64 = l.iter().map(|x| x * x).sum();
                    if square < (g.radius + h.radius).powi(2) {
                        count += 1;
                        for k in 0..9 {
                            sum[k] += l[k / 3] * l[k % 3] / square;
                        }
                    }
                }
            }
        }
        assert_eq!(count, a.contacts.len());
        for (column, k) in [("fabric_11", 0), ("fabric_12", 1), ("fabric_33", 8)] {
            assert!((sum[k] / count as f64 - value(a, column)).abs() < 1e-12, "{column}");
        }
        let z = 2.0 * count as f64 / a.bodies.len() as f64;
        assert!((z - value(a, "coordination_number")).abs() < 1e-12);
    }
}

/// Anisotropies of a state: those of the contact directions, the normal forces and the tangential forces (deviators of the
/// tensors a in `E(n) = (1 + a_c : n n) / 4 pi` and so on).
fn anisotropies(a: &Assembly) -> [f64; 3] {
    let count = a.contacts.len() as f64;
    let diagonal = |of: &dyn Fn(usize, &granum_core::assembly::Contact) -> f64| -> [f64; 3] {
        std::array::from_fn(|k| a.contacts.iter().map(|c| of(k, c)).sum::<f64>() / count)
    };
    let deviator = |t: [f64; 3]| t[0] - 0.5 * (t[1] + t[2]);
    let trace = |t: [f64; 3]| t.iter().sum::<f64>();
    let fabric = diagonal(&|k, c| c.normal[k] * c.normal[k]);
    let contact = fabric.map(|x| 7.5 * (x - 1.0 / 3.0));
    // The means are taken over directions, not over contacts.
    let share = |c: &granum_core::assembly::Contact| {
        1.0 + (0..3).map(|k| contact[k] * c.normal[k] * c.normal[k]).sum::<f64>()
    };
    let normal = diagonal(&|k, c| c.normal_force * c.normal[k] * c.normal[k] / share(c));
    let tangential = diagonal(&|k, c| -c.tangential_force[k] * c.normal[k] / share(c));
    [deviator(contact), 7.5 * deviator(normal) / trace(normal), 5.0 * deviator(tangential) / trace(normal)]
}

/// The stress-force-fabric relation (Rothenburg and Bathurst 1989; Ouadfel and Rothenburg 2001) holds: to first order
/// `q/p = 2/5 (a_c + a_n + 3/2 a_t)`.
#[test]
fn stress_force_and_fabric_agree() {
    let mut sums = [0.0; 5];
    for a in sheared() {
        let [c, n, t] = anisotropies(a);
        for (sum, x) in sums.iter_mut().zip([c, n, t, 0.4 * (c + n + 1.5 * t), value(a, "stress_ratio")]) {
            *sum += x / sheared().len() as f64;
        }
    }
    let [c, n, t, predicted, measured] = sums;
    println!("a_c {c:.3} a_n {n:.3} a_t {t:.3}: q/p {predicted:.4}, from the stress {measured:.4}");
    assert!((predicted / measured - 1.0).abs() < 0.05, "{predicted} {measured}");
    assert!(n > c && c > 0.0 && t > 0.0);
}

/// The sensor, which assumes no axis, finds the anisotropies that the sums along the axis of compression give, and the stress ratio
/// of its relation is the von Mises ratio.
#[test]
fn the_sensor_of_anisotropies_finds_those_along_the_axis() {
    for a in sheared() {
        let observation = granum_sensors::Observation::new(a);
        let found = granum_sensors::anisotropies::Anisotropy::from_observation(&observation);
        let [contact, normal, tangential] = anisotropies(a);
        for (value, along) in
            [(found.contacts, contact), (found.normal, normal), (found.tangential, tangential)]
        {
            // What lies across the axis adds to the size of the tensor.
            assert!(value >= along - 1e-12 && value < along + 0.1, "{found:?} {along}");
        }
        let relation = 0.4 * (found.contacts + found.normal + 1.5 * found.tangential);
        let stress = observation.stress.tensor();
        let ratio = granum_dem::invariants::signed_von_mises(&stress) / observation.stress.mean();
        assert!((relation / ratio - 1.0).abs() < 0.15, "{relation} {ratio}");
    }
}

/// Volumes of the Voronoi cells of a sheared sample add up to the cell, and its local solid fractions lie about the whole one.
#[test]
fn voronoi_cells_of_a_sheared_sample_fill_the_cell() {
    let a = &sheared()[9];
    let positions: Vec<[f64; 3]> = a.bodies.iter().map(|grain| grain.position).collect();
    let radii: Vec<f64> = a.pieces.iter().map(|piece| piece.radius).collect();
    let cells = granum_sensors::local_solid_fraction::radical_voronoi(&a.cell, &positions, &radii);
    let volume: f64 = cells.iter().map(|cell| cell.volume).sum();
    assert!((volume / a.volume() - 1.0).abs() < 1e-12, "{}", volume / a.volume() - 1.0);
    let faces = cells.iter().map(|cell| cell.faces).sum::<usize>() as f64 / cells.len() as f64;
    println!("{faces:.2} faces a cell");
    // Random packings of equal spheres have some 14.3 (Finney 1970).
    assert!((13.8..15.0).contains(&faces), "{faces}");
}
