//! The 6 x 6 stiffness of a sample and what follows from it.

use granum_core::assembly::Matrix;

/// A stiffness by components (xx, yy, zz, yz, zx, xy): stress `d_sigma_i = C_ij d_eps_j`, Pa, compression positive, with shear
/// strains as angles.
///
/// ```
/// use granum_run::stiffness::Tensor;
///
/// let (k, g) = (2e8, 1.5e8);
/// let tensor = Tensor::isotropic(k, g);
/// assert!((tensor.bulk_modulus() / k - 1.0).abs() < 1e-12 && (tensor.shear_modulus() / g - 1.0).abs() < 1e-12);
/// assert!(tensor.anisotropy().unwrap().abs() < 1e-9);
/// let [young, _, _] = tensor.youngs_moduli().unwrap();
/// assert!((young / (9.0 * k * g / (3.0 * k + g)) - 1.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tensor(pub [[f64; 6]; 6]);

impl Tensor {
    /// The stiffness of an isotropic solid with these bulk and shear moduli.
    pub fn isotropic(bulk: f64, shear: f64) -> Tensor {
        Tensor(std::array::from_fn(|i| {
            std::array::from_fn(|j| match (i < 3, j < 3, i == j) {
                (true, true, same) => bulk + shear * if same { 4.0 / 3.0 } else { -2.0 / 3.0 },
                (false, false, true) => shear,
                _ => 0.0,
            })
        }))
    }

    /// Bulk modulus K: the mean stress in a uniform compression over the volumetric strain (Voigt average), Pa.
    pub fn bulk_modulus(&self) -> f64 {
        let c = &self.0;
        (0..3).map(|i| c[i][..3].iter().sum::<f64>()).sum::<f64>() / 9.0
    }

    /// Shear modulus G, the Voigt average over all directions, Pa: of an isotropic sample its shear modulus.
    pub fn shear_modulus(&self) -> f64 {
        let c = &self.0;
        let axial = c[0][0] + c[1][1] + c[2][2];
        let cross = 0.5 * (c[0][1] + c[1][0] + c[1][2] + c[2][1] + c[2][0] + c[0][2]);
        (axial - cross + 3.0 * (c[3][3] + c[4][4] + c[5][5])) / 15.0
    }

    /// The compliance, 1/Pa; `None` where the stiffness is singular.
    pub fn compliance(&self) -> Option<[[f64; 6]; 6]> {
        inverse(&self.0)
    }

    /// Young's moduli along x, y and z at constant lateral stress, Pa; `None` where the stiffness is singular.
    pub fn youngs_moduli(&self) -> Option<[f64; 3]> {
        let s = self.compliance()?;
        Some(std::array::from_fn(|k| 1.0 / s[k][k]))
    }

    /// Universal anisotropy `5 G_V / G_R + K_V / K_R - 6` of Voigt's and Reuss's averages (Ranganathan and Ostoja-Starzewski
    /// 2008): zero for an isotropic solid, else positive. `None` where the stiffness is singular.
    pub fn anisotropy(&self) -> Option<f64> {
        let s = self.compliance()?;
        let bulk: f64 = (0..3).map(|i| s[i][..3].iter().sum::<f64>()).sum();
        let axial = s[0][0] + s[1][1] + s[2][2];
        let cross = 0.5 * (s[0][1] + s[1][0] + s[1][2] + s[2][1] + s[2][0] + s[0][2]);
        let shear = (4.0 * (axial - cross) + 3.0 * (s[3][3] + s[4][4] + s[5][5])) / 15.0;
        Some(5.0 * self.shear_modulus() * shear + self.bulk_modulus() * bulk - 6.0)
    }

    /// Largest `|C_ij - C_ji|` over the largest entry: 0 where an elastic potential exists. It is not exactly zero in a sample
    /// under an anisotropic stress, which changes with the shape of the cell even at constant contact forces (a part of the order
    /// of q over the stiffness), nor where contacts slide.
    pub fn asymmetry(&self) -> f64 {
        let c = &self.0;
        let pairs = (0..6).flat_map(|i| (0..6).map(move |j| (i, j)));
        let (gap, size) = pairs.fold((0.0f64, 0.0f64), |(gap, size), (i, j)| {
            (gap.max((c[i][j] - c[j][i]).abs()), size.max(c[i][j].abs()))
        });
        if size > 0.0 { gap / size } else { 0.0 }
    }

    /// The stress that follows from a strain.
    pub fn stress(&self, strain: &Matrix) -> [f64; 6] {
        let parts: [f64; 6] = std::array::from_fn(|k| granum_dem::servo::strain_component(strain, k));
        self.0.map(|row| row.iter().zip(parts).map(|(c, e)| c * e).sum())
    }
}

/// Inverse by elimination with the largest pivot of each column; `None` for a singular matrix.
fn inverse(matrix: &[[f64; 6]; 6]) -> Option<[[f64; 6]; 6]> {
    let mut a = *matrix;
    let mut b: [[f64; 6]; 6] =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    let size = a.iter().flatten().fold(0.0f64, |size, x| size.max(x.abs()));
    for k in 0..6 {
        let pivot = (k..6).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        if a[pivot][k].is_nan() || a[pivot][k].abs() <= 1e-12 * size {
            return None;
        }
        a.swap(k, pivot);
        b.swap(k, pivot);
        let factor = 1.0 / a[k][k];
        (a[k], b[k]) = (a[k].map(|x| x * factor), b[k].map(|x| x * factor));
        for row in (0..6).filter(|row| *row != k) {
            let factor = a[row][k];
            for column in 0..6 {
                a[row][column] -= factor * a[k][column];
                b[row][column] -= factor * b[k][column];
            }
        }
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubic(c11: f64, c12: f64, c44: f64) -> Tensor {
        let mut tensor = Tensor::isotropic(0.0, 0.0);
        for i in 0..3 {
            for j in 0..3 {
                tensor.0[i][j] = if i == j { c11 } else { c12 };
            }
            tensor.0[3 + i][3 + i] = c44;
        }
        tensor
    }

    /// Cubic solids: `G_V = (C11 - C12 + 3 C44) / 5`, `5 / G_R = 4 / (C11 - C12) + 3 / C44`,
    /// `E = (C11 - C12) (C11 + 2 C12) / (C11 + C12)`.
    #[test]
    fn moduli_of_a_cubic_solid() {
        let (c11, c12, c44) = (9.9e8, 0.5e8, 4.9e8);
        let tensor = cubic(c11, c12, c44);
        let voigt = (c11 - c12 + 3.0 * c44) / 5.0;
        let reuss = 5.0 / (4.0 / (c11 - c12) + 3.0 / c44);
        assert!((tensor.shear_modulus() / voigt - 1.0).abs() < 1e-14);
        assert!((tensor.bulk_modulus() / ((c11 + 2.0 * c12) / 3.0) - 1.0).abs() < 1e-14);
        assert!((tensor.anisotropy().unwrap() - 5.0 * (voigt / reuss - 1.0)).abs() < 1e-12);
        let young = (c11 - c12) * (c11 + 2.0 * c12) / (c11 + c12);
        assert!((tensor.youngs_moduli().unwrap()[1] / young - 1.0).abs() < 1e-13);
        assert_eq!(tensor.asymmetry(), 0.0);
        assert_eq!(cubic(1.0, 1.0, 1.0).anisotropy(), None, "singular");
    }

    #[test]
    fn stress_follows_from_strain() {
        let strain = [[1e-3, 2e-4, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
        let stress = cubic(10.0, 2.0, 3.0).stress(&strain);
        for (value, exact) in stress.iter().zip([1e-2, 2e-3, 2e-3, 0.0, 0.0, 6e-4]) {
            assert!((value - exact).abs() < 1e-15);
        }
    }
}
