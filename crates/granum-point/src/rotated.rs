//! Tensors and stiffnesses in rotated axes.

use granum_core::geometry::{Matrix, multiply};
use granum_dem::servo::PLACES;
use granum_run::stiffness;

use crate::matrix_functions::{UNIT, transposed};

/// A tensor that is known in the axes of the cell, in those of space: `R t R^T`. Without a rotation it keeps its bits.
pub(crate) fn to_space(rotation: &Matrix, tensor: &Matrix) -> Matrix {
    if *rotation == UNIT { *tensor } else { multiply(&multiply(rotation, tensor), &transposed(rotation)) }
}

/// A tensor that is known in the axes of space, in those of the cell: `R^T t R`. Without a rotation it keeps its bits.
pub(crate) fn to_cell(rotation: &Matrix, tensor: &Matrix) -> Matrix {
    if *rotation == UNIT { *tensor } else { multiply(&multiply(&transposed(rotation), tensor), rotation) }
}

/// A stiffness in the axes of space: column by column, from a unit strain in space.
pub(crate) fn stiffness_to_space(rotation: &Matrix, stiffness: &stiffness::Tensor) -> stiffness::Tensor {
    if *rotation == UNIT {
        return *stiffness;
    }
    let mut rotated = stiffness::Tensor::default();
    for j in 0..6 {
        let [r, c] = PLACES[j];
        let mut strain = [[0.0; 3]; 3];
        strain[r][c] += 0.5;
        strain[c][r] += 0.5;
        let stress = stiffness.stress(&to_cell(rotation, &strain));
        let mut tensor = [[0.0; 3]; 3];
        for (k, [r, c]) in PLACES.into_iter().enumerate() {
            (tensor[r][c], tensor[c][r]) = (stress[k], stress[k]);
        }
        let tensor = to_space(rotation, &tensor);
        for (i, [r, c]) in PLACES.into_iter().enumerate() {
            rotated.0[i][j] = tensor[r][c];
        }
    }
    rotated
}

#[cfg(test)]
mod tests {
    use granum_core::rotation::{about, matrix};
    use granum_run::stiffness::Tensor;

    use super::*;

    #[test]
    fn a_quarter_turn_about_z_exchanges_x_and_y() {
        let turn = matrix(&about(&[0.0, 0.0, 1.0], 0.5 * std::f64::consts::PI));
        let tensor = [[1.0, 0.5, 0.0], [0.5, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let turned = to_space(&turn, &tensor);
        for (value, exact) in
            [(turned[0][0], 2.0), (turned[1][1], 1.0), (turned[0][1], -0.5), (turned[2][2], 3.0)]
        {
            assert!((value - exact).abs() < 1e-15, "{turned:?}");
        }
        let back = to_cell(&turn, &turned);
        assert!((back[0][1] - 0.5).abs() < 1e-15 && (back[0][0] - 1.0).abs() < 1e-15);

        let mut stiff = Tensor::isotropic(2.0, 1.0);
        // Stiffer along x, and an asymmetric coupling of the stress along x with the shear in the plane xy.
        stiff.0[0][0] += 5.0;
        stiff.0[0][5] = 0.7;
        let turned = stiffness_to_space(&turn, &stiff).0;
        assert!((turned[1][1] - stiff.0[0][0]).abs() < 1e-14, "{turned:?}");
        assert!((turned[1][5] + 0.7).abs() < 1e-14 && turned[5][1].abs() < 1e-14, "{turned:?}");
    }

    #[test]
    fn an_isotropic_stiffness_has_no_axes() {
        let stiff = Tensor::isotropic(2.0, 1.5);
        let turned = stiffness_to_space(&matrix(&about(&[1.0, -2.0, 0.4], 1.1)), &stiff);
        for k in 0..36 {
            assert!((turned.0[k / 6][k % 6] - stiff.0[k / 6][k % 6]).abs() < 2e-15);
        }
    }
}
