//! Real orthonormal spherical harmonics.
//!
//! `Y_n0 = Q_n0(z)`, `Y_nm = sqrt(2) Q_nm(z) Re (x + i y)^m` and with Im for -m, of a unit vector (x, y, z). Q is the normalised associated Legendre function
//! without its factor `(1 - z^2)^(m/2)`: `Q_00 = sqrt(1/4 pi)`, `Q_mm = sqrt((2m + 1)/2m) Q_(m-1)(m-1)`,
//! `Q_nm = a (z Q_(n-1)m - b Q_(n-2)m)`, `a^2 = (4 n^2 - 1)/(n^2 - m^2)`, `b^2 = ((n - 1)^2 - m^2)/(4 (n - 1)^2 - 1)`.

use granum_core::assembly::Vector;

/// Adds up harmonics: `coefficients[n - first]` are those of the degree n, for m from -n to n.
pub(crate) fn sum(coefficients: &[Vec<f64>], first: usize, [x, y, z]: &Vector) -> f64 {
    let last = first + coefficients.len();
    let mut total = 0.0;
    let mut diagonal = (0.25 / std::f64::consts::PI).sqrt();
    let [mut re, mut im] = [1.0, 0.0];
    for m in 0..last {
        if m > 0 {
            diagonal *= ((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
            [re, im] = [re * x - im * y, re * y + im * x];
        }
        let (mut before, mut now) = (0.0, diagonal);
        for n in m..last {
            if n > m {
                let (n, m) = (n as f64, m as f64);
                let a = ((4.0 * n * n - 1.0) / (n * n - m * m)).sqrt();
                let b = (((n - 1.0) * (n - 1.0) - m * m) / (4.0 * (n - 1.0) * (n - 1.0) - 1.0)).sqrt();
                (before, now) = (now, a * (z * now - b * before));
            }
            if n >= first {
                let of_degree = &coefficients[n - first];
                total += match m {
                    0 => of_degree[n] * now,
                    _ => 2.0f64.sqrt() * now * (of_degree[n + m] * re + of_degree[n - m] * im),
                };
            }
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::unit;
    use granum_core::geometry::dot;

    /// The addition theorem: `sum over m of Y_nm(u) Y_nm(v) = (2 n + 1)/(4 pi) P_n(u.v)`.
    #[test]
    fn harmonics_obey_the_addition_theorem() {
        let (u, v) = (unit(&[0.3, -0.5, 0.8]), unit(&[-0.6, 0.2, 0.1]));
        let cosine = dot(&u, &v);
        let (mut before, mut legendre) = (1.0, cosine);
        for n in 1..=15 {
            let harmonic = |k: usize, at: &Vector| {
                let one = (0..2 * n + 1).map(|j| if j == k { 1.0 } else { 0.0 }).collect();
                sum(&[one], n, at)
            };
            let found: f64 = (0..2 * n + 1).map(|k| harmonic(k, &u) * harmonic(k, &v)).sum();
            let golden = (2 * n + 1) as f64 / (4.0 * std::f64::consts::PI) * legendre;
            assert!((found - golden).abs() < 1e-12, "{n}: {found} {golden}");
            let k = n as f64;
            (before, legendre) = (legendre, ((2.0 * k + 1.0) * cosine * legendre - k * before) / (k + 1.0));
        }
        // Y_10 = sqrt(3/4 pi) z, Y_11 = sqrt(3/4 pi) x, Y_1-1 = sqrt(3/4 pi) y.
        let golden = (0.75 / std::f64::consts::PI).sqrt() * (2.0 * u[1] + 3.0 * u[2] + 5.0 * u[0]);
        assert!((sum(&[vec![2.0, 3.0, 5.0]], 1, &u) - golden).abs() < 1e-14);
    }
}
