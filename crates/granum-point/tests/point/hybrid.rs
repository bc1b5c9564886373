//! A point that a surrogate answers for while it knows, and grains where it does not.

use granum_core::Table;
use granum_learn::{Dataset, RunStates};
use granum_point::{Increment, MaterialPoint, PointError, State, Store, Trust};

use crate::sample;
use crate::surrogate::{bits, sample_values, tensor};

fn hybrid(largest_deviation: f64) -> MaterialPoint {
    let (surrogate, values) = (tensor(), sample_values());
    let (sample, controls) = (sample::simulation().clone(), sample::quick());
    MaterialPoint::hybrid(surrogate, &values, sample, Trust::up_to(largest_deviation), controls).unwrap()
}

/// Small shear, three increments there and three back.
fn step(k: u32) -> Increment {
    let d = if (k / 3).is_multiple_of(2) { 4e-4 } else { -4e-4 };
    Increment::from_components([d, -0.4 * d, -0.5 * d, 0.3 * d, 0.0, 0.2 * d])
}

/// The states after each of some increments.
fn states(point: &MaterialPoint, increments: impl IntoIterator<Item = Increment>) -> Vec<State> {
    let mut found = vec![point.start()];
    for increment in increments {
        let next = point.advance(&found[found.len() - 1], &increment).unwrap().state;
        found.push(next);
    }
    found
}

#[test]
fn it_answers_as_its_surrogate_where_that_is_trusted_and_as_its_grains_where_it_is_not() {
    let trusted = states(&hybrid(1e3), (0..3).map(step));
    let alone = MaterialPoint::from_surrogate(tensor(), &sample_values(), sample::quick()).unwrap();
    for (own, other) in trusted.iter().zip(states(&alone, (0..3).map(step))) {
        assert!(!own.is_live());
        assert_eq!(bits(&own.stress()), bits(&other.stress()));
    }
    let doubted = states(&hybrid(0.0), (0..3).map(step));
    let live = MaterialPoint::new(sample::simulation().clone(), sample::quick()).unwrap();
    let of_grains = states(&live, (0..3).map(step));
    for (own, other) in doubted.iter().zip(&of_grains).skip(1) {
        assert!(own.is_live());
        assert_eq!(bits(&own.stress()), bits(&other.stress()));
    }
    // No state of another point is taken for one of its own.
    let error = alone.advance(&doubted[2], &step(3)).err().unwrap();
    assert!(matches!(error, PointError::OtherKind { .. }), "{error}");
}

/// Where the path becomes longer than those of training, grains follow all of it and go on; what they did is a test for a surrogate.
#[test]
fn grains_follow_the_whole_path_where_they_take_over() {
    let point = hybrid(1e3);
    let all = states(&point, (0..60).map(step));
    let first = all.iter().position(State::is_live).unwrap();
    assert!(first > 2 && all[first..].iter().all(State::is_live), "{first}");
    assert!(all[..first].iter().all(|state| state.outside().is_empty()));
    let live = MaterialPoint::new(sample::simulation().clone(), sample::quick()).unwrap();
    let of_grains = states(&live, (0..first as u32 + 2).map(step));
    for k in [first, first + 2] {
        assert_eq!(bits(&all[k].stress()), bits(&of_grains[k].stress()), "{k}");
    }
    // The same increment from the state before gives the same bits again: the state was not changed.
    let again = hybrid(1e3).advance(&all[first - 1], &step(first as u32 - 1)).unwrap();
    assert_eq!(bits(&again.stress()), bits(&all[first].stress()));
    assert!(again.steps > 100 && !all[first - 1].is_live());
    // Another increment from the same state finds the grains at the end of the path as they were, and the bits are those of grains that follow it again.
    let other = Increment::from_components([-9e-4, 3e-4, 6e-4, 0.0, 3e-4, 0.0]);
    let asked = |point: &MaterialPoint| point.advance(&all[first - 1], &other).unwrap();
    let (remembered, anew) = (asked(&point), asked(&hybrid(1e3)));
    assert!(remembered.state.is_live() && anew.state.is_live());
    assert_eq!(bits(&remembered.state.stress()), bits(&anew.state.stress()));
    assert_eq!(remembered.steps, anew.steps);
    let table = all[first + 2].path(&point.start()).unwrap();
    let stresses = table.values("stress_11").unwrap();
    assert_eq!(stresses.len(), first + 3);
    for k in 1..first + 3 {
        assert_eq!(stresses[k].to_bits(), of_grains[k].stress()[0][0].to_bits());
    }
    let run = RunStates::new("taken over", table).unwrap();
    assert!(Dataset::new(vec![run]).is_ok() && point.start().path(&point.start()).is_none());
    assert!(of_grains[1].path(&live.start()).is_none());
}

/// Grains that keep the stress go on from that of the surrogate, where others go on from that of the path; what they were strained by belongs to their path.
#[test]
fn grains_that_take_over_can_keep_the_stress() {
    let keeping = |largest_deviation: f64| {
        let (sample, trust) = (sample::simulation().clone(), Trust { largest_deviation, keeps_stress: true });
        MaterialPoint::hybrid(tensor(), &sample_values(), sample, trust, sample::quick()).unwrap()
    };
    let point = keeping(1e3);
    let all = states(&point, (0..60).map(step));
    let first = all.iter().position(State::is_live).unwrap();
    let without = states(&hybrid(1e3), (0..first as u32).map(step));
    let zero = Increment::from_components([0.0; 6]);
    let [before, after, other] = [&all[first - 1], &all[first], &without[first]];
    assert!(other.is_live() && point.advance(before, &zero).unwrap().state.stress() == before.stress());
    let (path, by_path) = (after.path(&point.start()).unwrap(), other.path(&point.start()).unwrap());
    assert_eq!(path.rows(), by_path.rows() + 1);
    // Before the increment that made them take over, the grains had the last stress of the surrogate, and by the path alone another one.
    let last = before.stress();
    let of_path = |table: &Table, name: &str| table.values(name).unwrap()[table.rows() - 2];
    for (name, stress) in [("stress_11", last[0][0]), ("stress_22", last[1][1]), ("stress_12", last[0][1])] {
        let [kept, led] = [&path, &by_path].map(|table| of_path(table, name) - stress);
        assert!(kept.abs() < 200.0 && led.abs() > 5.0 * kept.abs(), "{name}: {kept} {led}");
    }
    let again = keeping(1e3).advance(before, &step(first as u32 - 1)).unwrap().state;
    assert_eq!(bits(&again.stress()), bits(&after.stress()));
}

#[test]
fn its_states_go_on_from_a_file_and_can_be_brought_to_a_stress() {
    let point = hybrid(1e3);
    let all = states(&point, (0..60).map(step));
    let first = all.iter().position(State::is_live).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points");
    let store = Store::new();
    for (name, k) in [(1, first - 1), (2, first + 1)] {
        store.put(name, all[k].clone());
    }
    store.save(&file).unwrap();
    let store = Store::load(&file).unwrap();
    for (name, k) in [(1, first - 1), (2, first + 1)] {
        let state = store.state(name, all[k].identity().ticket(), &point).unwrap();
        assert_eq!(state.is_live(), k > first);
        let next = point.advance(&state, &step(k as u32)).unwrap();
        assert_eq!(bits(&next.stress()), bits(&all[k + 1].stress()));
        assert_eq!(next.state.path(&point.start()), all[k + 1].path(&point.start()));
    }
    // The surrogate is strained to a stress that its host imposes, and grains can follow the strains.
    let p = 1.01 * all[2].mean_stress();
    let isotropic = [[p, 0.0, 0.0], [0.0, p, 0.0], [0.0, 0.0, p]];
    let imposed = point.at_stress(&all[2], &isotropic).unwrap();
    assert!(!imposed.state.is_live() && (imposed.stress()[0][0] - p).abs() < 1e-3 * p);
    assert!(imposed.state.path(&point.start()).unwrap().rows() > all[2].path(&point.start()).unwrap().rows());
    // Where it is not trusted, grains take the stress; they have no path from the start.
    let doubtful = hybrid(0.0);
    let imposed = doubtful.at_stress(&doubtful.start(), &isotropic).unwrap();
    assert!(imposed.state.is_live() && (imposed.stress()[0][0] - p).abs() < 2e-3 * p);
    let next = doubtful.advance(&imposed.state, &step(0)).unwrap();
    assert!(next.state.is_live() && next.state.path(&doubtful.start()).is_none());
}

#[test]
fn what_cannot_be_is_refused() {
    for largest_deviation in [-0.1, f64::NAN, f64::INFINITY] {
        let (sample, trust) = (sample::simulation().clone(), Trust::up_to(largest_deviation));
        let made = MaterialPoint::hybrid(tensor(), &sample_values(), sample, trust, sample::quick());
        let error = made.err().unwrap().to_string();
        assert!(error.contains("largest trusted deviation"), "{error}");
    }
    // One network alone does not say how sure it is.
    let alone = crate::surrogate::path_of(1);
    let (sample, trust) = (sample::simulation().clone(), Trust::up_to(0.1));
    let error = MaterialPoint::hybrid(alone, &sample_values(), sample, trust, sample::quick()).err().unwrap();
    assert!(error.to_string().contains("does not say how sure it is"), "{error}");
    // The void ratio is measured where it is not given.
    let trust = Trust::up_to(1e3);
    let point = MaterialPoint::hybrid(
        tensor(),
        &Default::default(),
        sample::simulation().clone(),
        trust,
        sample::quick(),
    );
    let point = point.unwrap();
    let measured = 1.0 / sample::simulation().state().solid_fraction() - 1.0;
    assert!((point.start().void_ratio().unwrap() - measured).abs() < 1e-2);
}
