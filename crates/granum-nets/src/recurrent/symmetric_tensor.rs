//! Symmetric deviators as vectors of five components, and the product of two of them.

use granum_simd::Lanes;

const A: f64 = 0.408_248_290_463_863; // 1 / sqrt(6)
const B: f64 = 0.353_553_390_593_273_8; // 1 / (2 sqrt(2))

/// Number of components of a symmetric deviator.
pub(crate) const COMPONENTS: usize = 5;

/// The deviator of the symmetric product `(a b + b a) / 2` of two symmetric deviators. With the orthonormal basis
///
/// ```text
/// E_0 = diag(2, -1, -1) / sqrt(6),   E_1 = diag(0, 1, -1) / sqrt(2),   E_2, E_3, E_4 = (yz, zx, xy, each with its transpose) / sqrt(2)
/// ```
///
/// its component k is `sum d_kij a_i b_j`, where `d_kij = tr(E_k (E_i E_j + E_j E_i)) / 2` is the same for every order of its indices. The product is
/// therefore objective, and its derivative with respect to `a` for the derivatives `p` of the product is the product of `b` and `p`.
#[inline(always)]
pub(crate) fn product_of<L: Lanes>(a: [L; COMPONENTS], b: [L; COMPONENTS]) -> [L; COMPONENTS] {
    let (one, other, half) = (L::splat(A), L::splat(B), L::splat(0.5 * A));
    let [a0, a1, a2, a3, a4] = a;
    let [b0, b1, b2, b3, b4] = b;
    let (z, x) = (a3 * b3, a4 * b4);
    [
        one * (a0 * b0 - a1 * b1 - a2 * b2) + half * (z + x),
        other * (x - z) - one * (a0 * b1 + a1 * b0),
        other * (a3 * b4 + a4 * b3) - one * (a0 * b2 + a2 * b0),
        half * (a0 * b3 + a3 * b0) + other * (a2 * b4 + a4 * b2 - a1 * b3 - a3 * b1),
        half * (a0 * b4 + a4 * b0) + other * (a1 * b4 + a4 * b1 + a2 * b3 + a3 * b2),
    ]
}

/// The inner product.
#[inline(always)]
pub(crate) fn inner<L: Lanes>(a: [L; COMPONENTS], b: [L; COMPONENTS]) -> L {
    let mut sum = a[0] * b[0];
    for k in 1..COMPONENTS {
        sum = a[k].mul_add(b[k], sum);
    }
    sum
}

/// `sum + factor * a`.
#[inline(always)]
pub(crate) fn plus<L: Lanes>(sum: &mut [L; COMPONENTS], factor: L, a: [L; COMPONENTS]) {
    for k in 0..COMPONENTS {
        sum[k] = factor.mul_add(a[k], sum[k]);
    }
}

#[cfg(test)]
mod tests {
    use granum_simd::{Isa, Kernel, dispatch};

    use super::*;

    type Matrix = [[f64; 3]; 3];

    fn matrix(c: [f64; 5]) -> Matrix {
        let (r6, r2) = (6f64.sqrt(), 2f64.sqrt());
        let diagonal = [2.0 * c[0] / r6, -c[0] / r6 + c[1] / r2, -c[0] / r6 - c[1] / r2];
        let [yz, zx, xy] = [c[2] / r2, c[3] / r2, c[4] / r2];
        [[diagonal[0], xy, zx], [xy, diagonal[1], yz], [zx, yz, diagonal[2]]]
    }

    fn times(a: Matrix, b: Matrix) -> Matrix {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
    }

    struct Both([f64; 5], [f64; 5]);

    impl Kernel for Both {
        type Output = ([f64; 5], f64);
        fn run<L: Lanes>(self) -> Self::Output {
            let (a, b) = (self.0.map(L::splat), self.1.map(L::splat));
            let read = |value: L| {
                let mut all = [0.0; 8];
                value.store(&mut all);
                all[3]
            };
            (product_of(a, b).map(read), read(inner(a, b)))
        }
    }

    #[test]
    fn products_are_those_of_matrices() {
        let (a, b) = ([0.3, -0.7, 0.2, 0.9, -0.4], [-0.5, 0.1, 0.8, -0.6, 0.25]);
        let (product, inner) = dispatch(Isa::detect(), Both(a, b));
        let (ab, ba) = (times(matrix(a), matrix(b)), times(matrix(b), matrix(a)));
        let trace = ab[0][0] + ab[1][1] + ab[2][2];
        assert!((inner - trace).abs() < 1e-14);
        let ours = matrix(product);
        for i in 0..3 {
            for j in 0..3 {
                let expected = 0.5 * (ab[i][j] + ba[i][j]) - if i == j { trace / 3.0 } else { 0.0 };
                assert!((ours[i][j] - expected).abs() < 1e-14, "{i} {j}");
            }
        }
    }
}
