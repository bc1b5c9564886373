//! Grains and contacts of one instant: from the dumps of LAMMPS to an assembly that sensors can measure.
//!
//! Positions, velocities, spins and torques are those of the dump of grains. Which grains touch, how far they overlap, and the elastic
//! normal force follow from the positions by granum's own law, since the forces of LAMMPS contain those of the dashpots, which a stress
//! of granum leaves out. The tangential force of a contact is that of LAMMPS, with its dashpot. The resultant on a grain is the sum of the
//! forces that LAMMPS has, with the dashpots as in granum.

use std::collections::HashMap;
use std::path::Path;

use granum_core::assembly::{Assembly, Body, Vector};
use granum_core::geometry::{apply, dot, invert};
use granum_core::{Part, Parts};
use granum_dem::simulation::Properties;
use granum_io::formats::lammps_dump::LammpsDump;
use granum_io::formats::{FileContact, Frame, FrameCell, ReadOptions, ResultFormat};
use granum_io::{Error, Packing};

use super::events::Instant;
use super::place::Place;
use crate::engine::native::simulation;
use crate::lammps_deck::hooks::COLUMNS_OF_CONTACTS;
use crate::task::laboratory_error::LaboratoryError;

/// What LAMMPS does not tell. Of sliding contacts it does not, since it evaluates the dashpots once more for a dump, so that a tangential
/// force at its limit does not show it (of 38 % of sliding contacts 22 % were found within a thousandth of the limit).
const UNKNOWN: [Part; 4] = [Part::Sliding, Part::ContactEnergies, Part::EnergyBalance, Part::Liquid];

/// What LAMMPS tells of grains.
pub(super) fn parts() -> Parts {
    Parts::new(&Parts::new(&UNKNOWN).missing(&Part::ALL))
}

/// The grains of a test, of which dumps give positions and motion only.
#[derive(Clone, Debug)]
pub(super) struct Grains {
    /// The sample with which the test begins.
    sample: Assembly,
    properties: Properties,
}

/// An instant as sensors see it.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub(super) assembly: Assembly,
    /// Largest `dt sqrt(k_t / m)` of a contact.
    pub(super) time_step_fraction: f64,
}

impl Grains {
    /// The grains of a sample with the properties of its test.
    pub(super) fn new(sample: Assembly, properties: Properties) -> Grains {
        Grains { sample, properties }
    }

    /// Their number.
    pub(super) fn count(&self) -> usize {
        self.sample.bodies.len()
    }

    /// The properties of their contacts.
    pub(super) fn properties(&self) -> &Properties {
        &self.properties
    }

    /// The assembly of the dumps of an instant.
    ///
    /// # Errors
    /// If a dump is missing or does not belong to these grains.
    pub(super) fn seen(&self, place: &Place, instant: &Instant) -> Result<Seen, LaboratoryError> {
        let [grains, contacts] = place.dumps(instant.step);
        let frame = one(&grains, None)?;
        let columns = COLUMNS_OF_CONTACTS.map(str::to_string).to_vec();
        let pairs = one(&contacts, Some(columns))?.contacts.unwrap_or_default();
        let mut assembly = self.placed(&grains, &frame, instant)?;
        let simulated = simulation(&Packing::from_assembly(&assembly), self.properties.clone())?;
        let state = simulated.state();
        let time_step_fraction = state.time_step_fraction() / state.time_step() * instant.time_step;
        assembly.contacts = simulated.assembly().contacts;
        self.add_forces(&contacts, &mut assembly, &pairs)?;
        Ok(Seen { assembly, time_step_fraction })
    }

    /// The grains where a dump has them, in the cell of the dump.
    fn placed(&self, path: &Path, frame: &Frame, instant: &Instant) -> Result<Assembly, LaboratoryError> {
        let bad = |what: &str| LaboratoryError::File(Error::content(path, what));
        let Some(FrameCell { origin, edges }) = frame.cell else { return Err(bad("has no periodic box")) };
        if frame.grains.len() != self.count() {
            return Err(bad("does not have the grains of the sample"));
        }
        let inverse = invert(&edges);
        let mut spheres = self.sample.spheres().unwrap_or_default();
        let assembly = Assembly {
            time: instant.time,
            step: instant.step,
            time_step: instant.time_step,
            cell: edges,
            velocity_gradient: instant.gradient,
            strain: instant.strain,
            arc_length: instant.arc_length,
            target_mean_stress: (instant.target != 0.0).then_some(instant.target),
            materials: self.sample.materials.clone(),
            ..Assembly::default()
        };
        for dumped in &frame.grains {
            let Ok(at) = spheres.binary_search_by_key(&dumped.id, |sphere| sphere.id) else {
                return Err(bad("has a grain that the sample does not have"));
            };
            let share = apply(&inverse, std::array::from_fn(|a| dumped.position[a] - origin[a]));
            let homogeneous = apply(&instant.gradient, dumped.position);
            let grain = &mut spheres[at];
            grain.position = apply(&edges, share.map(|x| x - x.floor()));
            // Velocities of LAMMPS are those in the laboratory, with the homogeneous part about the middle of the box.
            grain.velocity = std::array::from_fn(|a| dumped.velocity[a] - homogeneous[a]);
            (grain.spin, grain.torque, grain.force) = (dumped.spin, dumped.torque, [0.0; 3]);
        }
        Ok(assembly.with_spheres(spheres))
    }

    /// Adds the forces of LAMMPS to contacts and grains.
    fn add_forces(
        &self,
        path: &Path,
        assembly: &mut Assembly,
        pairs: &[FileContact],
    ) -> Result<(), LaboratoryError> {
        let mut forces: HashMap<[usize; 2], Vector> = HashMap::with_capacity(pairs.len());
        for pair in pairs {
            let force = pair.force.unwrap_or_default();
            let ends = [pair.first, pair.second].map(|id| place_of(&assembly.bodies, id));
            let [Some(i), Some(j)] = ends else {
                return Err(
                    Error::content(path, "has a contact of a grain that the sample does not have").into()
                );
            };
            for a in 0..3 {
                assembly.bodies[i].force[a] += force[a];
                assembly.bodies[j].force[a] -= force[a];
            }
            let on_first = if i < j { force } else { force.map(|x| -x) };
            forces.insert([i.min(j), i.max(j)], on_first);
        }
        for contact in &mut assembly.contacts {
            let (i, j) = (contact.i, contact.j);
            let Some(force) = forces.remove(&[i.min(j), i.max(j)]) else { continue };
            let force = if i < j { force } else { force.map(|x| -x) };
            let normal = -dot(&force, &contact.normal);
            contact.tangential_force = std::array::from_fn(|a| force[a] + normal * contact.normal[a]);
        }
        Ok(())
    }
}

/// The place of a grain in a list that is sorted by ids.
fn place_of(grains: &[Body], id: u64) -> Option<usize> {
    grains.binary_search_by_key(&id, |grain| grain.id).ok()
}

/// The one instant of a dump.
fn one(path: &Path, columns: Option<Vec<String>>) -> Result<Frame, LaboratoryError> {
    let mut frames = LammpsDump.read(path, &ReadOptions::with_columns(columns))?;
    match frames.pop() {
        Some(frame) if frames.is_empty() => Ok(frame),
        _ => Err(Error::content(path, "should have one time step").into()),
    }
}
