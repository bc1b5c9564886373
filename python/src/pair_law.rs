//! A contact law that is a function of Python, for two grains on a path alone: a simulation evaluates its laws for eight contacts at once,
//! billions of times.

use std::cell::RefCell;

use granum::law::{
    LawDescription, LawEnergies, MAX_HISTORY, MAX_NORMAL_HISTORY, Mask, Normal, NormalLaw, NormalTraits,
    PairProperties, Real, Tangential, TangentialLaw, law_constants,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::detached::raise;
use crate::errors;

/// The functions of a pair.
#[derive(Default)]
pub struct Functions {
    pub normal: Option<Py<PyAny>>,
    pub tangential: Option<Py<PyAny>>,
}

thread_local! {
    /// The functions of the pair that this thread moves; laws have no data of their own.
    static HERE: RefCell<Functions> = RefCell::default();
}

/// Does some work for which the laws of this file are these functions.
pub fn with_functions<T>(functions: Functions, work: impl FnOnce() -> T) -> T {
    /// Puts back the functions of a pair within whose law this one is moved.
    struct Before(Option<Functions>);
    impl Drop for Before {
        fn drop(&mut self) {
            HERE.replace(self.0.take().unwrap_or_default());
        }
    }
    let _before = Before(Some(HERE.replace(functions)));
    work()
}

/// What a function returned: its first value or values, and what to keep.
struct Answer<const N: usize> {
    force: [f64; N],
    radius: Option<f64>,
}

/// Calls a function of this thread.
fn call<const N: usize>(
    what: &'static str,
    find: fn(&Functions) -> Option<&Py<PyAny>>,
    arguments: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyTuple>>,
    kept: &mut [f64],
) -> Answer<N> {
    let answer = Python::try_attach(|py| {
        let function = HERE.with_borrow(|functions| find(functions).map(|function| function.clone_ref(py)));
        let Some(function) = function else { return Err(errors::internal(py, "a law without a function")) };
        let answer = function.bind(py).call1(arguments(py)?)?;
        read(what, &answer, kept)
    });
    match answer {
        Some(Ok(answer)) => answer,
        Some(Err(error)) => raise(error),
        None => Answer { force: [0.0; N], radius: None },
    }
}

/// Reads what a function returned: a force, or a dict with `force`, `radius` and `kept`.
fn read<const N: usize>(what: &str, answer: &Bound<'_, PyAny>, kept: &mut [f64]) -> PyResult<Answer<N>> {
    let py = answer.py();
    let (force, radius, keep) = match answer.cast::<PyDict>() {
        Ok(dict) => {
            for key in dict.keys() {
                let key: String = key.extract()?;
                if !["force", "radius", "kept"].contains(&key.as_str()) {
                    let message =
                        format!("the {what} law returned {key}; a law returns force, radius and kept");
                    return Err(PyTypeError::new_err(message));
                }
            }
            let Some(force) = dict.get_item("force")? else {
                return Err(PyTypeError::new_err(format!("the {what} law returned no force")));
            };
            (force, dict.get_item("radius")?, dict.get_item("kept")?)
        }
        Err(_) => (answer.clone(), None, None),
    };
    let wrong = |value: &Bound<'_, PyAny>, wanted: &str| match value.get_type().name() {
        Ok(kind) => PyTypeError::new_err(format!("the {what} law returned {kind}, not {wanted}")),
        Err(error) => error,
    };
    let finite = |number: f64| match number.is_finite() {
        true => Ok(number),
        false => {
            let message = format!("the {what} law returned {number}, which is not finite");
            Err(errors::of_value(py, what, number.to_string(), message))
        }
    };
    let number =
        |value: &Bound<'_, PyAny>| finite(value.extract::<f64>().map_err(|_| wrong(value, "a number"))?);
    let mut found = Answer { force: [0.0; N], radius: radius.as_ref().map(number).transpose()? };
    if let [only] = &mut found.force[..] {
        *only = number(&force)?;
    } else {
        let components: Vec<f64> = force.extract().map_err(|_| wrong(&force, "two components"))?;
        if components.len() != N {
            return Err(wrong(&force, "two components"));
        }
        for (to, component) in found.force.iter_mut().zip(components) {
            *to = finite(component)?;
        }
    }
    if let Some(keep) = keep {
        let numbers: Vec<f64> = keep.extract().map_err(|_| wrong(&keep, "numbers to keep"))?;
        if numbers.len() > kept.len() {
            let message = format!("a {what} law keeps at most {} numbers, not {}", kept.len(), numbers.len());
            return Err(errors::of_value(py, what, numbers.len().to_string(), message));
        }
        for (to, number) in kept.iter_mut().zip(numbers) {
            *to = finite(number)?;
        }
    }
    Ok(found)
}

law_constants! {
    /// What is prepared for a pair.
    pub struct OfPair<R> {
        /// Effective radius, m.
        radius: R,
    }
}

/// A normal law that is a function of Python.
#[derive(Clone, Copy)]
pub struct PythonNormal;

impl NormalLaw for PythonNormal {
    const DESCRIPTION: LawDescription =
        LawDescription::new("python", "function of Python", "a function of Python, for a pair alone", &[]);
    type Constants<R: Real> = OfPair<R>;
    const HISTORY: usize = MAX_NORMAL_HISTORY;

    fn prepare(pair: &PairProperties, _: &[f64]) -> OfPair<f64> {
        OfPair { radius: pair.effective_radius }
    }

    fn evaluate<R: Real>(c: &OfPair<R>, overlap: R, touched: R::Mask) -> Normal<R> {
        let (zero, energies) = (R::zero(), &mut [R::zero(); 2]);
        Self::update(c, overlap, touched, &mut [zero; MAX_NORMAL_HISTORY], energies)
    }

    /// A pair is evaluated as one number, of which the largest lane is the number itself.
    fn update<R: Real>(
        c: &OfPair<R>,
        overlap: R,
        _touched: R::Mask,
        history: &mut [R; MAX_NORMAL_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Normal<R> {
        let (alpha, effective) = (overlap.reduce_max(), c.radius.reduce_max());
        let mut kept = history.map(Real::reduce_max);
        let before = kept;
        let answer: Answer<1> = call(
            "normal",
            |functions| functions.normal.as_ref(),
            |py| (alpha, before).into_pyobject(py),
            &mut kept,
        );
        let [force] = answer.force;
        let touches = alpha > 0.0 || force != 0.0;
        let hertz = (effective * alpha.max(0.0)).sqrt();
        let radius = if touches { answer.radius.unwrap_or(hertz).max(0.0) } else { 0.0 };
        *history = if touches { kept.map(R::splat) } else { [R::zero(); MAX_NORMAL_HISTORY] };
        Normal {
            force: R::splat(force),
            radius: R::splat(radius),
            // Dashpots have no part in the elastic forces of a pair.
            stiffness: R::zero(),
            root_stiffness: R::zero(),
            tangential_measure: R::splat(radius),
            root_tangential_measure: R::splat(radius.sqrt()),
            friction_load: R::splat(force.max(0.0)),
            touching: R::Mask::splat(touches),
        }
    }

    fn loaded(_: &PairProperties, _: &[f64], _: f64) -> Normal<f64> {
        Normal::none()
    }

    fn energy<R: Real>(_: &OfPair<R>, _: R) -> R {
        R::zero()
    }
}

/// Number of columns of the force, before what a tangential law keeps.
const FORCE: usize = 2;

/// A tangential law that is a function of Python.
#[derive(Clone, Copy)]
pub struct PythonTangential;

impl TangentialLaw for PythonTangential {
    const DESCRIPTION: LawDescription =
        LawDescription::new("python", "function of Python", "a function of Python, for a pair alone", &[]);
    type Constants<R: Real> = OfPair<R>;
    const HISTORY: usize = MAX_HISTORY;
    const PLANE_VECTORS: usize = 1;

    fn prepare(pair: &PairProperties, _: &NormalTraits, _: &[f64]) -> OfPair<f64> {
        OfPair { radius: pair.effective_radius }
    }

    fn stiffness<R: Real>(_: &OfPair<R>, _: &Normal<R>) -> R {
        R::zero()
    }

    fn update<R: Real>(
        _: &OfPair<R>,
        normal: &Normal<R>,
        increment: [R; 2],
        history: &mut [R; MAX_HISTORY],
        _energies: &mut LawEnergies<R>,
    ) -> Tangential<R> {
        let mut force = [0.0; FORCE];
        if normal.touching.any() {
            let mut numbers = history.map(Real::reduce_max);
            let (before, kept) = numbers.split_at_mut(FORCE);
            let before = [before[0], before[1]];
            let slip = increment.map(Real::reduce_max);
            let (load, radius) = (normal.force.reduce_max(), normal.radius.reduce_max());
            let held = kept.to_vec();
            let answer = call(
                "tangential",
                |functions| functions.tangential.as_ref(),
                |py| (before, slip, load, radius, held).into_pyobject(py),
                kept,
            );
            force = answer.force;
            for (to, number) in history.iter_mut().zip(force.iter().chain(&*kept)) {
                *to = R::splat(*number);
            }
        }
        Tangential {
            force: force.map(R::splat),
            stiffness: R::zero(),
            root_stiffness: R::zero(),
            sliding: R::Mask::splat(false),
            friction_loss: R::zero(),
            micro_slip_loss: R::zero(),
            discards: R::Mask::splat(false),
        }
    }
}
