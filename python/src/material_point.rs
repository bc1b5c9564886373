//! Material points: samples that a program strains step by step, whose states are values.

use std::collections::BTreeMap;
use std::sync::Arc;

use granum_core::geometry::Matrix;
use granum_core::quantity::Dimension;
use granum_dem::servo::{PLACES, component};
use granum_point::{BeyondLargest, Controls, Increment, PointError, State, Tangent, Trust};
use granum_sensors::Sensors;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};

use crate::arrays::{self, Array};
use crate::assembly::answer;
use crate::detached::detached;
use crate::errors;
use crate::quantity;
use crate::simulation::Simulation;
use crate::surrogate::Surrogate;
use crate::table::Table;

/// A sample that is strained step by step: it answers with stress, stiffness and sensors. Its states are values: the same strain from the
/// same state gives the same bits, and a state is never changed.
///
/// `sample` is a simulation, as `granum.prepare(case).simulation()` gives one; it is copied. `inertial_number` is that of the straining,
/// `relaxation` the number of steps for which the cell is held after an increment, over the last `averaging` of which the stress is a mean.
/// An increment larger than `largest_increment`, `sqrt(2/3 e:e)`, is divided, or refused with `refuse_larger`. With `from_surrogate` a surrogate
/// stands in place of the grains.
#[pyclass(frozen, module = "granum")]
pub struct MaterialPoint {
    inner: granum_point::MaterialPoint,
}

/// A state of a material point. It is never changed.
#[pyclass(frozen, module = "granum")]
pub struct PointState {
    inner: State,
}

/// Reasons of a point as exceptions: arguments as those of a case, everything else as a run that fails.
fn raised(py: Python<'_>, error: &PointError) -> PyErr {
    match error {
        PointError::Control { name, value, .. } => {
            errors::of_value(py, name, value.to_string(), error.to_string())
        }
        PointError::NotFinite { .. } | PointError::Rotation { .. } | PointError::Deformation { .. } => {
            errors::of_value(py, "increment", "", error.to_string())
        }
        PointError::NoMaterial { method, .. } => errors::of_value(py, "surrogate", method, error.to_string()),
        _ => errors::of_running(py, &error.to_string()),
    }
}

/// So many numbers of an array.
fn exactly<const N: usize>(name: &str, values: &Bound<'_, PyAny>) -> PyResult<[f64; N]> {
    let (numbers, shape) = arrays::numbers(name, values)?;
    <[f64; N]>::try_from(numbers).map_err(|_| {
        let message = format!("{N} numbers are needed, and the shape is {shape:?}");
        errors::of_value(values.py(), name, format!("{shape:?}"), message)
    })
}

/// The six components of a tensor.
fn six<'py>(py: Python<'py>, tensor: &Matrix) -> PyResult<Array<'py>> {
    arrays::reals(py, (0..6).map(|k| component(tensor, k)).collect(), vec![6])
}

/// A surrogate, or that of a file.
fn surrogate_of(
    py: Python<'_>,
    surrogate: &Bound<'_, PyAny>,
) -> PyResult<Arc<dyn granum_learn::surrogate::Surrogate>> {
    match surrogate.cast::<Surrogate>() {
        Ok(known) => Ok(known.get().shared()),
        Err(_) => Surrogate::of_file(py, surrogate.extract()?),
    }
}

/// Values by their names, in SI units.
fn values_of(sample: Option<&Bound<'_, PyMapping>>) -> PyResult<BTreeMap<String, f64>> {
    let mut values = BTreeMap::new();
    for item in sample.map(|sample| sample.items()).transpose()?.iter().flat_map(|items| items.iter()) {
        let (name, value): (String, Bound<PyAny>) = item.extract()?;
        let value = quantity::in_si(&name, &value, Dimension::NUMBER)?;
        values.insert(name, value);
    }
    Ok(values)
}

#[pymethods]
impl MaterialPoint {
    #[new]
    #[pyo3(signature = (sample, *, inertial_number=None, relaxation=None, averaging=None, largest_increment=None, refuse_larger=false))]
    fn new(
        py: Python<'_>,
        sample: &Simulation,
        inertial_number: Option<f64>,
        relaxation: Option<u64>,
        averaging: Option<u64>,
        largest_increment: Option<f64>,
        refuse_larger: bool,
    ) -> PyResult<MaterialPoint> {
        let simulation = sample.copied(py)?;
        let controls = Controls::default().with(|controls| {
            controls.inertial_number = inertial_number.unwrap_or(controls.inertial_number);
            controls.relaxation = relaxation.unwrap_or(controls.relaxation);
            controls.averaging = averaging.unwrap_or(controls.averaging.min(controls.relaxation));
            controls.largest_increment = largest_increment.unwrap_or(controls.largest_increment);
            if refuse_larger {
                controls.beyond_largest = BeyondLargest::Refuse;
            }
        });
        let made = detached(py, || granum_point::MaterialPoint::new(simulation, controls))?;
        Ok(MaterialPoint { inner: made.map_err(|error| raised(py, &error))? })
    }

    /// A point whose stress a surrogate predicts in place of grains, for example one of the methods `path-...`. `surrogate` is one, or the file of one.
    ///
    /// Its inputs are the six logarithmic strains since the start (`axial_strain`, `lateral_strain_2`, `lateral_strain_3`, `shear_strain_yz`,
    /// `shear_strain_zx`, `shear_strain_xy`), and `sample` has the values of its other inputs by name, in SI units. Its outputs are the six stresses
    /// (`stress_11`, `stress_22`, `stress_33`, `stress_23`, `stress_13`, `stress_12`), Pa, and any others but `volumetric_strain`, which a point prescribes
    /// (`PointState.value`). It needs a memory.
    ///
    /// The answer depends on how a path is cut: increments should be about as long as those between the training states. `largest_increment` and
    /// `refuse_larger` are as for a sample. `granum.CaseError` says what a surrogate or a sample lacks.
    #[staticmethod]
    #[pyo3(signature = (surrogate, sample=None, *, largest_increment=None, refuse_larger=false))]
    fn from_surrogate(
        py: Python<'_>,
        surrogate: &Bound<'_, PyAny>,
        sample: Option<&Bound<'_, PyMapping>>,
        largest_increment: Option<f64>,
        refuse_larger: bool,
    ) -> PyResult<MaterialPoint> {
        let surrogate = surrogate_of(py, surrogate)?;
        let values = values_of(sample)?;
        let controls = Controls::default().with(|controls| {
            controls.largest_increment = largest_increment.unwrap_or(controls.largest_increment);
            if refuse_larger {
                controls.beyond_largest = BeyondLargest::Refuse;
            }
        });
        let made =
            detached(py, || granum_point::MaterialPoint::from_surrogate(surrogate, &values, controls))?;
        Ok(MaterialPoint { inner: made.map_err(|error| raised(py, &error))? })
    }

    /// A point that a surrogate answers for while it knows, and grains where it does not: where the standard deviation of a stress that it predicts is larger than
    /// `largest_trusted_deviation` of the mean stress, or an input or the path is outside of what it was trained on. The grains of `simulation` then follow the path of
    /// the state from the start on and answer from there; the stress changes by the error that the surrogate had. With `keeps_stress` they are then
    /// brought to the last stress of the surrogate, if they can carry it, so that the stress goes on. `PointState.is_live` tells who answered.
    ///
    /// `surrogate` and `sample` are as for `from_surrogate`; values of inputs `sample.X` that are not given are measured on the simulation, which is copied.
    #[staticmethod]
    #[pyo3(signature = (surrogate, simulation, sample=None, *, largest_trusted_deviation=0.1, keeps_stress=false, inertial_number=None, relaxation=None, averaging=None, largest_increment=None))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
    fn hybrid(
        py: Python<'_>,
        surrogate: &Bound<'_, PyAny>,
        simulation: &Simulation,
        sample: Option<&Bound<'_, PyMapping>>,
        largest_trusted_deviation: f64,
        keeps_stress: bool,
        inertial_number: Option<f64>,
        relaxation: Option<u64>,
        averaging: Option<u64>,
        largest_increment: Option<f64>,
    ) -> PyResult<MaterialPoint> {
        let surrogate = surrogate_of(py, surrogate)?;
        let values = values_of(sample)?;
        let simulation = simulation.copied(py)?;
        let controls = Controls::default().with(|controls| {
            controls.inertial_number = inertial_number.unwrap_or(controls.inertial_number);
            controls.relaxation = relaxation.unwrap_or(controls.relaxation);
            controls.averaging = averaging.unwrap_or(controls.averaging.min(controls.relaxation));
            controls.largest_increment = largest_increment.unwrap_or(controls.largest_increment);
        });
        let trust = Trust { largest_deviation: largest_trusted_deviation, keeps_stress };
        let made = detached(py, || {
            granum_point::MaterialPoint::hybrid(surrogate, &values, simulation, trust, controls)
        })?;
        Ok(MaterialPoint { inner: made.map_err(|error| raised(py, &error))? })
    }

    /// The state of the sample before any increment.
    #[getter]
    fn start(&self) -> PointState {
        PointState { inner: self.inner.start() }
    }

    /// The state after an increment: a logarithmic strain of six components xx, yy, zz, yz, zx, xy, compression positive, shear strains as
    /// angles, after a `rotation` (3 x 3) of the sample, if there is one.
    #[pyo3(signature = (state, strain, *, rotation=None))]
    fn advance(
        &self,
        py: Python<'_>,
        state: &PointState,
        strain: &Bound<'_, PyAny>,
        rotation: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PointState> {
        let mut increment = Increment::from_components(exactly::<6>("strain", strain)?);
        if let Some(rotation) = rotation {
            let flat = exactly::<9>("rotation", rotation)?;
            let matrix: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| flat[3 * r + c]));
            increment = increment.after_rotation(&matrix).map_err(|error| raised(py, &error))?;
        }
        let answer = detached(py, || self.inner.advance(&state.inner, &increment))?;
        Ok(PointState { inner: answer.map_err(|error| raised(py, &error))?.state })
    }

    /// The states after increments of many states, rows of six components of strain, on up to `threads` threads (0: all of the machine),
    /// with the same bits on any number of them.
    #[pyo3(signature = (states, strains, *, threads=0))]
    fn advance_all(
        &self,
        py: Python<'_>,
        states: Vec<PyRef<'_, PointState>>,
        strains: &Bound<'_, PyAny>,
        threads: usize,
    ) -> PyResult<Vec<PointState>> {
        let (numbers, shape) = arrays::numbers("strains", strains)?;
        if shape != [states.len(), 6] {
            let message =
                format!("{} rows of six numbers are needed, and the shape is {shape:?}", states.len());
            return Err(errors::of_value(py, "strains", format!("{shape:?}"), message));
        }
        let rows = numbers.as_chunks::<6>().0;
        let questions: Vec<(State, Increment)> = states
            .iter()
            .zip(rows)
            .map(|(state, row)| (state.inner.clone(), Increment::from_components(*row)))
            .collect();
        let answers = detached(py, || self.inner.advance_all(&questions, threads))?;
        let state = |answer: Result<granum_point::Answer, PointError>| match answer {
            Ok(answer) => Ok(PointState { inner: answer.state }),
            Err(error) => Err(raised(py, &error)),
        };
        answers.into_iter().map(state).collect()
    }

    /// The state brought to a stress, Pa, of six components, compression positive: each is then within a thousandth of the largest.
    fn at_stress(
        &self,
        py: Python<'_>,
        state: &PointState,
        stress: &Bound<'_, PyAny>,
    ) -> PyResult<PointState> {
        let components = exactly::<6>("stress", stress)?;
        let mut tensor = [[0.0; 3]; 3];
        for (value, [r, c]) in components.iter().zip(PLACES) {
            (tensor[r][c], tensor[c][r]) = (*value, *value);
        }
        let answer = detached(py, || self.inner.at_stress(&state.inner, &tensor))?;
        Ok(PointState { inner: answer.map_err(|error| raised(py, &error))?.state })
    }

    /// The stiffness of a state (6 x 6), Pa: `d_sigma_i = C_ij d_eps_j`. `kind` is `affine`, `elastic`, `probes` (differences of answers
    /// to strains of `probe_strain`) or `secant`, as the chapter on finite elements explains.
    #[pyo3(signature = (state, kind="probes", *, probe_strain=1e-5))]
    fn tangent<'py>(
        &self,
        py: Python<'py>,
        state: &PointState,
        kind: &str,
        probe_strain: f64,
    ) -> PyResult<Array<'py>> {
        let tangent = match kind {
            "affine" => Tangent::Affine,
            "elastic" => Tangent::Elastic,
            "probes" => Tangent::Probes { strain: probe_strain },
            "secant" => Tangent::Secant,
            _ => {
                let message =
                    format!("there is no stiffness {kind:?}; there are affine, elastic, probes, secant");
                return Err(errors::of_value(py, "kind", kind, message));
            }
        };
        let found = detached(py, || self.inner.tangent(&state.inner, tangent))?;
        let tensor = found.map_err(|error| raised(py, &error))?;
        arrays::reals(py, tensor.0.concat(), vec![6, 6])
    }
}

#[pymethods]
impl PointState {
    /// Stress, Pa: xx, yy, zz, yz, zx, xy, compression positive.
    #[getter]
    fn stress<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        six(py, &self.inner.stress())
    }

    /// Standard deviation of the stress over the steps of its mean, Pa, by the same components, in the axes of the cell; that of a surrogate is that
    /// of its prediction for a new sample, zero if it does not know it.
    #[getter]
    fn noise<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        six(py, self.inner.noise())
    }

    /// Mean stress, Pa.
    #[getter]
    fn mean_stress(&self) -> f64 {
        self.inner.mean_stress()
    }

    /// Volume of the voids over that of the grains; `None` for a surrogate that neither predicts it nor has it as an input.
    #[getter]
    fn void_ratio(&self) -> Option<f64> {
        self.inner.void_ratio()
    }

    /// A whole number that stands for sample, controls and path; it is the same in every process.
    #[getter]
    fn ticket(&self) -> u64 {
        self.inner.identity().ticket()
    }

    /// True if grains are behind the state, and not a surrogate.
    #[getter]
    fn is_live(&self) -> bool {
        self.inner.is_live()
    }

    /// The path that led to this state of a hybrid point from its start, as a table: the six strains and the six stresses, a row for each part that was carried out. Where the
    /// state is live all stresses are those of the grains, so that it is a test from which a surrogate can learn. `None` for other points.
    fn path(&self, start: &PointState) -> Option<Table> {
        self.inner.path(&start.inner).map(Table::from)
    }

    /// What is outside of what a surrogate was trained on, and then not to be trusted: names of inputs, and the length and the turns of the path.
    /// Nothing for grains.
    #[getter]
    fn outside(&self) -> Vec<String> {
        self.inner.outside().iter().map(|outside| outside.name.clone()).collect()
    }

    /// The value of a column: a sensor of the grains, or an output of a surrogate; `None` if there is none of that name.
    fn value(&self, py: Python<'_>, column: &str) -> PyResult<Option<f64>> {
        detached(py, || self.inner.value(column, &Sensors::standard()))
    }

    /// The values of every sensor of one state, by column. `granum.RunError` for a surrogate, which has no grains.
    fn measure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let measured = detached(py, || self.inner.measure(&Sensors::standard()))?;
        let measured = measured.ok_or_else(|| errors::of_running(py, "this state has no grains"))?;
        answer(py, &measured)
    }
}
