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

/// The standard deviation of the six components of the stress over the steps of their average, Pa, in the axes of the cell.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_noise(state: *const GranumState, noise: *mut f64) -> c_int {
    guarded(|| unsafe { six(state, noise, "noise", |state| *state.0.noise()) })
}

/// The void ratio: volume of the voids over that of the grains.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_void_ratio(state: *const GranumState, void_ratio: *mut f64) -> c_int {
    guarded(|| unsafe { write(void_ratio, reference(state, "state")?.0.void_ratio(), "void ratio") })
}

/// A value of a sensor by the name of its column, for example "coordination_number" or "phi_d".
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_sensor(
    state: *const GranumState,
    column: *const c_char,
    value: *mut f64,
) -> c_int {
    guarded(|| unsafe {
        let column = text(column, "name of the column")?;
        let measurement = reference(state, "state")?.0.measure(&Sensors::standard());
        let missing =
            || Failure::Argument(format!("no sensor gives the column {column:?} of a single state"));
        write(value, measurement.value(column).ok_or_else(missing)?, "value")
    })
}

/// The ticket of a state: a whole number from 1 to 2^52, which is the same in every process.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_state_ticket(state: *const GranumState, ticket: *mut u64) -> c_int {
    guarded(|| unsafe { write(ticket, reference(state, "state")?.0.identity().ticket(), "ticket") })
}
