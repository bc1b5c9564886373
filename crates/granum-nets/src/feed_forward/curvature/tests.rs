//! Comparison of steps, effective parameters and left-out residuals with the formulas evaluated with explicit matrices.

use super::*;
use crate::feed_forward::network::Network;
use crate::table::data::Data;
use proptest::prelude::*;

pub(super) struct Example {
    pub workspace: Workspace,
    /// Jacobian of the residuals of the observations, by finite differences.
    pub jacobian: Vec<Vec<f64>>,
    residuals: Vec<Row8>,
    pub network: Network,
}

fn residuals(workspace: &mut Workspace, weights: &[f64]) -> Vec<Row8> {
    workspace.squared_error(weights);
    let mut residuals = vec![Row8::default(); blocks(workspace.observations())];
    workspace.residuals(&mut residuals);
    residuals
}

pub(super) fn example(isa: Isa, layers: &[usize], observations: usize, points: usize, seed: u64) -> Example {
    let network = Network::new(layers, seed).unwrap();
    let rows = observations * points;
    let inputs = (0..rows * layers[0]).map(|k| (k as f64 * 1.7 + seed as f64 % 10.0).sin()).collect();
    let targets = (0..rows).map(|k| 0.5 + 0.4 * ((k / points) as f64 * 0.9).cos()).collect();
    let data = Data::new(inputs, layers[0], targets).unwrap().with_points(points).unwrap();
    let data = data.with_observations(0.6 * observations as f64).unwrap();
    let mut workspace = Workspace::for_residuals(isa, &network, &data);
    let mut weights = network.weights().to_vec();
    let mut jacobian = vec![vec![0.0; weights.len()]; observations];
    for k in 0..weights.len() {
        let (h, before) = (1e-5, weights[k]);
        weights[k] = before + h;
        let up = residuals(&mut workspace, &weights);
        weights[k] = before - h;
        let down = residuals(&mut workspace, &weights);
        weights[k] = before;
        for (r, row) in jacobian.iter_mut().enumerate() {
            row[k] = (Row8::numbers(&up)[r] - Row8::numbers(&down)[r]) / (2.0 * h);
        }
    }
    let residuals = residuals(&mut workspace, &weights);
    workspace.sensitivities(&weights);
    Example { workspace, jacobian, residuals, network }
}

/// Solves a dense system by Gaussian elimination.
pub(super) fn solved(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for p in 0..n {
        for s in p + 1..n {
            let factor = a[s][p] / a[p][p];
            for k in p..n {
                a[s][k] -= factor * a[p][k];
            }
            b[s] -= factor * b[p];
        }
    }
    for p in (0..n).rev() {
        let sum: f64 = (p + 1..n).map(|k| a[p][k] * b[k]).sum();
        b[p] = (b[p] - sum) / a[p][p];
    }
    b
}

fn step(example: &Example, decay: f64, shift: f64) -> (Vec<f64>, f64) {
    let weights = example.network.weights();
    let mut curvature = Curvature::new(&example.workspace, weights.len());
    assert!(curvature.form(&example.workspace) && curvature.factorise(shift));
    let mut step = vec![0.0; weights.len()];
    curvature.step(&example.workspace, &example.residuals, weights, decay, shift, &mut step);
    (step, curvature.effective_parameters(shift))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn steps_are_those_of_the_normal_equations(
        hidden in 2usize..6, observations in 2usize..20, points in 1usize..4, seed in any::<u64>(),
    ) {
        let layers = [2, hidden, hidden, 1];
        let example = example(Isa::detect(), &layers, observations, points, seed);
        let (decay, shift) = (0.02, 0.05);
        let (found, _) = step(&example, decay, shift);
        let count = example.network.weights().len();
        let product = |f: &dyn Fn(&[f64], f64) -> f64| -> f64 {
            example.jacobian.iter().zip(Row8::numbers(&example.residuals)).map(|(row, e)| f(row, *e)).sum()
        };
        let matrix: Vec<Vec<f64>> = (0..count)
            .map(|p| {
                (0..count).map(|s| product(&|row, _| row[p] * row[s]) + if p == s { shift } else { 0.0 }).collect()
            })
            .collect();
        let right = (0..count)
            .map(|p| -product(&|row, e| row[p] * e) - decay * example.network.weights()[p])
            .collect();
        let expected = solved(matrix, right);
        let length = expected.iter().map(|s| s * s).sum::<f64>().sqrt();
        for (a, b) in found.iter().zip(&expected) {
            prop_assert!((a - b).abs() < 1e-5 * length, "{a} {b}");
        }
    }
}

/// If there are more rows than are chosen, the steps of a network with few effective parameters still agree with those of
/// the normal equations.
#[test]
fn some_of_the_rows_are_enough() {
    let example = example(Isa::detect(), &[2, 8, 8, 1], 700, 1, 3);
    assert!(example.workspace.rows > MOST_CHOSEN);
    let (found, gamma) = step(&example, 0.5, 0.5);
    let count = example.network.weights().len();
    let mut matrix = vec![vec![0.0; count]; count];
    let mut right: Vec<f64> = example.network.weights().iter().map(|w| -0.5 * w).collect();
    for (row, e) in example.jacobian.iter().zip(Row8::numbers(&example.residuals)) {
        for p in 0..count {
            right[p] -= row[p] * e;
            for s in 0..count {
                matrix[p][s] += row[p] * row[s];
            }
        }
    }
    (0..count).for_each(|p| matrix[p][p] += 0.5);
    let expected = solved(matrix, right);
    let length = expected.iter().map(|s| s * s).sum::<f64>().sqrt();
    let distance = found.iter().zip(&expected).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    assert!(distance < 0.02 * length, "{distance} of {length}");
    assert!(gamma > 3.0 && gamma < 90.0, "{gamma}");
}

/// For a linear network the formula is exact: training again without a block gives the same residuals.
#[test]
fn left_out_residuals_are_those_of_a_network_trained_without_the_block() {
    use crate::feed_forward::activation::Activation;
    let rows = 24;
    let inputs: Vec<f64> = (0..rows * 2).map(|k| (k as f64 * 1.3).sin()).collect();
    let targets: Vec<f64> = (0..rows).map(|r| (r as f64 * 0.7).cos() + 0.1 * (r / 8) as f64).collect();
    let decay = 0.3;
    let fit = |members: &[usize]| {
        let mut a = vec![vec![0.0; 3]; 3];
        let mut b = vec![0.0; 3];
        for &r in members {
            let x = [inputs[2 * r], inputs[2 * r + 1], 1.0];
            for p in 0..3 {
                b[p] += x[p] * targets[r];
                (0..3).for_each(|s| a[p][s] += x[p] * x[s]);
            }
        }
        (0..3).for_each(|p| a[p][p] += decay);
        solved(a, b)
    };
    let all: Vec<usize> = (0..rows).collect();
    let network = Network::from_weights(&[2, 1], &[Activation::Linear], fit(&all)).unwrap();
    let data = Data::new(inputs.clone(), 2, targets.clone()).unwrap();
    let mut workspace = Workspace::new(Isa::detect(), &network, &data);
    let residuals = residuals(&mut workspace, network.weights());
    workspace.sensitivities(network.weights());
    let mut curvature = Curvature::new(&workspace, 3);
    assert!(curvature.form(&workspace));
    let block_of: Vec<usize> = (0..rows).map(|r| r / 8).collect();
    let found = curvature.left_out_residuals(&block_of, &Row8::numbers(&residuals)[..rows], decay).unwrap();
    for block in 0..3 {
        let others: Vec<usize> = all.iter().copied().filter(|r| r / 8 != block).collect();
        let w = fit(&others);
        for r in block * 8..block * 8 + 8 {
            let prediction = w[0] * inputs[2 * r] + w[1] * inputs[2 * r + 1] + w[2];
            assert!((found[r] - (prediction - targets[r])).abs() < 1e-6, "{r}");
        }
    }
}

#[test]
fn chosen_rows_are_spread_and_differ() {
    for (rows, most) in [(10, 20), (840, 128), (3584, 256), (129, 128)] {
        let chosen = choose(rows, most);
        assert_eq!(chosen.len(), rows.min(most));
        assert!(chosen.windows(2).all(|pair| pair[0] < pair[1]) && chosen[chosen.len() - 1] < rows);
    }
    // In a table with a period of 14 rows, all phases of the period are sampled.
    let mut met: Vec<usize> = choose(14 * 256, 256).iter().map(|row| row % 14).collect();
    met.sort_unstable();
    met.dedup();
    assert_eq!(met.len(), 14);
}

#[test]
fn same_bits_on_every_instruction_set() {
    for points in [1, 3] {
        let of = |isa| step(&example(isa, &[2, 7, 5, 1], 21, points, 5), 0.01, 0.02);
        let reference = of(Isa::Portable);
        for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
            assert_eq!(of(isa), reference, "{}", isa.name());
        }
    }
}
