//! The equations of a tensor state-space network and their derivatives.

use granum_simd::{Lanes, Row8, tanh};

use crate::linear_algebra::kernels::Scalars;
use crate::recurrent::cell_batch::{CellKernel, Work, ones};
use crate::recurrent::symmetric_tensor::{COMPONENTS, inner, plus, product_of};
use crate::recurrent::tensor_sizes::TensorSizes;
use crate::sequence::sequence_group::{CellSizes, Group, add, below_tanh, product};

/// The components of tensor `i` of `count`, whose first row is `row`.
#[inline(always)]
fn tensor<L: Lanes>(
    rows: &[Row8],
    row: usize,
    count: usize,
    i: usize,
    stride: usize,
    at: usize,
) -> [L; COMPONENTS] {
    let mut components = [L::zero(); COMPONENTS];
    for (c, component) in components.iter_mut().enumerate() {
        *component = L::load(&rows[(row + c * count + i) * stride + at].0);
    }
    components
}

#[inline(always)]
fn value<L: Lanes>(rows: &[Row8], row: usize, stride: usize, at: usize) -> L {
    L::load(&rows[row * stride + at].0)
}

#[inline(always)]
fn put<L: Lanes>(
    rows: &mut [Row8],
    count: usize,
    i: usize,
    stride: usize,
    at: usize,
    values: [L; COMPONENTS],
) {
    for (c, value) in values.into_iter().enumerate() {
        value.store(&mut rows[(c * count + i) * stride + at].0);
    }
}

/// Square of the norm that bounded tensors do not reach.
const BOUND: f64 = 16.0;

/// The factor by which a tensor is bounded: `1 / sqrt(1 + T : T / 16)`.
#[inline(always)]
fn bound<L: Lanes>(tensor: [L; COMPONENTS]) -> L {
    let one = L::splat(1.0);
    one / inner(tensor, tensor).mul_add(L::splat(1.0 / BOUND), one).sqrt()
}

/// The direction, the bounded tensors and the products before a step.
struct Before<'a> {
    below: &'a [Row8],
    bounded: &'a [Row8],
    products: &'a [Row8],
    count: usize,
    stride: usize,
    at: usize,
}

impl Before<'_> {
    #[inline(always)]
    fn direction<L: Lanes>(&self) -> [L; COMPONENTS] {
        tensor(self.below, 1, 1, 0, self.stride, self.at)
    }

    #[inline(always)]
    fn tensor<L: Lanes>(&self, i: usize) -> [L; COMPONENTS] {
        tensor(self.bounded, 0, self.count, i, self.stride, self.at)
    }

    /// The product of the direction with itself (0), or with tensor `i - 1`.
    #[inline(always)]
    fn product<L: Lanes>(&self, i: usize) -> [L; COMPONENTS] {
        tensor(self.products, 0, self.count + 1, i, self.stride, self.at)
    }

    /// Element `b` of the tensors of which changes are sums.
    #[inline(always)]
    fn basis<L: Lanes>(&self, b: usize) -> [L; COMPONENTS] {
        match b {
            0 => self.direction(),
            b if b <= self.count => self.tensor(b - 1),
            b => self.product(b - self.count - 1),
        }
    }
}

impl CellKernel for TensorSizes {
    fn sizes(&self) -> CellSizes {
        CellSizes {
            inputs: self.inputs(),
            starts: self.starts(),
            state: self.state(),
            outputs: self.outputs(),
            weights: self.weights(),
            rows: self.rows(self.outputs()),
        }
    }

    /// Inputs of the hidden neurons with a row of ones; a row of ones with the hidden neurons; coefficients; products of tensors; bounded
    /// tensors.
    fn own(&self) -> Vec<usize> {
        let products = COMPONENTS * (1 + self.all_tensors());
        let bounded = COMPONENTS * self.all_tensors();
        vec![self.features() + 1, 1 + self.hidden, self.coefficients(), products, bounded]
    }

    /// With respect to the states after each step, the coefficients, the weighted sums and the inputs of the hidden neurons, and the rates of
    /// decay.
    fn derivatives(&self) -> Vec<usize> {
        let decays = self.all_tensors() + self.all_scalars();
        vec![self.state(), self.coefficients(), self.hidden, self.features(), decays]
    }

    #[inline(always)]
    fn start<L: Lanes>(self, weights: &[f64], group: &mut Group, _: &mut Work) {
        let Group { layout, below, starts: start_rows, .. } = group;
        let (stride, start_stride, (_, all)) = (layout.stride, layout.start_stride, layout.step(0));
        let (m, measured) = (self.all_tensors(), self.tensors);
        let place = self.inputs() + 1;
        let scalars_at = place + COMPONENTS * m;
        for c in 0..COMPONENTS {
            for i in 0..measured {
                for b in 0..all {
                    below[(place + c * m + i) * stride + b] =
                        start_rows[(c * measured + i) * start_stride + b];
                }
            }
            product::<L>(
                Scalars { values: &weights[self.first_tensors()..], by_k: 1, by_j: measured },
                self.internal_tensors,
                measured,
                &start_rows[c * measured * start_stride..],
                start_stride,
                0,
                all,
                #[inline(always)]
                |j, b, sum| sum.store(&mut below[(place + c * m + measured + j) * stride + b].0),
            );
        }
        let start_scalars = COMPONENTS * measured * start_stride;
        for j in 0..self.scalars {
            for b in 0..all {
                below[(scalars_at + j) * stride + b] = start_rows[start_scalars + j * start_stride + b];
            }
        }
        product::<L>(
            Scalars { values: &weights[self.first_scalars()..], by_k: 1, by_j: self.start_scalars + 1 },
            self.internal_scalars,
            self.start_scalars + 1,
            &start_rows[start_scalars..],
            start_stride,
            0,
            all,
            #[inline(always)]
            |j, b, sum| sum.store(&mut below[(scalars_at + self.scalars + j) * stride + b].0),
        );
    }

    #[inline(always)]
    fn forward<L: Lanes>(self, weights: &[f64], group: &mut Group, work: &mut Work) {
        let Group { layout, below, .. } = group;
        let Work { outputs: results, own, .. } = work;
        let [features, neurons, coefficients, products, bounded] = &mut own[..] else { return };
        let stride = layout.stride;
        let (m, measured) = (self.all_tensors(), self.tensors);
        let (place, width_of_f) = (self.inputs() + 1, self.features());
        let scalars_at = place + COMPONENTS * m;
        ones(&mut features[width_of_f * stride..(width_of_f + 1) * stride]);
        ones(&mut neurons[..stride]);
        for step in 0..layout.steps() {
            let (first, width) = layout.step(step);
            for at in first..first + width {
                self.invariants::<L>(below, features, products, bounded, stride, at);
            }
            product::<L>(
                Scalars { values: weights, by_k: 1, by_j: width_of_f + 1 },
                self.hidden,
                width_of_f + 1,
                features,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| tanh(sum).store(&mut neurons[(1 + j) * stride + b].0),
            );
            product::<L>(
                Scalars { values: &weights[self.changes()..], by_k: 1, by_j: 1 + self.hidden },
                self.coefficients(),
                1 + self.hidden,
                neurons,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| sum.store(&mut coefficients[j * stride + b].0),
            );
            let next = layout.next(step);
            for b in 0..width {
                let at = first + b;
                let length = L::load(&below[at].0);
                for i in 0..m {
                    let before = Before { below, bounded, products, count: m, stride, at };
                    let mut change = [L::zero(); COMPONENTS];
                    for e in 0..self.basis() {
                        let factor = L::load(&coefficients[(i * self.basis() + e) * stride + at].0);
                        plus(&mut change, factor, before.basis(e));
                    }
                    let mut after: [L; COMPONENTS] = tensor(below, place, m, i, stride, at);
                    plus(&mut change, L::splat(-self.decay(weights, i)), after);
                    plus(&mut after, length, change);
                    if i < measured {
                        put(results, measured, i, stride, at, after);
                    }
                    if b < next.1 {
                        put(&mut below[place * stride..], m, i, stride, next.0 + b, after);
                    }
                }
                for j in 0..self.all_scalars() {
                    let rate: L = value(coefficients, m * self.basis() + j, stride, at);
                    let before: L = value(below, scalars_at + j, stride, at);
                    let rate = L::splat(-self.decay(weights, m + j)).mul_add(before, rate);
                    let after = length.mul_add(rate, before);
                    if j < self.scalars {
                        after.store(&mut results[(COMPONENTS * measured + j) * stride + at].0);
                    }
                    if b < next.1 {
                        after.store(&mut below[(scalars_at + j) * stride + next.0 + b].0);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn backward<L: Lanes>(self, weights: &[f64], group: &Group, work: &mut Work, gradient: &mut [f64]) {
        let Group { layout, below, starts: start_rows, .. } = group;
        let Work { output_deltas, own, derivatives, carried, .. } = work;
        let [features, neurons, coefficients, products, bounded] = &own[..] else { return };
        let [state_deltas, factor_deltas, deltas, feature_deltas, decay_deltas] = &mut derivatives[..] else {
            return;
        };
        let (stride, start_stride, one) = (layout.stride, layout.start_stride, L::splat(1.0));
        let (m, measured, basis) = (self.all_tensors(), self.tensors, self.basis());
        let (place, width_of_f) = (self.inputs() + 1, self.features());
        let scalars = COMPONENTS * m;
        state_deltas.fill(Row8::default());
        let mut copy = |to: usize, from: usize| {
            state_deltas[to * stride..(to + 1) * stride]
                .copy_from_slice(&output_deltas[from * stride..(from + 1) * stride]);
        };
        for c in 0..COMPONENTS {
            (0..measured).for_each(|i| copy(c * m + i, c * measured + i));
        }
        (0..self.scalars).for_each(|j| copy(scalars + j, COMPONENTS * measured + j));
        for step in (0..layout.steps()).rev() {
            let (first, width) = layout.step(step);
            for at in first..first + width {
                let before = Before { below, bounded, products, count: m, stride, at };
                let length = L::load(&below[at].0);
                for i in 0..m {
                    let delta: [L; COMPONENTS] = tensor(state_deltas, 0, m, i, stride, at);
                    for e in 0..basis {
                        let value = length * inner(delta, before.basis(e));
                        value.store(&mut factor_deltas[(i * basis + e) * stride + at].0);
                    }
                    let own: [L; COMPONENTS] = tensor(below, place, m, i, stride, at);
                    let of_root = L::splat(-2.0 * weights[self.decays() + i]);
                    (of_root * length * inner(delta, own)).store(&mut decay_deltas[i * stride + at].0);
                }
                for j in 0..self.all_scalars() {
                    let delta = length * value::<L>(state_deltas, scalars + j, stride, at);
                    delta.store(&mut factor_deltas[(m * basis + j) * stride + at].0);
                    let of_root = L::splat(-2.0 * weights[self.decays() + m + j]);
                    let own: L = value(below, place + scalars + j, stride, at);
                    (of_root * delta * own).store(&mut decay_deltas[(m + j) * stride + at].0);
                }
            }
            let (changes, counts) = (&weights[self.changes()..], [self.hidden, self.coefficients()]);
            below_tanh::<L>(changes, counts, factor_deltas, neurons, deltas, stride, (first, width));
            product::<L>(
                Scalars { values: weights, by_k: width_of_f + 1, by_j: 1 },
                width_of_f,
                self.hidden,
                deltas,
                stride,
                first,
                width,
                #[inline(always)]
                |j, b, sum| sum.store(&mut feature_deltas[j * stride + b].0),
            );
            for b in 0..width {
                let at = first + b;
                for i in 0..m {
                    let before = Before { below, bounded, products, count: m, stride, at };
                    let of_bounded: [L; COMPONENTS] =
                        self.tensor_delta(&before, state_deltas, coefficients, feature_deltas, i);
                    let own: [L; COMPONENTS] = tensor(below, place, m, i, stride, at);
                    let after: [L; COMPONENTS] = tensor(state_deltas, 0, m, i, stride, at);
                    let (length, factor) = (L::load(&below[at].0), bound(own));
                    let mut sum = [L::zero(); COMPONENTS];
                    plus(&mut sum, factor, of_bounded);
                    let along = inner(own, of_bounded) * factor * factor * factor * L::splat(-1.0 / BOUND);
                    plus(&mut sum, along, own);
                    plus(&mut sum, length.mul_add(L::splat(-self.decay(weights, i)), one), after);
                    for (c, value) in sum.into_iter().enumerate() {
                        let row = c * m + i;
                        if step == 0 {
                            value.store(&mut carried[row * start_stride + b].0);
                        } else {
                            let entry = &mut state_deltas[row * stride + layout.offsets[step - 1] + b].0;
                            (L::load(entry) + value).store(entry);
                        }
                    }
                }
                for j in 0..self.all_scalars() {
                    let delta: L = value(state_deltas, scalars + j, stride, at);
                    let kept = L::load(&below[at].0).mul_add(L::splat(-self.decay(weights, m + j)), one);
                    let sum = kept.mul_add(delta, value(feature_deltas, self.further + j, stride, at));
                    let row = scalars + j;
                    if step == 0 {
                        sum.store(&mut carried[row * start_stride + b].0);
                    } else {
                        let entry = &mut state_deltas[row * stride + layout.offsets[step - 1] + b].0;
                        (L::load(entry) + sum).store(entry);
                    }
                }
            }
        }
        let (total, all) = (layout.total(), layout.step(0).1);
        add::<L>(deltas, self.hidden, features, width_of_f + 1, 0, stride, total, gradient);
        let factors = self.coefficients();
        add::<L>(factor_deltas, factors, neurons, 1 + self.hidden, self.changes(), stride, total, gradient);
        let decays = m + self.all_scalars();
        add::<L>(decay_deltas, decays, neurons, 1, self.decays(), stride, total, gradient);
        for c in 0..COMPONENTS {
            let inner = &carried[(c * m + measured) * start_stride..];
            let start = &start_rows[c * measured * start_stride..];
            let at = self.first_tensors();
            add::<L>(inner, self.internal_tensors, start, measured, at, start_stride, all, gradient);
        }
        let inner = &carried[(scalars + self.scalars) * start_stride..];
        let start = &start_rows[COMPONENTS * measured * start_stride..];
        let (width, at) = (self.start_scalars + 1, self.first_scalars());
        add::<L>(inner, self.internal_scalars, start, width, at, start_stride, all, gradient);
    }
}

impl TensorSizes {
    /// The inputs of the hidden neurons before a step, and the products of tensors.
    #[inline(always)]
    fn invariants<L: Lanes>(
        self,
        below: &[Row8],
        features: &mut [Row8],
        products: &mut [Row8],
        bounded: &mut [Row8],
        stride: usize,
        at: usize,
    ) {
        let (m, place) = (self.all_tensors(), self.inputs() + 1);
        for k in 0..self.further {
            features[k * stride + at] = below[(1 + COMPONENTS + k) * stride + at];
        }
        for k in 0..self.all_scalars() {
            features[(self.further + k) * stride + at] = below[(place + COMPONENTS * m + k) * stride + at];
        }
        let direction: [L; COMPONENTS] = tensor(below, 1, 1, 0, stride, at);
        let squared = product_of(direction, direction);
        put(products, m + 1, 0, stride, at, squared);
        let linear = self.further + self.all_scalars();
        let pairs = linear + m;
        let cubic = pairs + m * (m + 1) / 2;
        inner(direction, squared).store(&mut features[cubic * stride + at].0);
        for i in 0..m {
            let own: [L; COMPONENTS] = tensor(below, place, m, i, stride, at);
            let mut limited = [L::zero(); COMPONENTS];
            plus(&mut limited, bound(own), own);
            put(bounded, m, i, stride, at, limited);
        }
        let mut pair = pairs;
        for i in 0..m {
            let own: [L; COMPONENTS] = tensor(bounded, 0, m, i, stride, at);
            inner(direction, own).store(&mut features[(linear + i) * stride + at].0);
            for j in i..m {
                inner(own, tensor(bounded, 0, m, j, stride, at)).store(&mut features[pair * stride + at].0);
                pair += 1;
            }
            inner(own, squared).store(&mut features[(cubic + 1 + i) * stride + at].0);
            let with_direction = product_of(own, direction);
            put(products, m + 1, 1 + i, stride, at, with_direction);
            inner(own, with_direction).store(&mut features[(cubic + 1 + m + i) * stride + at].0);
        }
    }

    /// The derivative with respect to bounded tensor `i` before a step, from those with respect to the state after it and to the inputs of the hidden
    /// neurons.
    #[inline(always)]
    fn tensor_delta<L: Lanes>(
        self,
        before: &Before,
        state_deltas: &[Row8],
        coefficients: &[Row8],
        feature_deltas: &[Row8],
        i: usize,
    ) -> [L; COMPONENTS] {
        let (m, basis, stride, at) = (self.all_tensors(), self.basis(), before.stride, before.at);
        let length = L::load(&before.below[at].0);
        let mut sum = [L::zero(); COMPONENTS];
        let mut of_product = [L::zero(); COMPONENTS];
        for j in 0..m {
            let after: [L; COMPONENTS] = tensor(state_deltas, 0, m, j, stride, at);
            plus(&mut sum, length * value(coefficients, j * basis + 1 + i, stride, at), after);
            plus(&mut of_product, length * value(coefficients, j * basis + m + 2 + i, stride, at), after);
        }
        let mut row = self.further + self.all_scalars();
        plus(&mut sum, value(feature_deltas, row + i, stride, at), before.direction());
        row += m;
        for a in 0..m {
            for b in a..m {
                if a == i {
                    plus(&mut sum, value(feature_deltas, row, stride, at), before.tensor(b));
                }
                if b == i {
                    plus(&mut sum, value(feature_deltas, row, stride, at), before.tensor(a));
                }
                row += 1;
            }
        }
        plus(&mut sum, value(feature_deltas, row + 1 + i, stride, at), before.product(0));
        row += 1 + m;
        plus(&mut sum, value(feature_deltas, row + i, stride, at), before.product(1 + i));
        plus(&mut of_product, value(feature_deltas, row + i, stride, at), before.tensor(i));
        plus(&mut sum, L::splat(1.0), product_of(before.direction(), of_product));
        sum
    }
}
