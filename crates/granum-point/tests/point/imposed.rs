//! C6: a stress that the host imposes.

use granum_point::{Increment, PointError};

use crate::sample::point;

/// The stress -50, -100, -50 kPa of a host is 50, 100, 50 kPa here; ten zero increments later it is the same to the bit.
#[test]
fn an_imposed_stress_is_taken_over_and_does_not_drift() {
    let point = point();
    let stress = [[50e3, 0.0, 0.0], [0.0, 100e3, 0.0], [0.0, 0.0, 50e3]];
    let answer = point.at_stress(&point.start(), &stress).unwrap();
    for r in 0..3 {
        for c in 0..3 {
            let got = answer.stress()[r][c];
            assert!((got - stress[r][c]).abs() < 1e-3 * 100e3, "{r} {c}: {got}");
        }
    }
    let mut state = answer.state.clone();
    for _ in 0..10 {
        state = point.advance(&state, &Increment::zero()).unwrap().state;
    }
    assert_eq!(state.stress(), answer.stress());
    // From the same state the same bits; and the stress that it has is the stress that it keeps.
    let other = crate::sample::point();
    let again = other.at_stress(&other.start(), &stress).unwrap();
    assert_eq!(again.stress(), answer.stress());
    assert!(point.at_stress(&state, &answer.stress()).unwrap().state.is_same_value(&state));
}

/// What no sample carries is refused, and the state that was asked is as it was.
#[test]
fn a_stress_beyond_the_strength_is_refused() {
    let point = point();
    let start = point.start();
    let before = start.stress();
    for axial in [1e6, -100e3] {
        let stress = [[axial, 0.0, 0.0], [0.0, 50e3, 0.0], [0.0, 0.0, 50e3]];
        let error = point.at_stress(&start, &stress).unwrap_err();
        assert!(matches!(error, PointError::StressNotReached { .. }), "{error}");
    }
    assert!(point.at_stress(&start, &[[f64::NAN; 3]; 3]).is_err());
    assert_eq!(start.stress(), before);
}

/// A host that begins without stress gets a sample without stress, which can be loaded again.
#[test]
fn no_stress_can_be_imposed() {
    let point = point();
    let empty = point.at_stress(&point.start(), &[[0.0; 3]; 3]).unwrap();
    assert!(
        empty.state.mean_stress().abs() < 1e-3 * point.least_mean_stress(),
        "{}",
        empty.state.mean_stress()
    );
    let loaded =
        point.at_stress(&empty.state, &[[20e3, 0.0, 0.0], [0.0, 20e3, 0.0], [0.0, 0.0, 20e3]]).unwrap();
    assert!((loaded.state.mean_stress() / 20e3 - 1.0).abs() < 1e-3);
}
