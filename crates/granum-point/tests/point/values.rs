//! States are values: what is asked in between, how often, in how many parts and on how many threads.

use granum_core::observer::Flow;
use granum_point::{BeyondLargest, Increment, MaterialPoint, PointError, State};

use crate::sample::{difference, point, quick, simulation};

fn axial(strain: f64) -> Increment {
    Increment::from_components([strain, 0.0, 0.0, 0.0, 0.0, 0.0])
}

/// Everything that a state has, as bits.
fn bits(state: &State) -> Vec<u8> {
    let mut bytes = state.simulation().unwrap().checkpoint("").unwrap();
    bytes.extend(state.stress().iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes
}

fn assert_shareable<T: Send + Sync>(_: &T) {}

#[test]
fn points_and_states_can_be_shared_between_threads() {
    let point = point();
    assert_shareable(&point);
    assert_shareable(&point.start());
}

/// C3: asked for 0.1, then for NaN, then for 1e-4: the bits are those of 1e-4 alone.
#[test]
fn a_trial_leaves_no_traces() {
    let alone = point();
    let alone = alone.advance(&alone.start(), &axial(1e-4)).unwrap();
    let asked = point();
    let start = asked.start();
    let before = bits(&start);
    asked.advance(&start, &axial(0.1)).unwrap();
    let refused = asked.advance(&start, &axial(f64::NAN)).unwrap_err();
    assert!(matches!(refused, PointError::NotFinite { .. }), "{refused}");
    let answer = asked.advance(&start, &axial(1e-4)).unwrap();
    assert_eq!(bits(&answer.state), bits(&alone.state));
    assert_eq!(answer.state.identity(), alone.state.identity());
    assert_eq!(bits(&start), before);
}

/// A trial that is stopped makes no state, and the next question is answered as if it had never been.
#[test]
fn a_trial_that_is_stopped_makes_no_state() {
    let point = point();
    let start = point.start();
    let mut calls = 0;
    let stopped = point.advance_watched(&start, &axial(6e-3), &mut |share| {
        assert!(share > 0.0 && share < 1.0);
        calls += 1;
        if calls == 3 { Flow::Stop } else { Flow::Continue }
    });
    assert!(matches!(stopped, Err(PointError::Stopped)) && calls == 3);
    let whole = point.advance(&start, &axial(6e-3)).unwrap();
    let other = crate::sample::point();
    assert_eq!(bits(&whole.state), bits(&other.advance(&other.start(), &axial(6e-3)).unwrap().state));
}

#[test]
fn a_zero_increment_changes_no_bit_and_costs_nothing() {
    let point = point();
    let state = point.advance(&point.start(), &axial(1e-4)).unwrap().state;
    let answer = point.advance(&state, &Increment::zero()).unwrap();
    assert!(answer.state.is_same_value(&state) && answer.steps == 0);
    let minus = point.advance(&state, &Increment::from_strain(&[[-0.0; 3]; 3])).unwrap();
    assert!(minus.state.is_same_value(&state));
}

#[test]
fn the_same_question_costs_once() {
    let point = point();
    let start = point.start();
    let first = point.advance(&start, &axial(1e-4)).unwrap();
    let again = point.advance(&start, &axial(1e-4)).unwrap();
    assert!(first.state.is_same_value(&again.state) && first.steps > 0);
}

/// C4: one cell length, however a path is cut; a factor `1 - 0.1 / n` would give 0.9, 0.9043821 and 0.9047921.
#[test]
fn one_cell_length_however_the_path_is_cut() {
    let point = point();
    let start = point.start();
    for parts in [1u32, 10, 100] {
        let mut state = start.clone();
        for _ in 0..parts {
            state = point.advance(&state, &axial(0.1 / f64::from(parts))).unwrap().state;
        }
        let ratio = state.cell().unwrap()[0][0] / start.cell().unwrap()[0][0];
        assert!((ratio - 0.904_837_418_035_959_6).abs() < 1e-11, "{parts} parts: {ratio}");
        assert_eq!(state.cell().unwrap()[1][1], start.cell().unwrap()[1][1]);
    }
}

/// An increment that is too large is divided, with the bits of the parts asked for one after the other; or refused.
#[test]
fn large_increments_are_divided_or_refused() {
    let dividing =
        MaterialPoint::new(simulation().clone(), quick().with(|c| c.largest_increment = 1e-3)).unwrap();
    // An axial strain of 3e-3 has the size 2.45e-3: three parts.
    let whole = dividing.advance(&dividing.start(), &axial(3e-3)).unwrap();
    let mut state = dividing.start();
    for _ in 0..3 {
        state = dividing.advance(&state, &axial(3e-3 / 3.0)).unwrap().state;
    }
    assert_eq!(bits(&whole.state), bits(&state));
    assert_ne!(whole.state.identity(), state.identity(), "another path, even if it leads to the same place");

    let refusing = quick().with(|c| {
        c.largest_increment = 1e-3;
        c.beyond_largest = BeyondLargest::Refuse;
    });
    let refusing = MaterialPoint::new(simulation().clone(), refusing).unwrap();
    let error = refusing.advance(&refusing.start(), &axial(3e-3)).unwrap_err();
    assert!(matches!(error, PointError::TooLarge { limit: 1e-3, .. }), "{error}");
    assert!(refusing.advance(&refusing.start(), &axial(1e-3)).is_ok());
    // Beyond all sense it is refused in any case, at once.
    let error = dividing.advance(&dividing.start(), &axial(50.0)).unwrap_err().to_string();
    assert!(error.contains("4.082e1") && error.contains("smaller step"), "{error}");
    // Nor does a point work without end.
    let slow = axial(1e-3).in_time(1.0);
    let error = dividing.advance(&dividing.start(), &slow).unwrap_err();
    assert!(matches!(error, PointError::TooLong { .. }), "{error}");
}

/// Many points on one, two and five threads: the same bits.
#[test]
fn threads_change_no_bit() {
    let answers = |threads: usize| {
        let point = point();
        let questions: Vec<_> = (1..=6)
            .map(|k| {
                let k = f64::from(k);
                (point.start(), Increment::from_components([1e-4 * k, -5e-5 * k, 0.0, 2e-5 * k, 0.0, 1e-5]))
            })
            .collect();
        let answers = point.advance_all(&questions, threads);
        answers.into_iter().map(|answer| bits(&answer.unwrap().state)).collect::<Vec<_>>()
    };
    let one = answers(1);
    assert_eq!(one.len(), 6);
    assert!(one == answers(2) && one == answers(5));
    assert_ne!(one[0], one[1]);
}

/// Expanded until nothing touches, a sample answers with no stress; compressed again it carries load.
#[test]
fn a_sample_without_stress_can_be_loaded_again() {
    let point = point();
    let start = point.start();
    let volume = |strain: f64| Increment::from_components([strain, strain, strain, 0.0, 0.0, 0.0]);
    let mut state = start.clone();
    for _ in 0..4 {
        state = point.advance(&state, &volume(-5e-3)).unwrap().state;
    }
    assert!(state.mean_stress().abs() < 1e-3 * start.mean_stress(), "{} Pa", state.mean_stress());
    let empty = point.advance(&state, &axial(1e-5)).unwrap();
    assert!(empty.stress().iter().flatten().all(|x| x.is_finite()));
    for _ in 0..5 {
        state = point.advance(&state, &volume(5e-3)).unwrap().state;
    }
    assert!(state.mean_stress() > 0.5 * start.mean_stress(), "{} Pa", state.mean_stress());
}

/// The stress is the mean over the last steps, and its scatter over them is stated.
#[test]
fn the_noise_of_the_average_is_stated() {
    let point = point();
    let answer = point.advance(&point.start(), &axial(1e-3)).unwrap();
    let noise = answer.noise()[0][0];
    let last = answer.state.simulation().unwrap().state().stress();
    assert!(noise > 0.0 && noise < 0.05 * answer.stress()[0][0], "{noise} Pa");
    assert!(
        difference(&last, &answer.stress()) < 10.0 * noise + 1.0,
        "the average is not far from the last value"
    );
    let void_ratio = answer.state.value("void_ratio", &granum_sensors::Sensors::standard()).unwrap();
    assert!((void_ratio - answer.state.void_ratio().unwrap()).abs() < 1e-12);
}
