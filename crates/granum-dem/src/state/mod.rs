//! The complete state of a simulation at one instant: the content of a checkpoint, and what sensors observe.

pub(crate) mod bodies;

use granum_core::geometry::dot;
use granum_simd::{LANES, Row4, Row8};
use serde::{Deserialize, Serialize};

use crate::assembly::{EnergyBalance, Matrix, Vector};
use crate::bond::{Bonds, ListedPair};
use crate::cell::Cell;
use crate::clump::clumps::{Clump, Clumps, NO_CLUMP};
use crate::contact_sums::ContactSums;
use crate::images::{NO_IMAGE, image_vector};
use crate::inner_list::InnerList;
use crate::ledger::Ledger;
use crate::loading::measure::MacroState;
use crate::pairs::{Pairs, resultant};
use crate::particle_row::ParticleRow;
use crate::servo::{CellControl, Row, Servo};
use crate::{invariants, rows};
use granum_shape::equivalent_radius;

/// The state of a simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Pieces in spatial order, then two phantoms: x, y, z, R, v'_x, v'_y, v'_z, and the mass m of the body.
    #[serde(with = "rows::eight")]
    pub(crate) particles: Vec<Row8>,
    /// Spins: x, y, z, unused.
    #[serde(with = "rows::four")]
    pub(crate) spin: Vec<Row4>,
    /// Id of the body of each piece.
    pub(crate) ids: Vec<u64>,
    /// Material of each piece, as its place in the mixture; empty where there is one material.
    pub(crate) materials: Vec<u8>,
    /// Volume of the liquid film of each grain, m3; empty as long as no law has shared liquid.
    pub(crate) films: Vec<f64>,
    pub(crate) cell: Cell,
    pub(crate) gradient: Matrix,
    pub(crate) strain: Matrix,
    /// Arc length of the strain path up to the anchor.
    pub(crate) walked: f64,
    /// The strain from which the arc length is measured further.
    pub(crate) anchor: Matrix,
    pub(crate) time: f64,
    pub(crate) step: u64,
    pub(crate) dt: f64,
    pub(crate) pairs: Pairs,
    /// Skin of the neighbour list, m.
    pub(crate) skin: f64,
    /// Bound on the displacement of any grain from affine motion since the list was built, m.
    pub(crate) travel: f64,
    /// Bound on the strain since the list was built.
    pub(crate) distortion: f64,
    pub(crate) steps_since_rebuild: u64,
    pub(crate) rebuilds: u64,
    pub(crate) inner_list: InnerList,
    /// Sums over the contacts in the last step.
    pub(crate) sums: ContactSums,
    /// Largest `k_t / m` since the time step was last raised.
    pub(crate) fastest_peak: f64,
    pub(crate) ledger: Ledger,
    pub(crate) servo: Servo,
    pub(crate) control: CellControl,
    /// Rate of global damping of the velocities, 1/s, used only during the preparation of a sample.
    pub(crate) global_damping: f64,
    /// Relative errors of the controlled stresses from the arc length `judge_from` on.
    pub(crate) servo_error: ServoError,
    pub(crate) judge_from: f64,
    /// Bodies of several pieces. A checkpoint has them at its end, if there are any.
    #[serde(skip)]
    pub(crate) clumps: Clumps,
    /// Bonds. A checkpoint has them at its end, if there ever were any.
    #[serde(skip)]
    pub(crate) bonds: Bonds,
    /// Pairs of pieces that the file of a packing lists as bonded. A checkpoint has them at its end, if there are any.
    #[serde(skip)]
    pub(crate) listed_pairs: Vec<ListedPair>,
}

/// Length of the strain chords that are added up to the arc length: shorter movements to and fro, caused by the servo, do
/// not count.
const ARC_STEP: f64 = 1e-5;

/// Accuracy with which the controlled stresses were held. Each is counted from the time at which it first came within half a
/// per cent of its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ServoError {
    /// For each controlled stress: sum of squares of its error over the mean stress.
    pub squares: [f64; 6],
    /// For each: number of steps counted.
    pub steps: [u64; 6],
    /// For each: largest error over the mean stress.
    pub largest: [f64; 6],
}

/// Error of a controlled stress over the mean stress below which it counts as held.
const HELD: f64 = 0.005;
/// Share of its first value below which a moving target of the mean stress is no measure of errors any more.
const VANISHED: f64 = 0.2;

impl ServoError {
    /// Root mean square of the error over the mean stress, of the worst controlled stress.
    pub fn rms(&self) -> f64 {
        let rms = |(squares, steps): (&f64, &u64)| {
            if *steps == 0 { 0.0 } else { (squares / *steps as f64).sqrt() }
        };
        self.squares.iter().zip(&self.steps).map(rms).fold(0.0, f64::max)
    }

    /// Largest error over the mean stress, of the worst controlled stress.
    pub fn largest(&self) -> f64 {
        self.largest.iter().copied().fold(0.0, f64::max)
    }

    /// Adds the error of a controlled stress in one step to the statistics.
    fn count(&mut self, row: usize, error: f64) {
        if self.steps[row] == 0 && error.abs() > HELD {
            return;
        }
        self.squares[row] += error * error;
        self.steps[row] += 1;
        self.largest[row] = self.largest[row].max(error.abs());
    }
}

impl State {
    /// Number of grains: of bodies, whether they have one piece or several.
    pub fn grains(&self) -> usize {
        self.ids.len() - self.clumps.pieces.len() + self.clumps.bodies.len()
    }

    /// Number of pieces: as many as grains, if all grains are spheres.
    pub fn pieces(&self) -> usize {
        self.ids.len()
    }

    /// True if some grain has several pieces.
    pub fn has_clumps(&self) -> bool {
        !self.clumps.is_empty()
    }

    /// Sum over the bodies of a number of each: the spheres in their order in memory, then the clumps.
    fn sum(&self, of_sphere: impl Fn(&Row8) -> f64, of_clump: impl Fn(&Clump) -> f64) -> f64 {
        let rows = &self.particles[..self.pieces()];
        if !self.has_clumps() {
            return rows.iter().map(of_sphere).sum();
        }
        let clump_of = self.clumps.of_rows(rows.len());
        let spheres = rows.iter().zip(&clump_of).filter(|(_, clump)| **clump == NO_CLUMP);
        spheres.map(|(row, _)| of_sphere(row)).sum::<f64>()
            + self.clumps.bodies.iter().map(of_clump).sum::<f64>()
    }

    /// Stress tensor from the elastic contact forces, Pa, compression positive.
    pub fn stress(&self) -> Matrix {
        let v = self.cell.volume();
        std::array::from_fn(|r| std::array::from_fn(|c| self.sums.virial[3 * r + c] / v))
    }

    /// Mean stress p, Pa.
    pub fn mean_stress(&self) -> f64 {
        (self.sums.virial[0] + self.sums.virial[4] + self.sums.virial[8]) / (3.0 * self.cell.volume())
    }

    /// Mean stress of the fluctuating motion, Pa: `sum m v^2 / (3 V)`. It is not a part of p.
    pub fn kinetic_mean_stress(&self) -> f64 {
        let twice = self.sum(
            |row| row.mass() * dot(&row.velocity(), &row.velocity()),
            |clump| clump.mass * dot(&clump.velocity, &clump.velocity),
        );
        twice / (3.0 * self.cell.volume())
    }

    /// Affine bulk modulus of the contacts, Pa.
    pub fn bulk_modulus(&self) -> f64 {
        self.sums.stiffness / (9.0 * self.cell.volume())
    }

    /// Volume of the grains over that of the cell.
    pub fn solid_fraction(&self) -> f64 {
        let cubes = self.sum(|row| row.radius().powi(3), |clump| equivalent_radius(clump.volume).powi(3));
        4.0 / 3.0 * std::f64::consts::PI * cubes / self.cell.volume()
    }

    /// Logarithmic strain since the start of the phase, compression positive.
    pub fn strain(&self) -> Matrix {
        self.strain
    }

    /// Arc length of the strain path since the start of the phase: the sum of `sqrt(2/3 d_eps:d_eps)` over chords of 1e-5.
    pub fn arc_length(&self) -> f64 {
        self.walked + self.chord()
    }

    fn chord(&self) -> f64 {
        invariants::length(&std::array::from_fn(|r| {
            std::array::from_fn(|c| self.strain[r][c] - self.anchor[r][c])
        }))
    }

    /// Updates the arc length after a step.
    pub(crate) fn walk(&mut self) {
        let chord = self.chord();
        if chord >= ARC_STEP {
            self.walked += chord;
            self.anchor = self.strain;
        }
    }

    /// Present stress, strain and time.
    pub fn macro_state(&self) -> MacroState {
        MacroState {
            stress: self.stress(),
            strain: self.strain,
            arc_length: self.arc_length(),
            time: self.time,
        }
    }

    /// Stress, Pa, that the magnitudes of the normal forces make: `sum |N| d / (3 V)` with the mean diameter d. It is close to p
    /// without adhesion; with adhesion it remains where tension and compression balance and p is zero.
    pub fn contact_stress(&self) -> f64 {
        let radii = self.sum(|row| row.radius(), |clump| equivalent_radius(clump.volume));
        let diameter = 2.0 * radii / self.grains().max(1) as f64;
        self.sums.normal_force * diameter / (3.0 * self.cell.volume())
    }

    /// Distances of the controlled stresses from their targets, Pa.
    fn stress_distances(&self) -> [Option<f64>; 6] {
        let stress = self.stress();
        let elapsed = self.control.progress(self.time);
        self.control.rows.map(|row| row.map(|row| row.value(&stress, &self.strain) - row.aim(elapsed)))
    }

    /// Errors of the controlled stresses over the mean stress: over its target, where the control has one; over the stress of the
    /// contacts, if that is larger, where single stresses are held at zero.
    fn stress_errors(&self) -> [Option<f64>; 6] {
        let p = match self.target_mean_stress() {
            Some(target) => target.abs(),
            None if self.holds_no_stress() => self.mean_stress().abs().max(self.contact_stress()),
            None => self.mean_stress().abs(),
        };
        self.stress_distances().map(|distance| distance.filter(|_| p > 0.0).map(|distance| distance / p))
    }

    /// Largest distance of a controlled stress from its target, over the mean stress.
    pub fn largest_stress_error(&self) -> f64 {
        self.stress_errors().iter().flatten().fold(0.0, |m, error| m.max(error.abs()))
    }

    /// Largest distance of a controlled stress from its target, Pa.
    pub fn largest_stress_distance(&self) -> f64 {
        self.stress_distances().iter().flatten().fold(0.0, |m, distance| m.max(distance.abs()))
    }

    /// True if normal stresses are held, and all of them at zero.
    fn holds_no_stress(&self) -> bool {
        let mut rows = self.control.rows().peekable();
        let is_zero = |row: &Row| row.target == 0.0 && row.target_rate == 0.0;
        rows.peek().is_some() && rows.all(|row| row.single().is_some_and(|k| k < 3) && is_zero(row))
    }

    /// True if the target of the mean stress has fallen to a small share of its value when the targets began to change: an error in
    /// per cent of it says nothing of the servo.
    fn target_has_vanished(&self) -> bool {
        let began = self.control.target_mean_stress(self.control.since);
        let now = self.target_mean_stress();
        matches!((began, now), (Some(began), Some(now)) if now.abs() < VANISHED * began.abs())
    }

    /// Updates the statistics of the controlled stresses, from the arc length `judge_from` on.
    pub(crate) fn judge_servo(&mut self) {
        if self.arc_length() < self.judge_from || self.target_has_vanished() {
            return;
        }
        for (row, error) in self.stress_errors().into_iter().enumerate() {
            if let Some(error) = error {
                self.servo_error.count(row, error);
            }
        }
    }

    /// Deviator strain `eps_1 - (eps_2 + eps_3) / 2` with axis 0 as 1.
    pub fn deviator_strain(&self) -> f64 {
        self.strain[0][0] - 0.5 * (self.strain[1][1] + self.strain[2][2])
    }

    /// The cell.
    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    /// Time since the start of the phase, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Time step, s.
    pub fn time_step(&self) -> f64 {
        self.dt
    }

    /// Steps since the start of the phase.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Energy by mechanism since the start of the phase, without the channels that laws declare: those are in the assembly.
    pub fn energy(&self) -> &EnergyBalance {
        &self.ledger.balance
    }

    /// How accurately the controlled stresses were held after the start-up of the phase or stage.
    pub fn servo_error(&self) -> ServoError {
        self.servo_error
    }

    /// Present largest `dt sqrt(k_t / m)` of a contact; above 0.316 a grain with twelve such contacts is unstable.
    pub fn time_step_fraction(&self) -> f64 {
        self.dt * self.sums.fastest.sqrt()
    }

    /// The control of the cell.
    pub fn control(&self) -> &CellControl {
        &self.control
    }

    /// Starts a phase: strain, time, steps, energy balance and servo statistics count from here, the last from the arc
    /// length `judge_from` on.
    pub(crate) fn reset_phase(&mut self, judge_from: f64) {
        self.judge_from = judge_from;
        self.strain = [[0.0; 3]; 3];
        self.anchor = self.strain;
        self.walked = 0.0;
        self.control.since = 0.0;
        self.time = 0.0;
        self.step = 0;
        self.ledger = Ledger::default();
        self.bonds.reset_phase();
        self.servo_error = ServoError::default();
    }

    /// Force on a piece (entries 0..3) and torque over its radius (4..7).
    #[inline(always)]
    pub(crate) fn resultant(&self, g: usize) -> [f64; 8] {
        let p = &self.pairs;
        resultant::<granum_simd::Portable>(&p.forces, &p.outer_offsets, &p.outer, g)
    }

    /// Force on a clump, N, and moment about its centre, N m.
    pub(crate) fn loads_of(&self, clump: &Clump) -> [Vector; 2] {
        let rotation = granum_core::rotation::matrix(&clump.orientation);
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for piece in self.clumps.pieces_of(clump) {
            let row = piece.row as usize;
            let total = self.resultant(row);
            let arm = granum_core::rotation::to_space(&rotation, &piece.centre);
            let lever = granum_core::geometry::cross(&arm, &[total[0], total[1], total[2]]);
            for a in 0..3 {
                force[a] += total[a];
                moment[a] += self.particles[row].radius() * total[4 + a] + lever[a];
            }
        }
        [force, moment]
    }

    /// Mean resultant force on the grains that touch at least one other, over the mean normal force of the contacts.
    pub fn unbalanced_force(&self) -> f64 {
        let (mut resultants, mut loaded) = (0.0, 0u64);
        let mut count = |f: &[f64]| {
            let size = (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]).sqrt();
            if size > 0.0 {
                resultants += size;
                loaded += 1;
            }
        };
        let clump_of = self.clumps.of_rows(self.pieces());
        for g in 0..self.pieces() {
            if clump_of.get(g).is_none_or(|clump| *clump == NO_CLUMP) {
                count(&self.resultant(g));
            }
        }
        for clump in &self.clumps.bodies {
            count(&self.loads_of(clump)[0]);
        }
        let contacts = self.contacts();
        if loaded == 0 || contacts == 0 || self.sums.normal_force == 0.0 {
            return 0.0;
        }
        (resultants / loaded as f64) / (self.sums.normal_force / contacts as f64)
    }

    /// Number of contacts that touch.
    pub fn contacts(&self) -> usize {
        self.pairs.contacts()
    }

    /// Largest overlap of two grains that touch over the sum of their radii; zero without contacts.
    pub fn largest_overlap(&self) -> f64 {
        let overlap = |slot: usize| {
            let (b, l) = (slot / LANES, slot % LANES);
            let [i, j] = [&self.pairs.first, &self.pairs.second].map(|list| list[b][l] as usize);
            let [one, two] = [i, j].map(|grain| &self.particles[grain].0);
            let code = self.pairs.image[b][l];
            let image = if code == NO_IMAGE { [0.0; 3] } else { self.cell.image(image_vector(code)) };
            let branch: [f64; 3] = std::array::from_fn(|k| two[k] - one[k] + image[k]);
            let distance = branch.iter().map(|x| x * x).sum::<f64>().sqrt();
            1.0 - distance / (one[3] + two[3])
        };
        self.pairs.touching().map(overlap).fold(0.0, f64::max)
    }

    /// The target of the mean stress, if the control has one.
    pub fn target_mean_stress(&self) -> Option<f64> {
        self.control.target_mean_stress(self.time)
    }
}
