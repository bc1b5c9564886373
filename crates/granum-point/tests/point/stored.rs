//! A store of states: tickets, what is dropped, and the file of all points.

use std::path::Path;

use granum_point::{Increment, Recipe, Store, StoreError};

use crate::sample::point;

fn axial(strain: f64) -> Increment {
    Increment::from_components([strain, 0.0, 0.0, 0.0, 0.0, 0.0])
}

/// A host tries, goes back, accepts: only what it can come back to is kept.
#[test]
fn what_a_host_cannot_come_back_to_is_dropped() {
    let (point, store) = (point(), Store::new());
    let first = store.put(7, point.start());
    let tried = store.advance(7, first, &point, None, &axial(2e-4)).unwrap();
    let taken = store.advance(7, first, &point, None, &axial(1e-4)).unwrap();
    assert!(tried.ticket != taken.ticket && taken.steps > 0);
    assert_eq!(
        store.advance(7, first, &point, None, &axial(1e-4)).unwrap().steps,
        0,
        "the same question costs once"
    );
    assert_eq!(store.states(), 3);
    // The ticket that comes in was accepted.
    let next = store.advance(7, taken.ticket, &point, None, &axial(1e-4)).unwrap();
    assert_eq!(store.states(), 2);
    for gone in [first, tried.ticket, 12345] {
        let error = store.advance(7, gone, &point, None, &axial(1e-4)).unwrap_err();
        assert!(matches!(error, StoreError::NoTicket { name: 7, .. }), "{error}");
        assert!(error.to_string().contains(&taken.ticket.to_string()), "{error}");
    }
    assert!(matches!(
        store.advance(8, first, &point, None, &axial(1e-4)),
        Err(StoreError::NoPoint { name: 8, count: 1 })
    ));
    // A refused increment leaves everything as it is.
    assert!(store.advance(7, taken.ticket, &point, None, &axial(f64::NAN)).is_err());
    let again = store.advance(7, taken.ticket, &point, None, &axial(1e-4)).unwrap();
    assert!(again.state.is_same_value(&next.state) && again.steps == 0);
    let zero = store.advance(7, next.ticket, &point, None, &Increment::zero()).unwrap();
    assert_eq!((zero.ticket, zero.steps), (next.ticket, 0));
}

/// A trial that fell out of memory is computed again if the host accepts it after all, with the same bits.
#[test]
fn a_trial_that_was_dropped_to_save_memory_comes_back() {
    let (point, store) = (point(), Store::new());
    let first = store.put(1, point.start());
    let early = store.advance(1, first, &point, None, &axial(1e-5)).unwrap();
    for k in 2..30 {
        store.advance(1, first, &point, None, &axial(1e-5 * f64::from(k))).unwrap();
    }
    assert!(store.states() < 10, "{}", store.states());
    let next = store.advance(1, early.ticket, &point, None, &axial(1e-5)).unwrap();
    let direct = point.advance(&early.state, &axial(1e-5)).unwrap();
    assert_eq!(next.ticket, direct.state.identity().ticket());
    assert_eq!(next.state.stress(), direct.stress());
}

/// A stress that the host changed, as a K0 procedure does, is taken over before the increment.
#[test]
fn a_stress_that_the_host_changed_is_taken_over() {
    let (point, store) = (point(), Store::new());
    let first = store.put(1, point.start());
    let stress = [[70e3, 0.0, 0.0], [0.0, 70e3, 0.0], [0.0, 0.0, 110e3]];
    let answer = store.advance(1, first, &point, Some(&stress), &Increment::zero()).unwrap();
    assert!((answer.state.stress()[2][2] - 110e3).abs() < 110.0);
    let own = answer.state.stress();
    let again = store.advance(1, answer.ticket, &point, Some(&own), &Increment::zero()).unwrap();
    assert_eq!((again.ticket, again.steps), (answer.ticket, 0));
}

/// C5: ten steps; five, a new store from a file, and five: the same bits. Trials that were not accepted yet are saved with the rest.
#[test]
fn a_file_keeps_everything() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.granum");
    let (point, mut store) = (point(), Store::new());
    let mut tickets = [1u64, 2].map(|name| store.put(name, point.start()));
    let mut straight = point.start();
    for step in 0..10 {
        if step == 5 {
            store.save(&path).unwrap();
            store = Store::load(&path).unwrap();
            assert_eq!(store.len(), 2);
        }
        for (name, ticket) in [1u64, 2].into_iter().zip(&mut tickets) {
            *ticket = store.advance(name, *ticket, &point, None, &axial(1e-4)).unwrap().ticket;
        }
        straight = point.advance(&straight, &axial(1e-4)).unwrap().state;
    }
    // Another process has no memory of answers.
    let fresh = crate::sample::point();
    let end = store.state(1, tickets[0], &fresh).unwrap();
    assert_eq!(end.identity(), straight.identity());
    assert_eq!(end.stress(), straight.stress());
    assert_eq!(
        end.simulation().unwrap().checkpoint("").unwrap(),
        straight.simulation().unwrap().checkpoint("").unwrap()
    );
    // The path that was accepted, with its first half from the file, can be carried out again.
    store.accept(1, tickets[0], &fresh).unwrap();
    let (_, path) = store.accepted(1).unwrap();
    assert_eq!(path, [Recipe::Advance(axial(1e-4)); 10]);
    let replayed =
        path.iter().fold(fresh.start(), |state, recipe| fresh.follow(&state, recipe).unwrap().state);
    assert_eq!(replayed.identity(), end.identity());
}

fn refusal(path: &Path, bytes: &[u8]) -> String {
    std::fs::write(path, bytes).unwrap();
    let error = Store::load(path).err().unwrap().to_string();
    assert!(error.contains("points.granum"), "{error}");
    error
}

#[test]
fn damaged_files_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.granum");
    let store = Store::new();
    store.put(1, point().start());
    store.save(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    assert!(refusal(&path, b"").contains("GRANUMPT"));
    assert!(refusal(&path, b"something else").contains("GRANUMPT"));
    assert!(refusal(&path, &whole[..30]).contains("cut short"));
    assert!(refusal(&path, &whole[..whole.len() - 1]).contains("cut short"));
    for at in [20, 60, whole.len() / 2, whole.len() - 1] {
        let mut damaged = whole.clone();
        damaged[at] ^= 1;
        assert!(refusal(&path, &damaged).contains("damaged"), "{at}");
    }
    let mut newer = whole.clone();
    newer[8] = 9;
    assert!(refusal(&path, &newer).contains("version 9"));
    assert!(matches!(Store::load(&folder.path().join("none")), Err(StoreError::Read { .. })));
    std::fs::write(&path, &whole).unwrap();
    assert!(Store::load(&path).is_ok());
}

/// A checksum can be forged: whatever the content is, it is refused or read, and never a panic.
#[test]
fn damage_behind_a_right_checksum_is_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.granum");
    let (point, store) = (point(), Store::new());
    let first = store.put(1, point.start());
    store.advance(1, first, &point, None, &axial(1e-4)).unwrap();
    store.save(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let mut refused = 0;
    for k in 0..300usize {
        let mut damaged = whole.clone();
        // The first bytes are lengths and identities, the rest is mostly grains.
        let at = 52 + if k < 100 { k } else { k * 7919 % (whole.len() - 52) };
        damaged[at] ^= 1 << (k % 8);
        let sum = granum_core::digest::sha256(&damaged[52..]);
        for byte in 0..32 {
            damaged[20 + byte] = u8::from_str_radix(&sum[2 * byte..2 * byte + 2], 16).unwrap();
        }
        std::fs::write(&path, &damaged).unwrap();
        if let Err(error) = Store::load(&path) {
            assert!(error.to_string().contains("points.granum"), "{error}");
            refused += 1;
        }
    }
    assert!(refused > 50, "{refused}");
}

/// Points are asked from several threads at the same time: the same tickets and the same bits.
#[test]
fn a_store_can_be_asked_from_several_threads() {
    let ask = |threads: usize| -> Vec<u64> {
        let (point, store) = (point(), Store::new());
        let tickets: Vec<u64> = (0..6).map(|name| store.put(name, point.start())).collect();
        let answer = |k: usize| {
            let increment = axial(1e-4 * (1.0 + k as f64));
            store.advance(k as u64, tickets[k], &point, None, &increment).map(|answer| answer.ticket)
        };
        granum_core::parallel::map(6, threads, answer).unwrap()
    };
    assert_eq!(ask(1), ask(3));
}
