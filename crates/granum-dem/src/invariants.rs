//! Invariants of stress and strain tensors, compression positive. No axis is treated differently from the others.
//!
//! `p = tr(sigma) / 3`; the von Mises stress `q_vM = sqrt(3 J_2)`, here with the sign of `J_3`, so that it is positive in triaxial
//! compression and negative in triaxial extension, while close to an isotropic stress the sign is that of residual stresses; `b = (sigma_2 - sigma_3) / (sigma_1 - sigma_3)` of the principal stresses, 0 in
//! compression and 1 in extension; volumetric strain `tr(eps)`; deviatoric strain `eps_q = sqrt(2/3 e:e)`. Only square roots
//! are used, so that the bits are the same on every machine.

use granum_core::geometry::{Matrix, determinant};

/// Sum of the diagonal.
pub fn trace(t: &Matrix) -> f64 {
    t[0][0] + t[1][1] + t[2][2]
}

/// Mean stress, a third of the trace.
pub fn mean(t: &Matrix) -> f64 {
    trace(t) / 3.0
}

/// The deviator of the symmetric part.
pub fn deviator(t: &Matrix) -> Matrix {
    let third = mean(t);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| 0.5 * (t[i][j] + t[j][i]) - if i == j { third } else { 0.0 })
    })
}

/// Sum of the squares of all entries.
fn square(t: &Matrix) -> f64 {
    t.iter().flatten().map(|x| x * x).sum()
}

/// Von Mises stress `sqrt(3/2 s:s)` of the deviator s, negative where the determinant of s is negative.
pub fn signed_von_mises(stress: &Matrix) -> f64 {
    let s = deviator(stress);
    let q = (1.5 * square(&s)).sqrt();
    if determinant(&s) < 0.0 { -q } else { q }
}

/// Deviatoric strain `sqrt(2/3 e:e)` of the deviator e.
pub fn deviatoric_strain(strain: &Matrix) -> f64 {
    (2.0 / 3.0 * square(&deviator(strain))).sqrt()
}

/// Length `sqrt(2/3 eps:eps)` of the symmetric part of a strain, its volumetric part included.
pub fn length(strain: &Matrix) -> f64 {
    let symmetric: Matrix =
        std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (strain[i][j] + strain[j][i])));
    (2.0 / 3.0 * square(&symmetric)).sqrt()
}

/// The deviator `t_1 - (t_2 + t_3) / 2` with axis x as 1: q and the deviator strain of triaxial tests along x. It is not an
/// invariant.
pub fn axial_deviator(t: &Matrix) -> f64 {
    t[0][0] - 0.5 * (t[1][1] + t[2][2])
}

/// Intermediate stress ratio `b = (sigma_2 - sigma_3) / (sigma_1 - sigma_3)`; 0 where the stress is isotropic.
pub fn intermediate_ratio(stress: &Matrix) -> f64 {
    let [major, middle, minor] = eigenvalues(stress);
    if major > minor { (middle - minor) / (major - minor) } else { 0.0 }
}

/// `cos(3 theta)` of the Lode angle, `(3 sqrt(3) / 2) J_3 / J_2^(3/2)`: 1 in triaxial compression, -1 in extension; 0 where
/// the stress is isotropic.
pub fn lode_cosine(stress: &Matrix) -> f64 {
    let s = deviator(stress);
    let second = 0.5 * square(&s);
    if second > 0.0 { 1.5 * 3.0f64.sqrt() * determinant(&s) / (second * second.sqrt()) } else { 0.0 }
}

/// `sin(phi)` of the mobilised friction angle, `(sigma_1 - sigma_3) / (sigma_1 + sigma_3)`; 0 where the sum is not positive.
pub fn mobilised_friction(stress: &Matrix) -> f64 {
    let [major, _, minor] = eigenvalues(stress);
    if major + minor > 0.0 { (major - minor) / (major + minor) } else { 0.0 }
}

/// Eigenvalues of the symmetric part, largest first (Jacobi rotations).
pub fn eigenvalues(t: &Matrix) -> [f64; 3] {
    let mut a: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (t[i][j] + t[j][i])));
    // Cyclic Jacobi converges quadratically; a 3 x 3 tensor needs 4 to 5 sweeps.
    for _ in 0..12 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut a, p, q);
        }
    }
    let mut values = [a[0][0], a[1][1], a[2][2]];
    values.sort_by(|x, y| y.total_cmp(x));
    values
}

/// One Jacobi rotation that makes `a[p][q]` zero.
fn rotate(a: &mut Matrix, p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    if !t.is_finite() || t == 0.0 {
        return;
    }
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for k in 0..3 {
        let (x, y) = (a[k][p], a[k][q]);
        a[k][p] = c * x - s * y;
        a[k][q] = s * x + c * y;
    }
    for k in 0..3 {
        let (x, y) = (a[p][k], a[q][k]);
        a[p][k] = c * x - s * y;
        a[q][k] = s * x + c * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference values of a general and of a diagonal stress, computed independently.
    #[test]
    fn invariants_of_known_stresses() {
        let near = |value: f64, golden: f64| assert!((value / golden - 1.0).abs() < 1e-9, "{value} {golden}");
        let general = [[200.0, 30.0, 0.0], [30.0, 150.0, -20.0], [0.0, -20.0, 100.0]];
        near(mean(&general), 150.0);
        near(signed_von_mises(&general), 106.7707825203);
        near(lode_cosine(&general).acos().to_degrees() / 3.0, 24.63404813);
        near(intermediate_ratio(&general), 0.4186557036);
        near(mobilised_friction(&general).asin().to_degrees(), 23.59558289);
        let diagonal = [[300.0, 0.0, 0.0], [0.0, 150.0, 0.0], [0.0, 0.0, 100.0]];
        near(signed_von_mises(&diagonal), 180.2775637732);
        near(intermediate_ratio(&diagonal), 0.25);
        near(lode_cosine(&diagonal).acos().to_degrees() / 3.0, 13.89788625);
        near(mobilised_friction(&diagonal).asin().to_degrees(), 30.0);
    }

    #[test]
    fn compression_is_positive_and_extension_negative_along_any_axis() {
        for axis in 0..3 {
            let mut stress = [[100.0, 0.0, 0.0], [0.0, 100.0, 0.0], [0.0, 0.0, 100.0]];
            stress[axis][axis] = 250.0;
            assert!((signed_von_mises(&stress) - 150.0).abs() < 1e-12);
            stress[axis][axis] = 40.0;
            assert!((signed_von_mises(&stress) + 60.0).abs() < 1e-12);
        }
        let strain = [[0.3, 0.0, 0.0], [0.0, -0.15, 0.0], [0.0, 0.0, -0.15]];
        assert!((deviatoric_strain(&strain) - 0.3).abs() < 1e-15 && (length(&strain) - 0.3).abs() < 1e-15);
    }
}
