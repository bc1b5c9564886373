//! Assemblies: all grains and contacts at one moment, as arrays; and their measurement by every sensor.

use std::mem::offset_of;
use std::path::PathBuf;
use std::sync::Arc;

use granum_core::assembly::{Contact, Grain, Matrix, Vector};
use granum_core::{Part, Parts};
use granum_io::formats::join::join;
use granum_io::formats::{FileContact, Frame, FrameCell, JoinOptions};
use granum_io::snapshot::{contacts_table, grains_table};
use granum_sensors::force_chains::Chains;
use granum_sensors::{Measurement, Observation, Sensors};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{self, Array, Field, FieldKind, Records};
use crate::detached::detached;
use crate::errors;
use crate::table;

/// All grains and contacts at one moment.
#[pyclass(frozen, module = "granum")]
pub struct Assembly {
    inner: Arc<granum_core::Assembly>,
}

impl From<granum_core::Assembly> for Assembly {
    fn from(assembly: granum_core::Assembly) -> Assembly {
        Assembly { inner: Arc::new(assembly) }
    }
}

impl Assembly {
    /// An assembly that others hold as well.
    pub fn shared(inner: Arc<granum_core::Assembly>) -> Assembly {
        Assembly { inner }
    }

    /// What it holds.
    pub fn inner(&self) -> Arc<granum_core::Assembly> {
        self.inner.clone()
    }

    fn field<'py>(
        &self,
        py: Python<'py>,
        of: Records,
        kind: FieldKind,
        offset: usize,
    ) -> PyResult<Array<'py>> {
        arrays::field(py, self.inner.clone(), Field { of, offset, kind })
    }

    /// A number of each grain.
    fn of_grains<'py>(&self, py: Python<'py>, offset: usize) -> PyResult<Array<'py>> {
        self.field(py, Records::Grains, FieldKind::Real, offset)
    }

    fn vectors_of_grains<'py>(&self, py: Python<'py>, offset: usize) -> PyResult<Array<'py>> {
        self.field(py, Records::Grains, FieldKind::Vector, offset)
    }

    /// A number of each contact.
    fn of_contacts<'py>(&self, py: Python<'py>, offset: usize) -> PyResult<Array<'py>> {
        self.field(py, Records::Contacts, FieldKind::Real, offset)
    }

    fn vectors_of_contacts<'py>(&self, py: Python<'py>, offset: usize) -> PyResult<Array<'py>> {
        self.field(py, Records::Contacts, FieldKind::Vector, offset)
    }
}

/// A matrix as an array of three rows.
pub fn matrix<'py>(py: Python<'py>, matrix: &[Vector; 3]) -> PyResult<Array<'py>> {
    arrays::reals(py, matrix.concat(), vec![3, 3])
}

#[pymethods]
impl Assembly {
    #[getter]
    fn time(&self) -> f64 {
        self.inner.time
    }

    #[getter]
    fn step(&self) -> u64 {
        self.inner.step
    }

    #[getter]
    fn volume(&self) -> f64 {
        self.inner.volume()
    }

    #[getter]
    fn cell<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        matrix(py, &self.inner.cell)
    }

    #[getter]
    fn strain<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        matrix(py, &self.inner.strain)
    }

    #[getter]
    fn velocity_gradient<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        matrix(py, &self.inner.velocity_gradient)
    }

    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let ids: Vec<i64> = self.inner.grains.iter().map(|grain| grain.id as i64).collect();
        let shape = vec![ids.len()];
        arrays::integers(py, ids, shape)
    }

    #[getter]
    fn materials<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let materials: Vec<i64> = self.inner.grains.iter().map(|grain| i64::from(grain.material)).collect();
        let shape = vec![materials.len()];
        arrays::integers(py, materials, shape)
    }

    #[getter]
    fn material_names(&self) -> Vec<String> {
        self.inner.materials.clone()
    }

    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, offset_of!(Grain, position))
    }

    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, offset_of!(Grain, velocity))
    }

    #[getter]
    fn spins<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, offset_of!(Grain, spin))
    }

    #[getter]
    fn grain_forces<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, offset_of!(Grain, force))
    }

    #[getter]
    fn grain_torques<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, offset_of!(Grain, torque))
    }

    #[getter]
    fn radii<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.of_grains(py, offset_of!(Grain, radius))
    }

    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.of_grains(py, offset_of!(Grain, mass))
    }

    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let contacts = &self.inner.contacts;
        let pairs: Vec<i64> =
            contacts.iter().flat_map(|contact| [contact.i as i64, contact.j as i64]).collect();
        arrays::integers(py, pairs, vec![contacts.len(), 2])
    }

    #[getter]
    fn branches<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_contacts(py, offset_of!(Contact, branch))
    }

    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_contacts(py, offset_of!(Contact, normal))
    }

    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let forces: Vec<f64> = py.detach(|| self.inner.contacts.iter().flat_map(Contact::force).collect());
        arrays::reals(py, forces, vec![self.inner.contacts.len(), 3])
    }

    #[getter]
    fn normal_forces<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.of_contacts(py, offset_of!(Contact, normal_force))
    }

    #[getter]
    fn tangential_forces<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_contacts(py, offset_of!(Contact, tangential_force))
    }

    #[getter]
    fn overlaps<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.of_contacts(py, offset_of!(Contact, approach))
    }

    #[getter]
    fn sliding<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.field(py, Records::Contacts, FieldKind::Boolean, offset_of!(Contact, sliding))
    }

    fn grains_table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let found = detached(py, || grains_table(&self.inner))?;
        let found = found.map_err(|error| errors::of_file(py, &error, false))?;
        table::object(py, found)
    }

    fn contacts_table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let found = detached(py, || contacts_table(&self.inner))?;
        let found = found.map_err(|error| errors::of_file(py, &error, false))?;
        table::object(py, found)
    }

    /// The grains of each force chain, by their places.
    fn force_chains<'py>(&self, py: Python<'py>) -> PyResult<Vec<Array<'py>>> {
        let found = detached(py, || Chains::from_observation(&Observation::new(&self.inner)).chains)?;
        let chain = |chain: Vec<usize>| {
            let shape = vec![chain.len()];
            arrays::integers(py, chain.into_iter().map(|grain| grain as i64).collect(), shape)
        };
        found.into_iter().map(chain).collect()
    }

    fn measure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let assembly = self.inner.clone();
        answer(py, &detached(py, move || Sensors::standard().measure(&assembly, Parts::all()))?)
    }

    fn __repr__(&self) -> String {
        let (grains, contacts) = (self.inner.grains.len(), self.inner.contacts.len());
        format!("<granum.Assembly of {grains} grains and {contacts} contacts>")
    }
}

/// The values of the columns that could be measured.
fn answer<'py>(py: Python<'py>, measured: &Measurement) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (column, value) in &measured.columns {
        dict.set_item(column.name, value)?;
    }
    Ok(dict)
}

/// Vectors from an array of rows of three.
fn vectors(name: &str, values: &Bound<'_, PyAny>) -> PyResult<Vec<Vector>> {
    let (numbers, shape) = arrays::numbers(name, values)?;
    if shape.len() != 2 || shape[1] != 3 {
        let message = format!("rows of three numbers are needed, and the shape is {shape:?}");
        return Err(errors::of_value(values.py(), name, format!("{shape:?}"), message));
    }
    arrays::check_finite(values.py(), name, &numbers, &shape)?;
    Ok(numbers.as_chunks::<3>().0.to_vec())
}

/// Every sensor on arrays of anyone, which are joined by the rules for the files of other programs.
#[pyfunction]
#[pyo3(signature = (positions, radii, contacts=None, forces=None, cell=None))]
pub fn measure<'py>(
    py: Python<'py>,
    positions: &Bound<'py, PyAny>,
    radii: &Bound<'py, PyAny>,
    contacts: Option<&Bound<'py, PyAny>>,
    forces: Option<&Bound<'py, PyAny>>,
    cell: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let positions = vectors("positions", positions)?;
    let (radii, shape) = arrays::numbers("radii", radii)?;
    arrays::check_finite(py, "radii", &radii, &shape)?;
    if shape.len() != 1 || radii.len() != positions.len() {
        let message =
            format!("there are {} positions, and the radii have the shape {shape:?}", positions.len());
        return Err(errors::of_value(py, "radii", format!("{shape:?}"), message));
    }
    let mut frame = Frame::default();
    frame.knows(&[Part::Positions, Part::Radii]);
    let grain = |(id, (position, radius)): (u64, (&Vector, &f64))| Grain {
        id,
        position: *position,
        radius: *radius,
        ..Grain::default()
    };
    frame.grains = (1..).zip(positions.iter().zip(&radii)).map(grain).collect();
    frame.cell = cell.map(edges).transpose()?.map(|edges| FrameCell { origin: [0.0; 3], edges });
    let forces = forces.map(|forces| vectors("forces", forces)).transpose()?;
    frame.contacts = contacts.map(|contacts| pairs(contacts, positions.len())).transpose()?;
    if let Some(forces) = forces {
        let contacts = frame.contacts.as_deref_mut().unwrap_or_default();
        if forces.len() != contacts.len() {
            let message = format!("there are {} forces for {} contacts", forces.len(), contacts.len());
            return Err(errors::of_value(py, "forces", forces.len().to_string(), message));
        }
        contacts.iter_mut().zip(forces).for_each(|(contact, force)| contact.force = Some(force));
    }
    let measured = detached(py, move || -> granum_io::Result<Measurement> {
        let observed = join(vec![(PathBuf::from("arrays"), vec![frame])], &JoinOptions::default())?;
        let mut observed = observed.into_iter();
        let first = observed.next().map(|one| Sensors::standard().measure(&one.assembly, one.parts));
        Ok(first.unwrap_or_default())
    })?;
    answer(py, &measured.map_err(|error| errors::of_file(py, &error, true))?)
}

/// The edge matrix of a cell: three lengths, or a matrix whose columns are the edges.
fn edges(cell: &Bound<'_, PyAny>) -> PyResult<Matrix> {
    let (numbers, shape) = arrays::numbers("cell", cell)?;
    arrays::check_finite(cell.py(), "cell", &numbers, &shape)?;
    match (shape.as_slice(), numbers.as_slice()) {
        ([3], [x, y, z]) => Ok([[*x, 0.0, 0.0], [0.0, *y, 0.0], [0.0, 0.0, *z]]),
        ([3, 3], [a, b, c, d, e, f, g, h, i]) => Ok([[*a, *b, *c], [*d, *e, *f], [*g, *h, *i]]),
        _ => {
            let message = "three lengths or a matrix whose columns are the edges of the cell are needed";
            Err(errors::of_value(cell.py(), "cell", format!("{shape:?}"), message))
        }
    }
}

/// Contacts of pairs of grains, which are given by their places in the arrays, from 0.
fn pairs(pairs: &Bound<'_, PyAny>, grains: usize) -> PyResult<Vec<FileContact>> {
    let (numbers, shape) = arrays::numbers("contacts", pairs)?;
    let wrong = |value: String, message: String| errors::of_value(pairs.py(), "contacts", value, message);
    if shape.len() != 2 || shape[1] != 2 {
        let message = format!("rows of the indices of two grains are needed, and the shape is {shape:?}");
        return Err(wrong(format!("{shape:?}"), message));
    }
    let id = |number: f64| -> PyResult<u64> {
        if number >= 0.0 && number.fract() == 0.0 && number < grains as f64 {
            return Ok(number as u64 + 1);
        }
        let message = format!("{number} is no index of a grain; there are {grains} grains, from 0");
        Err(wrong(number.to_string(), message))
    };
    let each = numbers.as_chunks::<2>().0.iter();
    each.map(|[i, j]| Ok(FileContact { first: id(*i)?, second: id(*j)?, ..FileContact::default() })).collect()
}
