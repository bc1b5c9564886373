//! Abaqus's user material, `UMAT`, which Kratos and CalculiX call as well.
//!
//! `PROPS(1)` is the number of the material in the configuration. `STATEV(1)` is the name of the point, a whole number from 1 that the
//! host's script gives before the first step; `STATEV(2)` is the ticket of its state, zero at first. Where there is room, `STATEV(3)` is
//! the void ratio, `STATEV(4)` the coordination number and `STATEV(5)` the largest standard deviation of a stress over the steps of its
//! average, in the unit of the host.
//!
//! What cannot be answered is answered with NaN in `STRESS`, which hosts take as a step that has to be cut, and `PNEWDT` is halved if
//! there is one. `STATEV` is then as it was.

use std::ffi::{c_char, c_int};
use std::slice;

use granum_core::geometry::Matrix;

use crate::failure::{Failure, caught};
use crate::host::{self, HostIncrement, PointAnswer, PointQuestion, Session};

/// Largest whole number up to which doubles are exact.
const LARGEST: f64 = 9_007_199_254_740_992.0;
/// State variables that are needed, and those that are written where there is room.
const NEEDED: usize = 2;

/// Abaqus's user material; `DDSDDE` by columns, as Fortran has it. Pointers that a host leaves null are not touched.
#[unsafe(no_mangle)]
#[rustfmt::skip]
pub unsafe extern "C" fn umat_(
    stress: *mut f64, statev: *mut f64, ddsdde: *mut f64, _sse: *mut f64, _spd: *mut f64, _scd: *mut f64,
    _rpl: *mut f64, _ddsddt: *mut f64, _drplde: *mut f64, _drpldt: *mut f64,
    _stran: *const f64, dstran: *const f64, _time: *const f64, _dtime: *const f64, _temp: *const f64, _dtemp: *const f64,
    _predef: *const f64, _dpred: *const f64, _cmname: *const c_char, ndi: *const c_int, nshr: *const c_int,
    ntens: *const c_int, nstatv: *const c_int, props: *const f64, nprops: *const c_int, _coords: *const f64,
    drot: *const f64, pnewdt: *mut f64, _celent: *const f64, _dfgrd0: *const f64, _dfgrd1: *const f64,
    _noel: *const c_int, _npt: *const c_int, _layer: *const c_int, _kspt: *const c_int, _kstep: *const c_int, _kinc: *const c_int,
) {
    let call = Call { stress, statev, ddsdde, dstran, ndi, nshr, ntens, nstatv, props, nprops, drot, pnewdt };
    unsafe { call.run(true) };
}

/// The same for hosts that call a function of C: `DDSDDE` by rows.
#[unsafe(no_mangle)]
#[rustfmt::skip]
pub unsafe extern "C" fn umat(
    stress: *mut f64, statev: *mut f64, ddsdde: *mut f64, _sse: *mut f64, _spd: *mut f64, _scd: *mut f64,
    _rpl: *mut f64, _ddsddt: *mut f64, _drplde: *mut f64, _drpldt: *mut f64,
    _stran: *const f64, dstran: *const f64, _time: *const f64, _dtime: *const f64, _temp: *const f64, _dtemp: *const f64,
    _predef: *const f64, _dpred: *const f64, _cmname: *const c_char, ndi: *const c_int, nshr: *const c_int,
    ntens: *const c_int, nstatv: *const c_int, props: *const f64, nprops: *const c_int, _coords: *const f64,
    drot: *const f64, pnewdt: *mut f64, _celent: *const f64, _dfgrd0: *const f64, _dfgrd1: *const f64,
    _noel: *const c_int, _npt: *const c_int, _layer: *const c_int, _kspt: *const c_int, _kstep: *const c_int, _kinc: *const c_int,
) {
    let call = Call { stress, statev, ddsdde, dstran, ndi, nshr, ntens, nstatv, props, nprops, drot, pnewdt };
    unsafe { call.run(false) };
}

/// The arguments that are used.
struct Call {
    stress: *mut f64,
    statev: *mut f64,
    ddsdde: *mut f64,
    dstran: *const f64,
    ndi: *const c_int,
    nshr: *const c_int,
    ntens: *const c_int,
    nstatv: *const c_int,
    props: *const f64,
    nprops: *const c_int,
    drot: *const f64,
    pnewdt: *mut f64,
}

/// A count that a host gives by its address.
unsafe fn count(pointer: *const c_int, name: &str) -> Result<usize, Failure> {
    // SAFETY: null or valid, as Abaqus's manual has it.
    let value = unsafe { pointer.as_ref() };
    let value = value.ok_or_else(|| Failure::Argument(format!("{name} is a null pointer")))?;
    usize::try_from(*value).map_err(|_| Failure::Argument(format!("{name} is {value}")))
}

/// A whole number among the state variables.
pub(crate) fn whole(value: f64, name: &str) -> Result<u64, Failure> {
    if (0.0..=LARGEST).contains(&value) && value.fract() == 0.0 {
        return Ok(value as u64);
    }
    Err(Failure::Argument(format!("{name} is {value:e}; it must be a whole number that is not negative")))
}

impl Call {
    /// Answers the call; `by_columns` is the order of `DDSDDE`.
    unsafe fn run(&self, by_columns: bool) {
        if let Err((_, message)) = caught(|| unsafe { self.answer(by_columns) }) {
            host::refused(&message);
            unsafe { self.refuse() };
        }
    }

    /// Fills the stress with NaN and halves the step.
    unsafe fn refuse(&self) {
        let components = unsafe { count(self.ntens, "NTENS") }.unwrap_or(0).min(6);
        if !self.stress.is_null() {
            unsafe { slice::from_raw_parts_mut(self.stress, components) }.fill(f64::NAN);
        }
        if !self.pnewdt.is_null() {
            unsafe { self.pnewdt.write(0.5) };
        }
    }

    unsafe fn answer(&self, by_columns: bool) -> Result<(), Failure> {
        let components = unsafe { self.components() }?;
        let null = |name: &str| Failure::Argument(format!("{name} is a null pointer"));
        if self.stress.is_null() || self.ddsdde.is_null() || self.dstran.is_null() || self.statev.is_null() {
            return Err(null("one of STRESS, DDSDDE, DSTRAN and STATEV"));
        }
        let variables = unsafe { count(self.nstatv, "NSTATV") }?;
        if variables < NEEDED {
            let what = "name and ticket of a point need two";
            return Err(Failure::Argument(format!("there are {variables} state variables; {what}")));
        }
        if self.props.is_null() || unsafe { count(self.nprops, "NPROPS") }? < 1 {
            return Err(Failure::Argument("PROPS(1) must be the number of a material".to_string()));
        }
        let session = host::current()?;
        let statev = unsafe { slice::from_raw_parts_mut(self.statev, variables) };
        let question = unsafe { self.question(&session, statev, components) }?;
        let answer = session.answer(&question, true)?;
        let stress = unsafe { slice::from_raw_parts_mut(self.stress, components) };
        let ddsdde = unsafe { slice::from_raw_parts_mut(self.ddsdde, components * components) };
        write_answer(&session, &answer, stress, Some((ddsdde, by_columns)), statev);
        Ok(())
    }

    /// The number of components: six, or four of plane strain and axial symmetry.
    unsafe fn components(&self) -> Result<usize, Failure> {
        let numbers =
            unsafe { [count(self.ndi, "NDI")?, count(self.nshr, "NSHR")?, count(self.ntens, "NTENS")?] };
        match numbers {
            [3, _, 6] => Ok(6),
            [3, _, 4] => Ok(4),
            [2, _, _] => Err(Failure::Argument(
                "plane stress (NDI = 2) is not possible: a sample of grains has no stress-free direction of its own; use a \
                 three-dimensional, plane-strain or axisymmetric element"
                    .to_string(),
            )),
            [ndi, nshr, ntens] => Err(Failure::Argument(format!(
                "NDI = {ndi}, NSHR = {nshr} and NTENS = {ntens} are not known; NTENS must be 6, or 4 with NDI = 3"
            ))),
        }
    }

    unsafe fn question(
        &self,
        session: &Session,
        statev: &[f64],
        components: usize,
    ) -> Result<PointQuestion, Failure> {
        let order = session.configuration().host;
        let unit = session.configuration().pascals_per_unit;
        let mut increment = HostIncrement { strain: [0.0; 6], stress: [0.0; 6], rotation: None };
        unsafe {
            increment.strain[..components].copy_from_slice(slice::from_raw_parts(self.dstran, components));
            for (value, given) in
                increment.stress.iter_mut().zip(slice::from_raw_parts(self.stress, components))
            {
                *value = unit * given;
            }
            if !self.drot.is_null() {
                let flat = slice::from_raw_parts(self.drot, 9);
                // Fortran has a matrix by columns.
                let rotation: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| flat[3 * c + r]));
                increment.rotation = Some(rotation);
            }
        }
        let (stress, increment) = order.read(&increment)?;
        if !stress.iter().flatten().all(|x| x.is_finite()) {
            return Err(Failure::Argument("STRESS has a component that is not a finite number".to_string()));
        }
        let name = whole(statev[0], "STATEV(1), the name of the point,")?;
        if name == 0 {
            return Err(Failure::Argument(
                "STATEV(1) is 0: give every point a name from 1 before the first step".to_string(),
            ));
        }
        let ticket = whole(statev[1], "STATEV(2), the ticket of the state,")?;
        let material = whole(unsafe { *self.props }, "PROPS(1), the number of the material,")? as usize;
        let is_plane = components == 4;
        Ok(PointQuestion { material, name, ticket, stress, is_plane, increment })
    }
}

/// Writes an answer in the order, the sign and the unit of the host: stress, stiffness (with true by columns) and state variables, of which
/// the first is the name.
pub(crate) fn write_answer(
    session: &Session,
    answer: &PointAnswer,
    stress: &mut [f64],
    stiffness: Option<(&mut [f64], bool)>,
    statev: &mut [f64],
) {
    let (order, unit) = (session.configuration().host, session.configuration().pascals_per_unit);
    for (place, value) in stress.iter_mut().zip(order.stress_to_host(&answer.state.stress())) {
        *place = value / unit;
    }
    if let (Some((places, by_columns)), Some(found)) = (stiffness, &answer.stiffness) {
        let size = stress.len();
        let found = order.stiffness_to_host(found);
        for i in 0..size {
            for j in 0..size {
                places[if by_columns { j * size + i } else { i * size + j }] = found[i][j] / unit;
            }
        }
    }
    let noise = answer.state.noise().iter().flatten().fold(0.0f64, |most, x| most.max(*x));
    let state = &answer.state;
    // Neither can be negative: minus one where a surrogate does not know it.
    let known = |value: Option<f64>| value.unwrap_or(-1.0);
    let (void_ratio, contacts) = (known(state.void_ratio()), known(state.coordination_number()));
    let outside = state.outside().len() as f64;
    let live = if state.is_live() { 1.0 } else { 0.0 };
    let values = [answer.ticket as f64, void_ratio, contacts, noise / unit, outside, live];
    for (place, value) in statev.iter_mut().skip(1).zip(values) {
        *place = value;
    }
}
