//! The Gauss-Newton matrix of a network, approximated by means of some of the rows.
//!
//! With `J` the Jacobian of the weighted residuals `e` (observations x weights), a regularised Gauss-Newton step needs
//! `(J^T J + c I)^-1`, which can be computed from the kernel `K = J J^T`:
//!
//! ```text
//! (J^T J + c I)^-1 J^T = J^T (K + c I)^-1
//! ```
//!
//! `J` is never formed: the derivative of row `r` with respect to the weights of one layer is the outer product of the
//! derivatives with respect to the weighted sums of the layer, `d_l(r)`, and the inputs of the layer, `a_l(r)` with an
//! additional one for the bias. `K(r, s)` is therefore the sum over layers of `(d_l(r) . d_l(s)) (a_l(r) . a_l(s) + 1)`,
//! that is a sum of Hadamard products of small Gram matrices.
//!
//! A small regularised network has a few dozen effective parameters, and `K` has that rank to working precision for any
//! number of rows. Steps are therefore sought in the span of the gradients of at most [`MOST_CHOSEN`] *chosen* rows,
//! spread evenly over the table (the Nystroem method; Smola and Bartlett 2001, Williams and Seeger 2001). With `C` the
//! kernel among the chosen rows and `B` that between them and all observations,
//!
//! ```text
//! C = U^T U,   L = U^-T B,   K ~ L^T L,   J^T (K + c I)^-1 ~ J_C^T U^-1 (L L^T + c I)^-1 L
//! ```
//!
//! The cost of a step is proportional to the number of rows times the number of chosen rows instead of the cube of the
//! number of rows or weights. If all rows are chosen, there is no approximation.

mod determined;

pub(crate) use determined::Determined;

use granum_simd::{Isa, Kernel, LANES, Lanes, Row8, dispatch, mul_add};

use crate::feed_forward::backprop::Workspace;
use crate::linear_algebra::kernels::Scalars;
use crate::linear_algebra::kernels::{blocks, lane_dots, odd, panels};
use crate::linear_algebra::symmetric::{Cholesky, Symmetric, Upper, eight_rows, factorise_panel};

/// Largest number of chosen rows, in the span of whose gradients steps are sought.
pub(crate) const MOST_CHOSEN: usize = 128;
/// Jitter that is added to the diagonal of the kernel among the chosen rows, as a fraction of its mean. It is needed because
/// the gradients of neighbouring rows are nearly equal.
const JITTER: f64 = 1e-11;
/// Factor by which the jitter is increased if it is not sufficient, and the number of attempts.
const MORE_JITTER: (f64, usize) = (100.0, 5);

/// The Gauss-Newton matrix, with the Cholesky factor of the shifted matrix.
#[derive(Clone)]
pub(crate) struct Curvature {
    isa: Isa,
    /// The chosen rows, and the results of the last passes over them.
    chosen: Vec<usize>,
    pivots: Option<Workspace>,
    /// `[U | L]`: one row for each chosen row; the columns are the chosen rows and then the observations, in lane blocks.
    panel: Vec<Row8>,
    stride: usize,
    /// Numbers of lane blocks of the chosen rows and of the observations.
    square: usize,
    observations: usize,
    reciprocal: Vec<f64>,
    /// `L L^T`, and the Cholesky factor of `L L^T` plus a shift.
    matrix: Symmetric,
    factor: Cholesky,
    /// Eight rows of the kernel.
    rows: Vec<Row8>,
}

/// Largest number of chosen rows for a network with so many weights. The gradients span at most as many dimensions as
/// there are weights, so that twice that number suffices.
fn most_chosen(weights: usize) -> usize {
    MOST_CHOSEN.min(2 * weights + LANES)
}

/// Evenly spread rows, at most `most`: one from each of as many equal intervals, at a position in it that advances by the
/// golden ratio, so that a periodic order of the rows is sampled at all phases.
fn choose(rows: usize, most: usize) -> Vec<usize> {
    let count = rows.min(most);
    (0..count)
        .map(|k| {
            let (from, to) = (k * rows / count, (k + 1) * rows / count);
            from + ((to - from) as f64 * (k as f64 * 0.618_033_988_749_894_8).fract()) as usize
        })
        .collect()
}

impl Curvature {
    /// Memory for the matrix of a network with so many weights and a table in the layout of `workspace`.
    pub(crate) fn new(workspace: &Workspace, weights: usize) -> Curvature {
        Curvature::from_rows(workspace, choose(workspace.rows, most_chosen(weights)))
    }

    /// Memory for the matrix that is approximated by means of these rows.
    fn from_rows(workspace: &Workspace, chosen: Vec<usize>) -> Curvature {
        let (square, observations) = (blocks(chosen.len()), blocks(workspace.observations()));
        let stride = odd(square + observations);
        let size = square * LANES;
        Curvature {
            isa: workspace.isa,
            chosen,
            pivots: None,
            panel: vec![Row8::default(); size * stride],
            stride,
            square,
            observations,
            reciprocal: vec![0.0; size],
            matrix: Symmetric::new(size),
            factor: Cholesky::new(workspace.isa, size),
            rows: Vec::new(),
        }
    }

    /// Size for so many rows, observations and weights, bytes.
    pub(crate) fn bytes(rows: usize, observations: usize, weights: usize) -> usize {
        let chosen = rows.min(most_chosen(weights));
        let panel = (chosen + LANES) * odd(blocks(chosen) + blocks(observations)) * size_of::<Row8>();
        panel + LANES * odd(blocks(rows)) * size_of::<Row8>() + 3 * Symmetric::bytes(chosen)
    }

    /// Forms the matrix from the sensitivities in the workspace; returns false if they are not finite.
    pub(crate) fn form(&mut self, workspace: &Workspace) -> bool {
        let pivots = workspace.some_rows(&self.chosen);
        let mut share = JITTER;
        for _ in 0..MORE_JITTER.1 {
            let mean = self.fill(&pivots, workspace) / self.chosen.len() as f64;
            let jitter = (share * mean).max(f64::MIN_POSITIVE);
            let columns = self.square + self.observations;
            let shape = (self.square, columns);
            if factorise_panel(self.isa, &mut self.panel, self.stride, shape, jitter, &mut self.reciprocal) {
                dispatch(self.isa, Gram { curvature: self });
                self.pivots = Some(pivots);
                return true;
            }
            share *= MORE_JITTER.0;
        }
        false
    }

    /// Fills the panel with the kernel among the chosen rows, and with that between them and the observations; returns the
    /// trace of the former.
    fn fill(&mut self, pivots: &Workspace, workspace: &Workspace) -> f64 {
        let (stride, square) = (self.stride, self.square);
        let mut trace = 0.0;
        for q in 0..square {
            let rows = &mut self.panel[q * LANES * stride..][..LANES * stride];
            rows.fill(Row8::default());
            // The part left of the diagonal block is never read.
            cross_kernel(pivots, q, pivots, (q, square), rows, stride);
            trace += (0..LANES).map(|i| rows[i * stride + q].0[i]).sum::<f64>();
            self.rows.resize(LANES * workspace.blocks, Row8::default());
            cross_kernel(pivots, q, workspace, (0, workspace.blocks), &mut self.rows, workspace.blocks);
            for i in 0..LANES {
                let source = &self.rows[i * workspace.blocks..][..workspace.blocks];
                workspace.sum_points(source, &mut rows[i * stride + square..][..self.observations]);
            }
        }
        trace
    }

    fn upper(&self) -> Upper<'_> {
        Upper { values: &self.panel, stride: self.stride, blocks: self.square, reciprocal: &self.reciprocal }
    }

    /// Factorises the matrix plus `shift I`; returns false if it is not positive definite to working precision.
    pub(crate) fn factorise(&mut self, shift: f64) -> bool {
        self.factor.factorise(&self.matrix, shift)
    }

    /// Effective number of parameters, the sum over the eigenvalues of `lambda / (lambda + shift)`, for the shift of the
    /// last factorisation (MacKay 1992 equation 4.9).
    pub(crate) fn effective_parameters(&mut self, shift: f64) -> f64 {
        self.matrix.size as f64 - shift * self.factor.trace_of_inverse()
    }

    /// `-(J^T J + shift I)^-1 (J^T e + decay w)` for the shift of the last factorisation, `decay <= shift`.
    pub(crate) fn step(
        &mut self,
        workspace: &Workspace,
        residuals: &[Row8],
        weights: &[f64],
        decay: f64,
        shift: f64,
        step: &mut [f64],
    ) {
        // The form J^T (K + c I)^-1 (e - (a / c) J w) + (a / c) w avoids a difference of large numbers for small c.
        let ratio = decay / shift;
        let mut right = vec![Row8::default(); self.observations];
        workspace.jacobian_times(weights, &mut right);
        for (r, e) in right.iter_mut().zip(residuals) {
            for l in 0..LANES {
                r.0[l] = mul_add(-ratio, r.0[l], e.0[l]);
            }
        }
        let mut factors = vec![Row8::default(); self.square];
        dispatch(self.isa, Project { curvature: self, vector: &right, product: &mut factors });
        self.factor.solve(&mut factors);
        self.upper().solve(self.isa, &mut factors);
        if let Some(pivots) = &mut self.pivots {
            pivots.transposed_jacobian_times(&factors, step);
        }
        for (s, w) in step.iter_mut().zip(weights) {
            *s = -mul_add(ratio, *w, *s);
        }
    }

    /// Residuals that the observations of each block would have if the network had not been trained on that block. To
    /// first order they are `(I - H_bb)^-1 e_b` with `H = L^T (L L^T + shift I)^-1 L`, so that no network has to be
    /// trained again. `block_of` gives the number of the block of each observation.
    pub(crate) fn left_out_residuals(
        &self,
        block_of: &[usize],
        residuals: &[f64],
        shift: f64,
    ) -> Option<Vec<f64>> {
        let mut left_out = residuals.to_vec();
        let mut names = block_of.to_vec();
        names.sort_unstable();
        names.dedup();
        let (stride, square) = (self.stride, self.square);
        let entry = |p: usize, k: usize| self.panel[p * stride + square + k / LANES].0[k % LANES];
        for name in names {
            let members: Vec<usize> = (0..block_of.len()).filter(|&k| block_of[k] == name).collect();
            // The identity used is (I - L_b^T A^-1 L_b)^-1 = I + L_b^T (A - L_b L_b^T)^-1 L_b, with A = L L^T + shift I.
            let lanes = blocks(members.len());
            let mut own = vec![Row8::default(); square * LANES * odd(lanes)];
            for p in 0..square * LANES {
                for (j, &k) in members.iter().enumerate() {
                    own[p * odd(lanes) + j / LANES].0[j % LANES] = entry(p, k);
                }
            }
            let mut rest = self.matrix.clone();
            let mut block = vec![Row8::default(); lanes];
            for (j, &k) in members.iter().enumerate() {
                block[j / LANES].0[j % LANES] = residuals[k];
            }
            let mut projected = vec![Row8::default(); square];
            dispatch(
                self.isa,
                TakeAway { rows: &own, lanes, matrix: &mut rest, vector: &block, product: &mut projected },
            );
            let mut factor = Cholesky::new(self.isa, self.matrix.size);
            if !factor.factorise(&rest, shift) {
                return None;
            }
            factor.solve(&mut projected);
            let numbers = Row8::numbers(&projected);
            for (j, &k) in members.iter().enumerate() {
                let at = |p: usize| own[p * odd(lanes) + j / LANES].0[j % LANES];
                left_out[k] += (0..square * LANES).fold(0.0, |sum, p| mul_add(at(p), numbers[p], sum));
            }
        }
        Some(left_out)
    }
}

/// Computes `L L^T`.
struct Gram<'a> {
    curvature: &'a mut Curvature,
}

impl Kernel for Gram<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Curvature { panel, stride, square, observations, matrix, .. } = self.curvature;
        gram::<L>(&panel[*square..], *stride, *square, *observations, |p, s, sum| {
            matrix.values[p * matrix.stride + s / LANES].0[s % LANES] = sum;
        });
    }
}

/// Calls `finish(p, s, row p . row s)` for `p < 8 square` and every `s` from the block of `p` on.
#[inline(always)]
fn gram<L: Lanes>(
    rows: &[Row8],
    stride: usize,
    square: usize,
    count: usize,
    mut finish: impl FnMut(usize, usize, f64),
) {
    for q in 0..square {
        let from = &rows[q * LANES * stride..];
        lane_dots::<L>(
            from,
            LANES,
            from,
            (square - q) * LANES,
            stride,
            count,
            #[inline(always)]
            |i, j, sum| finish(q * LANES + i, q * LANES + j, sum),
        );
    }
}

/// Computes `L v`.
struct Project<'a> {
    curvature: &'a Curvature,
    vector: &'a [Row8],
    product: &'a mut [Row8],
}

impl Kernel for Project<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let c = self.curvature;
        project::<L>(&c.panel[c.square..], c.stride, c.square, self.vector, self.product);
    }
}

#[inline(always)]
fn project<L: Lanes>(rows: &[Row8], stride: usize, square: usize, vector: &[Row8], product: &mut [Row8]) {
    lane_dots::<L>(
        rows,
        square * LANES,
        vector,
        1,
        stride,
        vector.len(),
        #[inline(always)]
        |p, _, sum| product[p / LANES].0[p % LANES] = sum,
    );
}

/// Subtracts the products of rows from a matrix, and multiplies the rows by a vector.
struct TakeAway<'a> {
    rows: &'a [Row8],
    lanes: usize,
    matrix: &'a mut Symmetric,
    vector: &'a [Row8],
    product: &'a mut [Row8],
}

impl Kernel for TakeAway<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let TakeAway { rows, lanes, matrix, vector, product } = self;
        let square = product.len();
        gram::<L>(rows, odd(lanes), square, lanes, |p, s, sum| {
            matrix.values[p * matrix.stride + s / LANES].0[s % LANES] -= sum;
        });
        project::<L>(rows, odd(lanes), square, vector, product);
    }
}

/// Block `q` of a lane matrix as scalars.
#[inline(always)]
fn eight_scalars(matrix: &[Row8], q: usize, stride: usize) -> Scalars<'_> {
    Scalars { values: &Row8::numbers(matrix)[q * LANES..], by_k: stride * LANES, by_j: 1 }
}

/// Eight rows of the kernel between the tables of two workspaces of one network: block `q` of `left` with the
/// blocks `from..to` of `right`.
#[inline(always)]
fn eight_kernel_rows<L: Lanes>(
    left: &Workspace,
    q: usize,
    right: &Workspace,
    (from, to): (usize, usize),
    rows: &mut [Row8],
    stride: usize,
) {
    let mut gram = [[Row8::default(); 3]; LANES];
    panels(
        from,
        to,
        if const { L::REGISTERS >= 32 } { 3 } else { 1 },
        #[inline(always)]
        |first, width| {
            for (l, layer) in right.layers.iter().enumerate() {
                eight_rows::<L>(
                    eight_scalars(&left.deltas[l], q, left.stride),
                    layer.neurons,
                    &right.deltas[l],
                    right.stride,
                    first,
                    width,
                    #[inline(always)]
                    |i, b, sum| sum.store(&mut gram[i][b - first].0),
                );
                eight_rows::<L>(
                    eight_scalars(&left.outputs[l], q, left.stride),
                    layer.inputs + 1,
                    &right.outputs[l],
                    right.stride,
                    first,
                    width,
                    #[inline(always)]
                    |i, b, sum| {
                        let entry = &mut rows[i * stride + b].0;
                        let before = if l == 0 { L::zero() } else { L::load(entry) };
                        sum.mul_add(L::load(&gram[i][b - first].0), before).store(entry);
                    },
                );
            }
        },
    );
}

/// The kernel between a block of eight rows of one table and all rows of another.
struct CrossKernel<'a> {
    left: &'a Workspace,
    block: usize,
    right: &'a Workspace,
    range: (usize, usize),
    rows: &'a mut [Row8],
    stride: usize,
}

impl Kernel for CrossKernel<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        eight_kernel_rows::<L>(self.left, self.block, self.right, self.range, self.rows, self.stride);
    }
}

/// Eight rows of the kernel, `stride` lane blocks apart: row `i` holds that between row `8 block + i` of `left` and the rows
/// of `right` in the lane blocks of `range`. Both need their sensitivities.
pub(crate) fn cross_kernel(
    left: &Workspace,
    block: usize,
    right: &Workspace,
    range: (usize, usize),
    rows: &mut [Row8],
    stride: usize,
) {
    dispatch(left.isa, CrossKernel { left, block, right, range, rows, stride });
}

#[cfg(test)]
mod tests;
