//! Tests that apply to every trainer, and comparisons of each trainer with an independent implementation of its rule.

use proptest::prelude::*;

use granum_simd::Isa;

use super::*;
use crate::feed_forward::activation::Activation;
use crate::feed_forward::backprop::Workspace;
use crate::feed_forward::network::Network;
use crate::table::data::Data;

/// Deterministic noise of standard deviation one (sum of twelve uniform numbers).
fn noise(k: usize) -> f64 {
    let mut h = k as u64 ^ 0x9e37_79b9_7f4a_7c15;
    let mut sum = -6.0;
    for _ in 0..12 {
        h = h.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        sum += (h >> 11) as f64 / 9_007_199_254_740_992.0;
    }
    sum
}

pub(super) fn surface(rows: usize) -> Data {
    let mut inputs = Vec::new();
    let mut targets = Vec::new();
    for r in 0..rows {
        let (x, y) = ((r as f64 * 0.37).sin(), (r as f64 * 0.73).cos());
        inputs.extend([x, y]);
        targets.push(0.5 + 0.3 * (2.0 * x).sin() * y + 0.01 * noise(r));
    }
    Data::new(inputs, 2, targets).unwrap()
}

fn sine(x: f64) -> f64 {
    0.5 + 0.35 * (4.0 * x).sin()
}

fn noisy_sine(rows: usize, deviation: f64) -> Data {
    let inputs: Vec<f64> = (0..rows).map(|r| -1.0 + 2.0 * r as f64 / (rows - 1) as f64).collect();
    let targets = inputs.iter().enumerate().map(|(r, x)| sine(*x) + deviation * noise(r)).collect();
    Data::new(inputs, 1, targets).unwrap()
}

/// Root mean square difference from the sine without noise.
fn error_against_truth(network: &Network) -> f64 {
    let inputs: Vec<f64> = (0..500).map(|r| -0.99 + 1.98 * r as f64 / 499.0).collect();
    let outputs = network.forward(&inputs).unwrap();
    let sum: f64 = inputs.iter().zip(&outputs).map(|(x, y)| (y - sine(*x)) * (y - sine(*x))).sum();
    (sum / 500.0).sqrt()
}

fn isas() -> impl Iterator<Item = Isa> {
    Isa::ALL.into_iter().filter(|isa| isa.available())
}

#[test]
fn names_and_options_are_checked() {
    for name in NAMES {
        assert_eq!(by_name(name, &Options::default()).unwrap().name(), name);
    }
    let error = by_name("trainlm", &Options::default()).err().unwrap();
    assert_eq!(
        error.to_string(),
        "there is no trainer \"trainlm\"; there are: levenberg-marquardt, traingdx, adam, l-bfgs"
    );
    let options = Options { goal: Some(-1.0), ..Options::default() };
    assert!(by_name("traingdx", &options).err().unwrap().to_string().contains("goal = -1"));
    let mut network = Network::new(&[3, 4, 1], 1).unwrap();
    for name in NAMES {
        let trainer = by_name(name, &Options::default()).unwrap();
        assert!(matches!(
            trainer.train(&mut network, &surface(5), &mut NoObserver),
            Err(TrainingError::Columns { inputs: 3, columns: 2, .. })
        ));
    }
}

#[test]
fn too_large_a_problem_is_refused_before_it_starts() {
    let rows = 400_000;
    let data = Data::new(vec![0.5; rows], 1, vec![0.5; rows]).unwrap();
    let mut network = Network::new(&[1, 200, 200, 1], 1).unwrap();
    let error = LevenbergMarquardt::default().train(&mut network, &data, &mut NoObserver).unwrap_err();
    assert!(error.to_string().contains("train with adam"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn gradients_agree_with_finite_differences(
        layers in proptest::collection::vec(1usize..11, 2..5),
        activations in proptest::collection::vec(0usize..3, 4),
        rows in 1usize..30,
        seed in any::<u64>(),
    ) {
        let all = [Activation::Tanh, Activation::Sigmoid, Activation::Linear];
        let activations: Vec<Activation> = activations[..layers.len() - 1].iter().map(|&a| all[a]).collect();
        let network = Network::with_activations(&layers, &activations, seed).unwrap();
        let m = network.outputs();
        let inputs = (0..rows * layers[0]).map(|k| noise(k) * 0.4).collect();
        let targets = (0..rows * m).map(|k| 0.5 + 0.1 * noise(k + 99)).collect();
        let data = Data::with_target_columns(inputs, layers[0], targets, m)
            .unwrap()
            .with_weights((0..rows).map(|r| 1.0 + (r % 3) as f64).collect())
            .unwrap();
        let mut workspace = Workspace::new(Isa::detect(), &network, &data);
        let mut weights = network.weights().to_vec();
        let mut gradient = vec![0.0; weights.len()];
        let error = workspace.squared_error(&weights);
        // The expected error is computed with the public forward pass.
        let outputs = network.forward(data.inputs()).unwrap();
        let expected: f64 = outputs
            .iter()
            .zip(data.targets())
            .enumerate()
            .map(|(k, (y, t))| data.weights().unwrap()[k / m] * (y - t) * (y - t))
            .sum();
        prop_assert!((error - expected).abs() < 1e-12 * (1.0 + expected));
        workspace.gradient(&weights, 2.0, &mut gradient);
        let scale = gradient.iter().fold(1.0, |s: f64, g| s.max(g.abs()));
        for k in 0..weights.len() {
            let (h, before) = (1e-5, weights[k]);
            weights[k] = before + h;
            let up = workspace.squared_error(&weights);
            weights[k] = before - h;
            let down = workspace.squared_error(&weights);
            weights[k] = before;
            let difference = (up - down) / (2.0 * h);
            prop_assert!((gradient[k] - difference).abs() < 1e-6 * scale, "{k}: {} {difference}", gradient[k]);
        }
    }
}

/// Ridge regression by Gaussian elimination on the normal equations.
fn ridge(data: &Data, decay: f64) -> Vec<f64> {
    let columns = data.input_columns() + 1;
    let mut a = vec![vec![0.0; columns + 1]; columns];
    for r in 0..data.rows() {
        let mut x = data.inputs()[r * (columns - 1)..(r + 1) * (columns - 1)].to_vec();
        x.push(1.0);
        for p in 0..columns {
            for s in 0..columns {
                a[p][s] += x[p] * x[s];
            }
            a[p][columns] += x[p] * data.targets()[r];
        }
    }
    for p in 0..columns {
        a[p][p] += decay;
    }
    for p in 0..columns {
        for s in 0..columns {
            if s != p {
                let factor = a[s][p] / a[p][p];
                for k in 0..=columns {
                    a[s][k] -= factor * a[p][k];
                }
            }
        }
    }
    (0..columns).map(|p| a[p][columns] / a[p][p]).collect()
}

#[test]
fn levenberg_marquardt_solves_linear_least_squares_and_ridge_regression() {
    let data = surface(25);
    for decay in [0.0, 0.7] {
        let mut network = Network::with_activations(&[2, 1], &[Activation::Linear], 5).unwrap();
        let rule = LevenbergMarquardt {
            regularisation: Regularisation::Fixed(decay),
            minimum_gradient: 1e-13,
            ..Default::default()
        };
        let report = rule.train(&mut network, &data, &mut NoObserver).unwrap();
        for (ours, exact) in network.weights().iter().zip(ridge(&data, decay)) {
            assert!((ours - exact).abs() < 1e-10, "{ours} {exact} after {} epochs", report.epochs);
        }
        assert!(report.evidence.is_none());
    }
}

#[test]
fn levenberg_marquardt_finds_a_network_that_made_the_data() {
    let teacher = Network::new(&[2, 3, 1], 8).unwrap();
    let inputs = surface(60).inputs().to_vec();
    let targets = teacher.forward(&inputs).unwrap();
    let data = Data::new(inputs, 2, targets).unwrap();
    let mut student = Network::new(&[2, 5, 1], 2).unwrap();
    let rule = LevenbergMarquardt {
        regularisation: Regularisation::Fixed(1e-12),
        goal: 1e-12,
        ..Default::default()
    };
    let report = rule.train(&mut student, &data, &mut NoObserver).unwrap();
    assert_eq!(report.termination, TerminationReason::Goal, "{:e}", report.error);
}

#[test]
fn bayesian_regularisation_does_not_overfit_a_noisy_sine() {
    let deviation = 0.05;
    let data = noisy_sine(80, deviation);
    for seed in 1..4 {
        let mut network = Network::new(&[1, 30, 30, 1], seed).unwrap();
        let report = LevenbergMarquardt::default().train(&mut network, &data, &mut NoObserver).unwrap();
        let evidence = report.evidence.unwrap();
        let truth = error_against_truth(&network);
        assert!(truth < 0.45 * deviation, "seed {seed}: error against the truth {truth}");
        assert!(evidence.gamma > 3.0 && evidence.gamma < 20.0, "gamma {}", evidence.gamma);
        let noise = 1.0 / evidence.beta.sqrt();
        assert!((noise / deviation - 1.0).abs() < 0.2, "noise {noise}");
        assert_eq!(report.termination, TerminationReason::Converged);

        let mut free = Network::new(&[1, 30, 30, 1], seed).unwrap();
        let rule = LevenbergMarquardt { regularisation: Regularisation::Fixed(1e-10), ..Default::default() };
        rule.train(&mut free, &data, &mut NoObserver).unwrap();
        assert!(error_against_truth(&free) > 1.5 * truth, "without regularisation it should be worse");
    }
}

#[test]
fn several_targets_are_trained_together() {
    let inputs: Vec<f64> = (0..40).map(|r| -1.0 + r as f64 / 19.5).collect();
    let targets = inputs.iter().flat_map(|x| [sine(*x), 0.5 - 0.3 * x]).collect();
    let data = Data::with_target_columns(inputs, 1, targets, 2).unwrap();
    for (name, error) in [("levenberg-marquardt", 1e-4), ("traingdx", 3e-3)] {
        let mut network = Network::new(&[1, 8, 8, 2], 4).unwrap();
        let options =
            Options { epochs: Some(if name == "traingdx" { 3000 } else { 100 }), ..Options::default() };
        let report = by_name(name, &options).unwrap().train(&mut network, &data, &mut NoObserver).unwrap();
        assert!(report.error < error, "{name} {}", report.error);
    }
}

#[test]
fn row_weights_count_as_repeated_rows() {
    let data = surface(12);
    let repeats: Vec<usize> = (0..12).map(|r| 1 + r % 3).collect();
    let mut inputs = Vec::new();
    let mut targets = Vec::new();
    for r in 0..12 {
        for _ in 0..repeats[r] {
            inputs.extend_from_slice(&data.inputs()[2 * r..2 * r + 2]);
            targets.push(data.targets()[r]);
        }
    }
    let repeated = Data::new(inputs, 2, targets).unwrap();
    let weighted = data.with_weights(repeats.iter().map(|&r| r as f64).collect()).unwrap();
    let train = |data: &Data| {
        let mut network = Network::new(&[2, 4, 1], 6).unwrap();
        let rule = Traingdx { epochs: 200, ..Default::default() };
        (rule.train(&mut network, data, &mut NoObserver).unwrap().error, network)
    };
    let ((a, weighted), (b, repeated)) = (train(&weighted), train(&repeated));
    assert!((a / b - 1.0).abs() < 1e-10);
    assert!(weighted.weights().iter().zip(repeated.weights()).all(|(a, b)| (a - b).abs() < 1e-9));
}

/// Five copies of every row contain no new information: if the effective number of observations is that of the original
/// rows, they give the same network with the same evidence; if they count as independent observations, they do not.
#[test]
fn copies_of_rows_are_not_taken_for_witnesses() {
    let data = surface(40);
    let copies = Data::new(data.inputs().repeat(5), 2, data.targets().repeat(5)).unwrap();
    let told = copies.clone().with_observations(40.0).unwrap();
    let evidence = |data: &Data| {
        let mut network = Network::new(&[2, 4, 1], 6).unwrap();
        let rule = LevenbergMarquardt { epochs: 30, ..Default::default() };
        rule.train(&mut network, data, &mut NoObserver).unwrap().evidence.unwrap()
    };
    let (once, five, copied) = (evidence(&data), evidence(&told), evidence(&copies));
    for (a, b) in [(once.alpha, five.alpha), (once.beta, five.beta), (once.gamma, five.gamma)] {
        assert!((a / b - 1.0).abs() < 1e-5, "{once:?} {five:?}");
    }
    assert!((once.gamma / copied.gamma - 1.0).abs() > 1e-1, "{once:?} {copied:?}");
}

fn trainers(isa: Isa) -> [(SharedTrainer, u64); 4] {
    let options = |epochs| Options { epochs: Some(epochs), isa: Some(isa), ..Options::default() };
    [
        (by_name("levenberg-marquardt", &options(24)).unwrap(), 24),
        (by_name("traingdx", &options(120)).unwrap(), 120),
        (by_name("adam", &options(20)).unwrap(), 20),
        (by_name("l-bfgs", &options(30)).unwrap(), 30),
    ]
}

#[test]
fn every_instruction_set_trains_to_the_same_bits() {
    let data = surface(37).with_validation(surface(11)).unwrap();
    for k in 0..4 {
        let train = |isa| {
            let mut network = Network::new(&[2, 9, 6, 1], 12).unwrap();
            let report = trainers(isa)[k].0.train(&mut network, &data, &mut NoObserver).unwrap();
            (network, report.state, report.error, report.evidence)
        };
        let reference = train(Isa::Portable);
        for isa in isas() {
            assert_eq!(train(isa), reference, "{}", isa.name());
        }
    }
}

#[test]
fn an_interrupted_training_goes_on_to_the_same_bits() {
    let data = surface(37);
    for (trainer, epochs) in trainers(Isa::detect()) {
        let start = Network::new(&[2, 9, 6, 1], 12).unwrap();
        let mut whole = start.clone();
        let expected = trainer.train(&mut whole, &data, &mut NoObserver).unwrap();
        assert_eq!(expected.epochs, epochs);
        for stop in [1, 7, epochs - 1] {
            let mut network = start.clone();
            let mut calls = 0;
            let mut observer = |progress: &Progress| {
                calls += 1;
                if progress.done == stop { Flow::Stop } else { Flow::Continue }
            };
            let report = trainer.train(&mut network, &data, &mut observer).unwrap();
            assert_eq!((report.termination, report.epochs, calls), (TerminationReason::Stopped, stop, stop));
            assert!(report.error <= report.history[0].error, "{} {stop}", trainer.name());
            let outputs = network.forward(data.inputs()).unwrap();
            assert!(outputs.iter().all(|y| (0.0..=1.0).contains(y)), "the network can be used as it is");
            let text = serde_json::to_string(&report.state).unwrap();
            let state: TrainerState = serde_json::from_str(&text).unwrap();
            assert_eq!(state, report.state);
            // The weights are taken from the state, so that any network of the same shape can be passed.
            let mut resumed = start.clone();
            let resumed_report = trainer.resume(&mut resumed, &data, Some(state), &mut NoObserver).unwrap();
            assert_eq!(resumed, whole, "{} stopped at {stop}", trainer.name());
            assert_eq!(resumed_report.state, expected.state);
            assert_eq!(resumed_report.history, expected.history);
        }
    }
}

#[test]
fn states_of_others_are_refused() {
    let data = surface(10);
    let [(first, _), (second, _), ..] = trainers(Isa::detect());
    let mut network = Network::new(&[2, 3, 1], 1).unwrap();
    let state = first.train(&mut network, &data, &mut NoObserver).unwrap().state;
    assert!(matches!(
        second.resume(&mut network, &data, Some(state.clone()), &mut NoObserver),
        Err(TrainingError::State(_))
    ));
    let mut other = Network::new(&[2, 4, 1], 1).unwrap();
    assert!(matches!(
        first.resume(&mut other, &data, Some(state), &mut NoObserver),
        Err(TrainingError::State(_))
    ));
}

#[test]
fn states_that_no_training_left_are_refused() {
    let data = surface(10);
    for (trainer, _) in trainers(Isa::detect()) {
        let mut network = Network::new(&[2, 3, 1], 1).unwrap();
        let state = trainer.train(&mut network, &data, &mut NoObserver).unwrap().state;
        let good = serde_json::to_value(&state).unwrap();
        let changes: [fn(&mut serde_json::Value); 5] = [
            |state| state["history"]["epoch"] = u64::MAX.into(),
            |state| state["history"]["every"] = 0.into(),
            |state| state["history"]["failures"] = u64::MAX.into(),
            // A damping of zero could never be increased by multiplication.
            |state| state["own"]["damping"][0] = 0.into(),
            |state| state["own"]["evidence"][1] = (-1).into(),
        ];
        let count = if trainer.name() == LevenbergMarquardt::NAME { 5 } else { 3 };
        for change in &changes[..count] {
            let mut forged = good.clone();
            change(&mut forged);
            let forged: TrainerState = serde_json::from_value(forged).unwrap();
            let result = trainer.resume(&mut network, &data, Some(forged), &mut NoObserver);
            assert!(matches!(result, Err(TrainingError::State(_))), "{}", trainer.name());
        }
    }
}

#[test]
fn validation_rows_stop_the_training_at_their_best() {
    let data = noisy_sine(24, 0.15);
    let validation = noisy_sine(25, 0.0);
    let data = data.with_validation(validation.clone()).unwrap();
    let rules: [Box<dyn Trainer>; 2] = [
        Box::new(LevenbergMarquardt {
            regularisation: Regularisation::Fixed(0.0),
            maximum_failures: 2,
            minimum_gradient: 0.0,
            ..Default::default()
        }),
        Box::new(Traingdx { maximum_failures: 200, epochs: 300_000, ..Default::default() }),
    ];
    for rule in rules {
        let mut network = Network::new(&[1, 25, 1], 2).unwrap();
        let report = rule.train(&mut network, &data, &mut NoObserver).unwrap();
        assert_eq!(report.termination, TerminationReason::ValidationFailures, "{}", rule.name());
        let outputs = network.forward(validation.inputs()).unwrap();
        let error = outputs.iter().zip(validation.targets()).map(|(y, t)| (y - t) * (y - t)).sum::<f64>()
            / outputs.len() as f64;
        assert!((report.validation_error.unwrap() / error - 1.0).abs() < 1e-12);
        let least = report.history.iter().filter_map(|p| p.validation_error).fold(f64::INFINITY, f64::min);
        assert!(report.validation_error.unwrap() <= least);
    }
}

#[test]
fn observers_cannot_change_the_result() {
    let data = surface(20);
    for (trainer, _) in trainers(Isa::detect()) {
        let mut silent = Network::new(&[2, 5, 1], 3).unwrap();
        let mut observed = silent.clone();
        trainer.train(&mut silent, &data, &mut NoObserver).unwrap();
        let mut epochs = Vec::new();
        let mut observer = |progress: &Progress| {
            epochs.push(progress.done);
            assert!(progress.value("error").unwrap() > 0.0 && progress.done <= progress.of.unwrap());
            Flow::Continue
        };
        let report = trainer.train(&mut observed, &data, &mut observer).unwrap();
        assert_eq!(silent, observed);
        assert_eq!(epochs, (1..=report.epochs).collect::<Vec<_>>());
    }
}
