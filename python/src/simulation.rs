//! Simulations that are advanced by hand.

use std::sync::{Arc, Mutex};

use granum_core::quantity::Dimension;
use granum_dem::servo::{COMPONENTS, CellControl, PLACES, Row};
use granum_dem::simulation::Simulation as Engine;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};

use crate::arrays::{self, Array};
use crate::assembly::{Assembly, matrix};
use crate::detached::detached;
use crate::errors;
use crate::quantity;

/// Number of grains times steps after which Python is asked for Ctrl-C.
const ASK_EVERY: u64 = 2_000_000;

/// Usual bound on the rate that the servo adds, 1/s.
const RATE_LIMIT: f64 = 1.0;

/// A simulation that is advanced by hand: `run.simulation()` gives the state at the end of a run. A copy (`copy.copy`) goes its own way.
#[pyclass(frozen, module = "granum")]
pub struct Simulation {
    /// Nothing while a thread advances it, and after a mistake of granum had left it half-advanced.
    /// It has a place of its own, since Python aligns its objects to sixteen bytes only, and the engine needs more.
    inner: Mutex<Option<Box<Engine>>>,
}

impl Simulation {
    pub fn new(simulation: Engine) -> Simulation {
        Simulation { inner: Mutex::new(Some(Box::new(simulation))) }
    }

    fn slot(&self) -> std::sync::MutexGuard<'_, Option<Box<Engine>>> {
        self.inner.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// A copy of the simulation.
    pub fn copied(&self, py: Python<'_>) -> PyResult<Engine> {
        self.see_detached(py, Engine::clone)
    }

    /// The simulation itself, which is then absent.
    pub fn taken(&self) -> Option<Box<Engine>> {
        self.slot().take()
    }

    /// Looks at the simulation. Nothing of Python is called while it is locked: another thread of Python could then wait for the lock
    /// while it holds the interpreter.
    fn see<T>(&self, py: Python<'_>, look: impl FnOnce(&Engine) -> T) -> PyResult<T> {
        let found = self.look(look);
        found.ok_or_else(|| absent(py))
    }

    fn look<T>(&self, look: impl FnOnce(&Engine) -> T) -> Option<T> {
        let slot = self.slot();
        slot.as_deref().map(look)
    }

    /// All grains and contacts as they are now.
    pub fn observed(&self, py: Python<'_>) -> PyResult<Arc<granum_core::Assembly>> {
        self.see_detached(py, Engine::assembly).map(Arc::new)
    }

    /// As [`Simulation::see`] for what takes long, while other threads of Python go on.
    fn see_detached<T: Send>(&self, py: Python<'_>, look: impl FnOnce(&Engine) -> T + Send) -> PyResult<T> {
        detached(py, || self.look(look))?.ok_or_else(|| absent(py))
    }
}

fn absent(py: Python<'_>) -> PyErr {
    errors::of_running(
        py,
        "the simulation is being advanced by another thread, or was lost in a mistake of granum",
    )
}

/// The entries of a mapping.
fn entries<'py>(mapping: Option<&Bound<'py, PyMapping>>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let Some(mapping) = mapping else { return Ok(Vec::new()) };
    mapping.items()?.iter().map(|item| item.extract()).collect()
}

/// The place of a component of stress or strain rate.
fn component(py: Python<'_>, name: &str) -> PyResult<usize> {
    COMPONENTS.iter().position(|known| *known == name).ok_or_else(|| {
        let message = format!("there is no component {name:?}; there are {}", COMPONENTS.join(", "));
        errors::of_value(py, "component", name, message)
    })
}

#[pymethods]
impl Simulation {
    /// Makes so many time steps. Other threads of Python go on meanwhile, and Ctrl-C ends it after a whole step.
    fn advance(&self, py: Python<'_>, steps: &Bound<'_, PyAny>) -> PyResult<()> {
        let steps = quantity::whole("steps", steps, 0, u64::MAX)?;
        let mut simulation = self.taken().ok_or_else(|| absent(py))?;
        let mut left = steps;
        // At least one call, so that no steps are no error.
        let result = loop {
            let grains = simulation.state().grains().max(1) as u64;
            let part = left.min((ASK_EVERY / grains).max(1));
            // A panic drops the simulation, which would be half-advanced.
            let (back, done) = detached(py, move || {
                let done = simulation.advance(part);
                (simulation, done)
            })?;
            simulation = back;
            left -= part;
            if let Err(error) = done {
                break Err(errors::of_running(py, &error.to_string()));
            }
            if let Err(signal) = py.check_signals() {
                break Err(signal);
            }
            if left == 0 {
                break Ok(());
            }
        };
        *self.slot() = Some(simulation);
        result
    }

    /// Lets a function steer: it is called with the simulation at once and after every so many steps (`every`, the control interval),
    /// and returns the arguments of `control` as a dict, or `None` at the end of the path. Returns the number of steps.
    ///
    /// `recorder` records the first state and that after every `states_every` intervals. At most `most_steps` steps are made. What the
    /// function raises ends the path; the simulation is then at the end of an interval.
    #[pyo3(signature = (path, *, every, recorder=None, states_every=1, most_steps=None))]
    fn follow<'py>(
        slf: &Bound<'py, Self>,
        path: &Bound<'py, PyAny>,
        every: &Bound<'py, PyAny>,
        recorder: Option<&Bound<'py, PyAny>>,
        states_every: u64,
        most_steps: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<u64> {
        let interval = quantity::whole("every", every, 1, u64::MAX)?;
        let most =
            most_steps.map_or(Ok(u64::MAX), |steps| quantity::whole("most_steps", steps, 0, u64::MAX))?;
        let record = |number: u64| match recorder {
            Some(recorder) if number.is_multiple_of(states_every.max(1)) => {
                recorder.call_method1("record", (slf,)).map(drop)
            }
            _ => Ok(()),
        };
        let (mut done, mut number) = (0, 0);
        record(number)?;
        while done < most {
            let control = path.call1((slf,))?;
            if control.is_none() {
                break;
            }
            let Ok(control) = control.cast::<PyDict>() else {
                let kind = control.get_type().name()?;
                let message = format!(
                    "a path returns a dict with the arguments of control, or None at its end, not {kind}"
                );
                return Err(pyo3::exceptions::PyTypeError::new_err(message));
            };
            slf.call_method("control", (), Some(control))?;
            let steps = interval.min(most - done);
            slf.call_method1("advance", (steps,))?;
            (done, number) = (done + steps, number + 1);
            record(number)?;
        }
        Ok(done)
    }

    /// Controls the cell from here on. Components are `xx`, `yy`, `zz`, `yz`, `zx`, `xy`; what is not given is fixed.
    ///
    /// `strain_rate` are rates of strain in 1/s, compression positive, shear strains as angles. `stress` are stresses in Pa that a servo
    /// holds; `mean_stress`, Pa, is held by the axes that have neither. `rate_limit` bounds the rate, by default 1 1/s, that the servo
    /// adds. Each may have a unit, as in a case. A stress that was held by the same strain rates before is held on without a jump, also if
    /// its value changes: the servo does not begin anew.
    #[pyo3(signature = (*, strain_rate=None, stress=None, mean_stress=None, rate_limit=None))]
    fn control(
        &self,
        py: Python<'_>,
        strain_rate: Option<&Bound<'_, PyMapping>>,
        stress: Option<&Bound<'_, PyMapping>>,
        mean_stress: Option<&Bound<'_, PyAny>>,
        rate_limit: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let rate = |value: &Bound<'_, PyAny>| quantity::in_si("rate_limit", value, Dimension::RATE);
        let rate_limit = rate_limit.map_or(Ok(RATE_LIMIT), rate)?;
        if rate_limit < 0.0 {
            return Err(errors::of_value(py, "rate_limit", rate_limit.to_string(), "is less than 0"));
        }
        let mut control = CellControl { rate_limit, ..CellControl::fixed() };
        let mut strained = [false; 6];
        for (name, value) in entries(strain_rate)? {
            let k = component(py, &name)?;
            let [row, column] = PLACES[k];
            let rate = quantity::in_si(COMPONENTS[k], &value, Dimension::RATE)?;
            // The rate of a shear strain is that of an angle, the sum of two entries.
            let entry = if k < 3 { rate } else { 0.5 * rate };
            (control.rate[row][column], control.rate[column][row]) = (entry, entry);
            strained[k] = true;
        }
        let mut rows = Vec::new();
        for (name, value) in entries(stress)? {
            let k = component(py, &name)?;
            if strained[k] {
                let message = "a component has a strain rate or a stress, not both";
                return Err(errors::of_value(py, COMPONENTS[k], value.to_string(), message));
            }
            strained[k] = true;
            rows.push(Row::component(k, quantity::in_si(COMPONENTS[k], &value, Dimension::STRESS)?));
        }
        if let Some(target) = mean_stress {
            let target = quantity::in_si("mean_stress", target, Dimension::STRESS)?;
            let free = [0, 1, 2].map(|axis| !strained[axis]);
            if !free.contains(&true) {
                let message = "a mean stress needs an axis that has neither a strain rate nor a stress";
                return Err(errors::of_value(py, "mean_stress", target.to_string(), message));
            }
            rows.push(Row::mean(target, free));
        }
        for (slot, row) in control.rows.iter_mut().zip(rows) {
            *slot = Some(row);
        }
        let mut set = || {
            let mut slot = self.slot();
            let simulation = slot.as_mut()?;
            control.since = simulation.state().time();
            simulation.change_control(control);
            Some(())
        };
        let is_set = set();
        is_set.ok_or_else(|| absent(py))
    }

    /// All grains and contacts as they are now: a copy, which shows no later step.
    fn assembly(&self, py: Python<'_>) -> PyResult<Assembly> {
        self.observed(py).map(Assembly::shared)
    }

    /// What the contact laws keep of each contact, in the order of the contacts of `assembly()`, as copies.
    ///
    /// `tangential_vectors` (contacts, vectors, 3) are vectors in the plane of contact on the first grain, the first of which is the
    /// tangential force, N; `tangential_scalars` (contacts, scalars) what else that law keeps. `normal_scalars`, `rolling_vectors`,
    /// `rolling_scalars` and `adhesion_scalars` are those of the other laws. What no law keeps is left out. Units are those of the law.
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let history = self.see_detached(py, Engine::contact_history)?;
        let contacts = history.contacts;
        let found = PyDict::new(py);
        for (name, law) in [
            ("normal", history.normal),
            ("tangential", history.tangential),
            ("rolling", history.moments),
            ("adhesion", history.adhesion),
        ] {
            if law.vectors_kept > 0 {
                let shape = vec![contacts, law.vectors_kept, 3];
                found.set_item(format!("{name}_vectors"), arrays::reals(py, law.vectors.concat(), shape)?)?;
            }
            if law.scalars_kept > 0 {
                let shape = vec![contacts, law.scalars_kept];
                found.set_item(format!("{name}_scalars"), arrays::reals(py, law.scalars, shape)?)?;
            }
        }
        Ok(found)
    }

    fn __copy__(&self, py: Python<'_>) -> PyResult<Simulation> {
        self.see_detached(py, Engine::clone).map(Simulation::new)
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> PyResult<Simulation> {
        self.__copy__(py)
    }

    fn __reduce__(&self) -> PyResult<()> {
        let message = "a simulation cannot be pickled; pickle the run in a folder from which it comes";
        Err(pyo3::exceptions::PyTypeError::new_err(message))
    }

    /// Time since the start of the phase, s.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.see(py, |simulation| simulation.state().time())
    }

    /// Steps since the start of the phase.
    #[getter]
    fn step(&self, py: Python<'_>) -> PyResult<u64> {
        self.see(py, |simulation| simulation.state().step())
    }

    /// Time step, s.
    #[getter]
    fn time_step(&self, py: Python<'_>) -> PyResult<f64> {
        self.see(py, |simulation| simulation.state().time_step())
    }

    /// Number of grains.
    #[getter]
    fn grains(&self, py: Python<'_>) -> PyResult<usize> {
        self.see(py, |simulation| simulation.state().grains())
    }

    /// Number of contacts.
    #[getter]
    fn contacts(&self, py: Python<'_>) -> PyResult<usize> {
        self.see(py, |simulation| simulation.state().contacts())
    }

    /// Mean stress, Pa.
    #[getter]
    fn mean_stress(&self, py: Python<'_>) -> PyResult<f64> {
        self.see(py, |simulation| simulation.state().mean_stress())
    }

    /// Volume of the grains over that of the cell.
    #[getter]
    fn solid_fraction(&self, py: Python<'_>) -> PyResult<f64> {
        self.see(py, |simulation| simulation.state().solid_fraction())
    }

    /// Mean resultant force on a grain over the mean contact force.
    #[getter]
    fn unbalanced_force(&self, py: Python<'_>) -> PyResult<f64> {
        self.see(py, |simulation| simulation.state().unbalanced_force())
    }

    /// Stress, Pa, compression positive.
    #[getter]
    fn stress<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let stress = self.see(py, |simulation| simulation.state().stress())?;
        matrix(py, &stress)
    }

    /// Logarithmic strain since the start of the phase, compression positive.
    #[getter]
    fn strain<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let strain = self.see(py, |simulation| simulation.state().strain())?;
        matrix(py, &strain)
    }

    /// Matrix of the periodic cell, whose columns are its edges, m.
    #[getter]
    fn cell<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let edges = self.see(py, |simulation| simulation.state().cell().edges)?;
        matrix(py, &edges)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        self.see(py, |simulation| {
            let state = simulation.state();
            format!("<granum.Simulation of {} grains at step {}>", state.grains(), state.step())
        })
    }
}
