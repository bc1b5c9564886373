//! `traingdx` against an independent implementation of its rule.

use super::tests::surface;
use super::*;
use crate::feed_forward::network::Network;
use crate::table::data::Data;

/// The rule of `traingdx` in plain loops for one hidden layer; returns the weights and the number of rejected steps after
/// some epochs.
fn plain_traingdx(network: &Network, data: &Data, rate: f64, epochs: usize) -> (Vec<f64>, usize, f64) {
    let (n, inputs, hidden) = (data.rows(), network.layers()[0], network.layers()[1]);
    let evaluate = |w: &[f64]| -> (f64, Vec<f64>) {
        let second = hidden * (inputs + 1);
        let mut gradient = vec![0.0; w.len()];
        let mut sum = 0.0;
        for r in 0..n {
            let x = &data.inputs()[r * inputs..(r + 1) * inputs];
            let mut h = vec![0.0; hidden];
            let mut z = w[second + hidden];
            for j in 0..hidden {
                let mut s = w[j * (inputs + 1) + inputs];
                for i in 0..inputs {
                    s += w[j * (inputs + 1) + i] * x[i];
                }
                h[j] = s.tanh();
                z += w[second + j] * h[j];
            }
            let y = 1.0 / (1.0 + (-z).exp());
            let e = y - data.targets()[r];
            sum += e * e;
            let d = 2.0 / n as f64 * e * y * (1.0 - y);
            gradient[second + hidden] += d;
            for j in 0..hidden {
                gradient[second + j] += d * h[j];
                let dj = d * w[second + j] * (1.0 - h[j] * h[j]);
                for i in 0..inputs {
                    gradient[j * (inputs + 1) + i] += dj * x[i];
                }
                gradient[j * (inputs + 1) + inputs] += dj;
            }
        }
        (sum / n as f64, gradient)
    };
    let mut x = network.weights().to_vec();
    let mut dx = vec![0.0; x.len()];
    let mut lr = rate;
    let (mut perf, mut g) = evaluate(&x);
    let mut rejected = 0;
    for _ in 0..epochs {
        for k in 0..x.len() {
            dx[k] = 0.9 * dx[k] - (1.0 - 0.9) * lr * g[k];
        }
        let x2: Vec<f64> = x.iter().zip(&dx).map(|(a, b)| a + b).collect();
        let (perf2, g2) = evaluate(&x2);
        if perf2 / perf > 1.04 {
            rejected += 1;
            lr *= 0.7;
            for k in 0..x.len() {
                dx[k] = -lr * g[k];
            }
        } else {
            if perf2 < perf {
                lr *= 1.05;
            }
            (x, perf, g) = (x2, perf2, g2);
        }
    }
    (x, rejected, perf)
}

#[test]
fn traingdx_follows_its_rule_through_rejections() {
    let data = surface(29);
    for rate in [0.01, 8.0, 300.0] {
        let mut network = Network::new(&[2, 7, 1], 3).unwrap();
        let (weights, rejected, error) = plain_traingdx(&network, &data, rate, 90);
        let rule = Traingdx { epochs: 90, learning_rate: rate, ..Default::default() };
        let report = rule.train(&mut network, &data, &mut NoObserver).unwrap();
        assert_eq!(rejected > 0, rate > 1.0, "{rejected} steps rejected");
        assert!((report.error / error - 1.0).abs() < 1e-11);
        for (ours, plain) in network.weights().iter().zip(&weights) {
            assert!((ours - plain).abs() < 1e-11, "rate {rate}: {ours} {plain}");
        }
        assert_eq!((report.epochs, report.termination), (90, TerminationReason::EpochLimit));
    }
}

#[test]
fn traingdx_ends_at_its_goal_and_at_a_flat_place() {
    let mut network = Network::new(&[2, 7, 1], 3).unwrap();
    let rule = Traingdx { goal: 3e-3, ..Default::default() };
    let report = rule.train(&mut network, &surface(40), &mut NoObserver).unwrap();
    assert_eq!(report.termination, TerminationReason::Goal);
    assert!(report.error <= 3e-3 && report.history.last().unwrap().error <= report.history[0].error);
    let rule = Traingdx { minimum_gradient: 10.0, ..Default::default() };
    let report = rule.train(&mut network, &surface(40), &mut NoObserver).unwrap();
    assert_eq!((report.termination, report.epochs), (TerminationReason::MinimumGradient, 0));
}
