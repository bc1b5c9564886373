//! The stiffness of a state, by the four ways in which it is found.

use granum_point::{Increment, Tangent};

use crate::sample::{difference, point};

#[test]
fn the_four_ways_agree_as_theory_says() {
    let point = point();
    let state = point.start();
    let elastic = point.tangent(&state, Tangent::Elastic).unwrap();
    let affine = point.tangent(&state, Tangent::Affine).unwrap();
    assert!(affine.bulk_modulus() > elastic.bulk_modulus(), "grains that follow the cell are an upper bound");
    assert!(affine.shear_modulus() > elastic.shear_modulus());
    assert!(elastic.bulk_modulus() > 0.3 * affine.bulk_modulus());
    // Tiny probes are nearly elastic: few contacts slide.
    let probed = point.tangent(&state, Tangent::Probes { strain: 1e-7 }).unwrap();
    assert!((probed.bulk_modulus() / elastic.bulk_modulus() - 1.0).abs() < 0.3, "{probed:?} {elastic:?}");
    assert_eq!(point.tangent(&state, Tangent::Secant).unwrap(), affine, "no increment yet");
    assert!(point.tangent(&state, Tangent::Probes { strain: 1.0 }).is_err());
}

/// C2 within the library: of a sheared cell the tangent is the central difference of the answers, its asymmetry included.
#[test]
fn a_tangent_is_the_difference_of_the_answers() {
    let point = point();
    let shear = Increment::from_components([4e-3, -2e-3, -2e-3, 0.0, 0.0, 6e-3]);
    let state = point.advance(&point.start(), &shear).unwrap().state;
    let strain = 1e-5;
    let tangent = point.tangent(&state, Tangent::Probes { strain }).unwrap().0;
    let largest = tangent.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs()));
    let mut asymmetry = 0.0f64;
    for j in 0..6 {
        let ask = |sign: f64| {
            let mut components = [0.0; 6];
            components[j] = sign * strain;
            point.advance(&state, &Increment::from_components(components)).unwrap().stress()
        };
        let (forward, backward) = (ask(1.0), ask(-1.0));
        for i in 0..6 {
            let [r, c] = [[0, 0], [1, 1], [2, 2], [1, 2], [2, 0], [0, 1]][i];
            let mean = |t: &[[f64; 3]; 3]| 0.5 * (t[r][c] + t[c][r]);
            let slope = (mean(&forward) - mean(&backward)) / (2.0 * strain);
            assert!((slope - tangent[i][j]).abs() < 1e-3 * largest, "{i} {j}: {slope} {}", tangent[i][j]);
            asymmetry = asymmetry.max((tangent[i][j] - tangent[j][i]).abs());
        }
    }
    assert!(
        asymmetry > 0.01 * largest,
        "a sheared sample with sliding contacts has no potential: {asymmetry}"
    );
}

/// The secant gives the stress of the last increment, and trials that were not taken do not enter it.
#[test]
fn the_secant_follows_the_path_of_its_state() {
    let point = point();
    let start = point.start();
    let increment = Increment::from_components([2e-4, -1e-4, 0.0, 0.0, 0.0, 1e-4]);
    for trial in [1e-3, 5e-4] {
        point.advance(&start, &Increment::from_components([trial; 6])).unwrap();
    }
    let answer = point.advance(&start, &increment).unwrap();
    let foreseen = point.tangent(&answer.state, Tangent::Secant).unwrap().stress(increment.strain());
    let (after, before) = (answer.stress(), start.stress());
    assert!((foreseen[0] - (after[0][0] - before[0][0])).abs() < 1.0, "{foreseen:?}");
    let alone = crate::sample::point();
    let other = alone.advance(&alone.start(), &increment).unwrap();
    assert_eq!(other.state.secant(), answer.state.secant());
    assert_eq!(difference(&other.stress(), &answer.stress()), 0.0);
}
