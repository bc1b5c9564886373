//! What the tests of all recurrent cells have in common.

use granum_simd::Isa;

use crate::differentiable::Differentiable;
use crate::table::data::Data;
use crate::table::sequences::Sequences;
use crate::trainer::{Adam, NoObserver, Trainer};

/// Sequences of different lengths, with start vectors, targets and weights; `[inputs, starts, outputs]`.
pub(crate) fn data(lengths: &[usize], [inputs, starts, outputs]: [usize; 3]) -> Data {
    let rows: usize = lengths.iter().sum();
    let wave = |k: usize, phase: f64| (1.7 * k as f64 + phase).sin();
    let starts_of = (0..lengths.len() * starts).map(|k| wave(k, 0.9)).collect();
    let sequences = Sequences::new(lengths.to_vec()).unwrap().with_starts(starts_of, starts).unwrap();
    let targets = (0..rows * outputs).map(|k| 0.5 * wave(k, 0.4)).collect();
    let weights = (0..rows).map(|k| 1.0 + (k % 3) as f64).collect();
    Data::with_target_columns((0..rows * inputs).map(|k| wave(k, 0.0)).collect(), inputs, targets, outputs)
        .and_then(|data| data.with_weights(weights))
        .and_then(|data| data.with_sequences(sequences))
        .unwrap()
}

/// Lengths that fill less than one lane, several lane blocks, and more than one group.
pub(crate) fn cases() -> Vec<Vec<usize>> {
    vec![vec![4], vec![1, 5, 3], (0..19).map(|k| 1 + (7 * k) % 6).collect(), vec![2; 70]]
}

/// Checks that the gradient of a small cell agrees with finite differences, that every instruction set gives the same bits, in
/// outputs, error, gradient and training, that the outputs for a sequence depend neither on its neighbours nor on their lengths, and that
/// rows without sequences are refused.
pub(crate) fn check<M: Differentiable + Clone + PartialEq + std::fmt::Debug>(model: &M, starts: usize) {
    for lengths in cases() {
        let data = data(&lengths, [model.inputs(), starts, model.outputs()]);
        let mut weights = model.weights().to_vec();
        let mut batch = model.batch(Isa::detect(), &data).unwrap();
        let mut gradient = vec![f64::NAN; weights.len()];
        let error = batch.squared_error(&weights);
        batch.gradient(&weights, 2.0, &mut gradient);
        let outputs = |isa: Isa| model.evaluate(isa, data.inputs(), data.sequences()).unwrap();
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            let mut batch = model.batch(isa, &data).unwrap();
            let mut other = vec![0.0; weights.len()];
            assert_eq!(batch.squared_error(&weights).to_bits(), error.to_bits(), "{}", isa.name());
            batch.gradient(&weights, 2.0, &mut other);
            assert_eq!(other, gradient, "{}", isa.name());
            assert_eq!(outputs(isa), outputs(Isa::Portable), "{}", isa.name());
        }
        let scale = gradient.iter().fold(1.0, |most: f64, g| most.max(g.abs()));
        for k in 0..weights.len() {
            let (h, before) = (1e-5, weights[k]);
            let mut at = |value: f64| {
                weights[k] = value;
                batch.squared_error(&weights)
            };
            let difference = (at(before + h) - at(before - h)) / (2.0 * h);
            weights[k] = before;
            let error = (gradient[k] - difference).abs();
            assert!(error < 1e-7 * scale, "{lengths:?} {k}: {} {difference}", gradient[k]);
        }
    }
    let data = data(&[5, 3, 7, 7, 2, 6, 1, 4, 9, 3], [model.inputs(), starts, model.outputs()]);
    let together = model.evaluate(Isa::detect(), data.inputs(), data.sequences()).unwrap();
    for (member, rows) in data.sequences().unwrap().ranges().into_iter().enumerate() {
        let own = data.only_members(&[member]).unwrap();
        let alone = model.evaluate(Isa::detect(), own.inputs(), own.sequences()).unwrap();
        assert_eq!(alone, together[rows.start * model.outputs()..rows.end * model.outputs()]);
    }
    let train = |isa: Isa| {
        let mut trained = model.clone();
        let rule = Adam { epochs: 5, batch_sequences: 3, isa, ..Adam::default() };
        rule.train(&mut trained, &data, &mut NoObserver).unwrap();
        trained
    };
    let reference = train(Isa::Portable);
    assert_ne!(reference, *model);
    for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
        assert_eq!(train(isa), reference, "{}", isa.name());
    }
    let error = model.evaluate(Isa::detect(), data.inputs(), None).unwrap_err().to_string();
    assert!(error.contains("divided into sequences"), "{error}");
    assert!(model.evaluate(Isa::detect(), &data.inputs()[1..], data.sequences()).is_err());
}
