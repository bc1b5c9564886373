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
//!
//! Each logarithm has a normal prior, for inputs and outputs with a standard deviation of one. It decides what few rows cannot, and
//! keeps terms small that rows do not support.

use granum_simd::exp;

use super::rows::Rows;

/// Parameters beside those of each input: pairs, product, constant, noise.
const SHARED: usize = 4;
/// Parameters of each input: length, weight of its function, slope.
const EACH: usize = 3;

/// Places of the shared parameters after those of the inputs.
const PAIRS: usize = 0;
const PRODUCT: usize = 1;
const CONSTANT: usize = 2;
const NOISE: usize = 3;

/// Mean and standard deviation of the prior of the logarithm of a parameter, as the parameter and its factor.
struct Prior {
    typical: f64,
    deviation: f64,
}

const LENGTH: Prior = Prior { typical: 1.098_612_288_668_11, deviation: 1.3 }; // ln 3
const WEIGHT: Prior = Prior { typical: -1.203_972_804_325_936, deviation: 1.5 }; // ln 0.3
const SLOPE: Prior = Prior { typical: -std::f64::consts::LN_10, deviation: 1.5 }; // ln 0.1
const OF_PAIRS: Prior = Prior { typical: 0.0, deviation: 1.5 }; // ln 1
const OF_PRODUCT: Prior = Prior { typical: -1.203_972_804_325_936, deviation: 1.5 }; // ln 0.3
const OF_CONSTANT: Prior = Prior { typical: -1.203_972_804_325_936, deviation: 1.0 }; // ln 0.3
const OF_NOISE: Prior = Prior { typical: -2.995_732_273_553_991, deviation: 2.5 }; // ln 0.05

/// Number of parameters for so many inputs.
pub(super) fn parameter_count(inputs: usize) -> usize {
    EACH * inputs + SHARED
}

/// Mean and standard deviation of the prior of each logarithm.
pub(super) fn prior(inputs: usize) -> Vec<[f64; 2]> {
    let each = |prior: &Prior| std::iter::repeat_n([prior.typical, prior.deviation], inputs);
    let shared = [OF_PAIRS, OF_PRODUCT, OF_CONSTANT, OF_NOISE].map(|prior| [prior.typical, prior.deviation]);
    each(&LENGTH).chain(each(&WEIGHT)).chain(each(&SLOPE)).chain(shared).collect()
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

/// What the value at two rows is made of.
struct Terms {
    line: f64,
    sum: f64,
    pairs: f64,
    product: f64,
}

impl Covariance {
    /// From the logarithms of the parameters.
    pub fn new(inputs: usize, logarithms: &[f64]) -> Covariance {
        granum_simd::fused(|| {
            let values = |from: usize| logarithms[from..from + inputs].iter().map(|l| exp(*l));
            let shared = EACH * inputs;
            Covariance {
                inputs,
                narrowness: values(0).map(|length| 0.5 / (length * length)).collect(),
                weights: values(inputs).collect(),
                slopes: values(2 * inputs).collect(),
                shared: std::array::from_fn(|k| exp(logarithms[shared + k])),
            }
        })
    }

    /// Variance of the noise.
    pub fn noise(&self) -> f64 {
        self.shared[NOISE]
    }

    /// The sums over inputs; `functions` receives `u_d`.
    #[inline(always)]
    fn terms(&self, a: &[f64], b: &[f64], functions: &mut [f64]) -> Terms {
        let (mut line, mut sum, mut squares, mut exponent) = (0.0, 0.0, 0.0, 0.0);
        for d in 0..self.inputs {
            line += self.slopes[d] * a[d] * b[d];
            let distance = a[d] - b[d];
            let power = distance * distance * self.narrowness[d];
            exponent += power;
            let u = self.weights[d] * exp((-power).max(-700.0));
            functions[d] = u;
            sum += u;
            squares += u * u;
        }
        Terms { line, sum, pairs: 0.5 * (sum * sum - squares), product: exp((-exponent).max(-700.0)) }
    }

    #[inline(always)]
    fn value(&self, a: &[f64], b: &[f64], functions: &mut [f64]) -> f64 {
        let terms = self.terms(a, b, functions);
        let [pairs, product, constant, _] = self.shared;
        terms.line + terms.sum + pairs * terms.pairs + product * terms.product + constant
    }

    /// Values at all pairs of rows `j <= i`, given to `take(i, j, value)`.
    pub fn values(&self, rows: &Rows, take: &mut dyn FnMut(usize, usize, f64)) {
        let mut functions = vec![0.0; self.inputs];
        granum_simd::fused(|| {
            for i in 0..rows.count() {
                for j in 0..=i {
                    take(i, j, self.value(rows.row(i), rows.row(j), &mut functions));
                }
            }
        });
    }

    /// Values at a row and every row of others, and at the row and itself.
    pub fn with(&self, row: &[f64], others: &Rows) -> (Vec<f64>, f64) {
        let mut functions = vec![0.0; self.inputs];
        granum_simd::fused(|| {
            let values =
                (0..others.count()).map(|k| self.value(row, others.row(k), &mut functions)).collect();
            (values, self.value(row, row, &mut functions))
        })
    }

    /// The sum over all pairs of rows, in both orders, of `weight(i, j)` times the derivatives of the value with respect to the
    /// logarithms of the parameters; the entry of the noise is the sum of `weight(i, i)` times the variance of the noise.
    pub fn weighted_gradient(&self, rows: &Rows, weight: &dyn Fn(usize, usize) -> f64) -> Vec<f64> {
        let inputs = self.inputs;
        let mut gradient = vec![0.0; parameter_count(inputs)];
        let mut functions = vec![0.0; inputs];
        let shared = EACH * inputs;
        granum_simd::fused(|| {
            for i in 0..rows.count() {
                let a = rows.row(i);
                gradient[shared + NOISE] += weight(i, i) * self.shared[NOISE];
                for j in 0..=i {
                    let b = rows.row(j);
                    let factor = if i == j { weight(i, i) } else { 2.0 * weight(i, j) };
                    let terms = self.terms(a, b, &mut functions);
                    let [pairs, product, constant, _] = self.shared;
                    for d in 0..inputs {
                        let distance = a[d] - b[d];
                        // The derivative of ln g_d with respect to ln l_d.
                        let power = 2.0 * distance * distance * self.narrowness[d];
                        let own = functions[d] * (1.0 + pairs * (terms.sum - functions[d]));
                        gradient[d] += factor * power * (own + product * terms.product);
                        gradient[inputs + d] += factor * own;
                        gradient[2 * inputs + d] += factor * self.slopes[d] * a[d] * b[d];
                    }
                    gradient[shared + PAIRS] += factor * pairs * terms.pairs;
                    gradient[shared + PRODUCT] += factor * product * terms.product;
                    gradient[shared + CONSTANT] += factor * constant;
                }
            }
        });
        gradient
    }
}
