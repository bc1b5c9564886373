//! The covariance of a function at two rows of inputs:
//!
//! ```text
//! k(x, z) = c + sum_d s_d x_d z_d + sum_d u_d + a sum_(d < e) u_d u_e + b prod_d g_d
//! u_d = w_d g_d,   g_d = exp(-(x_d - z_d)^2 / 2 l_d^2)
//! ```
//!
//! that is, a sum of straight lines, smooth functions of one input each, of two inputs each (Duvenaud, Nickisch and Rasmussen 2011), and
//! of all inputs together. The first terms are learned from few rows, the last can be anything if there are many. All parameters are
//! positive and are varied by their logarithms.

use granum_simd::{Isa, Kernel, LANES, Lanes, Real, Row8, ScalarKernel, dispatch, exp, fused};

use super::rows::RowLanes;
use crate::linear_algebra::symmetric::Symmetric;

/// Parameters beside those of each input: pairs, product, constant, noise.
pub(super) const SHARED: usize = 4;
/// Parameters of each input: length, weight of its function, slope.
pub(super) const EACH: usize = 3;

/// Places of the shared parameters after those of the inputs.
const PAIRS: usize = 0;
const PRODUCT: usize = 1;
const CONSTANT: usize = 2;
const NOISE: usize = 3;

/// Number of parameters for so many inputs.
pub(super) fn parameter_count(inputs: usize) -> usize {
    EACH * inputs + SHARED
}

/// A covariance with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Covariance {
    inputs: usize,
    /// `1 / 2 l_d^2`.
    narrowness: Vec<f64>,
    weights: Vec<f64>,
    slopes: Vec<f64>,
    shared: [f64; SHARED],
}

/// What the values at a row and others are made of.
struct Terms<R> {
    line: R,
    sum: R,
    pairs: R,
    product: R,
}

impl Covariance {
    /// From the logarithms of the parameters.
    pub fn new(inputs: usize, logarithms: &[f64]) -> Covariance {
        let values = |from: usize| logarithms[from..from + inputs].iter().map(|l| exp(*l));
        let shared = EACH * inputs;
        Covariance {
            inputs,
            narrowness: values(0).map(|length| 0.5 / (length * length)).collect(),
            weights: values(inputs).collect(),
            slopes: values(2 * inputs).collect(),
            shared: std::array::from_fn(|k| exp(logarithms[shared + k])),
        }
    }

    /// `1 / 2 l_d^2` for each input.
    pub fn narrowness(&self) -> &[f64] {
        &self.narrowness
    }

    /// `w_d` for each input.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// `s_d` for each input.
    pub fn slopes(&self) -> &[f64] {
        &self.slopes
    }

    /// The weights of pairs and of the product, and the constant.
    pub fn shared(&self) -> [f64; 3] {
        [PAIRS, PRODUCT, CONSTANT].map(|place| self.shared[place])
    }

    /// Variance of the noise.
    pub fn noise(&self) -> f64 {
        self.shared[NOISE]
    }

    /// The sums over inputs for a row and others; `functions` receives `u_d`.
    #[inline(always)]
    fn terms<R: Real>(
        &self,
        a: &[f64],
        b: impl Fn(usize) -> R,
        mut functions: impl FnMut(usize, R),
    ) -> Terms<R> {
        let (mut line, mut sum, mut squares, mut exponent) = (R::zero(), R::zero(), R::zero(), R::zero());
        let least = R::splat(-700.0);
        for d in 0..self.inputs {
            let own = b(d);
            line = R::splat(self.slopes[d] * a[d]).mul_add(own, line);
            let distance = R::splat(a[d]) - own;
            let power = distance * distance * R::splat(self.narrowness[d]);
            exponent = exponent + power;
            let u = R::splat(self.weights[d]) * exp((-power).max(least));
            functions(d, u);
            sum = sum + u;
            squares = u.mul_add(u, squares);
        }
        let pairs = R::splat(0.5) * sum.mul_add(sum, -squares);
        Terms { line, sum, pairs, product: exp((-exponent).max(least)) }
    }

    #[inline(always)]
    fn value<R: Real>(&self, a: &[f64], b: impl Fn(usize) -> R) -> R {
        let terms = self.terms(a, b, |_, _| {});
        let [pairs, product, constant, _] = self.shared;
        let smooth = R::splat(pairs).mul_add(terms.pairs, terms.line + terms.sum);
        R::splat(product).mul_add(terms.product, smooth) + R::splat(constant)
    }

    /// Values at all pairs of rows `j >= i`, in the upper triangle of the matrix; other entries of its blocks are not used.
    pub fn values(&self, isa: Isa, rows: &RowLanes, matrix: &mut Symmetric) {
        dispatch(isa, AllValues { covariance: self, rows, matrix });
    }

    /// Values at a row and every row of others, and at the row and itself.
    pub fn with(&self, isa: Isa, row: &[f64], others: &RowLanes) -> (Vec<Row8>, f64) {
        dispatch(isa, ValuesWith { covariance: self, row, others })
    }

    /// The value at two rows.
    pub fn between(&self, a: &[f64], b: &[f64]) -> f64 {
        fused(Between { covariance: self, a, b })
    }

    /// The sum over all pairs of rows, in both orders, of `B_ij - a_i a_j` times the derivatives of the value with respect to the
    /// logarithms of the parameters; the entry of the noise is the sum of `B_ii - a_i a_i` times the variance of the noise. `B` is a symmetric
    /// matrix, and `a` a vector with zeros beyond the rows.
    pub fn weighted_gradient(&self, isa: Isa, rows: &RowLanes, b: &Symmetric, a: &[Row8]) -> Vec<f64> {
        dispatch(isa, WeightedGradient { covariance: self, rows, b, a })
    }
}

struct Between<'a> {
    covariance: &'a Covariance,
    a: &'a [f64],
    b: &'a [f64],
}

impl ScalarKernel for Between<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<R: Real>(self) -> f64 {
        self.covariance
            .value(
                self.a,
                #[inline(always)]
                |d| R::splat(self.b[d]),
            )
            .reduce_add()
    }
}

struct AllValues<'a> {
    covariance: &'a Covariance,
    rows: &'a RowLanes,
    matrix: &'a mut Symmetric,
}

impl Kernel for AllValues<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let AllValues { covariance, rows, matrix } = self;
        let stride = matrix.stride;
        for i in 0..rows.count {
            for block in i / LANES..rows.blocks {
                let value = covariance.value(rows.row(i), |d| L::load(&rows.lanes(block, d).0));
                (value * L::load(&rows.present[block].0)).store(&mut matrix.values[i * stride + block].0);
            }
        }
    }
}

struct ValuesWith<'a> {
    covariance: &'a Covariance,
    row: &'a [f64],
    others: &'a RowLanes,
}

impl Kernel for ValuesWith<'_> {
    type Output = (Vec<Row8>, f64);
    #[inline(always)]
    fn run<L: Lanes>(self) -> (Vec<Row8>, f64) {
        let ValuesWith { covariance, row, others } = self;
        let mut values = vec![Row8::default(); others.blocks];
        for (block, value) in values.iter_mut().enumerate() {
            let found = covariance.value(row, |d| L::load(&others.lanes(block, d).0));
            (found * L::load(&others.present[block].0)).store(&mut value.0);
        }
        let own = covariance.value(row, |d| row[d]);
        (values, own)
    }
}

struct WeightedGradient<'a> {
    covariance: &'a Covariance,
    rows: &'a RowLanes,
    b: &'a Symmetric,
    a: &'a [Row8],
}

impl Kernel for WeightedGradient<'_> {
    type Output = Vec<f64>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<f64> {
        let WeightedGradient { covariance, rows, b, a } = self;
        let inputs = covariance.inputs;
        let shared = EACH * inputs;
        let mut sums = vec![L::zero(); parameter_count(inputs)];
        let mut functions = vec![L::zero(); inputs];
        let [pairs, product, constant, noise] = covariance.shared.map(L::splat);
        for i in 0..rows.count {
            let (own, lane) = (i / LANES, i % LANES);
            let solved = L::splat(-a[own].0[lane]);
            for block in own..rows.blocks {
                let weight = solved.mul_add(L::load(&a[block].0), L::load(&b.values[i * b.stride + block].0));
                let present = L::load(&rows.present[block].0);
                // Pairs of different rows count in both orders, and those before the diagonal have been.
                let factor = if block == own {
                    let times = |k: usize| if k > lane { 2.0 } else { f64::from(u8::from(k == lane)) };
                    let (counted, diagonal): ([f64; LANES], [f64; LANES]) =
                        (std::array::from_fn(times), std::array::from_fn(|k| f64::from(u8::from(k == lane))));
                    let factor = weight * (present * L::load(&counted));
                    sums[shared + NOISE] = (factor * L::load(&diagonal)).mul_add(noise, sums[shared + NOISE]);
                    factor
                } else {
                    weight * (present * L::splat(2.0))
                };
                let row = rows.row(i);
                let terms =
                    covariance.terms(row, |d| L::load(&rows.lanes(block, d).0), |d, u| functions[d] = u);
                for d in 0..inputs {
                    let other = L::load(&rows.lanes(block, d).0);
                    let distance = L::splat(row[d]) - other;
                    // The derivative of ln g_d with respect to ln l_d.
                    let power = L::splat(2.0 * covariance.narrowness[d]) * (distance * distance);
                    let own = functions[d] * pairs.mul_add(terms.sum - functions[d], L::splat(1.0));
                    sums[d] = (factor * power).mul_add(product.mul_add(terms.product, own), sums[d]);
                    sums[inputs + d] = factor.mul_add(own, sums[inputs + d]);
                    let line = L::splat(covariance.slopes[d] * row[d]) * other;
                    sums[2 * inputs + d] = factor.mul_add(line, sums[2 * inputs + d]);
                }
                sums[shared + PAIRS] = (factor * pairs).mul_add(terms.pairs, sums[shared + PAIRS]);
                sums[shared + PRODUCT] = (factor * product).mul_add(terms.product, sums[shared + PRODUCT]);
                sums[shared + CONSTANT] = factor.mul_add(constant, sums[shared + CONSTANT]);
            }
        }
        sums.into_iter().map(L::reduce_add).collect()
    }
}
