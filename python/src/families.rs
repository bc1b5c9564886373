//! Families of tests whose surrogates come with granum.

use std::path::PathBuf;
use std::sync::Arc;

use granum::families::{FITTED, fitted};
use granum_core::quantity::Dimension;
use granum_learn::family::{FamilyModel, InputSource, by_name};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyMapping};

use crate::arrays;
use crate::detached::detached;
use crate::errors;
use crate::quantity;

/// A family of tests with its fitted surrogate.
#[pyclass(frozen, module = "granum.surrogates")]
pub struct Family {
    model: Arc<FamilyModel>,
}

/// The names and paths of the families whose surrogates come with granum.
#[pyfunction]
pub fn families() -> Vec<(&'static str, &'static str)> {
    FITTED.iter().map(|family| (family.name, family.path)).collect()
}

#[pymethods]
impl Family {
    /// The family of that name, along a path.
    #[new]
    #[pyo3(signature = (name, path=None))]
    fn new(py: Python<'_>, name: &str, path: Option<&str>) -> PyResult<Family> {
        let failed = |error: granum_learn::LearnError| errors::general(py, error.to_string());
        let definition = by_name(name, path).map_err(failed)?;
        let Some(model) = detached(py, || fitted(definition))?.map_err(failed)? else {
            let known: Vec<String> =
                families().iter().map(|(name, path)| format!("{name} ({path})")).collect();
            let message = format!(
                "the family {name} along the path {} comes without a surrogate; there is {}",
                definition.path,
                known.join(", ")
            );
            return Err(errors::general(py, message));
        };
        Ok(Family { model: Arc::new(model) })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &'static str {
        self.model.definition().name
    }

    /// The path of its tests.
    #[getter]
    fn path(&self) -> &'static str {
        self.model.definition().path
    }

    /// What it is of.
    #[getter]
    fn title(&self) -> &'static str {
        self.model.definition().title
    }

    /// Number of the runs to which it was fitted.
    #[getter]
    fn runs(&self) -> usize {
        self.model.runs()
    }

    /// The inputs by name: `meaning`, whether it is `required`, and the `range` of the runs.
    #[getter]
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let inputs = PyDict::new(py);
        for (input, range) in self.model.definition().inputs.iter().zip(self.model.ranges()) {
            let about = PyDict::new(py);
            about.set_item("meaning", input.meaning)?;
            about.set_item("required", input.is_required)?;
            about.set_item("range", (range[0], range[1]))?;
            inputs.set_item(input.name, about)?;
        }
        Ok(inputs)
    }

    /// What it cannot answer.
    #[getter]
    fn limits(&self) -> Vec<&'static str> {
        self.model.definition().limits.to_vec()
    }

    /// Writes it as an ONNX file, which other programs evaluate without granum. The inputs are the coordinate and all inputs of the family, each of
    /// which must be given, and the outputs those of `Surrogate.export_onnx`: they are what `predict` says of such inputs at a point of the coordinate.
    #[pyo3(signature = (path, *, level=0.9, force=false))]
    fn export_onnx(&self, py: Python<'_>, path: PathBuf, level: f64, force: bool) -> PyResult<()> {
        let model = self.model.clone();
        let written = detached(py, move || -> granum_learn::Result<()> {
            granum_io::check_output_file(&path, force)?;
            granum_learn::onnx::save_family(&path, &model, level)
        })?;
        written.map_err(|error| errors::of_learning(py, &error))
    }

    /// Predicts the curves of a test. Properties of the grains that are not given are integrated over their ranges; what is not given of the sample
    /// has typical values, whose uncertainty widens the intervals.
    ///
    /// The answer has `coordinate` and its `points`; `curves`, which has for each output its `mean` and the ends `lower` and `upper` of the
    /// interval of the given `level`; the `inputs` that were given, the `typical_inputs`, the ranges of the `integrated_inputs`, and the names of
    /// those `outside` the range of the runs; and as `unseen_combination` the names of two inputs that the runs do not have together, or `None`.
    #[pyo3(signature = (inputs, *, level=0.9))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        inputs: &Bound<'py, PyMapping>,
        level: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let definition = self.model.definition();
        let mut given = vec![None; definition.inputs.len()];
        for item in inputs.items()?.iter() {
            let (name, value): (String, Bound<PyAny>) = item.extract()?;
            let place = definition
                .input(&name)
                .map_err(|error| errors::of_value(py, &name, value.to_string(), error.to_string()))?;
            given[place] = Some(quantity::in_si(&name, &value, Dimension::NUMBER)?);
        }
        let model = self.model.clone();
        let found = detached(py, move || model.predict(&given, level))?;
        let found = found.map_err(|error| errors::general(py, error.to_string()))?;
        let answer = PyDict::new(py);
        let used = PyDict::new(py);
        let typical = PyDict::new(py);
        let integrated = PyDict::new(py);
        for input in &found.inputs {
            match input.source {
                InputSource::Given => used.set_item(&input.name, input.value)?,
                InputSource::Typical(_) => typical.set_item(&input.name, input.value)?,
                InputSource::Integrated([low, high]) => integrated.set_item(&input.name, (low, high))?,
            }
        }
        answer.set_item("inputs", used)?;
        answer.set_item("typical_inputs", typical)?;
        answer.set_item("integrated_inputs", integrated)?;
        let outside = found.outside.iter().map(|outside| outside.name.clone()).collect::<Vec<String>>();
        answer.set_item("outside", PyList::new(py, outside)?)?;
        let combination = found.combination.map(|found| found.inputs.map(|(name, _)| name).to_vec());
        answer.set_item("unseen_combination", combination)?;
        answer.set_item("level", found.level)?;
        let rows = found.points.len();
        answer.set_item("coordinate", definition.coordinate)?;
        answer.set_item("points", arrays::reals(py, found.points, vec![rows])?)?;
        let curves = PyDict::new(py);
        for curve in found.curves {
            let of_curve = PyDict::new(py);
            let parts = [("mean", curve.mean), ("lower", curve.lower), ("upper", curve.upper)];
            for (name, values) in parts {
                let rows = values.len();
                of_curve.set_item(name, arrays::reals(py, values, vec![rows])?)?;
            }
            curves.set_item(curve.column, of_curve)?;
        }
        answer.set_item("curves", curves)?;
        Ok(answer)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (&'static str, &'static str)) {
        (slf.get_type().into_any(), (slf.get().name(), slf.get().path()))
    }

    /// What a notebook shows.
    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        slf.py().import("granum._plots")?.call_method1("of_family", (slf,))?.extract()
    }

    fn __repr__(&self) -> String {
        format!("granum.surrogates.load({:?}, {:?})", self.name(), self.path())
    }
}
