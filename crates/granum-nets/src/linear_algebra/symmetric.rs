//! Symmetric positive definite matrices: Cholesky factorisation and solution of linear systems.
//!
//! Only the upper triangle is stored, row by row with columns across the lanes. The factorisation processes eight rows at a
//! time. Every element is summed in a fixed order, so that the bits are identical with every instruction set.

use granum_simd::{Isa, Kernel, LANES, Lanes, Real, Row8, dispatch};

use crate::linear_algebra::kernels::{Scalars, blocks, odd, panels, scalar_times_lanes};

/// The upper triangle of a symmetric matrix, padded with zeros to whole lane blocks.
#[derive(Clone, Debug)]
pub(crate) struct Symmetric {
    pub size: usize,
    pub blocks: usize,
    /// Distance between rows in lane blocks.
    pub stride: usize,
    /// Entry (p, s), `s >= p`, in lane `s % 8` of `values[p * stride + s / 8]`.
    pub values: Vec<Row8>,
}

impl Symmetric {
    pub(crate) fn new(size: usize) -> Symmetric {
        let (count, stride) = (blocks(size), odd(blocks(size)));
        Symmetric { size, blocks: count, stride, values: vec![Row8::default(); count * LANES * stride] }
    }

    /// The whole matrix in row-major order, without the padding of rows.
    pub(crate) fn full(&self) -> Vec<f64> {
        let at = |p: usize, s: usize| self.values[p * self.stride + s / LANES].0[s % LANES];
        (0..self.size * self.size)
            .map(|k| (k / self.size, k % self.size))
            .map(|(p, s)| at(p.min(s), p.max(s)))
            .collect()
    }

    /// Memory of a matrix of this size, bytes.
    pub(crate) fn bytes(size: usize) -> usize {
        blocks(size) * LANES * odd(blocks(size)) * size_of::<Row8>()
    }
}

/// The factor `U` of `A + shift I = U^T U`.
#[derive(Clone, Debug)]
pub(crate) struct Cholesky {
    pub(crate) isa: Isa,
    pub(crate) upper: Symmetric,
    /// Reciprocals of the diagonal elements.
    pub(crate) reciprocal: Vec<f64>,
    /// Memory for the inverse of the factor.
    pub(crate) inverse: Vec<Row8>,
}

impl Cholesky {
    pub(crate) fn new(isa: Isa, size: usize) -> Cholesky {
        let upper = Symmetric::new(size);
        let reciprocal = vec![0.0; upper.blocks * LANES];
        Cholesky { isa, upper, reciprocal, inverse: Vec::new() }
    }

    /// Factorises `matrix + shift I`; returns false if it is not positive definite to working precision.
    pub(crate) fn factorise(&mut self, matrix: &Symmetric, shift: f64) -> bool {
        let Symmetric { blocks, stride, ref mut values, .. } = self.upper;
        values.copy_from_slice(&matrix.values);
        factorise_panel(self.isa, values, stride, (blocks, blocks), shift, &mut self.reciprocal)
    }

    /// The factor of a matrix, in its memory; `None` if it is not positive definite to working precision.
    pub(crate) fn of_matrix(isa: Isa, matrix: Symmetric) -> Option<Cholesky> {
        let reciprocal = vec![0.0; matrix.blocks * LANES];
        let mut factor = Cholesky { isa, upper: matrix, reciprocal, inverse: Vec::new() };
        let Symmetric { blocks, stride, ref mut values, .. } = factor.upper;
        factorise_panel(isa, values, stride, (blocks, blocks), 0.0, &mut factor.reciprocal).then_some(factor)
    }

    /// Solves `(A + shift I) x = b` in place.
    pub(crate) fn solve(&self, vector: &mut [Row8]) {
        dispatch(self.isa, SolveTransposed { upper: self.upper(), vector: &mut *vector });
        dispatch(self.isa, SolveUpper { upper: self.upper(), vector });
    }

    /// Solves `U^T y = b` in place: `y . y = b^T (A + shift I)^-1 b`.
    pub(crate) fn solve_transposed(&self, vector: &mut [Row8]) {
        dispatch(self.isa, SolveTransposed { upper: self.upper(), vector });
    }

    /// The factor.
    pub(crate) fn upper(&self) -> Upper<'_> {
        let Symmetric { blocks, stride, ref values, .. } = self.upper;
        Upper { values, stride, blocks, reciprocal: &self.reciprocal }
    }

    /// The logarithm of the determinant of `A + shift I`, with the padding of the matrix.
    pub(crate) fn log_determinant(&self) -> f64 {
        -2.0 * self.reciprocal.iter().map(|reciprocal| libm::log(*reciprocal)).sum::<f64>()
    }
}

/// Width of the tiles in lane blocks.
#[inline(always)]
pub(crate) fn widest<L: Lanes>() -> usize {
    if const { L::REGISTERS >= 32 } { 3 } else { 1 }
}

/// As [`scalar_times_lanes`], for eight outputs and sums that start from zero.
#[inline(always)]
pub(crate) fn eight_rows<L: Lanes>(
    scalars: Scalars,
    depth: usize,
    lanes: &[Row8],
    stride: usize,
    first: usize,
    width: usize,
    finish: impl FnMut(usize, usize, L),
) {
    #[inline(always)]
    fn zero<L: Lanes>(_: usize, _: usize) -> L {
        L::zero()
    }
    if const { L::REGISTERS >= 32 } {
        scalar_times_lanes::<L, 8, 3>(scalars, LANES, depth, lanes, stride, first, width, zero::<L>, finish);
    } else {
        scalar_times_lanes::<L, 4, 1>(scalars, LANES, depth, lanes, stride, first, width, zero::<L>, finish);
    }
}

/// Factorises the leading square of a lane matrix in place and transforms all columns to its right: `[A | B]` becomes
/// `[U | U^-T B]` with `A + shift I = U^T U`. Only the upper triangle of `A` is read.
struct Factorise<'a> {
    /// Rows of `stride` lane blocks, of which `columns` are used.
    values: &'a mut [Row8],
    stride: usize,
    /// Number of lane blocks of the square.
    blocks: usize,
    /// Number of lane blocks of a row.
    columns: usize,
    shift: f64,
    /// Receives the reciprocals of the diagonal elements of the factor.
    reciprocal: &'a mut [f64],
}

/// Factorises the leading square of `blocks` lane blocks of a matrix with rows of `columns` lane blocks, see [`Factorise`];
/// returns false if it is not positive definite to working precision.
pub(crate) fn factorise_panel(
    isa: Isa,
    values: &mut [Row8],
    stride: usize,
    (blocks, columns): (usize, usize),
    shift: f64,
    reciprocal: &mut [f64],
) -> bool {
    dispatch(isa, Factorise { values, stride, blocks, columns, shift, reciprocal })
}

impl Kernel for Factorise<'_> {
    type Output = bool;
    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        let Factorise { values, stride, blocks, columns, shift, reciprocal: reciprocals } = self;
        for q in 0..blocks {
            let (above, rest) = values.split_at_mut(q * LANES * stride);
            let rows = &mut rest[..LANES * stride];
            // Subtract the contributions of the rows above.
            let scalars =
                Scalars { values: &Row8::numbers(above)[q * LANES..], by_k: stride * LANES, by_j: 1 };
            panels(
                q,
                columns,
                widest::<L>(),
                #[inline(always)]
                |first, width| {
                    eight_rows::<L>(
                        scalars,
                        q * LANES,
                        above,
                        stride,
                        first,
                        width,
                        #[inline(always)]
                        |i, b, sum| {
                            let at = i * stride + b;
                            (L::load(&rows[at].0) - sum).store(&mut rows[at].0);
                        },
                    );
                },
            );
            let Some(diagonal) = diagonal_block::<L::Scalar>(rows, stride, q, shift) else { return false };
            let reciprocal = diagonal.map(|row| 1.0 / row.1);
            reciprocals[q * LANES..(q + 1) * LANES].copy_from_slice(&reciprocal);
            // Then process the eight rows themselves, one column block after another.
            for b in q + 1..columns {
                let mut values = [L::zero(); LANES];
                for i in 0..LANES {
                    values[i] = L::load(&rows[i * stride + b].0);
                }
                for i in 0..LANES {
                    values[i] = values[i] * L::splat(reciprocal[i]);
                    for j in i + 1..LANES {
                        values[j] = L::splat(-diagonal[i].0[j]).mul_add(values[i], values[j]);
                    }
                }
                for i in 0..LANES {
                    values[i].store(&mut rows[i * stride + b].0);
                }
            }
            for i in 0..LANES {
                rows[i * stride + q] = Row8(diagonal[i].0);
            }
        }
        true
    }
}

/// Factorises the block on the diagonal; returns its rows, with zeros left of the diagonal, and their diagonal elements.
#[inline(always)]
fn diagonal_block<R: Real>(
    rows: &[Row8],
    stride: usize,
    q: usize,
    shift: f64,
) -> Option<[([f64; LANES], f64); LANES]> {
    let mut block = [([0.0; LANES], 0.0); LANES];
    for i in 0..LANES {
        block[i].0 = rows[i * stride + q].0;
        block[i].0[i] += shift;
    }
    for i in 0..LANES {
        let pivot = block[i].0[i];
        if pivot.is_nan() || pivot <= 0.0 || pivot == f64::INFINITY {
            return None;
        }
        let root = pivot.sqrt();
        for j in 0..LANES {
            block[i].0[j] = if j < i { 0.0 } else { block[i].0[j] * (1.0 / root) };
        }
        block[i].0[i] = root;
        block[i].1 = root;
        for k in i + 1..LANES {
            let factor = R::splat(-block[i].0[k]);
            for j in k..LANES {
                let (above, here) = (R::splat(block[i].0[j]), R::splat(block[k].0[j]));
                block[k].0[j] = factor.mul_add(above, here).reduce_add();
            }
        }
    }
    Some(block)
}

/// An upper triangular factor `U` with rows at a distance of `stride` lane blocks, and the reciprocals of its diagonal
/// elements.
#[derive(Clone, Copy)]
pub(crate) struct Upper<'a> {
    pub values: &'a [Row8],
    pub stride: usize,
    /// Number of lane blocks of its columns.
    pub blocks: usize,
    pub reciprocal: &'a [f64],
}

impl Upper<'_> {
    /// Solves `U x = b` in place.
    pub(crate) fn solve(self, isa: Isa, vector: &mut [Row8]) {
        dispatch(isa, SolveUpper { upper: self, vector });
    }
}

struct SolveTransposed<'a> {
    upper: Upper<'a>,
    vector: &'a mut [Row8],
}

impl Kernel for SolveTransposed<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Upper { values, stride, blocks, reciprocal } = self.upper;
        for p in 0..blocks * LANES {
            let (b, lane) = (p / LANES, p % LANES);
            let y = self.vector[b].0[lane] * reciprocal[p];
            self.vector[b].0[lane] = y;
            let row = &values[p * stride..][..blocks];
            // The rest of this block is updated lane by lane, and the later blocks as a whole.
            let factor = L::Scalar::splat(-y);
            for s in lane + 1..LANES {
                let (entry, before) = (L::Scalar::splat(row[b].0[s]), L::Scalar::splat(self.vector[b].0[s]));
                self.vector[b].0[s] = factor.mul_add(entry, before).reduce_add();
            }
            let factor = L::splat(-y);
            for s in b + 1..blocks {
                factor.mul_add(L::load(&row[s].0), L::load(&self.vector[s].0)).store(&mut self.vector[s].0);
            }
        }
    }
}

struct SolveUpper<'a> {
    upper: Upper<'a>,
    vector: &'a mut [Row8],
}

impl Kernel for SolveUpper<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Upper { values, stride, blocks, reciprocal } = self.upper;
        for p in (0..blocks * LANES).rev() {
            let (b, lane) = (p / LANES, p % LANES);
            let row = &values[p * stride..][..blocks];
            let mut sum = L::zero();
            for s in b + 1..blocks {
                sum = L::load(&row[s].0).mul_add(L::load(&self.vector[s].0), sum);
            }
            let mut sum = L::Scalar::splat(sum.reduce_add());
            for s in lane + 1..LANES {
                sum = L::Scalar::splat(row[b].0[s]).mul_add(L::Scalar::splat(self.vector[b].0[s]), sum);
            }
            self.vector[b].0[lane] = (self.vector[b].0[lane] - sum.reduce_add()) * reciprocal[p];
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// `B B^T` of a fixed pseudo-random square matrix: its upper triangle, and the full matrix in row-major order.
    pub(crate) fn example(size: usize) -> (Symmetric, Vec<f64>) {
        let entry = |i: usize, j: usize| ((i * 37 + j * 101 + i * j) as f64 * 0.7).sin();
        let mut full = vec![0.0; size * size];
        let mut matrix = Symmetric::new(size);
        for p in 0..size {
            for s in 0..size {
                full[p * size + s] = (0..size).map(|k| entry(p, k) * entry(s, k)).sum();
                if s >= p {
                    matrix.values[p * matrix.stride + s / LANES].0[s % LANES] = full[p * size + s];
                }
            }
        }
        (matrix, full)
    }

    fn vector(size: usize) -> Vec<Row8> {
        let mut vector = vec![Row8::default(); blocks(size)];
        for i in 0..size {
            vector[i / LANES].0[i % LANES] = 1.0 + (i as f64 * 1.3).cos();
        }
        vector
    }

    fn bits(isa: Isa, size: usize) -> Vec<u64> {
        let (matrix, _) = example(size);
        let mut factor = Cholesky::new(isa, size);
        assert!(factor.factorise(&matrix, 0.5));
        let mut x = vector(size);
        factor.solve(&mut x);
        let mut bits: Vec<u64> = Row8::numbers(&x).iter().map(|v| v.to_bits()).collect();
        bits.push(factor.trace_of_inverse().to_bits());
        bits
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn solves_its_equations(size in 1usize..70, shift in 0.1..3.0f64) {
            let (matrix, full) = example(size);
            let mut factor = Cholesky::new(Isa::detect(), size);
            prop_assert!(factor.factorise(&matrix, shift));
            let b = vector(size);
            let mut x = b.clone();
            factor.solve(&mut x);
            let (x, b) = (Row8::numbers(&x), Row8::numbers(&b));
            for p in 0..size {
                let product: f64 = (0..size).map(|s| full[p * size + s] * x[s]).sum::<f64>() + shift * x[p];
                prop_assert!((product - b[p]).abs() < 1e-8, "{p}: {product} {}", b[p]);
            }
        }

        #[test]
        fn trace_of_the_inverse_column_by_column(size in 1usize..40) {
            let (matrix, _) = example(size);
            let mut factor = Cholesky::new(Isa::detect(), size);
            prop_assert!(factor.factorise(&matrix, 1.0));
            let mut trace = 0.0;
            for p in 0..size {
                let mut unit = vec![Row8::default(); blocks(size)];
                unit[p / LANES].0[p % LANES] = 1.0;
                factor.solve(&mut unit);
                trace += unit[p / LANES].0[p % LANES];
            }
            prop_assert!((factor.trace_of_inverse() / trace - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn same_bits_on_every_instruction_set() {
        for size in [1, 8, 19, 45] {
            let reference = bits(Isa::Portable, size);
            for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
                assert_eq!(bits(isa, size), reference, "{} {size}", isa.name());
            }
        }
    }

    #[test]
    fn an_indefinite_matrix_is_told() {
        let (matrix, _) = example(20);
        assert!(!Cholesky::new(Isa::detect(), 20).factorise(&matrix, -1e3));
        assert!(!Cholesky::new(Isa::detect(), 20).factorise(&matrix, f64::NAN));
    }
}
