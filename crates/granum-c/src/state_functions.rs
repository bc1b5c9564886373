//! The functions of the C interface about states.

use std::ffi::{c_char, c_int};

use granum_core::geometry::Matrix;
use granum_sensors::Sensors;

use crate::failure::{Failure, guarded};
use crate::host::components_of;
use crate::point_handles::{GranumState, free, handle, reference, text, write};

/// Another handle of the same state, which is to be freed as well.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_clone(
    state: *const GranumState,
    clone: *mut *mut GranumState,
) -> c_int {
    guarded(|| unsafe {
        let made = handle(GranumState(reference(state, "state")?.0.clone()));
        write(clone, made, "state").inspect_err(|_| free(made))
    })
}

/// Frees a state; null is nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_free(state: *mut GranumState) {
    unsafe { free(state) }
}

unsafe fn six(
    state: *const GranumState,
    place: *mut f64,
    what: &str,
    tensor: impl Fn(&GranumState) -> Matrix,
) -> Result<(), Failure> {
    unsafe {
        let components = components_of(&tensor(reference(state, "state")?));
        write(place.cast::<[f64; 6]>(), components, what)
    }
}

/// The stress, Pa: six numbers xx, yy, zz, yz, zx, xy, compression positive, in the axes of space.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_stress(state: *const GranumState, stress: *mut f64) -> c_int {
    guarded(|| unsafe { six(state, stress, "stress", |state| state.0.stress()) })
}

/// The standard deviation of the six components of the stress, Pa, in the axes of the cell: of grains that over the steps of their average, of a
/// surrogate that of its prediction for a new sample.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_noise(state: *const GranumState, noise: *mut f64) -> c_int {
    guarded(|| unsafe { six(state, noise, "noise", |state| *state.0.noise()) })
}

/// The void ratio: volume of the voids over that of the grains. A surrogate may not know it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_void_ratio(state: *const GranumState, void_ratio: *mut f64) -> c_int {
    guarded(|| unsafe {
        let found = reference(state, "state")?.0.void_ratio();
        let missing = || Failure::Argument("the surrogate of this point knows no void ratio".to_string());
        write(void_ratio, found.ok_or_else(missing)?, "void ratio")
    })
}

/// Number of the inputs and other quantities of a state that are outside of what its surrogate was trained on: its answer should not be trusted if there are
/// any. Zero for grains.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_outside(state: *const GranumState, count: *mut u64) -> c_int {
    guarded(|| unsafe { write(count, reference(state, "state")?.0.outside().len() as u64, "number") })
}

/// One if grains are behind the state, zero if a surrogate is: of a material of both it tells who answered.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_is_live(state: *const GranumState, is_live: *mut c_int) -> c_int {
    guarded(|| unsafe { write(is_live, c_int::from(reference(state, "state")?.0.is_live()), "answer") })
}

/// A value of a sensor by the name of its column, for example "coordination_number" or "phi_d", or of an output of a surrogate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_sensor(
    state: *const GranumState,
    column: *const c_char,
    value: *mut f64,
) -> c_int {
    guarded(|| unsafe {
        let column = text(column, "name of the column")?;
        let found = reference(state, "state")?.0.value(column, &Sensors::standard());
        let missing =
            || Failure::Argument(format!("no sensor or surrogate gives the column {column:?} of this state"));
        write(value, found.ok_or_else(missing)?, "value")
    })
}

/// The ticket of a state: a whole number from 1 to 2^52, which is the same in every process.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_ticket(state: *const GranumState, ticket: *mut u64) -> c_int {
    guarded(|| unsafe { write(ticket, reference(state, "state")?.0.identity().ticket(), "ticket") })
}
