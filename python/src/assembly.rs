//! Assemblies: all grains and contacts at one moment, as arrays. Of an assembly of another program only a part is known.

use std::mem::offset_of;
use std::sync::Arc;

use granum_core::assembly::{Body, Bond, BrokenBond, Contact, Piece, Rigid, Rupture, Vector};
use granum_core::{Part, Parts, Table};
use granum_io::formats::{ObservedAssembly, known_columns};
use granum_io::snapshot::{contacts_table, grains_table};
use granum_sensors::force_chains::Chains;
use granum_sensors::{Measurement, Observation, Sensors};
use pyo3::exceptions::PyAttributeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{self, Array, Field, FieldKind, Records};
use crate::detached::detached;
use crate::errors;
use crate::observed::{Arrays, from_arrays, warned};
use crate::table;

/// All grains and contacts at one moment, in the order of the ids of the grains. Every array is read-only and shows no later step.
///
/// An assembly is a copy of what the engine keeps in another layout. Its arrays are views of it without a further copy, which keep all of it in
/// memory: the distance from one grain to the next is that of all its data (`strides`). Only `ids`, `materials`, `contacts` and `forces` are
/// arrays of their own.
///
/// An assembly can be made of arrays of anyone, with the arguments of `granum.measure`, or read from files of other programs
/// (`granum.read`). Of these only a part is known (`parts`); what is not raises `AttributeError`.
#[pyclass(frozen, module = "granum")]
pub struct Assembly {
    inner: Arc<granum_core::Assembly>,
    /// What of it is known.
    parts: Parts,
    /// The corner of its cell in the file that it was read from, m.
    origin: Vector,
    /// What was set right in its data, and what is doubtful.
    remarks: Vec<String>,
}

impl From<granum_core::Assembly> for Assembly {
    fn from(assembly: granum_core::Assembly) -> Assembly {
        Assembly::shared(Arc::new(assembly))
    }
}

impl From<ObservedAssembly> for Assembly {
    fn from(observed: ObservedAssembly) -> Assembly {
        let ObservedAssembly { assembly, parts, origin, remarks, .. } = observed;
        let remarks = remarks.into_iter().map(|remark| remark.text).collect();
        Assembly { inner: Arc::new(assembly), parts, origin, remarks }
    }
}

impl Assembly {
    /// An assembly of granum that others hold as well.
    pub fn shared(inner: Arc<granum_core::Assembly>) -> Assembly {
        Assembly { inner, parts: Parts::all(), origin: [0.0; 3], remarks: Vec::new() }
    }

    /// What it holds.
    pub fn inner(&self) -> Arc<granum_core::Assembly> {
        self.inner.clone()
    }

    /// A vector of each bond.
    fn vectors_of_bonds<'py>(&self, py: Python<'py>, of: impl Fn(&Bond) -> Vector) -> PyResult<Array<'py>> {
        self.knows(Part::Bonds)?;
        let vectors: Vec<f64> = self.inner.bonds.iter().flat_map(of).collect();
        arrays::reals(py, vectors, vec![self.inner.bonds.len(), 3])
    }

    /// A number of each bond.
    fn numbers_of_bonds<'py>(&self, py: Python<'py>, of: impl Fn(&Bond) -> f64) -> PyResult<Array<'py>> {
        self.knows(Part::Bonds)?;
        let numbers: Vec<f64> = self.inner.bonds.iter().map(of).collect();
        let shape = vec![numbers.len()];
        arrays::reals(py, numbers, shape)
    }

    /// What it holds, if everything is known.
    ///
    /// # Errors
    /// `granum.RunError`: what records states would take what is missing for zero.
    pub fn whole(&self, py: Python<'_>) -> PyResult<Arc<granum_core::Assembly>> {
        match self.parts.missing(&Part::ALL)[..] {
            [] => Ok(self.inner()),
            [missing, ..] => {
                let advice = "granum.measure applies the sensors for which such data suffice";
                let message = format!("these data have no {}; {advice}", missing.name());
                Err(errors::of_running(py, &message))
            }
        }
    }

    /// What of it is known.
    pub fn known(&self) -> Parts {
        self.parts
    }

    /// The same as what was read from a file.
    pub fn observed(&self) -> ObservedAssembly {
        ObservedAssembly::new((*self.inner).clone(), self.parts, self.origin)
    }

    /// What a grain of several spheres has beyond a sphere.
    fn rigid(&self, body: &Body) -> Option<&Rigid> {
        self.inner.rigid.get(body.rigid? as usize)
    }

    /// Refuses to give what is not known.
    fn knows(&self, part: Part) -> PyResult<()> {
        if self.parts.has(part) {
            return Ok(());
        }
        let message = format!("these data have no {}; they have {}", part.name(), self.parts().join(", "));
        Err(PyAttributeError::new_err(message))
    }

    fn field<'py>(
        &self,
        py: Python<'py>,
        (of, part): (Records, Part),
        kind: FieldKind,
        offset: usize,
    ) -> PyResult<Array<'py>> {
        self.knows(part)?;
        arrays::field(py, self.inner.clone(), Field { of, offset, kind })
    }

    /// A number of each grain.
    fn of_grains<'py>(&self, py: Python<'py>, part: Part, offset: usize) -> PyResult<Array<'py>> {
        self.field(py, (Records::Grains, part), FieldKind::Real, offset)
    }

    fn vectors_of_grains<'py>(&self, py: Python<'py>, part: Part, offset: usize) -> PyResult<Array<'py>> {
        self.field(py, (Records::Grains, part), FieldKind::Vector, offset)
    }

    /// A number of each contact.
    fn of_contacts<'py>(&self, py: Python<'py>, part: Part, offset: usize) -> PyResult<Array<'py>> {
        self.field(py, (Records::Contacts, part), FieldKind::Real, offset)
    }

    fn vectors_of_contacts<'py>(&self, py: Python<'py>, part: Part, offset: usize) -> PyResult<Array<'py>> {
        self.field(py, (Records::Contacts, part), FieldKind::Vector, offset)
    }

    /// A table of what is known.
    fn table_of<'py>(
        &self,
        py: Python<'py>,
        make: impl FnOnce(&granum_core::Assembly) -> granum_io::Result<Table> + Send,
    ) -> PyResult<Bound<'py, PyAny>> {
        let found = detached(py, || Ok(known_columns(&make(&self.inner)?, self.parts)))?;
        table::object(py, found.map_err(|error: granum_io::Error| errors::of_file(py, &error, false))?)
    }
}

/// A matrix as an array of three rows.
pub fn matrix<'py>(py: Python<'py>, matrix: &[Vector; 3]) -> PyResult<Array<'py>> {
    arrays::reals(py, matrix.concat(), vec![3, 3])
}

#[pymethods]
impl Assembly {
    #[new]
    #[pyo3(signature = (positions, radii, contacts=None, forces=None, cell=None))]
    fn new(
        positions: &Bound<'_, PyAny>,
        radii: &Bound<'_, PyAny>,
        contacts: Option<&Bound<'_, PyAny>>,
        forces: Option<&Bound<'_, PyAny>>,
        cell: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Assembly> {
        warned(positions.py(), from_arrays(&Arrays { positions, radii, contacts, forces, cell })?)
            .map(Assembly::from)
    }

    /// What was set right in the data that were read, and what is doubtful in them, as sentences.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    /// The names of what is known: everything of a run of granum, and of files of another program what these have.
    #[getter]
    fn parts(&self) -> Vec<&'static str> {
        Part::ALL.into_iter().filter(|part| self.parts.has(*part)).map(Part::name).collect()
    }

    /// The corner of the cell in the file that was read, m; positions count from it.
    #[getter]
    fn origin<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        arrays::reals(py, self.origin.to_vec(), vec![3])
    }

    /// Time since the start of the phase, s.
    #[getter]
    fn time(&self) -> PyResult<f64> {
        self.knows(Part::Time)?;
        Ok(self.inner.time)
    }

    /// Steps since the start of the phase.
    #[getter]
    fn step(&self) -> u64 {
        self.inner.step
    }

    /// Volume of the cell, m3.
    #[getter]
    fn volume(&self) -> PyResult<f64> {
        self.knows(Part::Cell)?;
        Ok(self.inner.volume())
    }

    /// Matrix of the periodic cell, whose columns are its edges, m.
    #[getter]
    fn cell<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Cell)?;
        matrix(py, &self.inner.cell)
    }

    /// Logarithmic strain since the start of the phase, compression positive.
    #[getter]
    fn strain<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Strain)?;
        matrix(py, &self.inner.strain)
    }

    /// Velocity gradient of the cell, 1/s.
    #[getter]
    fn velocity_gradient<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::StrainRate)?;
        matrix(py, &self.inner.velocity_gradient)
    }

    /// Ids of the grains, from 1.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let ids: Vec<i64> = self.inner.bodies.iter().map(|grain| grain.id as i64).collect();
        let shape = vec![ids.len()];
        arrays::integers(py, ids, shape)
    }

    /// Material of each grain, as an index of `material_names`.
    #[getter]
    fn materials<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let materials: Vec<i64> = self.inner.bodies.iter().map(|grain| i64::from(grain.material)).collect();
        let shape = vec![materials.len()];
        arrays::integers(py, materials, shape)
    }

    /// Names of the materials; empty if there is one.
    #[getter]
    fn material_names(&self) -> Vec<String> {
        self.inner.materials.clone()
    }

    /// Centres of the grains inside the cell, m: a row a grain.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, Part::Positions, offset_of!(Body, position))
    }

    /// Fluctuating velocities of the grains, m/s: a row a grain.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, Part::Velocities, offset_of!(Body, velocity))
    }

    /// Spins of the grains, rad/s: a row a grain.
    #[getter]
    fn spins<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, Part::Spins, offset_of!(Body, spin))
    }

    /// Sum of the contact forces on each grain, N.
    #[getter]
    fn grain_forces<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, Part::ResultantForces, offset_of!(Body, force))
    }

    /// Sum of the contact torques on each grain, N m.
    #[getter]
    fn grain_torques<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_grains(py, Part::ResultantForces, offset_of!(Body, torque))
    }

    /// Radii of the grains, m; of a grain of several pieces that of the sphere of equal volume.
    #[getter]
    fn radii<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.of_grains(py, Part::Radii, offset_of!(Body, equivalent_radius))
    }

    /// Masses of the grains, kg.
    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.of_grains(py, Part::Masses, offset_of!(Body, mass))
    }

    /// Rotation of each grain from its principal axes to those of space, as a quaternion w, x, y, z: a row a grain, 1, 0, 0, 0 for a sphere.
    #[getter]
    fn orientations<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Positions)?;
        let of = |body: &Body| self.rigid(body).map_or([1.0, 0.0, 0.0, 0.0], |rigid| rigid.orientation);
        let rows: Vec<f64> = self.inner.bodies.iter().flat_map(of).collect();
        arrays::reals(py, rows, vec![self.inner.bodies.len(), 4])
    }

    /// Principal moments of inertia of each grain, kg m2: a row a grain.
    #[getter]
    fn moments_of_inertia<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Masses)?;
        let of_sphere = |body: &Body| [0.4 * body.mass * body.equivalent_radius * body.equivalent_radius; 3];
        let of = |body: &Body| self.rigid(body).map_or_else(|| of_sphere(body), |rigid| rigid.inertia);
        let rows: Vec<f64> = self.inner.bodies.iter().flat_map(of).collect();
        arrays::reals(py, rows, vec![self.inner.bodies.len(), 3])
    }

    /// The grain of each sphere, as an index from 0. A grain has one sphere, or several that are fixed on it.
    #[getter]
    fn piece_grains<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let grains: Vec<i64> = self.inner.pieces.iter().map(|piece| piece.body as i64).collect();
        let shape = vec![grains.len()];
        arrays::integers(py, grains, shape)
    }

    /// From the centre of its grain to that of each sphere, m: a row a sphere.
    #[getter]
    fn piece_arms<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        let of = (Records::Pieces, Part::Positions);
        self.field(py, of, FieldKind::Vector, offset_of!(Piece, arm))
    }

    /// Radius of each sphere, m.
    #[getter]
    fn piece_radii<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.field(py, (Records::Pieces, Part::Radii), FieldKind::Real, offset_of!(Piece, radius))
    }

    /// Indices, from 0, of the two grains of each bond that holds: a row a bond, in the order of their numbers.
    #[getter]
    fn bonds<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Bonds)?;
        let bodies = |piece: usize| self.inner.body_of(piece).unwrap_or_default() as i64;
        let pairs: Vec<i64> =
            self.inner.bonds.iter().flat_map(|bond| [bodies(bond.i), bodies(bond.j)]).collect();
        arrays::integers(py, pairs, vec![self.inner.bonds.len(), 2])
    }

    /// Elastic force of each bond on its first grain, N.
    #[getter]
    fn bond_forces<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_bonds(py, |bond| bond.force())
    }

    /// Unit vector along each bond, from the first grain to the second.
    #[getter]
    fn bond_normals<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_bonds(py, |bond| bond.normal)
    }

    /// Elastic energy of each bond, J.
    #[getter]
    fn bond_energies<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.numbers_of_bonds(py, |bond| bond.energy)
    }

    /// Ratio of load to strength of each bond: it ruptures at 1.
    #[getter]
    fn bond_utilisations<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.numbers_of_bonds(py, |bond| bond.utilisation)
    }

    /// Places of the cracks, which are the bonds that ruptured, in the order in which they did, m: a row a crack.
    #[getter]
    fn cracks<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Bonds)?;
        let place = |bond: &BrokenBond| granum_core::geometry::apply(&self.inner.cell, bond.place);
        let places: Vec<f64> = self.inner.broken_bonds.iter().flat_map(place).collect();
        arrays::reals(py, places, vec![self.inner.broken_bonds.len(), 3])
    }

    /// Unit normal of each crack: the direction of the bond.
    #[getter]
    fn crack_normals<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Bonds)?;
        let normals: Vec<f64> = self.inner.broken_bonds.iter().flat_map(|bond| bond.normal).collect();
        arrays::reals(py, normals, vec![self.inner.broken_bonds.len(), 3])
    }

    /// Energy that was stored in each bond that ruptured, J.
    #[getter]
    fn crack_energies<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Bonds)?;
        let energies: Vec<f64> = self.inner.broken_bonds.iter().map(|bond| bond.energy).collect();
        let shape = vec![energies.len()];
        arrays::reals(py, energies, shape)
    }

    /// True for each crack that opened by tension with bending, false for one by shear with twist.
    #[getter]
    fn crack_by_tension<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Bonds)?;
        let of = |bond: &BrokenBond| bond.rupture == Rupture::Tension;
        arrays::booleans(py, self.inner.broken_bonds.iter().map(of).collect())
    }

    /// Indices, from 0, of the two grains of each contact: a row a contact.
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::Contacts)?;
        let contacts = &self.inner.contacts;
        let pairs = contacts.iter().flat_map(|contact| self.inner.bodies_of(contact).unwrap_or_default());
        let pairs = pairs.map(|body| body as i64).collect();
        arrays::integers(py, pairs, vec![contacts.len(), 2])
    }

    /// Vector between the centres of the two grains of each contact, m.
    #[getter]
    fn branches<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        if self.inner.all_spheres() {
            return self.vectors_of_contacts(py, Part::Contacts, offset_of!(Contact, branch));
        }
        self.knows(Part::Contacts)?;
        let of = |contact| self.inner.branch_of_bodies(contact);
        let branches: Vec<f64> = py.detach(|| self.inner.contacts.iter().flat_map(of).collect());
        arrays::reals(py, branches, vec![self.inner.contacts.len(), 3])
    }

    /// Unit normal of each contact, from the first grain to the second.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_contacts(py, Part::Contacts, offset_of!(Contact, normal))
    }

    /// Elastic force on the first grain of each contact, N.
    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.knows(Part::NormalForces)?;
        self.knows(Part::TangentialForces)?;
        let forces: Vec<f64> = py.detach(|| self.inner.contacts.iter().flat_map(Contact::force).collect());
        arrays::reals(py, forces, vec![self.inner.contacts.len(), 3])
    }

    /// Elastic normal force of each contact, compression positive, N.
    #[getter]
    fn normal_forces<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.of_contacts(py, Part::NormalForces, offset_of!(Contact, normal_force))
    }

    /// Elastic tangential force on the first grain of each contact, N.
    #[getter]
    fn tangential_forces<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.vectors_of_contacts(py, Part::TangentialForces, offset_of!(Contact, tangential_force))
    }

    /// Overlap of each contact, m.
    #[getter]
    fn overlaps<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.of_contacts(py, Part::Overlaps, offset_of!(Contact, approach))
    }

    /// True where the tangential force was at the friction limit in the last step.
    #[getter]
    fn sliding<'py>(&self, py: Python<'py>) -> PyResult<Array<'py>> {
        self.field(py, (Records::Contacts, Part::Sliding), FieldKind::Boolean, offset_of!(Contact, sliding))
    }

    /// All grains as a table, with units.
    fn grains_table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table_of(py, grains_table)
    }

    /// All contacts as a table, with units.
    fn contacts_table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.knows(Part::Contacts)?;
        self.table_of(py, contacts_table)
    }

    /// The force chains (Peters et al. 2005), as the sensor of that name counts them: for each the indices of its grains along it.
    fn force_chains<'py>(&self, py: Python<'py>) -> PyResult<Vec<Array<'py>>> {
        self.knows(Part::Contacts)?;
        self.knows(Part::NormalForces)?;
        let found = detached(py, || Chains::from_observation(&Observation::new(&self.inner)).chains)?;
        let chain = |chain: Vec<usize>| {
            let shape = vec![chain.len()];
            arrays::integers(py, chain.into_iter().map(|grain| grain as i64).collect(), shape)
        };
        found.into_iter().map(chain).collect()
    }

    /// The values of every sensor that one assembly suffices for, by column, in SI units.
    fn measure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        answer(py, &detached(py, || Sensors::standard().measure(&self.inner, self.parts))?)
    }

    fn __repr__(&self) -> String {
        let (grains, contacts) = (self.inner.bodies.len(), self.inner.contacts.len());
        format!("<granum.Assembly of {grains} grains and {contacts} contacts>")
    }
}

/// The values of the columns that could be measured.
pub fn answer<'py>(py: Python<'py>, measured: &Measurement) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (column, value) in &measured.columns {
        dict.set_item(column.name, value)?;
    }
    Ok(dict)
}
