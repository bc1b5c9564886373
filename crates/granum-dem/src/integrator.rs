//! The time integrator: the serial part of a step. It keeps the neighbour lists, the time step, the servo and the energy
//! balance; the parallel stages of a step are in [`crate::kernel`].

use std::sync::Arc;

use granum_simd::{LANES, Row4, Row8};

use crate::assembly::Matrix;
use crate::blocks::{self, Change};
use crate::bond::BondWork;
use crate::boundary::Boundary;
use crate::clump::clumps::NO_CLUMP;
use crate::clump::ranks::Ranks;
use crate::config::MOST_CONTACTS;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact_sums::ContactSums;
use crate::hardware::Hardware;
use crate::images;
use crate::inner_list::{InnerList, Nearness};
use crate::kernel::{ContactStages, Views};
use crate::known_constants::KnownConstants;
use crate::loading::measure::MeasureGoal;
use crate::pair_table::{MaterialPair, PairTable};
use crate::pairs::{self, NORMAL_COLUMNS};
use crate::particle_row::ParticleRow;
use crate::properties::Properties;
use crate::search::{self, Near};
use crate::servo::ServoInput;
use crate::simulation_error::SimulationError;
use crate::state::State;
use crate::team::RawSlice;

/// Number of steps after which the time step may be raised.
const TIME_STEP_WINDOW: u64 = 256;
/// The neighbour list should last this many steps; the skin is adapted to that.
const WANTED_LIFE: std::ops::Range<u64> = 300..1200;
/// The grains are sorted in space again after this many rebuilds of the list.
const REORDER_EVERY: u64 = 64;

/// From this size of the contact data on, in bytes, the kernels prefetch it: below, it stays in the caches.
const FAR: usize = 2 << 20;

/// The state of a simulation with everything that advances it in time.
#[derive(Clone)]
pub(crate) struct Integrator {
    pub(crate) state: State,
    pub(crate) properties: Properties,
    /// What grains of any two materials have in common, by these properties.
    table: PairTable,
    pub(crate) stages: ContactStages,
    pub(crate) hardware: Hardware,
    pub(crate) time_step_factor: f64,
    pub(crate) fixed_time_step: Option<f64>,
    pub(crate) expected_force: f64,
    /// True where all grains have the same size, mass and material. This is not seen from the constants of pairs: there are none as long as no
    /// grain is near another.
    pub(crate) equal: bool,
    /// Constants of every pair where all grains are equal.
    pub(crate) alike: PairConstants<f64>,
    /// Largest distance of the surfaces at which a contact that is torn breaks, and at which grains that do not touch act on each
    /// other, m.
    reach: f64,
    range: f64,
    pub(crate) contact_sums: Vec<ContactSums>,
    fastest_grain: Vec<f64>,
    nearness: Vec<Nearness>,
    /// The clump of each row, and the arm of each from the centre of its body; empty without clumps. Both follow from the state.
    pub(crate) clump_of: Vec<u32>,
    pub(crate) arms: Vec<Row4>,
    ranks: Ranks,
    pub(crate) bond_work: BondWork,
    /// Share of the time step of spheres that all clumps allow.
    clump_share: f64,
    /// What acts on grains from outside, beside the cell.
    pub(crate) boundaries: Vec<Arc<dyn Boundary>>,
    /// Goals that end a series of steps early.
    pub(crate) goals: Vec<MeasureGoal>,
    /// Largest radius of a piece, and mean radius of the spheres of the volumes of the bodies, m.
    largest_radius: f64,
    mean_radius: f64,
    /// Diameter of the largest ball about the centre of a clump that holds all of it, m; zero without clumps.
    longest_clump: f64,
    /// Volume of the grains of each material, m3, and how many materials there are among the grains.
    volumes: Vec<f64>,
}

impl Integrator {
    pub(crate) fn new(state: State, properties: Properties) -> Integrator {
        let mut integrator = Integrator {
            state,
            table: properties.table(),
            stages: ContactStages::for_laws(&properties.contact),
            properties,
            hardware: Hardware::default(),
            time_step_factor: 0.2,
            fixed_time_step: None,
            expected_force: 0.0,
            equal: false,
            alike: PairConstants::from_columns(PairConstants::COUNT, |_| 0.0),
            reach: 0.0,
            range: 0.0,
            contact_sums: Vec::new(),
            fastest_grain: Vec::new(),
            nearness: Vec::new(),
            clump_of: Vec::new(),
            arms: Vec::new(),
            ranks: Ranks::default(),
            bond_work: BondWork::default(),
            clump_share: 1.0,
            boundaries: Vec::new(),
            goals: Vec::new(),
            largest_radius: 0.0,
            mean_radius: 0.0,
            longest_clump: 0.0,
            volumes: Vec::new(),
        };
        integrator.measure_bodies();
        integrator.bond_work = BondWork::new(&integrator.state.bonds);
        integrator
    }

    /// Measures what follows from the bodies.
    pub(crate) fn measure_bodies(&mut self) {
        self.measure_grains();
        self.clump_share = self.state.clumps.time_step_share();
        self.find_rows_of_clumps();
    }

    /// Finds which rows are pieces of clumps, and where those are.
    fn find_rows_of_clumps(&mut self) {
        let rows = self.state.particles.len();
        self.clump_of = self.state.clumps.of_rows(rows);
        self.arms = self.state.clumps.arms(rows);
        self.ranks = Ranks::new(&self.state.clumps);
    }

    /// Measures the sizes, which never change. The sum runs in the order of the grain ids: the storage order changes when
    /// grains are sorted in space, and a sum in storage order would differ in its last bits after a restart.
    fn measure_grains(&mut self) {
        let state = &self.state;
        let bodies = state.bodies_in_order();
        let radii = bodies.iter().map(|body| state.equivalent_radius(*body));
        let pieces = &state.particles[..state.pieces()];
        self.largest_radius = pieces.iter().map(|row| row.radius()).fold(0.0, f64::max);
        self.mean_radius = radii.sum::<f64>() / bodies.len() as f64;
        self.longest_clump = state.clumps.longest();
        self.volumes = vec![0.0; self.properties.mixture.components.len()];
        for body in bodies {
            let material = state.materials.get(state.row_of(body));
            if let Some(volume) = material.and_then(|k| self.volumes.get_mut(*k as usize)) {
                *volume += 4.0 / 3.0 * std::f64::consts::PI * state.equivalent_radius(body).powi(3);
            }
        }
    }

    /// Takes other properties.
    pub(crate) fn set_properties(&mut self, properties: Properties) {
        self.table = properties.table();
        self.properties = properties;
    }

    /// Density of the grains in the mean over their volume, kg/m3.
    pub(crate) fn mean_density(&self) -> f64 {
        let components = &self.properties.mixture.components;
        let Some(first) = components.first() else { return self.properties.material.density };
        let density = first.material.density;
        if components.iter().all(|component| component.material.density == density) {
            return density;
        }
        let mass: f64 = components.iter().zip(&self.volumes).map(|(c, v)| c.material.density * v).sum();
        mass / self.volumes.iter().sum::<f64>()
    }

    pub(crate) fn mean_diameter(&self) -> f64 {
        2.0 * self.mean_radius
    }

    /// Largest distance of the surfaces at which grains that do not touch begin to act on each other, m.
    fn onset(&self) -> f64 {
        if self.properties.contact.adhesion.law().begins_at_touch() { 0.0 } else { self.range }
    }

    fn all_alike(&self) -> bool {
        let n = self.state.pieces();
        let first = self.state.particles[0];
        self.table.is_one()
            && self.state.particles[..n]
                .iter()
                .all(|r| r.radius() == first.radius() && r.mass() == first.mass())
    }

    /// The material of the grain in a place; the phantoms have that of the first grain.
    pub(crate) fn material_of(&self, grain: u32) -> u8 {
        self.state.materials.get(grain as usize).or(self.state.materials.first()).copied().unwrap_or(0)
    }

    /// The laws between a grain and others of its material.
    pub(crate) fn contact_of_grain(&self, grain: u32) -> &ContactModel {
        let material = self.material_of(grain);
        &self.table.between(material, material).contact
    }

    /// Constants of a pair of grains of given materials and radii, m.
    pub(crate) fn constants_of(&self, [a, b]: [u8; 2], radii: [f64; 2]) -> PairConstants<f64> {
        let materials = self.table.between(a, b);
        materials.contact.constants(&materials.pair(radii))
    }

    /// Constants of a pair of pieces of given materials, radii, m, and masses of their bodies, kg, if these are not those of spheres.
    fn constants_of_pieces(
        &self,
        [a, b]: [u8; 2],
        radii: [f64; 2],
        masses: Option<[f64; 2]>,
    ) -> PairConstants<f64> {
        let Some(masses) = masses else { return self.constants_of([a, b], radii) };
        let materials = self.table.between(a, b);
        materials.contact.constants(&materials.pair(radii).of_bodies(radii, masses))
    }

    /// The masses of the bodies of two rows, kg, if there are clumps: those of spheres follow from their radii.
    fn masses_of(&self, rows: [u32; 2]) -> Option<[f64; 2]> {
        self.state.has_clumps().then(|| rows.map(|row| self.state.particles[row as usize].mass()))
    }

    /// Rebuilds the neighbour list: wraps the grains into the cell, sorts them in space every [`REORDER_EVERY`] rebuilds,
    /// searches, and carries the contact histories over.
    pub(crate) fn rebuild(&mut self) {
        let n = self.state.pieces();
        adapt_skin(&mut self.state, 2.0 * self.largest_radius);
        let state = &mut self.state;
        let moved = images::wrap(&state.cell, &mut state.particles[..n]);
        state.clumps.wrap(&state.cell, &moved);
        state.bonds.wrap(&moved);
        let reorder = state.rebuilds.is_multiple_of(REORDER_EVERY);
        let new_place = reorder.then(|| reorder_grains(state, 2.0 * self.largest_radius));
        self.renew_bonds(new_place.as_deref());
        let laws = self.properties.contact;
        self.find_rows_of_clumps();
        let state = &mut self.state;
        self.range = self.table.range(self.largest_radius);
        let near =
            search::find(self.hardware.isa, &state.cell, &state.particles[..n], state.skin + self.range);
        let near = between_bodies(near, &self.clump_of);
        let [tangential, moments, adhesion, normal] = laws.history();
        let columns = [NORMAL_COLUMNS + tangential, moments, adhesion, normal];
        let old = std::mem::take(&mut state.pairs);
        let change = Change {
            moved: &moved,
            new_place: new_place.as_deref(),
            swap: &|memory| laws.swap_sides(memory),
            skin: laws.adhesion.law().begins_at_touch().then_some(state.skin),
        };
        state.pairs = blocks::rebuild(old, &near, &state.cell, &state.particles[..n], &change, columns);
        state.travel = 0.0;
        state.distortion = 0.0;
        state.steps_since_rebuild = 0;
        state.rebuilds += 1;
        state.inner_list.travel = f64::NEG_INFINITY;
        self.prepare_constants();
    }

    pub(crate) fn prepare_constants(&mut self) {
        let radius = self.state.particles[0].radius();
        let laws = self.properties.contact;
        self.alike = self.constants_of_pieces([self.material_of(0); 2], [radius; 2], self.masses_of([0; 2]));
        self.range = self.table.range(self.largest_radius);
        self.reach = if self.table.is_one() {
            -laws.breaking_overlap(&self.alike)
        } else {
            self.table.reach(self.largest_radius)
        };
        self.state.pairs.constants = Vec::new();
        // Pieces of clumps have loops for unequal grains alone.
        self.equal = !self.state.has_clumps() && self.all_alike();
        if self.equal {
            return;
        }
        let count = laws.constants_kept();
        let batches = self.state.pairs.batches();
        let mut rows = vec![Row8::default(); batches * count];
        let mut known = KnownConstants::default();
        for b in 0..batches {
            for l in 0..LANES {
                let [i, j] = [&self.state.pairs.first, &self.state.pairs.second].map(|list| list[b][l]);
                let materials = [self.material_of(i), self.material_of(j)];
                let radii = [i, j].map(|grain| self.state.particles[grain as usize].radius());
                let masses = self.masses_of([i, j]);
                let make = || self.constants_of_pieces(materials, radii, masses).to_array();
                let values = known.constants(materials, radii, masses, make);
                for c in 0..count {
                    rows[b * count + c].0[l] = values[c];
                }
            }
        }
        self.state.pairs.constants = rows;
    }

    /// Stiffness over mass of a contact that carries the expected force, 1/s2: a lower bound for the choice of the time
    /// step.
    fn expected_fastest(&self) -> f64 {
        let of_pair = |materials: &MaterialPair| {
            let pair = materials.pair([self.mean_radius; 2]);
            let force =
                self.expected_force.max(1e-6 * pair.effective_modulus * pair.effective_radius.powi(2));
            let [_, stiffness] = materials.contact.stiffness_under(&pair, force);
            // The mass of the lighter of the two.
            let [a, b] = materials.materials.map(|material| material.density);
            let mass = if a == b { 2.0 } else { (a + b) / a.max(b) } * pair.effective_mass;
            stiffness / mass
        };
        self.table.all().iter().map(of_pair).fold(0.0, f64::max)
    }

    fn time_step_for(&self, fastest: f64) -> f64 {
        self.time_step_factor * self.damped_share() * self.clump_share
            / fastest.max(self.expected_fastest()).sqrt()
    }

    /// Fraction of the time step that remains with dashpots stronger than the default ones.
    fn damped_share(&self) -> f64 {
        let (contact, usual) = (self.properties.contact, ContactModel::default());
        if contact.damping <= usual.damping {
            return 1.0;
        }
        contact.stable_fraction(MOST_CONTACTS) / usual.stable_fraction(MOST_CONTACTS)
    }

    pub(crate) fn reset_time_step(&mut self) {
        self.state.fastest_peak = self.state.sums.fastest;
        self.state.dt = self.fixed_time_step.unwrap_or_else(|| self.time_step_for(self.state.sums.fastest));
    }

    /// Shortens the time step at once when a contact requires it; lengthens it slowly.
    fn adapt_time_step(&mut self) {
        if self.fixed_time_step.is_some() {
            return;
        }
        let fastest = self.state.sums.fastest;
        self.state.fastest_peak = self.state.fastest_peak.max(fastest);
        let allowed = self.time_step_for(fastest);
        if self.state.dt > allowed {
            self.state.dt = allowed;
        } else if self.state.step.is_multiple_of(TIME_STEP_WINDOW) {
            self.state.dt = (1.02 * self.state.dt).min(self.time_step_for(self.state.fastest_peak));
            self.state.fastest_peak = fastest;
        }
    }

    /// Serial work before the grains move: servo, time step, cell, image vectors.
    pub(crate) fn begin_step(&mut self, views: &mut Views) {
        self.adapt_time_step();
        let state = &mut self.state;
        let volume = state.cell.volume();
        let sample = ServoInput {
            stress: state.stress(),
            strain: state.strain,
            bulk_modulus: state.sums.stiffness / (9.0 * volume),
            time: state.time,
            dt: state.dt,
        };
        let control = state.control;
        let before = state.gradient;
        state.gradient = state.servo.gradient(&control, &sample);
        state.judge_servo();
        // The first half of the step uses the forces at its start with the new velocity gradient.
        let mut power = state.sums.boundary_power;
        for r in 0..3 {
            for c in 0..3 {
                power -= state.sums.virial[3 * r + c] * (state.gradient[r][c] - before[r][c]);
            }
        }
        state.ledger.balance.boundary_work += 0.5 * state.dt * power;
        state.cell = state.cell.strained(&state.gradient, state.dt);
        for r in 0..3 {
            for c in 0..3 {
                state.strain[r][c] -= state.dt * state.gradient[r][c];
            }
        }
        state.walk();
        views.gradient = state.gradient;
        views.edges = state.cell.edges;
        views.dt = state.dt;
        views.retain = 1.0 - state.global_damping * state.dt;
        views.sampling_weight = crate::discarded::sampling_weight(state.step);
        views.images = images::image_table(self.hardware.isa, &state.cell);
    }

    /// Serial work after the contacts: totals, energy balance, list statistics.
    pub(crate) fn end_step(&mut self, fastest_grain: f64, rebuilt: bool) -> Result<(), SimulationError> {
        self.state.sums = ContactSums::total(&self.contact_sums);
        self.add_bonds();
        self.add_loads();
        let state = &mut self.state;
        state.ledger.add(state.dt, &state.sums);
        state.time += state.dt;
        state.step += 1;
        state.steps_since_rebuild += 1;
        state.inner_list.steps += 1;
        if !rebuilt {
            state.travel += fastest_grain.sqrt() * state.dt;
            state.distortion += norm(&state.gradient) * state.dt;
        }
        let volume = state.cell.volume();
        let finite = volume.is_finite() && volume > 0.0 && fastest_grain.is_finite();
        if !(finite && state.sums.virial.iter().all(|x| x.is_finite())) {
            return Err(SimulationError::Diverged { step: state.step, time_step: state.dt });
        }
        // Looked at once a neighbour list: within one a cell is hardly deformed.
        let longest = self.longest_clump;
        let thinnest = || self.state.cell.heights().into_iter().fold(f64::INFINITY, f64::min);
        if rebuilt && longest > 0.0 && thinnest() < longest {
            return Err(SimulationError::NarrowForClumps { height: thinnest(), diameter: longest });
        }
        Ok(())
    }

    /// True if one of the goals is reached.
    pub(crate) fn event_has_come(&self) -> bool {
        if self.goals.is_empty() {
            return false;
        }
        let macro_state = self.state.macro_state();
        self.goals.iter().any(|goal| goal.has_come(&macro_state))
    }

    pub(crate) fn views(&mut self) -> Views {
        let s = &mut self.state;
        let blocks = s.pairs.blocks.len();
        self.contact_sums.clear();
        self.contact_sums.resize(blocks, ContactSums::default());
        self.fastest_grain.clear();
        self.fastest_grain.resize(blocks, 0.0);
        self.nearness.clear();
        self.nearness.resize(s.pairs.batches(), Nearness::default());
        Views {
            grains: s.ids.len(),
            images: images::image_table(self.hardware.isa, &s.cell),
            particles: RawSlice::new(&mut s.particles),
            spin: RawSlice::new(&mut s.spin),
            blocks: RawSlice::new(&mut s.pairs.blocks),
            first: RawSlice::new(&mut s.pairs.first),
            second: RawSlice::new(&mut s.pairs.second),
            target: RawSlice::new(&mut s.pairs.target),
            image: RawSlice::new(&mut s.pairs.image),
            memory: RawSlice::new(&mut s.pairs.memory),
            films: RawSlice::new(&mut s.films),
            marks: RawSlice::new(&mut s.pairs.marks),
            nearness: RawSlice::new(&mut self.nearness),
            columns: s.pairs.columns_in_all(),
            constants: RawSlice::new(&mut s.pairs.constants),
            forces: RawSlice::new(&mut s.pairs.forces),
            outer_offsets: RawSlice::new(&mut s.pairs.outer_offsets),
            outer: RawSlice::new(&mut s.pairs.outer),
            contact_sums: RawSlice::new(&mut self.contact_sums),
            fastest_grain: RawSlice::new(&mut self.fastest_grain),
            clumps: RawSlice::new(&mut s.clumps.bodies),
            ranks: RawSlice::new(&mut self.ranks.ranks),
            ranks_of_eight: RawSlice::new(&mut self.ranks.of_eight),
            clump_of: RawSlice::new(&mut self.clump_of),
            arms: RawSlice::new(&mut self.arms),
            bonds: self.bond_work.views(&mut s.bonds),
            equal: self.equal,
            far: (s.pairs.memory.len() + s.pairs.constants.len()) * size_of::<Row8>() > FAR,
            alike: self.alike,
            constants_kept: self.properties.contact.constants_kept(),
            laws: self.properties.contact,
            isa: self.hardware.isa,
            gradient: s.gradient,
            edges: s.cell.edges,
            dt: s.dt,
            inner_skin: s.inner_list.inner_skin,
            onset: self.onset(),
            sampling_weight: 0.0,
            retain: 1.0,
        }
    }

    /// True if the list may miss a contact after the grains have moved by up to `step_travel` more.
    pub(crate) fn list_is_stale(&self, views: &Views, fastest: f64) -> bool {
        let state = &self.state;
        let travel = state.travel + fastest.sqrt() * views.dt;
        let distortion = state.distortion + norm(&views.gradient) * views.dt;
        let diameter = 2.0 * self.largest_radius + state.skin + self.range;
        // With a NaN no list is valid; the step that produced it is reported at its end.
        let bound = 2.0 * travel + 1.01 * distortion * diameter + self.reach;
        bound > state.skin && bound.is_finite()
    }

    /// True if a pair outside the inner list may have come to touch, so that the lists must be pruned again; the bounds on
    /// travel are reset for that. The motion of a step that rebuilds the list does not count, since the list is built
    /// after it.
    pub(crate) fn prune_again(&mut self, views: &mut Views, fastest: f64, renewed: bool) -> bool {
        let diameter = 2.0 * self.largest_radius + self.state.skin + self.range;
        let state = &mut self.state;
        let (mut travel, mut distortion) = (state.travel, state.distortion);
        if !renewed {
            travel += fastest.sqrt() * views.dt;
            distortion += norm(&views.gradient) * views.dt;
        }
        let inner_list = &mut state.inner_list;
        if inner_list.holds(travel, distortion, diameter) {
            return false;
        }
        if !renewed {
            inner_list.adapt(state.skin);
        }
        *inner_list = InnerList { travel, distortion, steps: 0, ..*inner_list };
        views.inner_skin = inner_list.inner_skin;
        true
    }
}

/// Frobenius norm: an upper bound on the rate at which any vector is strained.
fn norm(m: &Matrix) -> f64 {
    m.iter().flatten().map(|x| x * x).sum::<f64>().sqrt()
}

/// Widens the skin of a list that lasted too few steps, and narrows that of a list that lasted too many.
fn adapt_skin(state: &mut State, diameter: f64) {
    if state.rebuilds == 0 {
        return;
    }
    if state.steps_since_rebuild < WANTED_LIFE.start {
        state.skin *= 1.25;
    } else if state.steps_since_rebuild > WANTED_LIFE.end {
        state.skin *= 0.9;
    }
    state.skin = state.skin.clamp(1e-3 * diameter, 0.2 * diameter);
}

/// The pairs of pieces of different bodies: pieces of one clump do not act on each other.
fn between_bodies(mut near: Vec<Near>, clump_of: &[u32]) -> Vec<Near> {
    if !clump_of.is_empty() {
        near.retain(|pair| {
            let [one, two] = [pair.i, pair.j].map(|row| clump_of[row as usize]);
            one == NO_CLUMP || one != two
        });
    }
    near
}

/// Sorts the grains along a space-filling curve; returns the new index of each.
fn reorder_grains(state: &mut State, spacing: f64) -> Vec<u32> {
    let n = state.pieces();
    let order = pairs::spatial_order(&state.cell, &state.particles[..n], spacing);
    let mut new_place = vec![0u32; n];
    for (new, &old) in order.iter().enumerate() {
        new_place[old as usize] = new as u32;
    }
    let particles: Vec<Row8> = order.iter().map(|&o| state.particles[o as usize]).collect();
    let spin: Vec<Row4> = order.iter().map(|&o| state.spin[o as usize]).collect();
    let ids: Vec<u64> = order.iter().map(|&o| state.ids[o as usize]).collect();
    state.particles[..n].copy_from_slice(&particles);
    state.spin[..n].copy_from_slice(&spin);
    state.ids = ids;
    state.clumps.renumber(&new_place);
    state.clumps.sort();
    if !state.films.is_empty() {
        state.films = order.iter().map(|&o| state.films[o as usize]).collect();
    }
    if !state.materials.is_empty() {
        state.materials = order.iter().map(|&o| state.materials[o as usize]).collect();
    }
    new_place
}
