//! The functions of the C interface about stores of states.

use std::ffi::{c_char, c_int};
use std::path::Path;

use granum_point::Store;

use crate::failure::guarded;
use crate::host::{components_of, tensor_from};
use crate::point_functions::increment_from;
use crate::point_handles::{
    GranumPoint, GranumState, GranumStore, free, handle, numbers, reference, text, write,
};

/// An empty store. `*store` is to be freed with `granum_store_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_store_new(store: *mut *mut GranumStore) -> c_int {
    guarded(|| unsafe {
        let made = handle(GranumStore(Store::new()));
        write(store, made, "store").inspect_err(|_| free(made))
    })
}

/// Frees a store with all its states; null is nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_store_free(store: *mut GranumStore) {
    unsafe { free(store) }
}

/// Keeps a state as the accepted one of a point, whose name is any number, and gives its ticket.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_store_put(
    store: *const GranumStore,
    name: u64,
    state: *const GranumState,
    ticket: *mut u64,
) -> c_int {
    guarded(|| unsafe {
        let kept = reference(store, "store")?.0.put(name, reference(state, "state")?.0.clone());
        write(ticket, kept, "ticket")
    })
}

/// The answer of a point to an increment from the state of a ticket, which is thereby accepted: what was tried otherwise is dropped.
/// `host_stress` (six numbers, Pa, compression positive) may be null; if it differs from the stress of the state, the point is brought to
/// it first. `strain` and `rotation` are those of `granum_point_advance`. The ticket and the stress of the new state are written; `stress`
/// may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_store_advance(
    store: *const GranumStore,
    name: u64,
    ticket: u64,
    point: *const GranumPoint,
    host_stress: *const f64,
    strain: *const f64,
    rotation: *const f64,
    new_ticket: *mut u64,
    stress: *mut f64,
) -> c_int {
    guarded(|| unsafe {
        let imposed = match host_stress.is_null() {
            true => None,
            false => Some(tensor_from(&numbers::<6>(host_stress, "stress of the host")?)),
        };
        let increment = increment_from(strain, rotation)?;
        let (store, point) = (reference(store, "store")?, reference(point, "point")?);
        let answer = store.0.advance(name, ticket, &point.0, imposed.as_ref(), &increment)?;
        if !stress.is_null() {
            write(stress.cast::<[f64; 6]>(), components_of(&answer.state.stress()), "stress")?;
        }
        write(new_ticket, answer.ticket, "new ticket")
    })
}

/// The state of a ticket, without taking it as accepted. `*state` is to be freed with `granum_state_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_store_state(
    store: *const GranumStore,
    name: u64,
    ticket: u64,
    point: *const GranumPoint,
    state: *mut *mut GranumState,
) -> c_int {
    guarded(|| unsafe {
        let found = reference(store, "store")?.0.state(name, ticket, &reference(point, "point")?.0)?;
        let made = handle(GranumState(found));
        write(state, made, "state").inspect_err(|_| free(made))
    })
}

/// Writes all points of a store to a file, beside its place and then renamed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_store_save(store: *const GranumStore, path: *const c_char) -> c_int {
    guarded(|| unsafe { Ok(reference(store, "store")?.0.save(Path::new(text(path, "path")?))?) })
}

/// Reads a store from a file. `*store` is to be freed with `granum_store_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_store_load(path: *const c_char, store: *mut *mut GranumStore) -> c_int {
    guarded(|| unsafe {
        let made = handle(GranumStore(Store::load(Path::new(text(path, "path")?))?));
        write(store, made, "store").inspect_err(|_| free(made))
    })
}
