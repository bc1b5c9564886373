//! A family with invented runs: fit, file, typical values, flags, scores.

use granum_core::observer::{Event, NoObserver, Observer, Progress};
use granum_core::{Column, Table};
use granum_run::Flow;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::dataset::{ColumnGroup, Dataset, RunStates};
use crate::error::Result;
use crate::surrogate::GaussianProcessOfCurves;

const STATES: usize = 26;
const END: f64 = 0.25;

struct Random(ChaCha8Rng);

impl Random {
    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Nearly normal, with the standard deviation one.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// What the plan gives a run.
#[derive(Clone, Copy)]
struct Sand {
    friction: f64,
    rolling: f64,
    looseness: f64,
}

/// A test whose strength grows with friction and whose first state is that of its sample.
fn run(name: &str, sand: Sand, end: f64, random: &mut Random) -> Result<RunStates> {
    let Sand { friction, rolling, looseness } = sand;
    let void_ratio = 0.55 + 0.2 * looseness + 0.1 * rolling + 0.004 * random.normal();
    let contacts = 7.0 - 4.0 * void_ratio + 0.02 * random.normal();
    let own = 0.02 * random.normal();
    let xs: Vec<f64> = (0..STATES).map(|k| end * k as f64 / (STATES - 1) as f64).collect();
    let curve = |f: &dyn Fn(f64) -> f64| xs.iter().map(|x| f(*x)).collect::<Vec<f64>>();
    let strength = 0.6 + 0.8 * friction + own;
    let mut columns = vec![
        Column::new("stress_ratio", "", curve(&|x| strength * (1.0 - (-40.0 * x).exp()))),
        Column::new("volumetric_strain", "", curve(&|x| (0.3 * (void_ratio - 0.65) + 0.2 * own) * x)),
        Column::new("deviator_fabric", "", curve(&|x| 0.3 * strength * (1.0 - (-20.0 * x).exp()))),
        Column::new(
            "mechanical_coordination_number",
            "",
            curve(&|x| 4.0 + (contacts - 4.0) * (-15.0 * x).exp()),
        ),
        Column::new("sliding_fraction", "", curve(&|x| 0.2 * (1.0 - (-60.0 * x).exp()) / (1.0 + friction))),
    ];
    // Three bins of a distribution whose mean is one.
    let first = |x: f64| 0.5 + 0.2 * friction * (1.0 - (-10.0 * x).exp());
    let centres = vec![0.5, 1.5, 2.5];
    let shares: [Vec<f64>; 3] =
        [curve(&first), curve(&|x| 1.5 - 2.0 * first(x) + 0.0 * x), curve(&|x| first(x) - 0.5)];
    let name_of = |k: usize| format!("probability_density_{}", centres[k]);
    for (k, share) in shares.into_iter().enumerate() {
        columns.push(Column::new(name_of(k), "", share));
    }
    columns.insert(0, Column::new("axial_strain", "", xs));
    let group = ColumnGroup {
        name: "probability_density".into(),
        binned: "force".into(),
        bin_width: 1.0,
        centres: centres.clone(),
    };
    let mut made = RunStates::new(name, Table::new(columns)?)?.with_group(group)?;
    for (key, word) in SAND.words {
        made = made.with_word(key, word)?;
    }
    let numbers = [
        ("grains.material.friction", friction),
        ("contact.rolling_friction", rolling),
        ("preparation.mean_stress", 1e5),
        ("grains.material.youngs_modulus", 2e9 / (0.5 + rolling)),
        ("grains.spread", 0.2 * (1.0 + looseness)),
        ("preparation.friction", looseness * friction),
        ("preparation.seed", random.uniform()),
        ("sample.void_ratio", void_ratio),
        ("sample.mechanical_coordination_number", contacts),
    ];
    for (key, number) in numbers {
        made = made.with_parameter(key, "", number)?;
    }
    Ok(made)
}

/// `points` sands with `seeds` samples each.
fn dataset(points: usize, seeds: usize, seed: u64) -> Dataset {
    let mut random = Random(ChaCha8Rng::seed_from_u64(seed));
    let mut runs = Vec::new();
    for point in 0..points {
        let sand = Sand {
            friction: 0.1 + 0.7 * random.uniform(),
            rolling: 0.5 * random.uniform(),
            looseness: random.uniform(),
        };
        for k in 0..seeds {
            runs.push(run(&format!("{seed}-{point}-{k}"), sand, END, &mut random).unwrap());
        }
    }
    Dataset::new(runs).unwrap()
}

fn data(name: &str) -> TrainingData {
    TrainingData { name: name.into(), digest: "abc".into(), runs: 0 }
}

fn fitted(dataset: &Dataset, observer: &mut dyn Observer) -> FamilyModel {
    let mut fit = FamilyFit::default();
    (fit.method.components, fit.method.starts) = (2, 1);
    FamilyModel::fit(&SAND, dataset, vec![data("training")], &fit, observer)
        .unwrap_or_else(|error| panic!("{error}"))
}

const GIVEN: [Option<f64>; 7] = [Some(0.4), Some(0.2), Some(4e-5), None, None, None, None];

#[test]
fn a_family_answers_with_what_it_was_not_given_and_says_so() {
    let model = fitted(&dataset(40, 1, 1), &mut NoObserver);
    let known = |void_ratio: Option<f64>| {
        let mut given = GIVEN;
        given[5] = void_ratio;
        model.predict(&given, 0.9).unwrap()
    };
    let open = known(None);
    assert!(open.outside.is_empty(), "{:?}", open.outside);
    assert_eq!((open.points[0], open.points[open.points.len() - 1]), (0.0, END));
    assert_eq!(open.inputs.iter().filter(|input| input.source == InputSource::Given).count(), 3);
    // Half of the runs' looseness, and what follows from it.
    let value = |answer: &FamilyPrediction, name: &str| {
        answer.inputs.iter().find(|input| input.name == name).unwrap().value
    };
    // Looseness is anything from 0 to 1, and the void ratio as uncertain as it is.
    let void_ratio = open.inputs.iter().find(|input| input.name == "sample.void_ratio").unwrap();
    let InputSource::Typical(typical) = void_ratio.source else { panic!("{void_ratio:?}") };
    assert!((0.045..0.07).contains(&typical.deviation), "{typical:?}");
    assert!((value(&open, "sample.void_ratio") - 0.67).abs() < 0.04, "{:?}", open.inputs);
    // A dense sample was prepared with less friction, and has more contacts.
    let dense = known(Some(0.60));
    assert!(value(&dense, "preparation_ratio") < 0.35, "{:?}", dense.inputs);
    let contacts = value(&dense, "sample.mechanical_coordination_number");
    assert!((contacts - 4.6).abs() < 0.05, "{contacts}");
    let curve = |answer: &FamilyPrediction, name: &str| {
        answer.curves.iter().find(|curve| curve.column == name).unwrap().clone()
    };
    // The curve starts at the coordination number of the sample, and its uncertainty is that of this number alone.
    let start = curve(&dense, "mechanical_coordination_number");
    assert!((start.mean[0] - contacts).abs() < 1e-12);
    assert!(start.from_inputs[0] > 0.0 && start.upper[0] - start.lower[0] > 0.02);
    // What is not known of the sample widens the interval of the volume, and hardly that of the strength.
    let last = open.points.len() - 1;
    let width = |answer: &FamilyPrediction, name: &str| {
        let curve = curve(answer, name);
        curve.upper[last] - curve.lower[last]
    };
    assert!(width(&open, "volumetric_strain") > 1.3 * width(&dense, "volumetric_strain"));
    let strength = curve(&dense, "stress_ratio");
    assert!((strength.mean[last] - 0.92).abs() < 0.03, "{}", strength.mean[last]);
    assert!(strength.lower[last] < 0.92 && 0.92 < strength.upper[last]);
    // What is outside the ranges is answered and flagged, and what is required is asked for.
    let far = model.predict(&[Some(1.4), Some(0.2), Some(4e-5), None, None, None, None], 0.9).unwrap();
    assert_eq!(far.outside.iter().map(|outside| outside.name.as_str()).collect::<Vec<_>>(), ["friction"]);
    let message = model.predict(&[None; 7], 0.9).unwrap_err().to_string();
    assert!(message.contains("it needs friction (coefficient of friction of the grains)"), "{message}");
    // Beyond all numbers there is no answer.
    let huge = model.predict(&[Some(0.4), Some(1e300), Some(1e300), None, None, None, None], 0.9);
    let message = huge.unwrap_err().to_string();
    assert!(
        message.contains("no finite value of") && message.contains("rolling_friction = 1e300"),
        "{message}"
    );
}

/// A property of the grains that is not given is integrated over its range, and the answer has the values between those of its ends.
#[test]
fn a_property_that_is_not_known_is_integrated_over() {
    let model = fitted(&dataset(40, 1, 1), &mut NoObserver);
    let at = |friction: Option<f64>, void_ratio: Option<f64>| {
        model.predict(&[friction, Some(0.2), Some(4e-5), None, None, void_ratio, None], 0.9).unwrap()
    };
    let open = at(None, None);
    let InputSource::Integrated([low, high]) = open.inputs[0].source else { panic!("{:?}", open.inputs[0]) };
    assert!(low < 0.15 && high > 0.75, "{low} {high}");
    assert!((open.inputs[0].value - 0.45).abs() < 0.05, "{:?}", open.inputs[0]);
    let last = open.points.len() - 1;
    let strength = |answer: &FamilyPrediction| {
        let curve = answer.curves.iter().find(|curve| curve.column == "stress_ratio").unwrap();
        [curve.lower[last], curve.mean[last], curve.upper[last]]
    };
    let [weak, strong] = [0.1, 0.8].map(|friction| strength(&at(Some(friction), None)));
    let [lower, mean, upper] = strength(&open);
    assert!(weak[1] < mean && mean < strong[1], "{weak:?} {mean} {strong:?}");
    assert!(lower < weak[2] && upper > strong[0] && lower > weak[0] && upper < strong[2], "{lower} {upper}");
    // The same again, and what is given of the sample counts.
    assert_eq!(at(None, None), open);
    assert_eq!(at(None, Some(0.62)).inputs[5].source, InputSource::Given);
}

#[test]
fn a_fitted_family_is_kept_in_a_file_that_is_checked() {
    let mut model = fitted(&dataset(24, 1, 2), &mut NoObserver);
    let scores = model.score(&dataset(4, 3, 3), data("unseen")).unwrap();
    model.add_scores(scores.clone());
    model.add_scores(scores);
    let text = model.to_json().unwrap();
    let read = FamilyModel::from_json(&text, "sand.json").unwrap();
    assert_eq!((read.scores().len(), read.runs(), read.data()), (1, 24, model.data()));
    assert_eq!(read.predict(&GIVEN, 0.9).unwrap(), model.predict(&GIVEN, 0.9).unwrap());
    assert_eq!(read.to_json().unwrap(), text);
    let told = |text: &str| FamilyModel::from_json(text, "sand.json").err().unwrap().to_string();
    assert!(told(&text.replacen("training", "other", 1)).contains("SHA-256"));
    assert!(told("{}").contains("sand.json: ") && told("{}").contains("not the file of a fitted family"));
}

/// Against the mean of eight samples the answer is nearer to the material than one more sample is, and nine of ten states are within
/// their intervals.
#[test]
fn scores_are_against_the_mean_of_samples_that_are_alike() {
    let model = fitted(&dataset(40, 1, 4), &mut NoObserver);
    let scores = model.score(&dataset(12, 8, 5), data("unseen")).unwrap();
    assert_eq!((scores.points, scores.data.runs, scores.outputs.len()), (12, 96, 6));
    let strength = &scores.outputs[0];
    assert_eq!(strength.output, "stress_ratio");
    assert!(strength.net_error < 0.7, "{strength:?}");
    assert!((0.01..0.03).contains(&strength.relative_scatter), "{strength:?}");
    // From 40 runs the factor of the intervals is known to some per cent; here it is large.
    assert!((0.8..0.995).contains(&strength.held), "{strength:?}");
    let friction = &strength.quarters[0];
    assert_eq!((friction.input.as_str(), friction.runs.iter().sum::<usize>()), ("friction", 96));
    // Runs that are alone have no scatter.
    let alone = model.score(&dataset(5, 1, 6), data("alone")).unwrap();
    assert!(alone.points == 0 && alone.outputs[0].net_error.is_nan());
}

struct Told(Vec<String>);

impl Observer for Told {
    fn progress(&mut self, _: &Progress) -> Flow {
        Flow::Continue
    }
    fn event(&mut self, event: &Event) {
        if let Event::Warning { text } = event {
            self.0.push(text.clone());
        }
    }
}

#[test]
fn a_test_that_was_ended_early_is_left_out_by_name() {
    let mut runs = dataset(24, 1, 7).runs().to_vec();
    let mut random = Random(ChaCha8Rng::seed_from_u64(8));
    let sand = Sand { friction: 0.3, rolling: 0.1, looseness: 0.5 };
    runs.push(run("early", sand, 0.147, &mut random).unwrap());
    let mut told = Told(Vec::new());
    let model = fitted(&Dataset::new(runs.clone()).unwrap(), &mut told);
    assert_eq!(model.left_out().iter().map(|early| early.run.as_str()).collect::<Vec<_>>(), ["early"]);
    assert!(told.0.iter().any(|text| text.contains("early (0.1470)")), "{:?}", told.0);
    assert_eq!((model.runs(), model.predict(&GIVEN, 0.9).unwrap().points.last()), (24, Some(&END)));
    // No score can be made of short runs alone.
    let short = Dataset::new(runs[24..].to_vec()).unwrap();
    let told = model.score(&short, data("short")).err().unwrap().to_string();
    assert!(told.contains("no run of `short` goes as far") && told.contains("axial_strain 0.25"), "{told}");
    // A run of other grains is refused.
    runs[3] = runs[3].clone().with_word("contact.normal", "jkr").unwrap();
    let fit = FamilyFit { method: GaussianProcessOfCurves::default(), threads: 1 };
    let refused = FamilyModel::fit(&SAND, &Dataset::new(runs).unwrap(), Vec::new(), &fit, &mut NoObserver);
    let told = refused.err().unwrap().to_string();
    assert!(told.contains("contact.normal is jkr") && told.contains("hertz"), "{told}");
}

/// States one by one are those of the curves where everything is given, and outside where the family says so.
#[test]
fn the_states_of_a_family_are_those_of_its_curves() {
    let model = std::sync::Arc::new(fitted(&dataset(20, 1, 1), &mut NoObserver));
    let states = FamilyStates::new(model.clone());
    let middle: Vec<f64> = model.ranges().iter().map(|[low, high]| 0.5 * (low + high)).collect();
    let mut far = middle.clone();
    far[0] = 3.0;
    let mut stream = crate::surrogate::PredictionStream::new(&states, 0.9).unwrap();
    for values in [&middle, &far, &middle] {
        let curves =
            model.predict(&values.iter().map(|value| Some(*value)).collect::<Vec<_>>(), 0.9).unwrap();
        for (point, x) in curves.points.iter().enumerate().step_by(7) {
            let row = [&[*x], values.as_slice()].concat();
            let state = stream.next_state(&row).unwrap();
            for (estimate, curve) in state.values.iter().zip(&curves.curves) {
                let interval = estimate.interval.as_ref().unwrap();
                assert_eq!(estimate.mean, curve.mean[point]);
                let width = interval.upper - interval.lower;
                assert!((width - (curve.upper[point] - curve.lower[point])).abs() <= 1e-9 * width.abs());
            }
            assert_eq!(state.outside, curves.outside);
        }
    }
    let beyond = stream.next_state(&[&[1.0], middle.as_slice()].concat()).unwrap();
    assert_eq!(beyond.outside[0].name, "axial_strain");
}
