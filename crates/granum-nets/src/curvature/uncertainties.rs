//! What the rows leave open about predictions for other observations.

use granum_simd::{Kernel, LANES, Lanes, Row8, dispatch};

use super::{Curvature, cross_kernel};
use crate::backprop::Workspace;
use crate::kernels::{blocks, odd};

impl Curvature {
    /// The remaining uncertainty of the predictions for other observations: for each observation the shift times
    /// `g . (J^T J + shift I)^-1 g`, where `g` is the gradient of the prediction with respect to the weights and the shift
    /// is that of the last factorisation. The sensitivities of `asked` must have been computed.
    ///
    /// With `k` the kernel between the chosen rows and an observation and `l = U^-T k` it is
    /// `g . g - l . l + shift l . (L L^T + shift I)^-1 l`.
    pub(crate) fn uncertainties(&self, asked: &Workspace, shift: f64) -> Vec<f64> {
        let Some(pivots) = &self.pivots else { return Vec::new() };
        let count = asked.observations();
        let (columns, stride) = (blocks(count), odd(blocks(count)));
        let mut lanes = vec![Row8::default(); self.square * LANES * stride];
        if asked.points == 1 {
            for q in 0..self.square {
                let rows = &mut lanes[q * LANES * stride..][..LANES * stride];
                cross_kernel(pivots, q, asked, (0, asked.blocks), rows, stride);
            }
        } else {
            let mut rows = vec![Row8::default(); LANES * asked.blocks];
            for q in 0..self.square {
                cross_kernel(pivots, q, asked, (0, asked.blocks), &mut rows, asked.blocks);
                for i in 0..LANES {
                    let target = &mut lanes[(q * LANES + i) * stride..][..columns];
                    asked.sum_points(&rows[i * asked.blocks..][..asked.blocks], target);
                }
            }
        }
        let squares_of = |lanes: &[Row8]| {
            let mut squares = vec![Row8::default(); columns];
            dispatch(self.isa, SquaresOfColumns { lanes, stride, squares: &mut squares });
            squares
        };
        let own = own_kernel(asked);
        self.upper().solve_transposed_lanes(self.isa, &mut lanes, stride, columns);
        let whole = squares_of(&lanes);
        self.factor.upper().solve_transposed_lanes(self.isa, &mut lanes, stride, columns);
        let left = squares_of(&lanes);
        let terms = own.iter().zip(Row8::numbers(&whole)).zip(Row8::numbers(&left)).take(count);
        terms.map(|((own, whole), left)| (own - whole).max(0.0) + shift * left).collect()
    }
}

/// The sum of the squares of each column of a lane matrix.
struct SquaresOfColumns<'a> {
    lanes: &'a [Row8],
    stride: usize,
    squares: &'a mut [Row8],
}

impl Kernel for SquaresOfColumns<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (b, square) in self.squares.iter_mut().enumerate() {
            let mut sum = L::zero();
            for row in self.lanes.chunks_exact(self.stride) {
                let value = L::load(&row[b].0);
                sum = value.mul_add(value, sum);
            }
            sum.store(&mut square.0);
        }
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
