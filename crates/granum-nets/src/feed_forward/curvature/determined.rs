//! What the training rows determine about predictions for other observations, and what they leave open.
//!
//! With the eigenvalues `lambda_d` and the eigenvectors `v_d` of `J^T J`, the uncertainty of a prediction with the gradient `g` is, with
//! the shift `c`,
//!
//! ```text
//! c g . (J^T J + c I)^-1 g = g . g - sum_d (v_d . g)^2 + sum_d c / (lambda_d + c) (v_d . g)^2
//! ```
//!
//! Directions whose eigenvalue is far below the shift do not change the sum and are left out, so that a few dozen remain of
//! any number of weights. They are found in the span of the gradients of some rows: of those that are chosen for the steps of training,
//! as many as are independent to working precision.

use granum_simd::{Isa, Kernel, LANES, Lanes, Row8, dispatch};

use super::{Curvature, JITTER, choose, cross_kernel, most_chosen};
use crate::feed_forward::backprop::Workspace;
use crate::linear_algebra::eigenvectors::eigenvectors;
use crate::linear_algebra::kernels::{Scalars, blocks, odd, panels};
use crate::linear_algebra::symmetric::{eight_rows, widest};

/// Directions with an eigenvalue of less than this share of the shift are left out. An uncertainty changes by less than this share
/// of itself.
const NEGLIGIBLE: f64 = 1e-6;

/// The directions in the space of the weights that training rows determine.
#[derive(Clone)]
pub(crate) struct Determined {
    isa: Isa,
    /// The independent rows, and the results of the last passes over them.
    pivots: Workspace,
    /// The factors by which the gradients of these rows are combined to the directions, a row for each of them with the
    /// directions across the lanes.
    factors: Vec<Row8>,
    /// Number of lane blocks of the directions.
    directions: usize,
    /// What is left open of each direction, `c / (lambda_d + c)`.
    open: Vec<f64>,
}

impl Determined {
    /// Directions for the shift, which is returned with them: for data without noise the regularisation nearly vanishes, and it is increased
    /// to what can be told from rounding, which only changes uncertainties that are already very small. The sensitivities of `training` must have
    /// been computed. `None` if they are not finite.
    pub(crate) fn new(training: &Workspace, weights: usize, shift: f64) -> Option<(Determined, f64)> {
        let isa = training.isa;
        let mut curvature = Curvature::from_rows(training, independent_rows(training, weights));
        if curvature.chosen.is_empty() || !curvature.form(training) {
            return None;
        }
        let (size, matrix) = (curvature.matrix.size, curvature.matrix.full());
        let (values, vectors) = eigenvectors(matrix, size);
        let largest = values.iter().copied().fold(0.0, f64::max);
        let shift = shift.max(size as f64 * f64::EPSILON * largest);
        if !shift.is_finite() {
            return None;
        }
        let kept: Vec<usize> = (0..size).filter(|&d| values[d] > NEGLIGIBLE * shift).collect();
        let directions = blocks(kept.len());
        let mut factors = vec![Row8::default(); curvature.chosen.len() * directions];
        let mut open = vec![0.0; directions * LANES];
        let mut vector = vec![Row8::default(); curvature.square];
        for (k, &d) in kept.iter().enumerate() {
            for p in 0..size {
                vector[p / LANES].0[p % LANES] = vectors[p * size + d];
            }
            curvature.upper().solve(isa, &mut vector);
            for (p, row) in factors.chunks_exact_mut(directions).enumerate() {
                row[k / LANES].0[k % LANES] = vector[p / LANES].0[p % LANES];
            }
            open[k] = shift / (values[d] + shift);
        }
        Some((Determined { isa, pivots: curvature.pivots?, factors, directions, open }, shift))
    }

    /// The directions as vectors in the space of the weights, `weights x directions` in row-major order, and what is left open of each.
    pub(crate) fn directions(&self, weights: usize) -> (Vec<f64>, Vec<f64>) {
        let rows = self.pivots.rows;
        let count = self.open.iter().rposition(|open| *open > 0.0).map_or(0, |last| last + 1);
        let mut pivots = self.pivots.clone();
        let mut directions = vec![0.0; weights * count];
        for d in 0..count {
            let mut factors = vec![Row8::default(); blocks(rows)];
            for p in 0..rows {
                factors[p / LANES].0[p % LANES] = self.factors[p * self.directions + d / LANES].0[d % LANES];
            }
            let mut vector = vec![0.0; weights];
            pivots.transposed_jacobian_times(&factors, &mut vector);
            for (w, value) in vector.into_iter().enumerate() {
                directions[w * count + d] = value;
            }
        }
        (directions, self.open[..count].to_vec())
    }

    /// The uncertainties of the predictions for other observations. The sensitivities of `asked` must have been computed.
    pub(crate) fn uncertainties(&self, asked: &Workspace) -> Vec<f64> {
        let count = asked.observations();
        let (columns, stride) = (blocks(count), odd(blocks(count)));
        let kernel = self.kernel(asked, columns, stride);
        let mut sums = vec![[Row8::default(); 2]; columns];
        dispatch(self.isa, Squares { determined: self, kernel: &kernel, stride, sums: &mut sums });
        let own = own_kernel(asked);
        let terms = own.iter().enumerate().take(count);
        let at = |k: usize, which: usize| sums[k / LANES][which].0[k % LANES];
        terms.map(|(k, own)| (own - at(k, 0)).max(0.0) + at(k, 1)).collect()
    }

    /// The kernel between the independent rows and the observations.
    fn kernel(&self, asked: &Workspace, columns: usize, stride: usize) -> Vec<Row8> {
        let mut kernel = vec![Row8::default(); self.pivots.blocks * LANES * stride];
        let mut rows = vec![Row8::default(); if asked.points == 1 { 0 } else { LANES * asked.blocks }];
        for q in 0..self.pivots.blocks {
            let target = &mut kernel[q * LANES * stride..][..LANES * stride];
            if asked.points == 1 {
                cross_kernel(&self.pivots, q, asked, (0, asked.blocks), target, stride);
                continue;
            }
            cross_kernel(&self.pivots, q, asked, (0, asked.blocks), &mut rows, asked.blocks);
            for i in 0..LANES {
                let row = &rows[i * asked.blocks..][..asked.blocks];
                asked.sum_points(row, &mut target[i * stride..][..columns]);
            }
        }
        kernel
    }
}

/// Of the rows that are chosen for training those whose gradients are independent to working precision, most independent first: the
/// pivots of a Cholesky factorisation of their kernel.
fn independent_rows(training: &Workspace, weights: usize) -> Vec<usize> {
    let candidates = choose(training.rows, most_chosen(weights));
    let rows = training.some_rows(&candidates);
    let (count, stride) = (candidates.len(), rows.blocks);
    let mut lanes = vec![Row8::default(); stride * LANES * stride];
    for q in 0..rows.blocks {
        cross_kernel(
            &rows,
            q,
            &rows,
            (0, stride),
            &mut lanes[q * LANES * stride..][..LANES * stride],
            stride,
        );
    }
    let kernel = Row8::numbers(&lanes);
    let at = |p: usize, s: usize| kernel[p * stride * LANES + s];
    let mut left: Vec<f64> = (0..count).map(|p| at(p, p)).collect();
    let least = JITTER * left.iter().sum::<f64>() / count as f64;
    let (mut chosen, mut factor) = (Vec::new(), Vec::<Vec<f64>>::new());
    while chosen.len() < count {
        let pivot = (0..count).fold(0, |best, p| if left[p] > left[best] { p } else { best });
        if left[pivot] <= least || !left[pivot].is_finite() {
            break;
        }
        let root = left[pivot].sqrt();
        let row: Vec<f64> = (0..count)
            .map(|s| factor.iter().fold(at(pivot, s), |sum, row| sum - row[pivot] * row[s]) / root)
            .collect();
        for s in 0..count {
            left[s] -= row[s] * row[s];
        }
        left[pivot] = f64::NEG_INFINITY;
        chosen.push(candidates[pivot]);
        factor.push(row);
    }
    chosen
}

/// For every observation the sum of the squares of the gradient along the directions, and of what is left open of them.
struct Squares<'a> {
    determined: &'a Determined,
    kernel: &'a [Row8],
    stride: usize,
    sums: &'a mut [[Row8; 2]],
}

impl Kernel for Squares<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Squares { determined, kernel, stride, sums } = self;
        let Determined { factors, directions, open, pivots, .. } = determined;
        panels(
            0,
            sums.len(),
            widest::<L>(),
            #[inline(always)]
            |first, width| {
                for q in 0..*directions {
                    let scalars = Scalars {
                        values: &Row8::numbers(factors)[q * LANES..],
                        by_k: directions * LANES,
                        by_j: 1,
                    };
                    eight_rows::<L>(
                        scalars,
                        pivots.rows,
                        kernel,
                        stride,
                        first,
                        width,
                        #[inline(always)]
                        |i, b, along| {
                            let [known, left] = &mut sums[b];
                            let square = along * along;
                            (L::load(&known.0) + square).store(&mut known.0);
                            square
                                .mul_add(L::splat(open[q * LANES + i]), L::load(&left.0))
                                .store(&mut left.0);
                        },
                    );
                }
            },
        );
    }
}

/// `g . g` for the prediction of every observation.
fn own_kernel(asked: &Workspace) -> Vec<f64> {
    if asked.points == 1 {
        let mut own = vec![Row8::default(); asked.blocks];
        dispatch(asked.isa, OwnKernel { asked, own: &mut own });
        return Row8::numbers(&own)[..asked.rows].to_vec();
    }
    let points = asked.points;
    let mut own = vec![0.0; asked.observations()];
    for (k, sum) in own.iter_mut().enumerate() {
        let rows: Vec<usize> = (k * points..(k + 1) * points).collect();
        let one = asked.some_rows(&rows);
        let mut kernel = vec![Row8::default(); LANES * one.blocks];
        for q in 0..one.blocks {
            cross_kernel(&one, q, &one, (0, one.blocks), &mut kernel, one.blocks);
            *sum = kernel.iter().flat_map(|row| row.0).fold(*sum, |sum, value| sum + value);
        }
    }
    own
}

/// `g . g` for the prediction of every row.
struct OwnKernel<'a> {
    asked: &'a Workspace,
    own: &'a mut [Row8],
}

impl Kernel for OwnKernel<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let OwnKernel { asked, own } = self;
        for (b, own) in own.iter_mut().enumerate() {
            let square = |matrix: &[Row8], height: usize| {
                let values = (0..height).map(|k| L::load(&matrix[k * asked.stride + b].0));
                values.fold(L::zero(), |sum, value| value.mul_add(value, sum))
            };
            let mut sum = L::zero();
            for (l, layer) in asked.layers.iter().enumerate() {
                let deltas = square(&asked.deltas[l], layer.neurons);
                sum = square(&asked.outputs[l], layer.inputs + 1).mul_add(deltas, sum);
            }
            sum.store(&mut own.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Example, example, solved};
    use super::*;

    fn determined(example: &Example, shift: f64) -> Determined {
        Determined::new(&example.workspace, example.network.weights().len(), shift).unwrap().0
    }

    /// The uncertainties of the training observations themselves are those of the formula with explicit matrices, from few directions, with
    /// fewer and with more rows than weights, and where an observation has several rows.
    #[test]
    fn few_directions_hold_what_many_rows_tell() {
        for (observations, points) in [(40, 1), (400, 1), (60, 4)] {
            let example = example(Isa::detect(), &[2, 8, 8, 1], observations, points, 3);
            let shift = 0.02;
            let determined = determined(&example, shift);
            let count = example.network.weights().len();
            assert!(determined.directions * LANES <= count * 2 / 3, "{}", determined.directions);
            let found = determined.uncertainties(&example.workspace);
            let product =
                |p: usize, s: usize| example.jacobian.iter().map(|row| row[p] * row[s]).sum::<f64>();
            let matrix: Vec<Vec<f64>> = (0..count)
                .map(|p| (0..count).map(|s| product(p, s) + if p == s { shift } else { 0.0 }).collect())
                .collect();
            assert_eq!(found.len(), observations);
            for k in (0..observations).step_by(7) {
                let g = &example.jacobian[k];
                let solution = solved(matrix.clone(), g.clone());
                let expected = shift * g.iter().zip(&solution).map(|(a, b)| a * b).sum::<f64>();
                assert!((found[k] / expected - 1.0).abs() < 1e-5, "{k}: {} {expected}", found[k]);
            }
        }
    }

    #[test]
    fn same_bits_on_every_instruction_set() {
        for (observations, points) in [(300, 1), (21, 3)] {
            let of = |isa| {
                let example = example(isa, &[2, 7, 5, 1], observations, points, 5);
                determined(&example, 0.02).uncertainties(&example.workspace)
            };
            let reference = of(Isa::Portable);
            for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
                assert_eq!(of(isa), reference, "{}", isa.name());
            }
        }
    }

    /// Without regularisation the shift is raised to what can be told from rounding.
    #[test]
    fn data_without_noise_leave_next_to_nothing_open() {
        let example = example(Isa::detect(), &[2, 4, 3, 1], 50, 1, 2);
        let (determined, shift) = Determined::new(&example.workspace, 31, 0.0).unwrap();
        assert!(shift > 0.0 && shift < 1e-10, "{shift}");
        let found = determined.uncertainties(&example.workspace);
        assert!(found.iter().all(|u| (0.0..1e-10).contains(u)), "{found:?}");
        assert!(Determined::new(&example.workspace, 31, f64::NAN).is_none_or(|(_, shift)| shift.is_finite()));
    }
}
