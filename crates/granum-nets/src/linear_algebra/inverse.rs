//! The inverse of a factorised symmetric matrix, and its trace.

use granum_simd::{Kernel, LANES, Lanes, Row8, dispatch};

use crate::linear_algebra::kernels::{Scalars, panels};
use crate::linear_algebra::symmetric::{Cholesky, Symmetric, eight_rows, widest};

impl Cholesky {
    /// Trace of `(A + shift I)^-1`, as the sum of squares of the inverse of the factor.
    pub(crate) fn trace_of_inverse(&mut self) -> f64 {
        dispatch(self.isa, TraceOfInverse { factor: self })
    }

    /// The upper triangle of `(A + shift I)^-1`, as the product of the inverse of the factor with its transpose; other entries of its blocks are
    /// those of the lower one.
    pub(crate) fn inverse(&mut self) -> Symmetric {
        // The rows of the transposed inverse of the factor.
        self.trace_of_inverse();
        let mut product = Symmetric::new(self.upper.size);
        dispatch(self.isa, ProductWithTransposed { rows: &self.inverse, product: &mut product });
        product
    }
}

/// `Y^T Y` of the lower triangular matrix `Y`.
struct ProductWithTransposed<'a> {
    rows: &'a [Row8],
    product: &'a mut Symmetric,
}

impl Kernel for ProductWithTransposed<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Symmetric { blocks, stride, ref mut values, .. } = *self.product;
        for q in 0..blocks {
            panels(
                q,
                blocks,
                widest::<L>(),
                #[inline(always)]
                |first, width| {
                    // Columns from block `first` on are zero above row `8 first`.
                    let from = first * LANES;
                    let scalars = Scalars {
                        values: &Row8::numbers(self.rows)[from * stride * LANES + q * LANES..],
                        by_k: stride * LANES,
                        by_j: 1,
                    };
                    eight_rows::<L>(
                        scalars,
                        blocks * LANES - from,
                        &self.rows[from * stride..],
                        stride,
                        first,
                        width,
                        #[inline(always)]
                        |i, b, sum| sum.store(&mut values[(q * LANES + i) * stride + b].0),
                    );
                },
            );
        }
    }
}

struct TraceOfInverse<'a> {
    factor: &'a mut Cholesky,
}

impl Kernel for TraceOfInverse<'_> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let Cholesky { upper, reciprocal, inverse, .. } = self.factor;
        let Symmetric { size, blocks, stride, ref values } = *upper;
        // The rows of the transposed inverse, which is a lower triangular matrix, follow from U^T Y = I.
        inverse.resize(values.len(), Row8::default());
        let mut sum = L::zero();
        for q in 0..blocks {
            let (above, rest) = inverse.split_at_mut(q * LANES * stride);
            let rows = &mut rest[..LANES * stride];
            panels(
                0,
                q,
                widest::<L>(),
                #[inline(always)]
                |first, width| {
                    // Column block `first` is zero above row `8 first`.
                    let from = first * LANES;
                    let scalars = Scalars {
                        values: &Row8::numbers(values)[from * stride * LANES + q * LANES..],
                        by_k: stride * LANES,
                        by_j: 1,
                    };
                    eight_rows::<L>(
                        scalars,
                        q * LANES - from,
                        &above[from * stride..],
                        stride,
                        first,
                        width,
                        #[inline(always)]
                        |i, b, sum| (-sum).store(&mut rows[i * stride + b].0),
                    );
                },
            );
            for i in 0..LANES {
                rows[i * stride + q] = Row8::default();
                rows[i * stride + q].0[i] = 1.0;
            }
            for b in 0..=q {
                for i in 0..LANES {
                    let p = q * LANES + i;
                    let mut value = L::load(&rows[i * stride + b].0);
                    for k in 0..i {
                        let factor = L::splat(-values[(q * LANES + k) * stride + q].0[i]);
                        value = factor.mul_add(L::load(&rows[k * stride + b].0), value);
                    }
                    value = value * L::splat(reciprocal[p]);
                    value.store(&mut rows[i * stride + b].0);
                    if p < size {
                        sum = value.mul_add(value, sum);
                    }
                }
            }
            // The rows below read zeros right of the diagonal.
            for i in 0..LANES {
                rows[i * stride + q + 1..(i + 1) * stride].fill(Row8::default());
            }
        }
        sum.reduce_add()
    }
}

#[cfg(test)]
mod tests {
    use granum_simd::Isa;

    use super::*;
    use crate::linear_algebra::symmetric::tests::example;

    #[test]
    fn the_inverse_times_the_matrix_is_one_on_every_instruction_set() {
        for size in [1, 7, 8, 23, 60] {
            let (matrix, full) = example(size);
            let mut bits = Vec::new();
            for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
                let mut factor = Cholesky::new(isa, size);
                assert!(factor.factorise(&matrix, 0.5));
                let inverse = factor.inverse();
                let entry = |p: usize, s: usize| {
                    let (p, s) = (p.min(s), p.max(s));
                    inverse.values[p * inverse.stride + s / LANES].0[s % LANES]
                };
                for p in 0..size {
                    for s in 0..size {
                        let shifted = |k: usize| full[k * size + s] + if k == s { 0.5 } else { 0.0 };
                        let product: f64 = (0..size).map(|k| entry(p, k) * shifted(k)).sum();
                        let expected = f64::from(u8::from(p == s));
                        assert!((product - expected).abs() < 1e-8, "{size} {p} {s} {product}");
                    }
                }
                bits.push((0..size).map(|k| entry(0, k).to_bits()).collect::<Vec<_>>());
            }
            assert!(bits.iter().all(|own| *own == bits[0]));
        }
    }
}
