//! Bonded spheres as beams: the lowest frequency of a cantilever, and a ring that is pressed along a diameter.

use super::law::beam::BeamBond;
use super::law::bond_law::{BondLaw, BondShape, BondStiffness};
use super::law::parallel::ParallelBond;
use super::statics_tests::{Frame, LENGTH, SHAPE, cantilever, parallel, solve};

const MODULUS: f64 = 1e9;
const DENSITY: f64 = 2650.0;
const SPHERE: f64 = 50e-6;

/// Mass, kg, and moment of inertia, kg m2, of a sphere.
fn sphere() -> (f64, f64) {
    let mass = DENSITY * 4.0 / 3.0 * std::f64::consts::PI * SPHERE.powi(3);
    (mass, 0.4 * mass * SPHERE * SPHERE)
}

/// The lowest angular frequency of a cantilever in bending, rad/s: by inverse iteration, `K x' = M x`.
fn lowest_frequency(bonds: usize, stiffness: BondStiffness) -> f64 {
    let (free, matrix) = cantilever(bonds, stiffness).matrix(&[0]);
    let (mass, inertia) = sphere();
    let masses: Vec<f64> = free.iter().map(|of| if of % 6 < 3 { mass } else { inertia }).collect();
    // Only along the second axis and about the third.
    let mut x: Vec<f64> = free.iter().map(|of| if of % 6 == 1 { LENGTH } else { 0.0 }).collect();
    let mut square = 0.0;
    for _ in 0..30 {
        let mut rows = matrix.clone();
        for (row, (x, mass)) in rows.iter_mut().zip(x.iter().zip(&masses)) {
            row.push(x * mass);
        }
        let next = solve(rows);
        let along = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).zip(&masses).map(|((a, b), mass)| a * b * mass).sum::<f64>()
        };
        square = along(&x, &next) / along(&next, &next);
        let length = along(&next, &next).sqrt();
        x = next.into_iter().map(|value| value / length).collect();
    }
    square.sqrt()
}

/// The golden numbers are eigenvalues of textbook matrices of beams with the masses and moments of inertia of the spheres at their nodes.
#[test]
fn a_cantilever_vibrates_with_the_frequency_of_a_beam() {
    let beam = BeamBond.stiffness(&SHAPE, &[MODULUS, 0.25, 1.0]);
    let springs = [495_946.301_961_97, 172_831.737_755_37, 35_131.964_883_396, 9_608.961_522_720_6];
    let elements = [457_163.590_655_68, 167_628.015_524_71, 34_908.292_128_867, 9_592.108_321_442_4];
    for (golden, stiffness) in [(springs, parallel()), (elements, beam)] {
        for (bonds, golden) in [1, 2, 5, 10].into_iter().zip(golden) {
            let found = lowest_frequency(bonds, stiffness);
            assert!((found / golden - 1.0).abs() < 1e-6, "{bonds}: {found} {golden}");
        }
    }
    // A slender beam of the mass of the spheres over their distance, which ends half a distance beyond the last: Euler and Bernoulli's
    // `1.8751^2 sqrt(E I / (mu L^4))`, to the second order in the number of bonds.
    let error = |bonds: usize| {
        let length = (bonds as f64 + 0.5) * LENGTH;
        let line = sphere().0 / LENGTH;
        let right =
            1.875_104_068_7f64.powi(2) * (MODULUS * SHAPE.second_moment() / line).sqrt() / length.powi(2);
        1.0 - lowest_frequency(bonds, beam) / right
    };
    let errors = [error(5), error(10), error(20)];
    assert!(errors[0] < 2.1e-3 && errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[1], "{errors:?}");
}

/// The approach of two opposite spheres of a ring per newton.
fn ring(count: usize, law: &dyn BondLaw, parameters: &[f64]) -> f64 {
    const RADIUS: f64 = 1e-3;
    let angle = |k: usize| 2.0 * std::f64::consts::PI * k as f64 / count as f64;
    let places =
        (0..count).map(|k| [RADIUS * angle(k).sin(), -RADIUS * angle(k).cos(), 0.0]).collect::<Vec<_>>();
    let length = 2.0 * RADIUS * (0.5 * angle(1)).sin();
    let stiffness = law.stiffness(&BondShape { radius: SHAPE.radius, length }, parameters);
    let bonds = (0..count).map(|k| [k, (k + 1) % count]).collect();
    let force = 1e-9;
    let moved = Frame { places, bonds, stiffness }.displaced(&[0], count / 2, [0.0, -force, 0.0]);
    -moved[count / 2][1] / force
}

/// A thin ring under two opposite forces approaches by `P R^3/(E I) (pi/4 - 2/pi) + pi/4 P R (1/(E A) + 1/(G A))` (Timoshenko 1955);
/// frames of straight members come to it with the square of their number.
#[test]
fn a_ring_gives_way_as_that_of_timoshenko() {
    let thin = 1.186_128_317_883_1;
    // Of the frame of straight members, by textbook matrices.
    let golden =
        [(8, 0.763_456_207_350_2, 1.060_771_918_018_7), (32, 1.156_742_718_757_8, 1.176_725_914_933_7)];
    for (count, springs, elements) in golden {
        let found = [
            ring(count, &ParallelBond, &[MODULUS, 0.25, 0.0]),
            ring(count, &BeamBond, &[MODULUS, 0.25, 1.0]),
        ];
        for (found, golden) in found.into_iter().zip([springs, elements]) {
            assert!((found / golden - 1.0).abs() < 1e-6, "{count}: {found} {golden}");
        }
        assert!(1.0 - found[1] / thin < 8.2 / (count * count) as f64, "{count}");
    }
}
