//! What a process computes with, for those who write it down in another form, such as a graph of operators.

use super::process::GaussianProcess;
use super::rows::Rows;

/// The numbers of a process. With the covariance
///
/// ```text
/// k(x, z) = c + sum_d s_d x_d z_d + sum_d u_d + a sum_(d < e) u_d u_e + b prod_d g_d
/// u_d = w_d g_d,   g_d = exp(-n_d (x_d - z_d)^2)
/// ```
///
/// and the rows `z_i` to which it was fitted, the mean at `x` is `m + s sum_i k(x, z_i) v_i`, and the variance of the mean `s^2 (k(x, x) - |F k|^2)`, at least zero, with the
/// covariances `k_i = k(x, z_i)` and the factor `F` ([`GaussianProcess::inverse_factor`]).
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ProcessParts<'a> {
    /// The rows `z`.
    pub rows: &'a Rows,
    /// For each input `n`.
    pub narrowness: &'a [f64],
    /// For each input `w`.
    pub weights: &'a [f64],
    /// For each input `s`.
    pub slopes: &'a [f64],
    /// The weight `a` of pairs.
    pub pairs: f64,
    /// The weight `b` of the product.
    pub product: f64,
    /// The constant `c`.
    pub constant: f64,
    /// For each row `v`.
    pub solved: &'a [f64],
    /// Mean `m` and standard deviation `s` of the targets.
    pub scale: [f64; 2],
}

impl GaussianProcess {
    /// The numbers with which it predicts.
    ///
    /// ```
    /// use granum_nets::gaussian_process::{FitOptions, GaussianProcess, Rows};
    ///
    /// let x: Vec<f64> = (0..12).map(|k| f64::from(k) / 4.0 - 1.5).collect();
    /// let y: Vec<f64> = x.iter().map(|x| x * x).collect();
    /// let process = GaussianProcess::fit(Rows::new(x, 1)?.into(), &y, &FitOptions::default())?;
    /// let parts = process.parts();
    /// let covariance = |x: f64, z: f64| {
    ///     let g = (-parts.narrowness[0] * (x - z) * (x - z)).exp();
    ///     parts.constant + parts.slopes[0] * x * z + parts.weights[0] * g + parts.product * g
    /// };
    /// let k: Vec<f64> = parts.rows.values().iter().map(|z| covariance(0.3, *z)).collect();
    /// let predicted = process.predict(&[0.3]);
    /// let mean = parts.scale[0] + parts.scale[1] * k.iter().zip(parts.solved).map(|(k, v)| k * v).sum::<f64>();
    /// assert!((mean - predicted.mean).abs() < 1e-9);
    /// let factor = process.inverse_factor();
    /// let products = factor.chunks(12).map(|row| row.iter().zip(&k).map(|(f, k)| f * k).sum::<f64>());
    /// let variance = parts.scale[1].powi(2) * (covariance(0.3, 0.3) - products.map(|y| y * y).sum::<f64>());
    /// assert!((variance - predicted.variance).abs() < 1e-9);
    /// # Ok::<(), granum_nets::gaussian_process::GaussianProcessError>(())
    /// ```
    pub fn parts(&self) -> ProcessParts<'_> {
        let covariance = self.covariance();
        let [pairs, product, constant] = covariance.shared();
        let (solved, _) = self.solved();
        ProcessParts {
            rows: self.rows(),
            narrowness: covariance.narrowness(),
            weights: covariance.weights(),
            slopes: covariance.slopes(),
            pairs,
            product,
            constant,
            solved,
            scale: self.scale(),
        }
    }
}
