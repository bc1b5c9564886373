//! An objective state-space network: its state consists of tensors and scalars, and its law holds in every frame by construction.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::feed_forward::network::NetworkError;
use crate::random::uniform;
use crate::recurrent::cell_batch::check_weights;
use crate::recurrent::cell_network::CellNetwork;
use crate::recurrent::tensor_sizes::TensorSizes;

/// A network that advances a state of symmetric deviators `T_i` (such as stress and fabric) and scalars `z` (such as volumetric strain and
/// coordination number), of each the measured ones first and then internal ones, for an increment of the length `l` along the deviator `N` of norm one:
///
/// ```text
/// S_i = T_i / sqrt(1 + T_i : T_i / 16)
/// B = (N, S_1 ... S_m, dev N N, dev sym S_1 N ... dev sym S_m N)
/// f = (u, z, N : S_i, S_i : S_j, N : N N, S_i : N N, S_i : S_i N)
/// a = tanh(W f + b)
/// T_i <- T_i + l (sum_b (V a + d)_ib B_b - k_i T_i),   z <- z + l (V' a + d' - k z)
/// ```
///
/// with further inputs `u` of a row. This is the form of an incremental constitutive law, such as a hypoplastic one, whose coefficients are any
/// functions of invariants: if path and sample are turned or mirrored, the answer is turned or mirrored with them, whatever the weights are. Nothing
/// changes in an increment of length zero, and twice the increment has nearly twice the effect. The rates of decay `k` are at least 0.05 and
/// all else is bounded, so that the state stays bounded on any path whose increments are shorter than `2 / k`. Internal tensors start as weighted sums of the
/// measured ones, internal scalars as linear functions of the start scalars, of which there may be more than are measured. All is predicted
/// freely, and gradients are computed by back-propagation through the whole sequence. Results have the same bits with every instruction set.
///
/// Columns of a deviator are its components in the orthonormal basis `diag(2, -1, -1) / sqrt(6)`, `diag(0, 1, -1) / sqrt(2)`, yz, zx, xy (the last three
/// with their transposes, over `sqrt(2)`). Inputs: `l`, `N`, `u`. Start values and outputs: the first component of each measured tensor, then the second of each,
/// and so on; then scalars.
///
/// ```
/// use granum_nets::trainer::{Adam, NoObserver, Trainer};
/// use granum_nets::{Data, Sequences, TensorSizes, TensorStateSpace};
///
/// // A material that yields: dT = l (N - T), along one direction for each of 16 runs.
/// let (mut inputs, mut targets) = (Vec::new(), Vec::new());
/// for run in 0..16 {
///     let direction: Vec<f64> = (0..5).map(|k| f64::from(3 * run + 7 * k).sin()).collect();
///     let norm = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
///     for step in 1..=20 {
///         inputs.push(0.1);
///         inputs.extend(direction.iter().map(|c| c / norm));
///         targets.extend(direction.iter().map(|c| c / norm * (1.0 - 0.9f64.powi(step))));
///     }
/// }
/// let sequences = Sequences::new(vec![20; 16])?.with_starts(vec![0.0; 80], 5)?;
/// let data = Data::with_target_columns(inputs, 6, targets, 5)?.with_sequences(sequences)?;
/// let sizes = TensorSizes { hidden: 4, tensors: 1, ..TensorSizes::default() };
/// let mut network = TensorStateSpace::new(sizes, 1)?;
/// let report = Adam { epochs: 200, learning_rate: 0.02, ..Adam::default() }.train(&mut network, &data, &mut NoObserver)?;
/// assert!(report.error.sqrt() < 0.02, "{}", report.error.sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TensorStateSpace {
    sizes: TensorSizes,
    weights: Vec<f64>,
}

/// The weights of a [`TensorStateSpace`] by what they are for. All weights of a neuron stand together.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorWeights<'a> {
    /// The hidden neurons: `f` in its order, bias.
    pub hidden: &'a [f64],
    /// The coefficients: bias, hidden neurons; those of the first tensor for each `B` in its order, of the second and so on, then those of the scalars.
    pub coefficients: &'a [f64],
    /// The internal tensors before the first row: measured tensors.
    pub first_tensors: &'a [f64],
    /// The internal scalars before the first row: start scalars, bias.
    pub first_scalars: &'a [f64],
    /// The rates of decay `k` of all tensors, then of all scalars.
    pub decays: Vec<f64>,
}

const NAME: &str = "tensor state-space network";
/// Square root of what the first rates of decay exceed the least one by.
const FIRST_DECAY: f64 = 0.5;

impl TensorStateSpace {
    /// A network with random weights from the seed: uniform with the magnitude `1 / sqrt(n)` for neurons with n weights.
    ///
    /// # Errors
    /// If there is no hidden neuron or nothing measured, there are too many, or fewer start scalars than measured ones.
    pub fn new(sizes: TensorSizes, seed: u64) -> Result<TensorStateSpace, NetworkError> {
        sizes.check()?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let magnitude = |place: usize| {
            let row = match place {
                place if place < sizes.changes() => sizes.features() + 1,
                place if place < sizes.first_tensors() => 1 + sizes.hidden,
                place if place < sizes.first_scalars() => sizes.tensors,
                _ => sizes.start_scalars + 1,
            };
            1.0 / (row as f64).sqrt()
        };
        let mut weights: Vec<f64> =
            (0..sizes.weights()).map(|place| magnitude(place) * uniform(&mut random)).collect();
        weights[sizes.decays()..].fill(FIRST_DECAY);
        Ok(TensorStateSpace { sizes, weights })
    }

    /// A network with given weights in the order of [`Differentiable::weights`](crate::Differentiable::weights).
    ///
    /// # Errors
    /// As [`TensorStateSpace::new`], and if the number of weights is wrong or a weight is not finite.
    pub fn from_weights(sizes: TensorSizes, weights: Vec<f64>) -> Result<TensorStateSpace, NetworkError> {
        sizes.check()?;
        check_weights(NAME, sizes.weights(), &weights)?;
        Ok(TensorStateSpace { sizes, weights })
    }

    /// Its numbers of values.
    pub fn sizes(&self) -> TensorSizes {
        self.sizes
    }

    /// The weights by what they are for, each a row for each neuron.
    pub fn parts(&self) -> TensorWeights<'_> {
        let (sizes, weights) = (self.sizes, &self.weights);
        let count = sizes.all_tensors() + sizes.all_scalars();
        TensorWeights {
            hidden: &weights[..sizes.changes()],
            coefficients: &weights[sizes.changes()..sizes.first_tensors()],
            first_tensors: &weights[sizes.first_tensors()..sizes.first_scalars()],
            first_scalars: &weights[sizes.first_scalars()..sizes.decays()],
            decays: (0..count).map(|k| sizes.decay(weights, k)).collect(),
        }
    }
}

impl CellNetwork for TensorStateSpace {
    type Cell = TensorSizes;
    const NAME: &'static str = NAME;

    fn cell(&self) -> TensorSizes {
        self.sizes
    }

    fn cell_weights(&self) -> &[f64] {
        &self.weights
    }

    fn cell_weights_mut(&mut self) -> &mut [f64] {
        &mut self.weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recurrent::cell_tests;
    use crate::{Differentiable, Isa, Sequences};

    fn sizes() -> TensorSizes {
        TensorSizes {
            further: 1,
            start_scalars: 2,
            hidden: 3,
            tensors: 2,
            scalars: 1,
            internal_tensors: 1,
            internal_scalars: 1,
        }
    }

    #[test]
    fn gradients_and_bits() {
        // Small weights: the waves of the test are far larger than directions, and products of them grow fast.
        let small = |sizes: TensorSizes, seed: u64| {
            let network = TensorStateSpace::new(sizes, seed).unwrap();
            let weights = network.weights.iter().map(|weight| 0.2 * weight).collect();
            TensorStateSpace::from_weights(sizes, weights).unwrap()
        };
        cell_tests::check(&small(sizes(), 8), 12);
        let plain = TensorSizes { hidden: 2, tensors: 1, ..TensorSizes::default() };
        cell_tests::check(&small(plain, 3), 5);
        let scalars =
            TensorSizes { hidden: 2, scalars: 1, start_scalars: 1, further: 2, ..TensorSizes::default() };
        cell_tests::check(&small(scalars, 3), 1);
        let error = TensorStateSpace::from_weights(plain, vec![0.0; 3]).unwrap_err().to_string();
        assert!(error.contains("needs 25 weights, not 3"), "{error}");
        let few = TensorSizes { start_scalars: 0, ..scalars };
        assert!(TensorStateSpace::new(few, 1).unwrap_err().to_string().contains("too few"));
        assert!(TensorStateSpace::new(TensorSizes { hidden: 0, ..plain }, 1).is_err());
        for internal_tensors in [3000, usize::MAX] {
            assert!(TensorStateSpace::new(TensorSizes { internal_tensors, ..plain }, 1).is_err());
        }
    }

    /// A turn about the axis x by an angle, of the components of a deviator.
    fn turned(c: [f64; 5], angle: f64) -> [f64; 5] {
        // The part (yy - zz, yz) turns by twice the angle, (zx, xy) by the angle.
        let (sin2, cos2) = (2.0 * angle).sin_cos();
        let (sin, cos) = angle.sin_cos();
        [
            c[0],
            cos2 * c[1] - sin2 * c[2],
            sin2 * c[1] + cos2 * c[2],
            cos * c[3] + sin * c[4],
            -sin * c[3] + cos * c[4],
        ]
    }

    /// Path and sample are turned about one axis and permuted cyclically: the answer is turned and permuted.
    #[test]
    fn answers_turn_with_path_and_sample() {
        // x -> y -> z -> x: a diagonal (a, b, c) becomes (c, a, b), and so do the shears.
        let permuted = |c: [f64; 5]| {
            let (cos, sin) = (-0.5, 0.75f64.sqrt());
            [cos * c[0] - sin * c[1], sin * c[0] + cos * c[1], c[4], c[2], c[3]]
        };
        let move_all = |c: [f64; 5]| permuted(turned(permuted(turned(c, 0.7)), -1.1));
        let network = TensorStateSpace::new(sizes(), 5).unwrap();
        let data = cell_tests::data(&[6, 4], [7, 12, 11]);
        let sequences = data.sequences().unwrap();
        let moved_row = |row: &[f64], first: usize, count: usize| {
            let mut row = row.to_vec();
            for i in 0..count {
                let at = |c: usize| first + c * count + i;
                let moved = move_all(std::array::from_fn(|c| row[at(c)]));
                (0..5).for_each(|c| row[at(c)] = moved[c]);
            }
            row
        };
        let inputs: Vec<f64> = data.inputs().chunks(7).flat_map(|row| moved_row(row, 1, 1)).collect();
        let starts: Vec<f64> = sequences.starts().chunks(12).flat_map(|row| moved_row(row, 0, 2)).collect();
        let moved = Sequences::new(vec![6, 4]).unwrap().with_starts(starts, 12).unwrap();
        let isa = Isa::detect();
        let answer = network.evaluate(isa, data.inputs(), Some(sequences)).unwrap();
        let expected: Vec<f64> = answer.chunks(11).flat_map(|row| moved_row(row, 0, 2)).collect();
        let answer_of_moved = network.evaluate(isa, &inputs, Some(&moved)).unwrap();
        assert!(answer != answer_of_moved);
        for (ours, expected) in answer_of_moved.iter().zip(expected) {
            assert!((ours - expected).abs() < 1e-12, "{ours} {expected}");
        }
    }
}
