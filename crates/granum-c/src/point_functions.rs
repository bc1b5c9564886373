//! The functions of the C interface about material points.

use std::ffi::{c_char, c_int};
use std::path::Path;
use std::sync::Arc;

use granum_core::geometry::Matrix;
use granum_io::Case;
use granum_point::{BeyondLargest, Controls, Increment, MaterialPoint, Tangent};

use crate::failure::{Failure, guarded};
use crate::point_handles::{GranumPoint, GranumState, free, handle, numbers, reference, text, write};

/// Version of the interface: it changes when a function or a structure of this header does in a way that callers must know.
pub const GRANUM_INTERFACE_VERSION: u32 = 1;

/// The stiffness if every grain follows the strain of the cell.
pub const GRANUM_TANGENT_AFFINE: c_int = 0;
/// The elastic stiffness, without sliding.
pub const GRANUM_TANGENT_ELASTIC: c_int = 1;
/// Central differences of the answers to small strains.
pub const GRANUM_TANGENT_PROBES: c_int = 2;
/// The secant that is kept up along the path.
pub const GRANUM_TANGENT_SECANT: c_int = 3;

/// Controls of a live cell; `granum_controls_default` fills them in.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct GranumControls {
    /// Inertial number of the straining.
    pub inertial_number: f64,
    /// Steps for which the cell is held after an increment.
    pub relaxation: u64,
    /// The last steps of the relaxation over which the stress is averaged.
    pub averaging: u64,
    /// Largest size of an increment, sqrt(2/3 e:e), that is carried out in one piece.
    pub largest_increment: f64,
    /// Not zero if a larger increment is refused; zero if it is divided.
    pub refuse_larger: c_int,
    /// Size from which on an increment is refused in any case.
    pub absurd_increment: f64,
    /// Mean stress, Pa, whose strain rate is the smallest one; zero for a hundredth of that of the sample.
    pub least_mean_stress: f64,
    /// Largest number of steps of an increment.
    pub most_steps: u64,
    /// Largest overlap of grains over the sum of their radii.
    pub largest_overlap: f64,
}

impl From<Controls> for GranumControls {
    fn from(controls: Controls) -> GranumControls {
        GranumControls {
            inertial_number: controls.inertial_number,
            relaxation: controls.relaxation,
            averaging: controls.averaging,
            largest_increment: controls.largest_increment,
            refuse_larger: c_int::from(controls.beyond_largest == BeyondLargest::Refuse),
            absurd_increment: controls.absurd_increment,
            least_mean_stress: controls.least_mean_stress.unwrap_or(0.0),
            most_steps: controls.most_steps,
            largest_overlap: controls.largest_overlap,
        }
    }
}

impl From<GranumControls> for Controls {
    fn from(from: GranumControls) -> Controls {
        Controls::default().with(|controls| {
            controls.inertial_number = from.inertial_number;
            controls.relaxation = from.relaxation;
            controls.averaging = from.averaging;
            controls.largest_increment = from.largest_increment;
            controls.beyond_largest =
                if from.refuse_larger != 0 { BeyondLargest::Refuse } else { BeyondLargest::Divide };
            controls.absurd_increment = from.absurd_increment;
            controls.least_mean_stress = Some(from.least_mean_stress).filter(|stress| *stress != 0.0);
            controls.most_steps = from.most_steps;
            controls.largest_overlap = from.largest_overlap;
        })
    }
}

/// Version of granum, for example "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn granum_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Version of the interface of the library; compare it with `GRANUM_INTERFACE_VERSION` of the header.
#[unsafe(no_mangle)]
pub extern "C" fn granum_interface_version() -> u32 {
    GRANUM_INTERFACE_VERSION
}

/// Fills in the default controls.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_controls_default(controls: *mut GranumControls) -> c_int {
    guarded(|| unsafe { write(controls, GranumControls::from(Controls::default()), "controls") })
}

/// The controls that a pointer gives, or the default ones.
unsafe fn controls_from(controls: *const GranumControls) -> Controls {
    // SAFETY: null or valid, as the header says.
    unsafe { controls.as_ref() }.map_or_else(Controls::default, |controls| Controls::from(*controls))
}

fn prepared(case: &Case, controls: Controls) -> Result<*mut GranumPoint, Failure> {
    Ok(handle(GranumPoint(Arc::new(MaterialPoint::from_case(case, controls)?))))
}

/// Makes a point whose sample is prepared as a case file says. `controls` may be null for the default ones. `*point` is to be freed with
/// `granum_point_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_point_from_case(
    path: *const c_char,
    controls: *const GranumControls,
    point: *mut *mut GranumPoint,
) -> c_int {
    guarded(|| unsafe {
        let path = Path::new(text(path, "path of the case")?);
        let unreadable =
            |error: granum_io::Error| Failure::File { path: path.to_path_buf(), what: error.to_string() };
        let made = prepared(&Case::read(path).map_err(unreadable)?, controls_from(controls))?;
        write(point, made, "point").inspect_err(|_| free(made))
    })
}

/// The same from the text of a case.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_point_from_case_text(
    case: *const c_char,
    controls: *const GranumControls,
    point: *mut *mut GranumPoint,
) -> c_int {
    guarded(|| unsafe {
        let case = Case::parse(text(case, "case")?, "case");
        let case = case.map_err(|error| Failure::Argument(error.to_string()))?;
        let made = prepared(&case, controls_from(controls))?;
        write(point, made, "point").inspect_err(|_| free(made))
    })
}

/// Frees a point; null is nothing. States and stores that came from it can still be used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_point_free(point: *mut GranumPoint) {
    unsafe { free(point) }
}

/// The state of the sample before any increment. `*state` is to be freed with `granum_state_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_point_start(
    point: *const GranumPoint,
    state: *mut *mut GranumState,
) -> c_int {
    guarded(|| unsafe {
        let made = handle(GranumState(reference(point, "point")?.0.start()));
        write(state, made, "state").inspect_err(|_| free(made))
    })
}

/// The increment that six strains and nine numbers of a rotation give.
///
/// # Safety
/// Pointers are null or valid.
pub(crate) unsafe fn increment_from(strain: *const f64, rotation: *const f64) -> Result<Increment, Failure> {
    let increment = Increment::from_components(unsafe { numbers::<6>(strain, "strain increment") }?);
    if rotation.is_null() {
        return Ok(increment);
    }
    let flat = unsafe { numbers::<9>(rotation, "rotation") }?;
    let rotation: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| flat[3 * r + c]));
    Ok(increment.after_rotation(&rotation)?)
}

/// The answer to an increment: the sample is rotated (`rotation`, nine numbers row by row; null for no rotation) and then strained by a
/// logarithmic strain (six numbers xx, yy, zz, yz, zx, xy, compression positive, shear strains as angles, in the axes of space). `state`
/// is not changed; `*answer` is the new state and is to be freed with `granum_state_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_point_advance(
    point: *const GranumPoint,
    state: *const GranumState,
    strain: *const f64,
    rotation: *const f64,
    answer: *mut *mut GranumState,
) -> c_int {
    guarded(|| unsafe {
        let increment = increment_from(strain, rotation)?;
        let found = reference(point, "point")?.0.advance(&reference(state, "state")?.0, &increment)?;
        let made = handle(GranumState(found.state));
        write(answer, made, "answer").inspect_err(|_| free(made))
    })
}

/// The state brought to a stress (six numbers, Pa, compression positive). `*answer` is to be freed with `granum_state_free`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_point_at_stress(
    point: *const GranumPoint,
    state: *const GranumState,
    stress: *const f64,
    answer: *mut *mut GranumState,
) -> c_int {
    guarded(|| unsafe {
        let stress = crate::host::tensor_from(&numbers::<6>(stress, "stress")?);
        let found = reference(point, "point")?.0.at_stress(&reference(state, "state")?.0, &stress)?;
        let made = handle(GranumState(found.state));
        write(answer, made, "answer").inspect_err(|_| free(made))
    })
}

/// The stiffness of a state, Pa: 36 numbers row by row, `d_sigma_i = C[6 i + j] d_eps_j`. `kind` is one of `GRANUM_TANGENT_...`;
/// `probe_strain` counts for `GRANUM_TANGENT_PROBES` only.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn granum_point_tangent(
    point: *const GranumPoint,
    state: *const GranumState,
    kind: c_int,
    probe_strain: f64,
    stiffness: *mut f64,
) -> c_int {
    guarded(|| unsafe {
        let tangent = match kind {
            GRANUM_TANGENT_AFFINE => Tangent::Affine,
            GRANUM_TANGENT_ELASTIC => Tangent::Elastic,
            GRANUM_TANGENT_PROBES => Tangent::Probes { strain: probe_strain },
            GRANUM_TANGENT_SECANT => Tangent::Secant,
            _ => {
                return Err(Failure::Argument(format!("there is no kind {kind} of stiffness; it is 0 to 3")));
            }
        };
        let found = reference(point, "point")?.0.tangent(&reference(state, "state")?.0, tangent)?;
        write(stiffness.cast::<[[f64; 6]; 6]>(), found.0, "stiffness")
    })
}
