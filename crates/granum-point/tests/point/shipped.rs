//! The surrogate of many sands that is shipped, as the material of a point.

use std::collections::BTreeMap;

use granum_core::geometry::{Matrix, multiply};
use granum_learn::SurrogateMethods;
use granum_point::{Controls, Increment, MaterialPoint, State, Tangent};

/// A sand of a void ratio at 100 kPa, whose fabric has no direction.
fn point(void_ratio: f64) -> MaterialPoint {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/surrogates/sand-step.json");
    let surrogate = SurrogateMethods::standard().load(file.as_ref()).unwrap();
    let mut sample: BTreeMap<String, f64> = BTreeMap::new();
    for name in surrogate.columns().input_names().into_iter().filter(|name| !name.contains("_strain")) {
        let value = match name.as_str() {
            "sample.stress_11" | "sample.stress_22" | "sample.stress_33" => 1e5,
            "sample.fabric_11" | "sample.fabric_22" | "sample.fabric_33" => 1.0 / 3.0,
            "sample.mechanical_coordination_number" => 4.6,
            "sample.void_ratio" => void_ratio,
            "grains.material.friction" => 0.5,
            "contact.rolling_friction" => 0.3,
            _ => 0.0,
        };
        sample.insert(name, value);
    }
    MaterialPoint::from_surrogate(surrogate.into(), &sample, Controls::default()).unwrap()
}

fn after(point: &MaterialPoint, increments: impl IntoIterator<Item = Increment>) -> State {
    let mut state = point.start();
    for increment in increments {
        state = point.advance(&state, &increment).unwrap().state;
    }
    state
}

fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| a[c][r]))
}

/// A path that is turned has a stress that is turned, to rounding: also at first, where the stress has no direction.
#[test]
fn a_turned_path_gives_the_turned_stress() {
    let (sin, cos) = 0.7f64.sin_cos();
    let about_x = [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]];
    let about_z = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
    let turn = multiply(&about_x, &about_z);
    let turned = |tensor: &Matrix| multiply(&multiply(&turn, tensor), &transposed(&turn));
    let strain = |k: u32| {
        let d = if (k / 8).is_multiple_of(2) { 5e-4 } else { -3e-4 };
        [[d, 0.2 * d, 0.0], [0.2 * d, -0.4 * d, 0.3 * d], [0.0, 0.3 * d, -0.5 * d]]
    };
    let point = point(0.65);
    for count in [1, 24] {
        let own = after(&point, (0..count).map(|k| Increment::from_strain(&strain(k)))).stress();
        let other = after(&point, (0..count).map(|k| Increment::from_strain(&turned(&strain(k))))).stress();
        let expected = turned(&own);
        for k in 0..9 {
            let difference = (other[k / 3][k % 3] - expected[k / 3][k % 3]).abs();
            assert!(difference < 1e-9 * own[0][0].abs(), "{count} {k} {difference}");
        }
    }
}

/// A dense sand that is sheared without drainage gains mean stress, a loose one loses it.
#[test]
fn dense_sand_gains_mean_stress_where_loose_sand_loses_it() {
    let sheared = |void_ratio: f64| {
        let point = point(void_ratio);
        let step = Increment::from_components([1e-3, -5e-4, -5e-4, 0.0, 0.0, 0.0]);
        let state = after(&point, (0..40).map(|_| step));
        assert!(state.outside().is_empty(), "{:?}", state.outside());
        (state.stress(), state.mean_stress())
    };
    let (stress, dense) = sheared(0.58);
    let ratio = (stress[0][0] - stress[2][2]) / dense;
    assert!(dense > 2e5 && (0.3..2.0).contains(&ratio), "{dense} {ratio}");
    // It cannot pull by more than a small part of the usual mean stress.
    let (_, loose) = sheared(0.78);
    assert!((-5e3..3e4).contains(&loose), "{loose}");
}

/// At rest it is as stiff in each direction, about half as stiff as the sample is elastically (a bulk modulus of 29 MPa): half of its probes unload, and half load. It
/// can be brought to a stress at rest.
#[test]
fn it_has_a_stiffness_without_direction_and_takes_a_stress() {
    let point = point(0.65);
    let stiffness = point.tangent(&point.start(), Tangent::Probes { strain: 1e-4 }).unwrap().0;
    let bulk = stiffness[..3].iter().flat_map(|row| &row[..3]).sum::<f64>() / 9.0;
    assert!((1e7..3e7).contains(&bulk), "{bulk:e}");
    for k in 0..3 {
        assert!((stiffness[k][k] - stiffness[0][0]).abs() < 1e-6 * bulk);
        assert!((stiffness[3 + k][3 + k] - 0.5 * (stiffness[0][0] - stiffness[0][1])).abs() < 0.5 * bulk);
    }
    let at_rest = [[1.5e5, 0.0, 0.0], [0.0, 1e5, 0.0], [0.0, 0.0, 1e5]];
    let imposed = point.at_stress(&point.start(), &at_rest).unwrap();
    let stress = imposed.stress();
    assert!((stress[0][0] - 1.5e5).abs() < 2e2 && (stress[1][1] - 1e5).abs() < 2e2, "{stress:?}");
    assert!(imposed.state.outside().is_empty());
}
