//! The curves of a laboratory, and runs over them.

use std::path::PathBuf;

use granum_core::{Column, Table};
use granum_io::{Conventions, LaboratoryTest, read_laboratory};
use granum_report::comparison::{ComparedRun, Errors, errors, figure, residuals};
use granum_run::record::read_record;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyMapping};

use crate::detached::detached;
use crate::errors as exceptions;
use crate::results::Place;
use crate::run::Run;
use crate::table::{self, Table as PyTable};
use crate::watch;

/// Columns of the curves of a laboratory.
const CURVES: [(&str, &str); 5] = [
    ("axial_strain", ""),
    ("volumetric_strain", ""),
    ("deviator_stress", "Pa"),
    ("mean_stress", "Pa"),
    ("void_ratio", ""),
];

/// The curves of a test as a table, without those that it does not have.
fn curves_table(py: Python<'_>, test: &LaboratoryTest) -> PyResult<Table> {
    let values = [
        &test.axial_strain,
        &test.volumetric_strain,
        &test.deviator_stress,
        &test.mean_stress,
        &test.void_ratio,
    ];
    let each = CURVES.iter().zip(values).filter(|(_, values)| !values.is_empty());
    let columns = each.map(|((name, unit), values)| Column::new(*name, *unit, values.clone())).collect();
    Table::new(columns).map_err(|error| exceptions::general(py, error.to_string()))
}

/// The curves of a table.
fn test_of(name: &str, table: &Table) -> LaboratoryTest {
    let values = |name: &str| table.values(name).map(<[f64]>::to_vec).unwrap_or_default();
    LaboratoryTest {
        name: name.to_string(),
        axial_strain: values("axial_strain"),
        volumetric_strain: values("volumetric_strain"),
        deviator_stress: values("deviator_stress"),
        mean_stress: values("mean_stress"),
        void_ratio: values("void_ratio"),
        ..LaboratoryTest::default()
    }
}

/// The tests of a laboratory's file by name: `axial_strain`, `volumetric_strain`, `deviator_stress`, `mean_stress`, `void_ratio`.
///
/// They are in SI units, compression positive, with engineering strains. `columns` maps known quantities to the columns that hold them:
/// `{"axial_strain": "eps1 (%)"}`. `conventions` are those that comments of the file may state: `compression="negative"`,
/// `strain="logarithmic"`, `stress="total"`, `deviator_stress="half"`, `bedding_strain="0.3 %"`.
#[pyfunction]
#[pyo3(signature = (path, *, columns=None, **conventions))]
pub fn laboratory<'py>(
    py: Python<'py>,
    path: PathBuf,
    columns: Option<&Bound<'py, PyMapping>>,
    conventions: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut stated = Conventions::default();
    for (key, value) in conventions.into_iter().flatten() {
        let (key, value): (String, String) = (key.extract()?, value.str()?.extract()?);
        stated.state(&key, &value).map_err(|why| exceptions::of_value(py, &key, &value, why))?;
    }
    if let Some(columns) = columns {
        stated.columns = columns.items()?.iter().map(|item| item.extract()).collect::<PyResult<_>>()?;
    }
    let tests = detached(py, || read_laboratory(&path, &stated))?;
    let tests = tests.map_err(|error| exceptions::of_file(py, &error, false))?;
    let doubts: Vec<String> =
        tests.iter().flat_map(|test| &test.doubts).map(|doubt| doubt.to_string()).collect();
    watch::warn(py, &doubts)?;
    let found = PyDict::new(py);
    for test in &tests {
        found.set_item(&test.name, table::object(py, curves_table(py, test)?)?)?;
    }
    Ok(found)
}

/// Runs over the curves of a laboratory, or over each other: `granum.compare` makes it. A notebook shows its figure.
#[pyclass(frozen, module = "granum")]
pub struct Comparison {
    runs: Vec<ComparedRun>,
    tests: Vec<LaboratoryTest>,
}

fn compared(name: &str, place: &Place) -> granum_io::Result<ComparedRun> {
    let (case, about, record) = match place {
        Place::Memory { case, result } => ((**case).clone(), result.about.clone(), result.record.clone()),
        Place::Folder { run, .. } => {
            let run = run.now();
            (run.case()?, run.record()?, read_record(&run)?)
        }
    };
    let measures = granum_run::strength::of_run(&case, &about, &record);
    Ok(ComparedRun { measures, ..ComparedRun::from_record(name, &record, &case.test_stages()) })
}

#[pymethods]
impl Comparison {
    /// `runs` and `tests` are mappings of names to runs and to tables.
    #[new]
    fn new(
        py: Python<'_>,
        runs: &Bound<'_, PyMapping>,
        tests: &Bound<'_, PyMapping>,
    ) -> PyResult<Comparison> {
        let mut all = Vec::new();
        for item in runs.items()?.iter() {
            let (name, run): (String, Bound<'_, Run>) = item.extract()?;
            let place = run.get().place.clone();
            let one = detached(py, || compared(&name, &place))?;
            all.push(one.map_err(|error| exceptions::of_file(py, &error, false))?);
        }
        let mut tables = Vec::new();
        for item in tests.items()?.iter() {
            let (name, table): (String, Bound<'_, PyTable>) = item.extract()?;
            let test = test_of(&name, &table.get().copied());
            if test.axial_strain.is_empty() {
                return Err(exceptions::of_value(
                    py,
                    &name,
                    "",
                    "the curves of a laboratory need a column axial_strain",
                ));
            }
            tables.push(test);
        }
        Ok(Comparison { runs: all, tests: tables })
    }

    /// The curves of each run in the measures of the laboratory: engineering strains, compression positive.
    #[getter]
    fn runs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        for run in &self.runs {
            found.set_item(&run.name, table::object(py, curves_table(py, &run.curves)?)?)?;
        }
        Ok(found)
    }

    /// The curves of each test of the laboratory.
    #[getter]
    fn tests<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        for test in &self.tests {
            found.set_item(&test.name, table::object(py, curves_table(py, test)?)?)?;
        }
        Ok(found)
    }

    /// The errors of each `run` against each `test`, or of the other runs against the first, `up_to` the largest axial strain that both
    /// have: root mean square of the `deviator_stress` over its largest value, of `volumetric_strain` and `void_ratio`, and the largest
    /// deviator stress over that of the test, minus one (`peak`).
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        for (run, test) in self.pairs() {
            let Errors { up_to, deviator_stress, peak, volumetric_strain, void_ratio } = errors(run, test);
            let found = PyDict::new(py);
            found.set_item("run", &run.name)?;
            found.set_item("test", &test.name)?;
            found.set_item("up_to", up_to)?;
            for (name, value) in [
                ("deviator_stress", deviator_stress),
                ("peak", peak),
                ("volumetric_strain", volumetric_strain),
                ("void_ratio", void_ratio),
            ] {
                found.set_item(name, value)?;
            }
            list.append(found)?;
        }
        Ok(list)
    }

    /// What the runs have more than the tests, reading by reading.
    #[getter]
    fn residuals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let found = residuals(&self.pairs()).map_err(|error| exceptions::general(py, error.to_string()))?;
        table::object(py, found)
    }

    /// The figure, as the program draws it.
    #[getter]
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || figure(&self.runs, &self.tests, &self.pairs(), &[]).0.to_svg())
    }

    fn _repr_svg_(&self, py: Python<'_>) -> PyResult<String> {
        self.svg(py)
    }

    fn __repr__(&self) -> String {
        format!("<granum.Comparison of {} runs with {} tests>", self.runs.len(), self.tests.len())
    }
}

impl Comparison {
    fn pairs(&self) -> Vec<(&ComparedRun, &LaboratoryTest)> {
        if self.tests.is_empty() {
            let Some((first, others)) = self.runs.split_first() else { return Vec::new() };
            return others.iter().map(|run| (run, &first.curves)).collect();
        }
        self.runs.iter().flat_map(|run| self.tests.iter().map(move |test| (run, test))).collect()
    }
}
