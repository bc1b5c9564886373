//! Answers on a material whose law is known: elastic, perfectly plastic, in triaxial cycles.

use granum_core::{Column, Table};

use super::baselines::{ElasticPerfectlyPlastic, first_states};
use super::columns::Learned;
use super::held::{Places, held};
use super::quantities::{Quantity, Row, means, rows_of};
use super::scatter::scatter;
use super::work::{WorkInCycles, cycles};
use crate::dataset::{Dataset, RunStates};
use crate::methods::{STRAINS, SUFFIXES};
use crate::surrogate::{Cause, Estimate, Prediction};

const PRESSURE: f64 = 1e5;
const STIFFNESS: f64 = 50.0;
const LIMIT: f64 = 0.4;

/// With a volume that is an output.
fn usual() -> Learned {
    Learned::default()
}

/// Two closed cycles between the strains of an amplitude, from one and from the next turning point; `more` is added to the norm of the stress deviator over mean stress.
fn run(name: &str, path: f64, seed: f64, amplitude: f64, more: f64) -> RunStates {
    let ends = [0.0, 1.0, -1.0, 1.0, -1.0, 1.0];
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); 22];
    let (mut stress, mut last) = (0.0, 0.0);
    for (line, pair) in ends.windows(2).enumerate() {
        for step in 0..10 {
            // The norm of the deviator diag(2, -1, -1) / sqrt(6) times it.
            let strain = amplitude * (pair[0] + (pair[1] - pair[0]) * f64::from(step) / 10.0);
            stress = f64::clamp(stress + STIFFNESS * (strain - last), -LIMIT, LIMIT);
            last = strain;
            let axial = 2.0 / 6f64.sqrt();
            let own = PRESSURE * (stress + more);
            let tensor = |size: f64, mean: f64| {
                [mean + axial * size, mean - 0.5 * axial * size, mean - 0.5 * axial * size, 0.0, 0.0, 0.0]
            };
            let row =
                [&[line as f64 + 1.0, f64::from(step)][..], &tensor(strain, 0.0), &tensor(own, PRESSURE)];
            let fabric = tensor(0.1 * stress, 1.0 / 3.0);
            let all = row.concat().into_iter().chain(fabric).chain([0.01 * stress, 4.0 + stress]);
            columns.iter_mut().zip(all).for_each(|(column, value)| column.push(value));
        }
    }
    let tensors =
        ["stress", "fabric"].iter().flat_map(|name| SUFFIXES.map(|suffix| format!("{name}_{suffix}")));
    let names = ["stage", "state"].into_iter().chain(STRAINS).map(String::from).chain(tensors);
    let names = names.chain(["volumetric_strain".into(), "mechanical_coordination_number".into()]);
    let table = names.zip(columns).map(|(name, values)| Column::new(name, "", values)).collect();
    let mut run = RunStates::new(name, Table::new(table).unwrap()).unwrap();
    let spec = Learned::default().spec();
    let first = |name: &str| run.column(name).map_or(0.7, |values| values[0]);
    let of_sample = |name: &String| Some((name.clone(), first(name.strip_prefix("sample.")?)));
    let samples: Vec<(String, f64)> = spec.inputs.iter().filter_map(of_sample).collect();
    for (name, value) in samples {
        run = run.with_parameter(&name, "", value).unwrap();
    }
    run.with_parameter("stage.1.seed", "", path)
        .and_then(|run| run.with_parameter("preparation.seed", "", seed))
        .unwrap()
}

#[test]
fn a_known_law_is_found_and_its_work_is_that_of_hysteresis() {
    let runs = Dataset::new(vec![run("plastic", 1.0, 1.0, 0.02, 0.0), run("elastic", 2.0, 2.0, 0.004, 0.0)])
        .unwrap();
    let (exact, means) = (rows_of(&usual(), &runs).unwrap(), means(&usual(), &runs).unwrap());
    let found = ElasticPerfectlyPlastic::fit(&usual(), &runs).unwrap().rows(&usual(), &runs).unwrap();
    let error = |rows| {
        let [error, value] = Quantity::Stress.squares(&exact, rows, &means);
        (error / value).sqrt()
    };
    // The grid has the limit, and stiffnesses within a fifth.
    assert!(error(&found) < 0.1, "{}", error(&found));
    assert!((error(&first_states(&usual(), &runs).unwrap()) - 1.0).abs() < 1e-9);
    // Two closed cycles lie between the four turning points of each run; those of the elastic one cost nothing.
    let cycles = cycles(&runs).unwrap();
    let work = WorkInCycles::new("exact", &cycles, &exact, &exact);
    assert_eq!((work.cycles, work.negative, work.error), (4, 0, 0.0));
    assert!(work.least.abs() < 1e-9, "{}", work.least);
    // Stresses of the opposite sign give work away.
    let opposite: Vec<_> = exact.iter().map(|row| Row { stress: row.stress.map(|c| -c), ..*row }).collect();
    let given = WorkInCycles::new("opposite", &cycles, &exact, &opposite);
    assert_eq!(given.negative, 2);
    assert!((given.error - 2.0).abs() < 1e-9 && given.least < -1.0, "{given:?}");
}

#[test]
fn the_scatter_is_that_of_samples_on_the_same_path() {
    // Two samples whose stress deviators differ by 0.1: each deviates from their mean by 0.05, and the standard deviation is 0.1 / sqrt(2).
    let all =
        vec![run("a", 1.0, 1.0, 0.02, 0.0), run("b", 1.0, 2.0, 0.02, 0.1), run("alone", 2.0, 3.0, 0.02, 0.3)];
    let runs = Dataset::new(all).unwrap();
    let (exact, means) = (rows_of(&usual(), &runs).unwrap(), means(&usual(), &runs).unwrap());
    let found = scatter(&runs, &exact, &means, &Quantity::judged(&usual()));
    let stress = found.iter().find(|own| own.quantity == "stress deviator").unwrap();
    let size =
        exact[..50].iter().map(|row| row.stress.iter().map(|c| c * c).sum::<f64>()).sum::<f64>() / 50.0;
    let expected = 0.1 / 2f64.sqrt() / size.sqrt();
    assert!((stress.error.relative - expected).abs() < 1e-9, "{stress:?} {expected}");
    assert_eq!(stress.error.runs, 1);
}

/// A predicted mean stress can be anything; errors that follow from it are numbers all the same.
#[test]
fn a_mean_stress_near_zero_gives_the_largest_ratio_that_grains_bear() {
    let norm = |stresses: [f64; 6]| {
        let mut outputs = [0.0; 14];
        outputs[..6].copy_from_slice(&stresses);
        Row::of_outputs(&usual(), &outputs).stress.iter().map(|c| c * c).sum::<f64>().sqrt()
    };
    let most = 6f64.sqrt();
    // Uniaxial stress is the limit; beyond it, where the mean stress is tiny, zero or negative, the norm is the same.
    assert!((norm([3e5, 0.0, 0.0, 0.0, 0.0, 0.0]) - most).abs() < 1e-9);
    for lateral in [-1e5, -1.5e5 + 1e-9, -1.5e5, -2e5] {
        assert!((norm([3e5, lateral, lateral, 0.0, 0.0, 0.0]) - most).abs() < 1e-9, "{lateral}");
    }
    assert_eq!(norm([0.0; 6]), 0.0);
    assert_eq!(norm([-1e5, -1e5, -1e5, 0.0, 0.0, 0.0]), 0.0);
    let usual = norm([2e5, 0.5e5, 0.5e5, 0.0, 0.0, 0.0]);
    assert!((usual - 1.5f64.sqrt()).abs() < 1e-9, "{usual}");
}

/// The intervals of one run hold all states, those of the other one none of the volume, and of the stress two of six components in the second half.
#[test]
fn states_within_intervals_are_counted_by_run_quantity_and_quarter() {
    let void = |run: RunStates, value: f64| run.with_parameter("sample.void_ratio", "", value).unwrap();
    let runs = Dataset::new(vec![
        void(run("a", 1.0, 1.0, 0.02, 0.0), 0.6),
        void(run("b", 2.0, 2.0, 0.02, 0.0), 0.8),
    ])
    .unwrap();
    let columns = usual().spec().columns(&runs).unwrap();
    let names = columns.output_names();
    let exact = runs.values(&names).unwrap();
    let prediction = |(row, values): (usize, &[f64])| {
        let estimate = |(name, exact): (&String, &f64)| {
            let is_missed = row >= 50
                && (name == "volumetric_strain"
                    || (row >= 75
                        && ["stress_11", "stress_22", "stress_23", "stress_12"].contains(&name.as_str())));
            let mean = if is_missed { exact + 2.0 } else { exact + 0.5 };
            Estimate::new(mean).by(vec![(Cause::Runs, 1.0)], 1.0)
        };
        Prediction::new(names.iter().zip(values).map(estimate).collect())
    };
    let predictions: Vec<Prediction> = exact.chunks_exact(names.len()).enumerate().map(prediction).collect();
    let places = Places::new(&runs).unwrap();
    let found =
        held("method", &runs, &places, (&columns, &Quantity::judged(&usual())), &predictions).unwrap();
    let of = |quantity: &str| found.iter().find(|own| own.quantity == quantity).unwrap();
    assert_eq!((of("fabric deviator").held, of("coordination number").held), (1.0, 1.0));
    let volume = of("volumetric strain");
    assert_eq!((volume.held, volume.standard_error), (0.5, 0.5));
    assert_eq!(
        (volume.by_void_ratio, volume.along_path),
        ([Some(1.0), None, None, Some(0.0)], [Some(0.5); 4])
    );
    let stress = of("stress deviator");
    assert!((stress.held - 0.5 * (1.0 + 0.5 * (1.0 + 1.0 / 3.0))).abs() < 1e-12, "{stress:?}");
    assert!(stress.along_path[0] == Some(1.0) && stress.along_path[3] < Some(0.7), "{stress:?}");
    // Without intervals nothing is told.
    let none: Vec<Prediction> =
        predictions.iter().map(|_| Prediction::new(vec![Estimate::new(0.0); names.len()])).collect();
    assert!(
        held("method", &runs, &places, (&columns, &Quantity::judged(&usual())), &none).unwrap().is_empty()
    );
}

/// Where the volume is an input, the mean stress is judged by its logarithm, and the properties are inputs.
#[test]
fn the_mean_stress_is_judged_where_the_volume_is_an_input() {
    let learned = Learned { volume_is_input: true, properties: vec!["friction".into()] };
    let spec = learned.spec();
    assert!(
        spec.outputs.iter().all(|name| name != "volumetric_strain")
            && spec.inputs.contains(&"friction".into())
    );
    let runs = Dataset::new(vec![run("a", 1.0, 1.0, 0.02, 0.0)]).unwrap();
    let exact = rows_of(&learned, &runs).unwrap();
    assert!(exact.iter().all(|row| (row.pressure - PRESSURE.ln()).abs() < 1e-12 && row.volume == 0.0));
    let half: Vec<Row> = exact.iter().map(|row| Row { pressure: row.pressure - 2f64.ln(), ..*row }).collect();
    let [_, pressure, ..] = Quantity::judged(&learned);
    let [errors, _] = pressure.squares(&exact, &half, &exact[0]);
    assert!((errors / 50.0 - 2f64.ln().powi(2)).abs() < 1e-12, "{errors}");
    // A sample that carries nothing, and one that pulls, have the least logarithm.
    let none = Row::of_outputs(&learned, &[0.0; 13]);
    assert_eq!((none.pressure, none.stress), (1e3f64.ln(), [0.0; 5]));
}
