//! A surrogate behind a point: what holds of a live cell holds of it.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use granum_core::geometry::{Matrix, multiply};
use granum_core::observer::NoObserver;
use granum_core::{Column, Table};
use granum_learn::surrogate::{
    FitSpec, PathCell, PathNetworks, Recurrent, RidgeRegression, RunInputs, Surrogate, SurrogateMethod,
};
use granum_learn::{Dataset, RunStates};
use granum_nets::trainer::Adam;
use granum_point::{Controls, Increment, MaterialPoint, PointError, Recipe, Store, StoreError, Tangent};

use crate::sample;

const STRAINS: [&str; 6] = [
    "axial_strain",
    "lateral_strain_2",
    "lateral_strain_3",
    "shear_strain_yz",
    "shear_strain_zx",
    "shear_strain_xy",
];
const STRESSES: [&str; 6] = ["stress_11", "stress_22", "stress_33", "stress_23", "stress_13", "stress_12"];
const VOID_RATIO: &str = "sample.void_ratio";

/// Runs of a material that hardens with its volume and yields by shear, along lines of strain that turn; each has its void ratio.
fn runs() -> Dataset {
    let run = |seed: u32| {
        let void_ratio = 0.6 + 0.02 * f64::from(seed % 5);
        let (mut strain, mut deviator, mut columns) = ([0.0; 6], [0.0; 6], vec![Vec::new(); 13]);
        for state in 0..25u32 {
            let turn = f64::from(state / 6);
            for k in 0..6usize {
                let rate = (f64::from(3 * seed) + 1.7 * k as f64 + 2.1 * turn).sin();
                let step = if state == 0 { 0.0 } else { 2e-3 * rate };
                strain[k] += step;
                let half = if k < 3 { 1.0 } else { 0.5 };
                deviator[k] += 4e7 * half * step - 300.0 * step.abs() * deviator[k];
            }
            let volumetric: f64 = strain[..3].iter().sum();
            let p = 1e5 * (1.0 + 20.0 * volumetric);
            let third = (deviator[0] + deviator[1] + deviator[2]) / 3.0;
            for k in 0..6 {
                columns[k].push(strain[k]);
                columns[6 + k].push(deviator[k] + if k < 3 { p - third } else { 0.0 });
            }
            columns[12].push((1.0 + void_ratio) * (-volumetric).exp() - 1.0);
        }
        let names = STRAINS.into_iter().chain(STRESSES).chain(["volumetric_strain"]);
        let table = names.zip(columns).map(|(name, values)| Column::new(name, "1", values)).collect();
        RunStates::new(&format!("run-{seed}"), Table::new(table)?)?
            .with_parameter(VOID_RATIO, "1", void_ratio)
    };
    Dataset::new((0..16).map(run).collect::<granum_learn::Result<_>>().unwrap()).unwrap()
}

fn spec() -> FitSpec {
    FitSpec::new(STRAINS.into_iter().chain([VOID_RATIO]), STRESSES).with_threads(1)
}

fn path(cell: PathCell, rotations: usize) -> Arc<dyn Surrogate> {
    fitted(cell, rotations, 2)
}

/// So many tensor networks.
pub(crate) fn path_of(networks: usize) -> Arc<dyn Surrogate> {
    fitted(PathCell::TensorStateSpace, 0, networks)
}

fn fitted(cell: PathCell, rotations: usize, networks: usize) -> Arc<dyn Surrogate> {
    let mut method = PathNetworks::new(cell);
    (method.hidden, method.networks, method.rotations) = (8, networks, rotations);
    method.trainer = Adam { epochs: 30, learning_rate: 0.02, batch_sequences: 4, ..Adam::default() }.into();
    method.fit(&runs(), &spec(), &mut NoObserver).unwrap().into()
}

/// A tensor network, trained once.
pub(crate) fn tensor() -> Arc<dyn Surrogate> {
    static FITTED: OnceLock<Arc<dyn Surrogate>> = OnceLock::new();
    Arc::clone(FITTED.get_or_init(|| path(PathCell::TensorStateSpace, 0)))
}

pub(crate) fn sample_values() -> BTreeMap<String, f64> {
    BTreeMap::from([(VOID_RATIO.to_string(), 0.64)])
}

fn point_of(surrogate: Arc<dyn Surrogate>) -> MaterialPoint {
    MaterialPoint::from_surrogate(surrogate, &sample_values(), Controls::default()).unwrap()
}

pub(crate) fn step(k: u32) -> Increment {
    let rate = |c: u32| 2e-3 * (f64::from(k / 5) + 1.3 * f64::from(c)).sin();
    Increment::from_components(std::array::from_fn(|c| rate(c as u32)))
}

pub(crate) fn bits(stress: &Matrix) -> Vec<u64> {
    stress.iter().flatten().map(|x| x.to_bits()).collect()
}

/// Increments of a point have the bits of the surrogate for the run as a whole, with trials in between.
#[test]
fn a_point_answers_as_its_surrogate_for_the_whole_run() {
    let mut recurrent = Recurrent::default();
    (recurrent.hidden, recurrent.networks) = (6, 2);
    recurrent.trainer = Adam { epochs: 20, ..Adam::default() }.into();
    let recurrent = recurrent.fit(&runs(), &spec(), &mut NoObserver).unwrap();
    for surrogate in [tensor(), path(PathCell::Gru, 1), recurrent.into()] {
        let point = point_of(Arc::clone(&surrogate));
        let (mut state, mut strain) = (point.start(), [0.0; 6]);
        let (mut rows, mut states) = (vec![[strain.as_slice(), &[0.64]].concat()], vec![state.clone()]);
        for k in 0..30 {
            let increment = step(k);
            // Trials: an absurd one, one without a number, and one that is not taken.
            assert!(matches!(
                point.advance(&state, &Increment::from_components([0.9; 6])),
                Err(PointError::TooLarge { .. })
            ));
            assert!(matches!(
                point.advance(&state, &Increment::from_components([f64::NAN; 6])),
                Err(PointError::NotFinite { .. })
            ));
            let _ = point.advance(&state, &Increment::from_components([5e-4; 6])).unwrap();
            state = point.advance(&state, &increment).unwrap().state;
            for (k, [r, c]) in [[0, 0], [1, 1], [2, 2], [1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
                let own = increment.strain();
                strain[k] += if r == c { own[r][c] } else { own[r][c] + own[c][r] };
            }
            rows.push([strain.as_slice(), &[0.64]].concat());
            states.push(state.clone());
        }
        let inputs = RunInputs::new(rows.concat(), 7, vec![rows.len()]).unwrap();
        let whole = surrogate.predict(&inputs, 0.9).unwrap();
        for (state, prediction) in states.iter().zip(&whole) {
            for (k, [r, c]) in [[0, 0], [1, 1], [2, 2], [1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
                let name = surrogate.method();
                assert_eq!(state.stress()[r][c].to_bits(), prediction.values[k].mean.to_bits(), "{name}");
                let interval = prediction.values[k].interval.as_ref();
                assert_eq!(state.noise()[r][c], interval.map_or(0.0, |own| own.standard_deviation()));
            }
            assert_eq!(state.outside(), prediction.outside);
        }
        let volumetric: f64 = strain[..3].iter().sum();
        assert!((state.void_ratio().unwrap() - (1.64 * (-volumetric).exp() - 1.0)).abs() < 1e-12);
        assert!(state.simulation().is_none() && state.coordination_number().is_none());
    }
}

/// Zero changes no bit, the same question has the same bits, and so has it on any number of threads.
#[test]
fn states_are_values() {
    let point = point_of(tensor());
    let state = point.advance(&point.start(), &step(1)).unwrap().state;
    let zero = point.advance(&state, &Increment::zero()).unwrap();
    assert!(zero.state.is_same_value(&state) && zero.steps == 0);
    let questions: Vec<_> = (0..40).map(|k| (state.clone(), step(7 * k))).collect();
    let one = point.advance_all(&questions, 1);
    let other = point_of(tensor());
    let four = other.advance_all(&questions, 4);
    for (one, four) in one.iter().zip(&four) {
        let (one, four) = (one.as_ref().unwrap(), four.as_ref().unwrap());
        assert_eq!(bits(&one.stress()), bits(&four.stress()));
        assert_eq!(one.state.identity(), four.state.identity());
    }
    // A large increment is divided as if its parts had been asked for.
    let large = Increment::from_components([0.03, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let halves = Increment::from_components([0.015, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let whole = point.advance(&state, &large).unwrap();
    let half = point.advance(&state, &halves).unwrap().state;
    assert_eq!(whole.steps, 2);
    assert_eq!(bits(&whole.stress()), bits(&point.advance(&half, &halves).unwrap().stress()));
}

/// A path that is rotated as a whole gives the rotated stress.
#[test]
fn a_rotation_turns_the_stress() {
    let point = point_of(tensor());
    let (cosine, sine) = (0.8, 0.6);
    let turn = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]];
    let back = [[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]];
    let turned = |tensor: &Matrix| multiply(&multiply(&turn, tensor), &back);
    let straight = point.advance(&point.start(), &step(1)).unwrap().stress();
    let first = Increment::from_strain(&turned(step(1).strain())).after_rotation(&turn).unwrap();
    let rotated = point.advance(&point.start(), &first).unwrap().stress();
    let difference = (0..9).map(|k| (rotated[k / 3][k % 3] - turned(&straight)[k / 3][k % 3]).abs());
    assert!(difference.fold(0.0, f64::max) < 1e-9 * 1e5, "{rotated:?}");
    // Also in axes that stay, since the network has no axes of its own.
    let axes = Increment::from_strain(&turned(step(1).strain()));
    let rotated = point.advance(&point.start(), &axes).unwrap().stress();
    let difference = (0..9).map(|k| (rotated[k / 3][k % 3] - turned(&straight)[k / 3][k % 3]).abs());
    assert!(difference.fold(0.0, f64::max) < 1e-6 * 1e5, "{rotated:?}");
}

/// The stiffness is that of differences by hand; what needs grains is refused with what can be asked instead.
#[test]
fn stiffness_is_that_of_the_next_increments() {
    let point = point_of(tensor());
    let state = point.advance(&point.start(), &step(2)).unwrap().state;
    let found = point.tangent(&state, Tangent::Probes { strain: 1e-5 }).unwrap().0;
    let by_hand = |sign: f64| {
        let mut strain = [0.0; 6];
        strain[5] = sign * 1e-5;
        point.advance(&state, &Increment::from_components(strain)).unwrap().stress()
    };
    let slope = (by_hand(1.0)[0][1] - by_hand(-1.0)[0][1]) / 2e-5;
    assert!((found[5][5] - slope).abs() <= 1e-9 * slope.abs(), "{} {slope}", found[5][5]);
    assert!(found[5][5] > 0.0 && found[0][0] > 0.0, "{found:?}");
    assert!(point.tangent(&state, Tangent::Secant).is_ok());
    for kind in [Tangent::Affine, Tangent::Elastic] {
        let error = point.tangent(&state, kind).unwrap_err();
        assert!(error.to_string().contains("ask for probes or for the secant"), "{error}");
    }
    // Its own stress is there already, another one is reached by strains, and one that it never has is refused.
    let own = state.stress();
    assert!(point.at_stress(&state, &own).unwrap().state.is_same_value(&state));
    let other = [[1.04e5, 2e3, 0.0], [2e3, 0.99e5, 0.0], [0.0, 0.0, 1.01e5]];
    let imposed = point.at_stress(&state, &other).unwrap();
    let missed =
        (0..9).fold(0.0f64, |most, k| most.max((imposed.stress()[k / 3][k % 3] - other[k / 3][k % 3]).abs()));
    assert!(missed < 1e-3 * 1.04e5 && imposed.steps > 0, "{missed}");
    assert_eq!(bits(&point.at_stress(&state, &other).unwrap().stress()), bits(&imposed.stress()));
    let error = point.at_stress(&state, &[[-1e9, 0.0, 0.0], [0.0; 3], [0.0; 3]]).unwrap_err();
    assert!(matches!(error, PointError::StressNotReached { .. }), "{error}");
}

/// An answer tells that it is outside of what the surrogate was trained on.
#[test]
fn what_is_outside_is_told_with_the_answer() {
    let point = point_of(tensor());
    assert!(point.start().outside().is_empty(), "{:?}", point.start().outside());
    let mut state = point.start();
    for _ in 0..20 {
        state = point
            .advance(&state, &Increment::from_components([1e-2, 0.0, 0.0, 0.0, 0.0, 0.0]))
            .unwrap()
            .state;
    }
    let names: Vec<&str> = state.outside().iter().map(|own| own.name.as_str()).collect();
    assert!(names.contains(&"axial_strain") && names.contains(&"length of the path"), "{names:?}");
}

/// A store keeps states of surrogates beside those of grains, and its file gives them back to the bit.
#[test]
fn a_store_keeps_and_saves_states() {
    let (point, grains, store) = (point_of(tensor()), sample::point(), Store::new());
    let first = store.put(1, point.start());
    store.put(2, grains.start());
    let answer = store.advance(1, first, &point, None, &step(3)).unwrap();
    let next = store.advance(1, answer.ticket, &point, Some(&answer.state.stress()), &step(4)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("states.granum");
    store.save(&file).unwrap();
    let read = Store::load(&file).unwrap();
    // A process of its own has a point of its own.
    let other = point_of(tensor());
    let again = read.advance(1, answer.ticket, &other, None, &step(4)).unwrap();
    assert_eq!((again.ticket, bits(&again.state.stress())), (next.ticket, bits(&next.state.stress())));
    let on = read.advance(1, again.ticket, &other, None, &step(5)).unwrap();
    let expected = store.advance(1, next.ticket, &point, None, &step(5)).unwrap();
    assert_eq!((on.ticket, bits(&on.state.stress())), (expected.ticket, bits(&expected.state.stress())));
    assert_eq!(on.state.outside(), expected.state.outside());
    let (accepted, way) = read.accepted(1).unwrap();
    let mut state = other.start();
    for recipe in &way {
        state = other.follow(&state, recipe).unwrap().state;
    }
    assert!(way.iter().all(|recipe| matches!(recipe, Recipe::Advance(_))) && way.len() == 2);
    assert_eq!(bits(&state.stress()), bits(&accepted.stress()));
    // The state of grains is none of a surrogate, nor the other way round.
    let grain_ticket = grains.start().identity().ticket();
    let error = read.advance(2, grain_ticket, &other, None, &step(1)).unwrap_err();
    assert!(matches!(error, StoreError::Point { source: PointError::OtherKind { .. }, .. }), "{error}");
    assert!(matches!(grains.advance(&state, &step(1)), Err(PointError::OtherKind { .. })));
}

/// Surrogates that are no material are refused by name, with what is needed.
#[test]
fn what_is_no_material_is_refused() {
    let refused = |surrogate: Arc<dyn Surrogate>, sample: &BTreeMap<String, f64>, word: &str| {
        let error = MaterialPoint::from_surrogate(surrogate, sample, Controls::default()).err().unwrap();
        assert!(error.to_string().contains(word), "{error}");
    };
    refused(tensor(), &BTreeMap::new(), VOID_RATIO);
    refused(tensor(), &BTreeMap::from([(VOID_RATIO.to_string(), f64::NAN)]), "finite value");
    let mut more = sample_values();
    more.insert("friction".to_string(), 0.5);
    refused(tensor(), &more, "friction is no input");
    let ridge = RidgeRegression::default().fit(&runs(), &spec(), &mut NoObserver).unwrap();
    refused(ridge.into(), &sample_values(), "no memory");
    let mut quick = PathNetworks::new(PathCell::StateSpace);
    (quick.hidden, quick.networks, quick.rotations) = (4, 1, 0);
    quick.trainer = Adam { epochs: 1, ..Adam::default() }.into();
    let fit = |outputs: Vec<&str>| -> Arc<dyn Surrogate> {
        let spec = FitSpec::new(STRAINS.into_iter().chain([VOID_RATIO]), outputs).with_threads(1);
        quick.fit(&runs(), &spec, &mut NoObserver).unwrap().into()
    };
    refused(fit(STRESSES[..5].to_vec()), &sample_values(), "stress_12 is not among its outputs");
    refused(fit([STRESSES.as_slice(), &["volumetric_strain"]].concat()), &sample_values(), "held");
}
