//! PLAXIS's user-defined soil model, `User_Mod`, which Kratos calls as well: stress and stiffness are two tasks.
//!
//! `Props(1)` is the number of the material in the configuration; the state variables are those of [`crate::umat`](mod@crate::umat). A point without a
//! name gets one at task 1: from the numbers of element and point where the host gives them, or else the next free one. Since the order of
//! such calls differs from run to run where a host has several threads, a material with more than one sample then asks for names that the
//! host's script gave.

use std::ffi::c_int;
use std::slice;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::failure::{Failure, caught};
use crate::host::{self, HostIncrement, PointQuestion, Session};
use crate::umat::{whole, write_answer};

/// Number of state variables: name, ticket, void ratio, coordination number, noise.
const VARIABLES: c_int = 5;
/// Number of parameters.
const PARAMETERS: c_int = 1;
/// Stiffness of the pore water of an undrained material, over the bulk modulus of the grains' skeleton.
const WATER: f64 = 100.0;
/// Names that are given in the order of the calls begin here, above those of elements and points.
static NEXT: AtomicU64 = AtomicU64::new(1 << 40);

/// The arguments that are used.
struct Call {
    task: c_int,
    undrained: bool,
    element: u64,
    point: u64,
    props: *const f64,
    stress_before: *const f64,
    water_before: *const f64,
    variables_before: *mut f64,
    strain: *const f64,
    stiffness: *mut f64,
    water_stiffness: *mut f64,
    stress: *mut f64,
    water: *mut f64,
    variables: *mut f64,
}

/// PLAXIS's user-defined soil model. `IDTask` is 1 (state variables), 2 (stress), 3 (stiffness), 4 (number of state variables), 5
/// (attributes of the stiffness) or 6 (elastic stiffness). What cannot be answered sets `iAbort`.
#[unsafe(no_mangle)]
#[rustfmt::skip]
pub unsafe extern "C" fn user_mod_(
    idtask: *const c_int, _imod: *const c_int, isundr: *const c_int, _istep: *const c_int, _iter: *const c_int,
    iel: *const c_int, int: *const c_int, _x: *const f64, _y: *const f64, _z: *const f64, _time0: *const f64,
    _dtime: *const f64, props: *const f64, sig0: *const f64, swp0: *const f64, stvar0: *mut f64, deps: *const f64,
    d: *mut f64, bulkw: *mut f64, sig: *mut f64, swp: *mut f64, stvar: *mut f64, ipl: *mut c_int, nstat: *mut c_int,
    nonsym: *mut c_int, istrsdep: *mut c_int, itimedep: *mut c_int, itang: *mut c_int, _iprjdir: *const c_int,
    _iprjlen: *const c_int, iabort: *mut c_int,
) {
    let number = |pointer: *const c_int| unsafe { pointer.as_ref() }.copied().unwrap_or(0);
    let put = |pointer: *mut c_int, value: c_int| {
        if !pointer.is_null() {
            unsafe { pointer.write(value) };
        }
    };
    put(iabort, 0);
    let index = |pointer| u64::try_from(number(pointer)).unwrap_or(0);
    let call = Call {
        task: number(idtask), undrained: number(isundr) == 1, element: index(iel), point: index(int), props,
        stress_before: sig0, water_before: swp0, variables_before: stvar0, strain: deps, stiffness: d,
        water_stiffness: bulkw, stress: sig, water: swp, variables: stvar,
    };
    match call.task {
        4 => put(nstat, VARIABLES),
        5 => {
            // Neither symmetric nor constant; it depends on the state and not on time, and is a tangent.
            put(nonsym, 1);
            put(istrsdep, 1);
            put(itimedep, 0);
            put(itang, 1);
        }
        1 | 2 | 3 | 6 => {
            if let Err((_, message)) = caught(|| unsafe { call.answer() }) {
                host::refused(&message);
                put(iabort, 1);
            } else if call.task == 2 {
                put(ipl, 0);
            }
        }
        _ => {}
    }
}

/// Number of parameters of a model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn getparamcount(_imod: *const c_int, count: *mut c_int) {
    if !count.is_null() {
        unsafe { count.write(PARAMETERS) };
    }
}

/// Number of state variables of a model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn getstatevarcount(_imod: *const c_int, count: *mut c_int) {
    if !count.is_null() {
        unsafe { count.write(VARIABLES) };
    }
}

/// The same under the name of Fortran.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn getparamcount_(imod: *const c_int, count: *mut c_int) {
    unsafe { getparamcount(imod, count) }
}

/// The same under the name of Fortran.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn getstatevarcount_(imod: *const c_int, count: *mut c_int) {
    unsafe { getstatevarcount(imod, count) }
}

impl Call {
    unsafe fn answer(&self) -> Result<(), Failure> {
        if self.props.is_null() || self.variables_before.is_null() {
            return Err(Failure::Argument("Props or StVar0 is a null pointer".to_string()));
        }
        let session = host::current()?;
        let material = whole(unsafe { *self.props }, "Props(1), the number of the material,")? as usize;
        let before = unsafe { slice::from_raw_parts_mut(self.variables_before, VARIABLES as usize) };
        if self.task == 1 {
            before[0] = self.name(&session, material, before[0])? as f64;
            return Ok(());
        }
        let question = unsafe { self.question(&session, material, before) }?;
        let wants_stiffness = self.task != 2 || self.undrained;
        let answer = session.answer(&question, wants_stiffness)?;
        if self.task == 2 {
            unsafe { self.write_stress(&session, &answer, before[0]) }
        } else if self.stiffness.is_null() {
            Err(Failure::Argument("D is a null pointer".to_string()))
        } else {
            let places = unsafe { slice::from_raw_parts_mut(self.stiffness, 36) };
            // The stress and the state variables of this task are not the host's.
            write_answer(&session, &answer, &mut [0.0; 6], Some((places, true)), &mut []);
            unsafe { self.write_water_stiffness(&session, &answer.stiffness) };
            Ok(())
        }
    }

    /// The name of a point that may have none.
    fn name(&self, session: &Session, material: usize, present: f64) -> Result<u64, Failure> {
        let name = whole(present, "StVar0(1), the name of the point,")?;
        if name != 0 {
            return Ok(name);
        }
        if self.element > 0 {
            // More points than any element has.
            return Ok(1000 * self.element + self.point);
        }
        let samples =
            session.configuration().materials.get(material.wrapping_sub(1)).map_or(1, |m| m.samples);
        if samples > 1 {
            return Err(Failure::Argument(
                "StVar0(1) is 0 and the host gives no number of the element: with several samples every point needs a name \
                 before the first step, or the result would depend on threads"
                    .to_string(),
            ));
        }
        Ok(NEXT.fetch_add(1, Ordering::Relaxed))
    }

    unsafe fn question(
        &self,
        session: &Session,
        material: usize,
        before: &[f64],
    ) -> Result<PointQuestion, Failure> {
        if self.stress_before.is_null() || self.strain.is_null() {
            return Err(Failure::Argument("Sig0 or dEps is a null pointer".to_string()));
        }
        let unit = session.configuration().pascals_per_unit;
        let [mut stress, mut strain] = [[0.0; 6]; 2];
        unsafe {
            for (value, given) in stress.iter_mut().zip(slice::from_raw_parts(self.stress_before, 6)) {
                *value = unit * given;
            }
            // A stiffness is that of the state before the increment where the host gives none with it.
            strain.copy_from_slice(slice::from_raw_parts(self.strain, 6));
        }
        let (stress, increment) =
            session.configuration().host.read(&HostIncrement { strain, stress, rotation: None })?;
        if !stress.iter().flatten().all(|x| x.is_finite()) {
            return Err(Failure::Argument("Sig0 has a component that is not a finite number".to_string()));
        }
        let name = self.name(session, material, before[0])?;
        let ticket = whole(before[1], "StVar0(2), the ticket of the state,")?;
        Ok(PointQuestion { material, name, ticket, stress, is_plane: false, increment })
    }

    unsafe fn write_stress(
        &self,
        session: &Session,
        answer: &host::PointAnswer,
        name: f64,
    ) -> Result<(), Failure> {
        if self.stress.is_null() || self.variables.is_null() {
            return Err(Failure::Argument("Sig or StVar is a null pointer".to_string()));
        }
        let stress = unsafe { slice::from_raw_parts_mut(self.stress, 6) };
        let variables = unsafe { slice::from_raw_parts_mut(self.variables, VARIABLES as usize) };
        write_answer(session, answer, stress, None, variables);
        variables[0] = name;
        if !self.water.is_null() && !self.water_before.is_null() {
            let strain = unsafe { slice::from_raw_parts(self.strain, 3) };
            let change = match (&answer.stiffness, self.undrained) {
                (Some(stiffness), true) => {
                    water_stiffness(session, stiffness) * (strain[0] + strain[1] + strain[2])
                }
                _ => 0.0,
            };
            unsafe { self.water.write(*self.water_before + change) };
        }
        unsafe { self.write_water_stiffness(session, &answer.stiffness) };
        Ok(())
    }

    unsafe fn write_water_stiffness(&self, session: &Session, stiffness: &Option<[[f64; 6]; 6]>) {
        if self.water_stiffness.is_null() {
            return;
        }
        let value = match (stiffness, self.undrained) {
            (Some(stiffness), true) => water_stiffness(session, stiffness),
            _ => 0.0,
        };
        unsafe { self.water_stiffness.write(value) };
    }
}

/// The bulk stiffness of the pore water of an undrained material in the unit of the host: a hundred times that of the skeleton.
fn water_stiffness(session: &Session, stiffness: &[[f64; 6]; 6]) -> f64 {
    let bulk: f64 = (0..3).map(|i| stiffness[i][..3].iter().sum::<f64>()).sum::<f64>() / 9.0;
    WATER * bulk / session.configuration().pascals_per_unit
}
