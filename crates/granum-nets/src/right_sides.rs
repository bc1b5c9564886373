//! Triangular systems with many right-hand sides, which lie side by side in the lanes.

use granum_simd::{Isa, Kernel, LANES, Lanes, Row8, dispatch};

use crate::kernels::{Scalars, panels};
use crate::symmetric::{Upper, eight_rows_from, widest};

impl Upper<'_> {
    /// Solves `U^T Y = -B` in place for all columns of `B`, a lane matrix with the given stride of which `columns` lane blocks are used. Every
    /// column has the bits of the solution of its own but for the sign, which spares a negation in the innermost loop.
    pub(crate) fn solve_transposed_lanes(self, isa: Isa, lanes: &mut [Row8], stride: usize, columns: usize) {
        dispatch(isa, SolveLanes { upper: self, lanes, stride, columns });
    }
}

struct SolveLanes<'a> {
    upper: Upper<'a>,
    lanes: &'a mut [Row8],
    stride: usize,
    columns: usize,
}

impl Kernel for SolveLanes<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let SolveLanes { upper, lanes, stride, columns } = self;
        for q in 0..upper.blocks {
            let (above, rest) = lanes.split_at_mut(q * LANES * stride);
            let rows = &mut rest[..LANES * stride];
            let scalars = Scalars {
                values: &Row8::numbers(upper.values)[q * LANES..],
                by_k: upper.stride * LANES,
                by_j: 1,
            };
            panels(
                0,
                columns,
                widest::<L>(),
                #[inline(always)]
                |first, width| {
                    let mut before = [[L::zero(); 3]; LANES];
                    for i in 0..LANES {
                        for w in 0..width {
                            before[i][w] = L::load(&rows[i * stride + first + w].0);
                        }
                    }
                    eight_rows_from::<L>(
                        scalars,
                        q * LANES,
                        above,
                        stride,
                        first,
                        width,
                        #[inline(always)]
                        |i, b| before[i][b - first],
                        #[inline(always)]
                        |i, b, sum| sum.store(&mut rows[i * stride + b].0),
                    );
                    for b in first..first + width {
                        diagonal::<L>(upper, q, rows, stride, b);
                    }
                },
            );
        }
    }
}

/// Solves the equations of the block `q` on the diagonal for one lane block of right-hand sides.
#[inline(always)]
fn diagonal<L: Lanes>(upper: Upper, q: usize, rows: &mut [Row8], stride: usize, b: usize) {
    let mut values = [L::zero(); LANES];
    for i in 0..LANES {
        values[i] = L::load(&rows[i * stride + b].0);
    }
    for i in 0..LANES {
        let factors = &upper.values[(q * LANES + i) * upper.stride + q].0;
        let negative = values[i] * L::splat(-upper.reciprocal[q * LANES + i]);
        negative.store(&mut rows[i * stride + b].0);
        for j in i + 1..LANES {
            values[j] = L::splat(factors[j]).mul_add(negative, values[j]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::{blocks, odd};
    use crate::symmetric::Cholesky;
    use crate::symmetric::tests::example;

    /// Every column has the bits of a system of its own, with every instruction set and any number of columns.
    #[test]
    fn columns_are_solved_as_if_each_were_alone() {
        for (size, count) in [(1, 1), (8, 3), (19, 24), (45, 70)] {
            let (matrix, _) = example(size);
            for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
                let mut factor = Cholesky::new(isa, size);
                assert!(factor.factorise(&matrix, 0.5));
                let (columns, stride) = (blocks(count), odd(blocks(count)));
                let mut lanes = vec![Row8::default(); blocks(size) * LANES * stride];
                for p in 0..size {
                    for k in 0..count {
                        lanes[p * stride + k / LANES].0[k % LANES] = (1.3 * p as f64 + 0.7 * k as f64).cos();
                    }
                }
                let right = lanes.clone();
                factor.upper().solve_transposed_lanes(isa, &mut lanes, stride, columns);
                for k in 0..count {
                    let at = |values: &[Row8], p: usize| values[p * stride + k / LANES].0[k % LANES];
                    let mut alone = vec![Row8::default(); blocks(size)];
                    for p in 0..size {
                        alone[p / LANES].0[p % LANES] = at(&right, p);
                    }
                    factor.solve_transposed(&mut alone);
                    for p in 0..size {
                        assert_eq!(
                            (-at(&lanes, p)).to_bits(),
                            alone[p / LANES].0[p % LANES].to_bits(),
                            "{size} {p} {k}"
                        );
                    }
                }
            }
        }
    }
}
