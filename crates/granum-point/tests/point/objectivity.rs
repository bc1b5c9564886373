//! A sample that is rotated with its path has the stress of the one that is not.

use granum_core::geometry::{Matrix, multiply};
use granum_core::rotation::{about, matrix};
use granum_point::Increment;

use crate::sample::{difference, point};

fn transposed(a: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| a[c][r]))
}

fn turned(turn: &Matrix, tensor: &Matrix) -> Matrix {
    multiply(&multiply(turn, tensor), &transposed(turn))
}

/// A rigid rotation before a strain turns the stress and changes nothing else.
#[test]
fn a_rigid_rotation_turns_the_stress() {
    let point = point();
    let turn = matrix(&about(&[0.3, -1.0, 0.5], 0.8));
    let strain = [[1e-4, 3e-5, 0.0], [3e-5, -5e-5, 0.0], [0.0, 0.0, 2e-5]];
    let plain = point.advance(&point.start(), &Increment::from_strain(&strain)).unwrap();
    let rotated = Increment::from_strain(&turned(&turn, &strain)).after_rotation(&turn).unwrap();
    let rotated = point.advance(&point.start(), &rotated).unwrap();
    let expected = turned(&turn, &plain.stress());
    assert!(difference(&rotated.stress(), &expected) < 1e-9 * 1e5, "{:?} {expected:?}", rotated.stress());
    // A rotation alone runs no step.
    let alone = point.advance(&plain.state, &Increment::zero().after_rotation(&turn).unwrap()).unwrap();
    assert_eq!(alone.steps, 0);
    assert!(difference(&alone.stress(), &expected) < 1e-12 * 1e5);
}

/// Over the first 1e-4 of strain a path in ten steps that rotate with it differs by rounding, multiplied by the motion of grains.
#[test]
fn a_rotated_path_gives_the_rotated_stress() {
    let point = point();
    let turn = matrix(&about(&[1.0, 2.0, 3.0], 0.6));
    let strain = [[1e-5, 0.0, 4e-6], [0.0, -5e-6, 0.0], [4e-6, 0.0, 0.0]];
    let mut plain = point.start();
    let mut rotated =
        point.advance(&point.start(), &Increment::zero().after_rotation(&turn).unwrap()).unwrap().state;
    for _ in 0..10 {
        plain = point.advance(&plain, &Increment::from_strain(&strain)).unwrap().state;
        rotated = point.advance(&rotated, &Increment::from_strain(&turned(&turn, &strain))).unwrap().state;
    }
    let expected = turned(&turn, &plain.stress());
    let worst = difference(&rotated.stress(), &expected);
    assert!(worst < 1e-9 * 1e5, "{worst} Pa");
}

/// Simple shear by its velocity gradient keeps the base of the cell in its plane: in the axes of space the cell is `H + gamma`.
#[test]
fn simple_shear_shears_the_cell() {
    let point = point();
    let start = point.start();
    let step = Increment::from_velocity_gradient(&[[0.0, 5e-3, 0.0], [0.0; 3], [0.0; 3]], 1.0).unwrap();
    let mut state = start.clone();
    for _ in 0..4 {
        state = point.advance(&state, &step).unwrap().state;
    }
    let in_space = multiply(state.rotation(), state.cell().unwrap());
    let expected = multiply(&[[1.0, 0.02, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], start.cell().unwrap());
    assert!(
        difference(&in_space, &expected) < 1e-10 * start.cell().unwrap()[0][0],
        "{in_space:?} {expected:?}"
    );
}
