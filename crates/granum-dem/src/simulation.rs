//! A simulation: grains in a controlled cell, advanced step by step.

use std::any::Any;
use std::collections::HashSet;
use std::sync::Arc;

use granum_core::{MacroState, ObservedState, Parts};
use granum_simd::{LANES, Row4, Row8};

use crate::assembly::{Assembly, Vector};
use crate::bond::Bonds;
use crate::boundary::Boundary;
use crate::cell::Cell;
use crate::clump::clumps::Clumps;
use crate::clump::placed::PlacedBodies;
use crate::clump::rotor;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact_sums::ContactSums;
use crate::inner_list::InnerList;
use crate::integrator::Integrator;
use crate::kernel::ContactStages;
use crate::ledger::Ledger;
use crate::loading::measure::MeasureGoal;
use crate::pairs::{NORMAL_COLUMNS, Pairs};
use crate::particle_row::ParticleRow;
use crate::properties::{check_assignment, check_properties};
use crate::servo::{CellControl, Servo};
use crate::state::bodies::BodyPlace;
use crate::state::{ServoError, State};
use crate::{images, stepping};

pub use crate::hardware::Hardware;
pub use crate::initial_body::InitialBody;
pub use crate::initial_sphere::InitialSphere;
pub use crate::properties::{LARGEST_REACH, Properties};
pub use crate::simulation_error::SimulationError;
pub use granum_shape::{RigidShape, ShapePiece};

/// A simulation.
#[derive(Clone)]
pub struct Simulation {
    pub(crate) integrator: Integrator,
}

impl Simulation {
    /// Grains at rest in a cell that is not strained. The forces follow from the geometry, without any history. Several
    /// materials are assigned to the grains at random from the seed of the mixture ([`crate::config::Mixture::assign`]).
    ///
    /// # Errors
    /// If a grain, the cell, a material or the laws are impossible.
    pub fn new(
        cell: Cell,
        spheres: &[InitialSphere],
        properties: Properties,
    ) -> Result<Simulation, SimulationError> {
        let materials = properties.mixture.assign(spheres.len(), properties.mixture.seed);
        Simulation::of_materials(cell, spheres, &materials, properties)
    }

    /// As [`Simulation::new`], with the material of each grain given as its place among the components of the mixture.
    ///
    /// # Errors
    /// As [`Simulation::new`]; also if there is not one known material for each grain.
    pub fn of_materials(
        cell: Cell,
        spheres: &[InitialSphere],
        materials: &[u8],
        properties: Properties,
    ) -> Result<Simulation, SimulationError> {
        Simulation::of_rows(cell, spheres, materials, properties, Clumps::default())
    }

    /// Grains of any shapes, spheres among them, at rest in a cell that is not strained. Each body names its shape by its place among
    /// `shapes`, and has the material in its place of `materials`, which is empty if there is one material.
    ///
    /// # Errors
    /// As [`Simulation::of_materials`]; also if a shape is impossible, or too large for the cell.
    pub fn of_bodies(
        cell: Cell,
        shapes: &[RigidShape],
        bodies: &[InitialBody],
        materials: &[u8],
        properties: Properties,
    ) -> Result<Simulation, SimulationError> {
        check_assignment(materials, bodies.len(), &properties.mixture)?;
        let bodies = PlacedBodies::place(&cell, shapes, bodies, materials, &properties)?;
        Simulation::of_rows(cell, &bodies.rows, &bodies.materials, properties, bodies.clumps)
    }

    /// Spheres, of which some are pieces of clumps.
    fn of_rows(
        cell: Cell,
        spheres: &[InitialSphere],
        materials: &[u8],
        properties: Properties,
        mut clumps: Clumps,
    ) -> Result<Simulation, SimulationError> {
        check_spheres(&cell, spheres, &clumps)?;
        check_clumps(&clumps, &properties)?;
        check_assignment(materials, spheres.len(), &properties.mixture)?;
        let smallest = spheres.iter().fold(f64::INFINITY, |m, s| m.min(s.radius));
        check_properties(&properties, smallest)?;
        let mut particles: Vec<Row8> = spheres
            .iter()
            .enumerate()
            .map(|(k, s)| {
                let density = properties.density_of(materials.get(k).copied());
                let mass = density * 4.0 / 3.0 * std::f64::consts::PI * s.radius.powi(3);
                let x = s.position;
                Row8([x[0], x[1], x[2], s.radius, 0.0, 0.0, 0.0, mass])
            })
            .collect();
        for clump in &clumps.bodies {
            for piece in clumps.pieces_of(clump) {
                particles[piece.row as usize].set_mass(clump.mass);
            }
        }
        let moved = images::wrap(&cell, &mut particles);
        clumps.wrap(&cell, &moved);
        let largest = spheres.iter().fold(0.0f64, |m, s| m.max(s.radius));
        let far = 1e6 * largest;
        particles.push(Row8([0.0, 0.0, 0.0, largest, 0.0, 0.0, 0.0, 1.0]));
        particles.push(Row8([far, far, far, largest, 0.0, 0.0, 0.0, 1.0]));
        let state = State {
            spin: vec![Row4::default(); particles.len()],
            ids: spheres.iter().map(|s| s.id).collect(),
            materials: materials.to_vec(),
            films: Vec::new(),
            particles,
            cell,
            gradient: [[0.0; 3]; 3],
            strain: [[0.0; 3]; 3],
            walked: 0.0,
            anchor: [[0.0; 3]; 3],
            time: 0.0,
            step: 0,
            dt: 0.0,
            pairs: Pairs::default(),
            skin: 0.02 * 2.0 * largest,
            travel: f64::INFINITY,
            distortion: 0.0,
            steps_since_rebuild: 0,
            rebuilds: 0,
            inner_list: InnerList::new(0.002 * 2.0 * largest),
            sums: ContactSums::default(),
            fastest_peak: 0.0,
            ledger: Ledger::default(),
            servo: Servo::default(),
            control: CellControl::fixed(),
            global_damping: 0.0,
            servo_error: ServoError::default(),
            judge_from: 0.0,
            clumps,
            bonds: Bonds::default(),
            listed_pairs: Vec::new(),
        };
        let mut simulation = Simulation { integrator: Integrator::new(state, properties) };
        simulation.integrator.rebuild();
        simulation.integrator.wet_grains(None);
        stepping::forces(&mut simulation.integrator);
        simulation.integrator.reset_time_step();
        Ok(simulation)
    }

    /// A simulation from its parts, as stored in a checkpoint.
    pub(crate) fn from_parts(state: State, properties: Properties) -> Result<Simulation, SimulationError> {
        check_properties(&properties, smallest(&state))?;
        check_assignment(&state.materials, state.pieces(), &properties.mixture)?;
        check_clumps(&state.clumps, &properties)?;
        Ok(Simulation { integrator: Integrator::new(state, properties) })
    }

    /// Sets the number of threads and the instruction set. Results do not depend on them.
    pub fn set_hardware(&mut self, hardware: Hardware) {
        self.integrator.hardware = hardware;
    }

    /// Calls every law through its slot from now on, also in sets of laws that are compiled into one loop, until other laws are set
    /// with [`Simulation::set_properties`]. Results have the same bits and take longer: for comparisons of the two.
    pub fn call_laws_through_slots(&mut self) {
        self.integrator.stages = ContactStages::any();
    }

    /// Adds something that acts on the grains from outside, from the next step on. It is no part of a checkpoint.
    pub fn add_boundary(&mut self, boundary: Arc<dyn Boundary>) {
        self.integrator.boundaries.push(boundary);
        stepping::forces(&mut self.integrator);
        self.integrator.reset_time_step();
    }

    /// What acts on the grains from outside.
    pub fn boundaries(&self) -> &[Arc<dyn Boundary>] {
        &self.integrator.boundaries
    }

    /// Sets the control of the cell and resets the servo.
    pub fn set_control(&mut self, control: CellControl) {
        self.integrator.state.control = control;
        self.integrator.state.servo = Servo::default();
    }

    /// Changes the control of the cell during a test: combinations of stresses that are held by the same strain rates as before keep the
    /// integrals of the servo, so that a control whose targets are changed often holds them as well as one that is not changed.
    pub fn change_control(&mut self, control: CellControl) {
        let state = &mut self.integrator.state;
        state.servo = state.servo.carried(&state.control, &control);
        state.control = control;
    }

    /// Changes the bound on the rates that the servo adds, and keeps its integrals.
    pub fn set_rate_limit(&mut self, limit: f64) {
        self.integrator.state.control.rate_limit = limit;
    }

    /// Sets the rate of global damping of the velocities, 1/s (for preparation only; zero is none).
    pub fn set_global_damping(&mut self, rate: f64) {
        self.integrator.state.global_damping = rate;
    }

    /// Sets the time step as a fraction of `sqrt(m / k_t)` of the stiffest contact.
    pub fn set_time_step_factor(&mut self, factor: f64) {
        self.integrator.time_step_factor = factor;
        self.integrator.reset_time_step();
    }

    /// Fixes the time step, s, or lets it follow the stiffest contact again.
    pub fn fix_time_step(&mut self, time_step: Option<f64>) {
        self.integrator.fixed_time_step = time_step;
        self.integrator.reset_time_step();
    }

    /// Sets the expected mean normal force, N, so that the time step is suitable from the start (`p d^2` for a sample at p).
    pub fn expect_force(&mut self, force: f64) {
        self.integrator.expected_force = force;
        self.integrator.reset_time_step();
    }

    /// Changes the material or the contact laws. Contacts keep the history of a tangential or moment law that stays;
    /// the forces of a new law start from zero, as do all where contacts gain or lose an area. Masses are scaled with
    /// the density, velocities and spins with its inverse root: without gravity this only rescales time, and the
    /// kinetic energy is unchanged. The materials of the grains do not change; the densities of several materials can only
    /// change by one factor.
    ///
    /// # Errors
    /// If a material or the laws cannot be, or the materials are not as many as before.
    pub fn set_properties(&mut self, properties: Properties) -> Result<(), SimulationError> {
        check_properties(&properties, smallest(&self.integrator.state))?;
        check_assignment(
            &self.integrator.state.materials,
            self.integrator.state.pieces(),
            &properties.mixture,
        )?;
        check_clumps(&self.integrator.state.clumps, &properties)?;
        let before = self.integrator.properties.contact;
        let ratio = self.integrator.density_ratio(&properties)?;
        self.integrator.scale_density(ratio);
        self.integrator.stages = ContactStages::for_laws(&properties.contact);
        let films = self.integrator.first_films();
        self.integrator.set_properties(properties);
        self.integrator.change_bridges(&before);
        self.integrator.wet_grains(films.as_deref());
        self.integrator.change_history(&before);
        self.integrator.rebuild();
        self.integrator.make_bridges();
        Ok(())
    }

    /// Material and contact laws.
    pub fn properties(&self) -> &Properties {
        &self.integrator.properties
    }

    /// Advances by `steps` steps.
    pub fn advance(&mut self, steps: u64) -> Result<(), SimulationError> {
        stepping::advance(&mut self.integrator, steps)
    }

    /// The state, read-only.
    pub fn state(&self) -> &State {
        &self.integrator.state
    }

    /// Advances until the first step at which one of the goals is reached, but by at most `most_steps` steps.
    ///
    /// # Errors
    /// As for [`Simulation::advance`].
    pub fn advance_to(&mut self, goals: &[MeasureGoal], most_steps: u64) -> Result<(), SimulationError> {
        self.integrator.goals.clear();
        self.integrator.goals.extend_from_slice(goals);
        let result = self.advance(most_steps);
        self.integrator.goals.clear();
        result
    }

    /// Reverses base rates and moving targets of the control.
    pub(crate) fn reverse(&mut self) {
        let state = &mut self.integrator.state;
        let (stress, strain) = (state.stress(), state.strain());
        state.control.reverse(state.time, &stress, &strain);
    }

    /// Damps velocities globally at a rate that is a fraction of the frequency `sqrt(k_t / m)` of a contact; zero is none.
    pub(crate) fn damp_globally(&mut self, fraction: f64) {
        let rate = fraction * self.integrator.time_step_factor / self.integrator.state.dt;
        self.integrator.state.global_damping = rate;
    }

    /// Restarts the statistics of the servo, from an arc length of strain on.
    pub(crate) fn judge_servo(&mut self, from: f64) {
        self.integrator.state.judge_from = from;
        self.integrator.state.servo_error = ServoError::default();
    }

    /// Starts a phase: strain, time, steps, energy balance and servo statistics count from here, the last from the arc
    /// length of strain `judge_from` on.
    pub fn reset_phase(&mut self, judge_from: f64) {
        self.integrator.state.reset_phase(judge_from);
    }

    /// A snapshot for sensors. It copies the data that it contains and changes nothing.
    pub fn assembly(&self) -> Assembly {
        let mut assembly = Assembly::default();
        self.assembly_into(&mut assembly);
        assembly
    }

    /// The same in place of an older one, whose memory is used again.
    pub fn assembly_into(&self, assembly: &mut Assembly) {
        let integrator = &self.integrator;
        let names = integrator.properties.mixture.components.iter().map(|component| component.name.clone());
        assembly.materials = names.collect();
        integrator.state.assembly_into(&integrator.alike, &integrator.properties.contact, assembly);
    }

    /// Mean diameter of the grains, m.
    pub fn mean_diameter(&self) -> f64 {
        self.integrator.mean_diameter()
    }

    /// The strain rate, 1/s, that has this inertial number at a mean stress, Pa: `I sqrt(p / rho) / d`.
    pub fn strain_rate(&self, inertial_number: f64, mean_stress: f64) -> f64 {
        inertial_number * (mean_stress / self.integrator.mean_density()).sqrt() / self.mean_diameter()
    }

    /// Number of pairs in the neighbour list.
    pub fn near_pairs(&self) -> usize {
        self.integrator.state.pairs.count
    }

    /// Number of times the neighbour list was built.
    pub fn rebuilds(&self) -> u64 {
        self.integrator.state.rebuilds
    }

    /// Gives fluctuating velocities and spins to the grains, in the order of their ids.
    pub fn set_velocities(&mut self, velocities: &[Vector], spins: &[Vector]) {
        let state = &mut self.integrator.state;
        for (rank, body) in state.bodies_in_order().into_iter().enumerate() {
            let (velocity, spin) = (velocities.get(rank), spins.get(rank));
            match body {
                BodyPlace::Sphere(row) => {
                    if let Some(v) = velocity {
                        state.particles[row].set_velocity(v);
                    }
                    if let Some(w) = spin {
                        state.spin[row].0[..3].copy_from_slice(w);
                    }
                }
                BodyPlace::Clump(k) => {
                    let clump = &mut state.clumps.bodies[k];
                    if let Some(v) = velocity {
                        clump.velocity = *v;
                    }
                    if let Some(w) = spin {
                        clump.momentum = rotor::momentum(&clump.orientation, w, &clump.inertia);
                    }
                }
            }
        }
        state.clumps.move_rows(&state.gradient, &mut state.particles, &mut state.spin);
    }
}

/// Refuses laws that have no meaning for bodies of several pieces.
fn check_clumps(clumps: &Clumps, properties: &Properties) -> Result<(), SimulationError> {
    let law = properties.contact.adhesion.law();
    if !clumps.is_empty() && law.shares_liquid() {
        return Err(SimulationError::LiquidOfClumps { law: properties.contact.adhesion.name() });
    }
    Ok(())
}

impl ObservedState for Simulation {
    fn grains(&self) -> usize {
        self.state().grains()
    }
    fn contacts(&self) -> usize {
        self.state().contacts()
    }
    fn step(&self) -> u64 {
        self.state().step()
    }
    fn macro_state(&self) -> MacroState {
        self.state().macro_state()
    }
    fn parts(&self) -> Parts {
        Parts::all()
    }
    fn assembly_into(&self, assembly: &mut Assembly) {
        Simulation::assembly_into(self, assembly);
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
    fn solid_fraction(&self) -> f64 {
        self.state().solid_fraction()
    }
}

fn check_spheres(cell: &Cell, spheres: &[InitialSphere], clumps: &Clumps) -> Result<(), SimulationError> {
    if spheres.is_empty() {
        return Err(SimulationError::NoGrains);
    }
    let volume = cell.volume();
    if !(volume.is_finite() && volume > 0.0) {
        return Err(SimulationError::Cell(volume));
    }
    let mut seen = HashSet::with_capacity(spheres.len());
    for s in spheres {
        let grain = |what: String| SimulationError::Grain { id: s.id, what };
        if !(s.radius.is_finite() && s.radius > 0.0) {
            return Err(grain(format!("its radius is {} m; it must be positive", s.radius)));
        }
        if s.position.iter().any(|x| !x.is_finite()) {
            return Err(grain(format!("its position {:?} is not finite", s.position)));
        }
        // The pieces of a clump have its id, and its own was looked at before.
        if clumps.is_empty() && !seen.insert(s.id) {
            return Err(grain("its id occurs twice; ids must differ".into()));
        }
    }
    let largest = spheres.iter().fold(0.0f64, |m, s| m.max(s.radius));
    let height = cell.heights().into_iter().fold(f64::INFINITY, f64::min);
    if height < largest {
        return Err(SimulationError::Thin { height, diameter: 2.0 * largest });
    }
    Ok(())
}

/// Smallest radius of a piece, m.
fn smallest(state: &State) -> f64 {
    state.particles[..state.pieces()].iter().fold(f64::INFINITY, |m, row| m.min(row.radius()))
}

impl Integrator {
    /// Constants of the pair in a slot.
    pub(crate) fn pair_constants(&self, slot: usize) -> PairConstants<f64> {
        if self.equal {
            return self.alike;
        }
        let (b, l) = (slot / LANES, slot % LANES);
        let laws = &self.properties.contact;
        let count = laws.constants_kept();
        PairConstants::from_columns(count, |c| self.state.pairs.constants[b * count + c].0[l])
    }

    /// The factor by which densities change with other properties.
    fn density_ratio(&self, properties: &Properties) -> Result<f64, SimulationError> {
        let before = &self.properties;
        if before.mixture.is_empty() {
            return Ok(properties.material.density / before.material.density);
        }
        let densities = |of: &Properties| -> Vec<f64> {
            of.mixture.components.iter().map(|component| component.material.density).collect()
        };
        let (old, new) = (densities(before), densities(properties));
        let ratio = new[0] / old[0];
        let same = old.len() == new.len()
            && old.iter().zip(&new).all(|(old, new)| (new / old / ratio - 1.0).abs() < 1e-12);
        if same {
            return Ok(ratio);
        }
        let what =
            "the densities of the materials of a simulation can be changed only by a common factor".into();
        Err(SimulationError::Assignment { what })
    }

    fn scale_density(&mut self, ratio: f64) {
        if ratio == 1.0 {
            return;
        }
        let state = &mut self.state;
        let grains = state.pieces();
        let slower = 1.0 / ratio.sqrt();
        for (particle, spin) in state.particles[..grains].iter_mut().zip(&mut state.spin) {
            particle.set_mass(particle.mass() * ratio);
            for k in 0..3 {
                particle.0[4 + k] *= slower;
                spin.0[k] *= slower;
            }
        }
        state.clumps.scale(ratio, slower);
        state.bonds.scale(ratio);
        state.sums.fastest /= ratio;
        // Half of the work in the first step uses the power of the last one, which was computed on the old time scale.
        state.sums.boundary_power *= slower;
        state.gradient = state.gradient.map(|row| row.map(|rate| rate * slower));
        state.fastest_peak /= ratio;
        state.dt /= slower;
    }

    /// Carries the histories of all contacts over to the present laws: their normals, and the histories of laws that stayed.
    fn change_history(&mut self, before: &ContactModel) {
        let now = &self.properties.contact;
        // A tangential history may contain the tangential measure of the normal law: an area, or a stiffness.
        let measured_alike =
            now.normal.law().traits().contact_area == before.normal.law().traits().contact_area;
        let same = [
            now.tangential == before.tangential && measured_alike,
            now.rolling == before.rolling && measured_alike,
            now.adhesion == before.adhesion,
            now.normal == before.normal,
        ];
        if same == [true; 4] {
            return;
        }
        let [tangential, moments, adhesion, normal] = now.history();
        let columns = NORMAL_COLUMNS + tangential + moments + adhesion + normal;
        let old = &self.state.pairs;
        // Columns of the new history, with their positions in the old one.
        let mut kept: Vec<[usize; 2]> = (0..NORMAL_COLUMNS).map(|c| [c, c]).collect();
        if same[0] {
            kept.extend((NORMAL_COLUMNS..NORMAL_COLUMNS + tangential).map(|c| [c, c]));
        }
        if same[1] {
            kept.extend((0..moments).map(|c| [NORMAL_COLUMNS + tangential + c, old.columns[0] + c]));
        }
        if same[2] {
            let (to, from) = (NORMAL_COLUMNS + tangential + moments, old.columns[0] + old.columns[1]);
            kept.extend((0..adhesion).map(|c| [to + c, from + c]));
        }
        if same[3] {
            let from: usize = old.columns[..3].iter().sum();
            kept.extend((0..normal).map(|c| [columns - normal + c, from + c]));
        }
        let stride = old.columns_in_all();
        let mut memory = vec![Row8::default(); old.batches() * columns];
        for b in 0..old.batches() {
            for [to, from] in &kept {
                memory[b * columns + to] = old.memory[b * stride + from];
            }
        }
        self.state.pairs.memory = memory;
        self.state.pairs.columns = [NORMAL_COLUMNS + tangential, moments, adhesion, normal];
        if !same[2] {
            // Another law starts without the histories of this one for separated pairs.
            self.state.pairs.marks.iter_mut().for_each(|marks| marks.attracting = 0);
        }
    }
}
