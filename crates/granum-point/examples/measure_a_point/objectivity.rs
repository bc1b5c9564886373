//! A sample that is rotated with its path, beside the sample that is not.

use std::error::Error;

use granum_core::geometry::{Matrix, multiply};
use granum_core::rotation::{about, matrix};
use granum_point::{Controls, Increment};

use crate::sand::point;

fn turned(turn: &Matrix, tensor: &Matrix) -> Matrix {
    let transposed: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| turn[c][r]));
    multiply(&multiply(turn, tensor), &transposed)
}

pub fn table() -> Result<(), Box<dyn Error>> {
    println!(
        "\na sample of 300 grains that is rotated by 0.6 rad with its path: largest difference of a stress over p"
    );
    println!("| axial strain | difference over p |");
    println!("|---|---|");
    let point = point(300, 1, Controls::default())?;
    let turn = matrix(&about(&[1.0, 2.0, 3.0], 0.6));
    let mut plain = point.start();
    let mut rotated = point.advance(&plain, &Increment::zero().after_rotation(&turn)?)?.state;
    let mut reached = 0.0;
    for strain in [1e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2] {
        let axial = strain - reached;
        reached = strain;
        let direction =
            [[axial, 0.2 * axial, 0.0], [0.2 * axial, -0.5 * axial, 0.0], [0.0, 0.0, -0.5 * axial]];
        plain = point.advance(&plain, &Increment::from_strain(&direction))?.state;
        rotated = point.advance(&rotated, &Increment::from_strain(&turned(&turn, &direction)))?.state;
        let (expected, stress) = (turned(&turn, &plain.stress()), rotated.stress());
        let difference =
            (0..9).map(|k| (stress[k / 3][k % 3] - expected[k / 3][k % 3]).abs()).fold(0.0f64, f64::max);
        println!("| {strain:e} | {:.1e} |", difference / plain.mean_stress());
    }
    Ok(())
}
