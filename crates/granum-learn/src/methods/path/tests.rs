//! Tests of networks with a state, on a material whose stress follows the strain: `ds = 2 |de| (n - s)`.

use granum_core::observer::NoObserver;
use granum_core::{Column, Table};
use granum_nets::trainer::Adam;

use super::channels::STRAINS;
use super::*;
use crate::dataset::{Dataset, RunStates};
use crate::input_use::SplitMix;
use crate::surrogate::stream_tests;
use crate::surrogate::{FitSpec, RunInputs, Surrogate, SurrogateMethod, SurrogateMethods, to_json};

const STRESSES: [&str; 6] = ["stress_11", "stress_22", "stress_33", "stress_23", "stress_13", "stress_12"];

/// Runs along random straight lines, of different lengths; the volumetric strain is the dilation by shearing, and depends on the sample.
fn runs(count: usize) -> Dataset {
    let random = &mut SplitMix(4);
    let run = |k: usize| {
        let mut unit = || (random.next() >> 11) as f64 * 2f64.powi(-52) - 1.0;
        let sample = unit();
        let (mut strain, mut stress, mut volume) = ([0.0; 5], [0.0; 5], 0.0);
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); 13];
        let mut direction = [0.0; 5];
        for state in 0..24 + 3 * (k % 5) {
            if state % 8 == 0 {
                direction = std::array::from_fn(|_| unit());
            }
            let norm = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
            let length = if state == 0 { 0.0 } else { 0.1 + 0.05 * f64::from(state as u32 % 3) };
            for c in 0..5 {
                strain[c] += length * direction[c] / norm;
                stress[c] += 2.0 * length * (direction[c] / norm - stress[c]);
            }
            volume += length * (sample - volume);
            let six = rotation::whole(strain, volume / 3.0);
            let angles = [1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
            (0..6).for_each(|c| columns[c].push(angles[c] * six[c]));
            let six = rotation::whole(stress, 1.0);
            (0..6).for_each(|c| columns[6 + c].push(six[c]));
            columns[12].push(volume);
        }
        let names = STRAINS.into_iter().chain(STRESSES).chain(["volumetric_strain"]);
        let columns = names.zip(columns).map(|(name, values)| Column::new(name, "", values)).collect();
        RunStates::new(&format!("run-{k}"), Table::new(columns)?)?.with_parameter(
            "sample.void_ratio",
            "",
            sample,
        )
    };
    Dataset::new((0..count).map(run).collect::<crate::Result<_>>().unwrap()).unwrap()
}

fn spec() -> FitSpec {
    FitSpec::new(
        STRAINS.into_iter().chain(["sample.void_ratio"]),
        STRESSES.into_iter().chain(["volumetric_strain"]),
    )
    .with_threads(1)
}

fn small(cell: PathCell) -> PathNetworks {
    let trainer = Adam { epochs: 60, learning_rate: 0.02, batch_sequences: 4, ..Adam::default() };
    let rotations = if cell == PathCell::Gru { 2 } else { 0 };
    PathNetworks {
        hidden: 12,
        internal: 1,
        window: 2,
        networks: 2,
        rotations,
        trainer: trainer.into(),
        ..PathNetworks::new(cell)
    }
}

fn means(fitted: &dyn Surrogate, inputs: &RunInputs) -> Vec<Vec<f64>> {
    fitted.means(inputs).unwrap()
}

/// Root mean square error over all outputs.
fn error(fitted: &dyn Surrogate, runs: &Dataset) -> f64 {
    let inputs = RunInputs::from_dataset(runs, fitted.columns()).unwrap();
    let exact = runs.values(&fitted.columns().output_names()).unwrap();
    let predicted = means(fitted, &inputs).concat();
    let squares: f64 = predicted.iter().zip(&exact).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares / exact.len() as f64).sqrt()
}

/// The rows with x, y and z in the place of y, z and x.
fn permuted(inputs: &RunInputs) -> RunInputs {
    let values = inputs.rows().flat_map(|row| [2, 0, 1, 5, 3, 4, 6].map(|place| row[place])).collect();
    RunInputs::new(values, 7, inputs.lengths().to_vec()).unwrap()
}

#[test]
fn every_kind_of_network_learns_paths_and_is_read_again() {
    let all = runs(20);
    let learned = all.select(|run, _| !["run-17", "run-18", "run-19"].contains(&run.name()));
    let unseen = all.select(|run, _| ["run-17", "run-18", "run-19"].contains(&run.name()));
    let methods = SurrogateMethods::standard();
    let names = ["path-gru", "path-lstm", "path-state-space", "path-window", "path-tensor"];
    let cells =
        [PathCell::Gru, PathCell::Lstm, PathCell::StateSpace, PathCell::Window, PathCell::TensorStateSpace];
    let mut errors = Vec::new();
    for (cell, name) in cells.into_iter().zip(names) {
        let fitted = small(cell).fit(&learned, &spec(), &mut NoObserver).unwrap();
        assert_eq!(fitted.method(), name);
        errors.push(error(fitted.as_ref(), &unseen));
        let text = to_json(fitted.as_ref()).unwrap();
        let loaded = methods.from_json(&text, "path.json").unwrap();
        let inputs = RunInputs::from_dataset(&unseen, fitted.columns()).unwrap();
        assert_eq!(loaded.predict(&inputs, 0.9).unwrap(), fitted.predict(&inputs, 0.9).unwrap(), "{name}");
        // A run alone, and its beginning alone, have the same predictions: nothing is padded.
        let length = inputs.lengths()[0];
        let alone =
            RunInputs::new(inputs.values()[..7 * (length - 5)].to_vec(), 7, vec![length - 5]).unwrap();
        assert_eq!(means(fitted.as_ref(), &alone), means(fitted.as_ref(), &inputs)[..length - 5], "{name}");
        let predictions = fitted.predict(&inputs, 0.9).unwrap();
        stream_tests::answers_as_whole_runs(loaded.as_ref(), &inputs);
        assert!(predictions[3].values[0].interval.is_some());
        // The run goes no farther than those it learned from; the same ten times over does, and is flagged.
        assert!(predictions.iter().all(|own| own.outside.iter().all(|own| own.name != "length of the path")));
        let rows = inputs.values()[..7 * length].repeat(10);
        let long = RunInputs::new(rows, 7, vec![10 * length]).unwrap();
        let predictions = fitted.predict(&long, 0.9).unwrap();
        assert!(
            predictions[10 * length - 1].outside.iter().any(|own| own.name == "length of the path"),
            "{name}"
        );
    }
    // The root mean square of the outputs without their means is about 0.4.
    assert!(errors.iter().all(|error| *error < 0.25), "{errors:?}");
    assert!(errors[4] < 0.1, "{errors:?}");
}

#[test]
fn answers_turn_with_the_axes() {
    let all = runs(12);
    let plain = PathNetworks { rotations: 0, ..small(PathCell::Gru) };
    let tensor = small(PathCell::TensorStateSpace);
    for (method, is_objective) in [(tensor, true), (small(PathCell::Gru), true), (plain, false)] {
        let fitted = method.fit(&all, &spec(), &mut NoObserver).unwrap();
        let inputs = RunInputs::from_dataset(&all, fitted.columns()).unwrap();
        let (own, moved) = (means(fitted.as_ref(), &inputs), means(fitted.as_ref(), &permuted(&inputs)));
        stream_tests::answers_as_whole_runs(fitted.as_ref(), &inputs);
        let difference = own.iter().zip(&moved).map(|(own, moved)| {
            let turned = [2, 0, 1, 5, 3, 4, 6].map(|place| own[place]);
            turned.iter().zip(moved).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        });
        let most = difference.fold(0.0, f64::max);
        assert_eq!(most < 1e-9, is_objective, "{} {most}", fitted.method());
    }
}

#[test]
fn files_and_settings_that_cannot_be_are_refused() {
    let all = runs(5);
    let method = PathNetworks { networks: 0, ..small(PathCell::Gru) };
    let text = method.fit(&all, &spec(), &mut NoObserver).err().unwrap().to_string();
    assert!(text.contains("must be 1 or more, not 0"), "{text}");
    let method = PathNetworks { window: usize::MAX, ..small(PathCell::Window) };
    let text = method.fit(&all, &spec(), &mut NoObserver).err().unwrap().to_string();
    assert!(text.contains("neurons; between 1 and"), "{text}");
    let method = PathNetworks { rotations: usize::MAX, ..small(PathCell::Gru) };
    let text = method.fit(&all, &spec(), &mut NoObserver).err().unwrap().to_string();
    assert!(text.contains("rotations must be at most 1000"), "{text}");
    let trainer = Adam { learning_rate: f64::NAN, ..Adam::default() }.into();
    let method = PathNetworks { trainer, ..small(PathCell::Gru) };
    let text = method.fit(&all, &spec(), &mut NoObserver).err().unwrap().to_string();
    assert!(text.contains("learning_rate = NaN: a positive number"), "{text}");
    let constant = FitSpec::new(["sample.void_ratio"], ["stress_11"]);
    let text = small(PathCell::Lstm).fit(&all, &constant, &mut NoObserver).err().unwrap().to_string();
    assert!(text.contains("no input varies along a run"), "{text}");
    let trainer = Adam { epochs: 1, ..Adam::default() }.into();
    let quick = PathNetworks { trainer, ..small(PathCell::StateSpace) };
    let fitted = quick.fit(&all, &spec(), &mut NoObserver).unwrap();
    let content = fitted.content().unwrap();
    assert!(quick.load(fitted.columns().clone(), &content).is_ok());
    let mut fewer = fitted.columns().clone();
    fewer.outputs.pop();
    assert!(quick.load(fewer, &content).is_err());
    let other = small(PathCell::Window).load(fitted.columns().clone(), &content);
    assert!(other.err().unwrap().to_string().contains("not those of its columns"));
}
