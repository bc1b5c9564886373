//! The Gauss-Newton matrix of a network, in whichever of two forms is cheaper.
//!
//! With `J` the Jacobian of the weighted residuals `e` (rows x weights), a regularised Gauss-Newton step needs
//! `(J^T J + c I)^-1`. With fewer rows than weights that inverse is had from the small matrix `K = J J^T`,
//!
//! ```text
//! (J^T J + c I)^-1 J^T = J^T (K + c I)^-1
//! ```
//!
//! and `J` need never be formed: the derivative of row `r` with respect to the weights of one layer is the outer product of
//! what was propagated back to the layer's sums, `d_l(r)`, and of what entered the layer, `a_l(r)` with its one for the
//! bias, so `K(r, s)` is the sum over layers of `(d_l(r) . d_l(s)) (a_l(r) . a_l(s) + 1)`: Hadamard products of small Gram
//! matrices. With many rows `J^T J` is summed from the rows, a slab at a time.

use granum_simd::{Isa, Kernel, LANES, Lanes, Row8, dispatch};

use crate::backprop::Workspace;
use crate::kernels::{Scalars, blocks, panels};
use crate::symmetric::{Cholesky, Symmetric, eight_rows};

/// Rows of the Jacobian that are formed at a time.
const SLAB: usize = 256;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// `J J^T`, rows x rows.
    Kernel,
    /// `J^T J`, weights x weights.
    Normal,
}

impl Form {
    /// The form with fewer multiplications an iteration: forming the matrix, two factorisations and one inverse.
    pub(crate) fn cheaper(rows: usize, weights: usize, neurons: usize) -> Form {
        let (n, w) = (rows as f64, weights as f64);
        let kernel = n * n * (neurons as f64 + n) / 2.0;
        let normal = w * w * (n + w) / 2.0;
        if kernel <= normal { Form::Kernel } else { Form::Normal }
    }

    fn size(self, rows: usize, weights: usize) -> usize {
        match self {
            Form::Kernel => rows,
            Form::Normal => weights,
        }
    }

    /// Bytes that a curvature of this form takes.
    pub(crate) fn bytes(self, rows: usize, weights: usize) -> usize {
        let slab = if self == Form::Normal { SLAB * (weights + LANES) * 8 } else { 0 };
        3 * Symmetric::bytes(self.size(rows, weights)) + slab
    }
}

/// The Gauss-Newton matrix with the factor of its shifted self.
#[derive(Clone)]
pub(crate) struct Curvature {
    isa: Isa,
    pub form: Form,
    matrix: Symmetric,
    factor: Cholesky,
    slab: Vec<Row8>,
}

impl Curvature {
    pub(crate) fn new(isa: Isa, form: Form, rows: usize, weights: usize) -> Curvature {
        let size = form.size(rows, weights);
        let matrix = Symmetric::new(size);
        let slab =
            if form == Form::Normal { vec![Row8::default(); SLAB * matrix.stride] } else { Vec::new() };
        Curvature { isa, form, factor: Cholesky::new(isa, size), matrix, slab }
    }

    /// Forms the matrix from the sensitivities in the workspace.
    pub(crate) fn form(&mut self, workspace: &Workspace) {
        match self.form {
            Form::Kernel => dispatch(self.isa, FormKernel { curvature: self, workspace }),
            Form::Normal => dispatch(self.isa, FormNormal { curvature: self, workspace }),
        }
    }

    /// Factorises the matrix plus `shift I`; false if it is not positive definite to working precision.
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
        &self,
        workspace: &mut Workspace,
        residuals: &[Row8],
        weights: &[f64],
        decay: f64,
        shift: f64,
        step: &mut [f64],
    ) {
        match self.form {
            Form::Kernel => {
                // J^T (K + c I)^-1 (e - (a / c) J w) + (a / c) w: no difference of large numbers for small c.
                let ratio = decay / shift;
                let mut right = vec![Row8::default(); self.matrix.blocks];
                workspace.jacobian_times(weights, &mut right);
                for (r, e) in right.iter_mut().zip(residuals) {
                    for l in 0..LANES {
                        r.0[l] = (-ratio).mul_add(r.0[l], e.0[l]);
                    }
                }
                self.factor.solve(&mut right);
                workspace.transposed_jacobian_times(&right, step);
                for (s, w) in step.iter_mut().zip(weights) {
                    *s = -ratio.mul_add(*w, *s);
                }
            }
            Form::Normal => {
                workspace.transposed_jacobian_times(residuals, step);
                let mut right = vec![Row8::default(); self.matrix.blocks];
                for (p, w) in weights.iter().enumerate() {
                    right[p / LANES].0[p % LANES] = -decay.mul_add(*w, step[p]);
                }
                self.factor.solve(&mut right);
                step.copy_from_slice(&Row8::numbers(&right)[..weights.len()]);
            }
        }
    }

    /// `b^T (M + shift I)^-1 b` for the shift of the last factorisation; `vector` is used up.
    pub(crate) fn quadratic_form(&self, vector: &mut [Row8]) -> f64 {
        self.factor.solve_transposed(vector);
        Row8::numbers(vector).iter().fold(0.0, |sum, v| v.mul_add(*v, sum))
    }
}

struct FormKernel<'a> {
    curvature: &'a mut Curvature,
    workspace: &'a Workspace,
}

impl Kernel for FormKernel<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Symmetric { blocks, stride, ref mut values, .. } = self.curvature.matrix;
        for q in 0..blocks {
            let rows = &mut values[q * LANES * stride..][..LANES * stride];
            eight_kernel_rows::<L>(self.workspace, q, self.workspace, (q, blocks), rows, stride);
        }
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
        if L::REGISTERS >= 32 { 3 } else { 1 },
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
}

impl Kernel for CrossKernel<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        eight_kernel_rows::<L>(self.left, self.block, self.right, self.range, self.rows, self.right.blocks);
    }
}

/// Eight rows of `right.blocks` lane blocks: row `i` holds the kernel between row `8 block + i` of `left` and the rows of
/// `right` in the blocks of `range`. Both need their sensitivities.
pub(crate) fn cross_kernel(
    left: &Workspace,
    block: usize,
    right: &Workspace,
    range: (usize, usize),
) -> Vec<Row8> {
    let mut rows = vec![Row8::default(); LANES * right.blocks];
    dispatch(left.isa, CrossKernel { left, block, right, range, rows: &mut rows });
    rows
}

struct FormNormal<'a> {
    curvature: &'a mut Curvature,
    workspace: &'a Workspace,
}

impl Kernel for FormNormal<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let w = self.workspace;
        let Curvature { matrix, slab, .. } = self.curvature;
        let Symmetric { blocks, stride, ref mut values, .. } = *matrix;
        values.fill(Row8::default());
        let widest = if L::REGISTERS >= 32 { 3 } else { 1 };
        let mut from = 0;
        while from < w.rows {
            let count = SLAB.min(w.rows - from);
            for r in 0..count {
                jacobian_row(w, from + r, &mut slab[r * stride..][..blocks]);
            }
            for q in 0..blocks {
                let rows = &mut values[q * LANES * stride..][..LANES * stride];
                let scalars =
                    Scalars { values: &Row8::numbers(slab)[q * LANES..], by_k: stride * LANES, by_j: 1 };
                panels(
                    q,
                    blocks,
                    widest,
                    #[inline(always)]
                    |first, width| {
                        eight_rows::<L>(
                            scalars,
                            count,
                            slab,
                            stride,
                            first,
                            width,
                            #[inline(always)]
                            |i, b, sum| {
                                let entry = &mut rows[i * stride + b].0;
                                (L::load(entry) + sum).store(entry);
                            },
                        );
                    },
                );
            }
            from += count;
        }
    }
}

/// Derivative of one row's weighted output with respect to all weights.
#[inline(always)]
pub(crate) fn jacobian_row(workspace: &Workspace, row: usize, target: &mut [Row8]) {
    let (block, lane) = (row / LANES, row % LANES);
    let mut at = 0;
    for (l, layer) in workspace.layers.iter().enumerate() {
        for j in 0..layer.neurons {
            let delta = workspace.deltas[l][j * workspace.stride + block].0[lane];
            for i in 0..=layer.inputs {
                let input = workspace.outputs[l][i * workspace.stride + block].0[lane];
                target[at / LANES].0[at % LANES] = delta * input;
                at += 1;
            }
        }
    }
    debug_assert!(blocks(at) == target.len());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Data;
    use crate::network::Network;
    use proptest::prelude::*;

    /// A workspace with sensitivities, its Jacobian row by row, residuals and weights.
    fn example(
        isa: Isa,
        layers: &[usize],
        rows: usize,
        seed: u64,
    ) -> (Workspace, Vec<f64>, Vec<Row8>, Network) {
        let network = Network::new(layers, seed).unwrap();
        let m = layers[layers.len() - 1];
        let inputs = (0..rows * layers[0]).map(|k| (k as f64 * 1.7 + seed as f64 % 10.0).sin()).collect();
        let targets = (0..rows * m).map(|k| 0.5 + 0.4 * (k as f64 * 0.9).cos()).collect();
        let data = Data::with_target_columns(inputs, layers[0], targets, m)
            .unwrap()
            .with_weights((0..rows).map(|r| 0.5 + (r % 3) as f64).collect())
            .unwrap();
        let mut workspace = Workspace::of_residuals(isa, &network, &data);
        workspace.squared_error(network.weights());
        workspace.sensitivities(network.weights());
        let count = network.weights().len();
        let mut jacobian = Vec::new();
        for r in 0..workspace.rows {
            let mut row = vec![Row8::default(); blocks(count)];
            jacobian_row(&workspace, r, &mut row);
            jacobian.extend_from_slice(&Row8::numbers(&row)[..count]);
        }
        let mut residuals = vec![Row8::default(); workspace.blocks];
        workspace.residuals(&mut residuals);
        (workspace, jacobian, residuals, network)
    }

    fn curvature(isa: Isa, form: Form, workspace: &Workspace, network: &Network) -> Curvature {
        let mut curvature = Curvature::new(isa, form, workspace.rows, network.weights().len());
        curvature.form(workspace);
        curvature
    }

    fn step(isa: Isa, form: Form, layers: &[usize], rows: usize, decay: f64, shift: f64) -> (Vec<f64>, f64) {
        let (mut workspace, _, residuals, network) = example(isa, layers, rows, 5);
        let mut curvature = curvature(isa, form, &workspace, &network);
        assert!(curvature.factorise(shift));
        let mut step = vec![0.0; network.weights().len()];
        curvature.step(&mut workspace, &residuals, network.weights(), decay, shift, &mut step);
        (step, curvature.effective_parameters(shift))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn hadamard_products_are_the_explicit_kernel(
            layers in proptest::collection::vec(1usize..9, 2..5), rows in 1usize..40, seed in any::<u64>(),
        ) {
            let isa = Isa::detect();
            let (workspace, jacobian, _, network) = example(isa, &layers, rows, seed);
            let count = network.weights().len();
            let kernel = curvature(isa, Form::Kernel, &workspace, &network);
            let normal = curvature(isa, Form::Normal, &workspace, &network);
            for p in 0..workspace.rows {
                for s in p..workspace.rows {
                    let explicit: f64 = (0..count).map(|k| jacobian[p * count + k] * jacobian[s * count + k]).sum();
                    let entry = kernel.matrix.values[p * kernel.matrix.stride + s / LANES].0[s % LANES];
                    prop_assert!((entry - explicit).abs() < 1e-12 * (1.0 + explicit.abs()));
                }
            }
            for p in 0..count {
                for s in p..count {
                    let explicit: f64 =
                        (0..workspace.rows).map(|r| jacobian[r * count + p] * jacobian[r * count + s]).sum();
                    let entry = normal.matrix.values[p * normal.matrix.stride + s / LANES].0[s % LANES];
                    prop_assert!((entry - explicit).abs() < 1e-12 * (1.0 + explicit.abs()));
                }
            }
        }
    }

    #[test]
    fn the_jacobian_is_that_of_finite_differences() {
        let (mut workspace, jacobian, _, network) = example(Isa::detect(), &[2, 5, 4, 2], 7, 3);
        let count = network.weights().len();
        let mut weights = network.weights().to_vec();
        let mut at = |weights: &[f64]| {
            let mut residuals = vec![Row8::default(); workspace.blocks];
            workspace.squared_error(weights);
            workspace.residuals(&mut residuals);
            Row8::numbers(&residuals).to_vec()
        };
        for k in 0..count {
            let h = 1e-5;
            let before = weights[k];
            weights[k] = before + h;
            let up = at(&weights);
            weights[k] = before - h;
            let down = at(&weights);
            weights[k] = before;
            for r in 0..14 {
                assert!((jacobian[r * count + k] - (up[r] - down[r]) / (2.0 * h)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn both_forms_take_the_same_step() {
        for (layers, rows) in [(&[2, 6, 5, 1][..], 20), (&[1, 3, 1][..], 300), (&[2, 4, 2][..], 9)] {
            let (kernel, gamma_kernel) = step(Isa::detect(), Form::Kernel, layers, rows, 0.02, 0.05);
            let (normal, gamma_normal) = step(Isa::detect(), Form::Normal, layers, rows, 0.02, 0.05);
            let length = kernel.iter().map(|s| s * s).sum::<f64>().sqrt();
            for (k, n) in kernel.iter().zip(&normal) {
                assert!((k - n).abs() < 1e-10 * length, "{k} {n}");
            }
            assert!((gamma_kernel - gamma_normal).abs() < 1e-8 * gamma_kernel);
            assert!(gamma_kernel > 1.0 && gamma_kernel < kernel.len() as f64);
        }
    }

    #[test]
    fn same_bits_on_every_instruction_set() {
        for form in [Form::Kernel, Form::Normal] {
            let reference = step(Isa::Portable, form, &[2, 7, 5, 1], 21, 0.01, 0.02);
            for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
                assert_eq!(step(isa, form, &[2, 7, 5, 1], 21, 0.01, 0.02), reference, "{}", isa.name());
            }
        }
    }
}
