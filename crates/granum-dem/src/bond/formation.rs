//! How bonds are made: which pieces are joined, and what each bond remembers of that moment.

use std::collections::HashSet;

use granum_core::rotation::{IDENTITY, conjugate};
use granum_simd::Row4;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::bonding::{BondPlaces, BondRadius, Bonding};
use super::bonds::column::{ALIVE, ARMS, COLUMNS, DASHPOTS, FRAMES, LIMIT, STIFFNESS};
use super::bonds::{BondRecord, Bonds};
use super::cement::share_of_radius;
use super::law::bond_law::{BondLaw, BondShape, BondStiffness};
use super::motion::{frame_along, product};
use super::work::BondWork;
use crate::assembly::Vector;
use crate::clump::clumps::NO_CLUMP;
use crate::images::image_vector;
use crate::integrator::Integrator;
use crate::particle_row::ParticleRow;
use crate::search;
use crate::simulation::Simulation;
use crate::simulation_error::SimulationError;
use granum_core::geometry::{apply, length};

/// Share of the sum of their radii by which the surfaces of two pieces of a grain may be apart and still touch.
const TOUCH: f64 = 1e-6;
/// Smallest gap, over the mean diameter, at which pieces of different grains are joined: those that touch exactly are.
const LEAST_GAP: f64 = 1e-9;
/// Share of the smaller radius by which they may overlap: the pieces of an agglomerate move by themselves.
const OVERLAP: f64 = 0.01;

/// Number of formations of bonds that are told from each other; beyond it there is room for other laws.
const TYPES: usize = 200;

/// Two pieces that are to be joined: their rows, and the edges of the cell to the image of the second.
pub(super) type Pair = ([u32; 2], [i32; 3]);

impl Simulation {
    /// Makes bonds; returns how many. No force changes: bonds carry nothing when they are made.
    ///
    /// # Errors
    /// If a value is impossible, no pieces are there to be joined, or grains attract each other by an interface energy or a law of adhesion.
    pub fn bond(&mut self, bonding: &Bonding) -> Result<usize, SimulationError> {
        self.integrator.check_bonding(bonding)?;
        // On a copy, so that bonds that cannot be made leave the simulation as it was.
        let mut changed = self.integrator.clone();
        // Wraps the pieces into the cell.
        changed.rebuild();
        let mut pairs = match bonding.places {
            BondPlaces::Between => changed.pairs_between(bonding.largest_gap),
            BondPlaces::Inside => changed.pairs_inside()?,
            BondPlaces::Listed => changed.pairs_listed(bonding)?,
        };
        changed.order(&mut pairs);
        if bonding.left_out > 0.0 {
            let mut rng = ChaCha8Rng::seed_from_u64(bonding.seed);
            rng.set_stream(u64::MAX);
            pairs.retain(|_| crate::random::unit(&mut rng) >= bonding.left_out);
        }
        if bonding.places == BondPlaces::Inside {
            changed.release_clumps();
        }
        let made = changed.join(bonding, &pairs)?;
        if bonding.places == BondPlaces::Inside {
            // Pieces of one grain become neighbours; only now, since rows that are sorted would no longer be those of the pairs.
            changed.rebuild();
        }
        self.integrator = changed;
        Ok(made)
    }

    /// Makes bonds between given pieces, as indices of the pieces of an assembly, at their nearest images.
    ///
    /// # Errors
    /// As for [`Simulation::bond`], and if there is no such piece.
    pub fn bond_pieces(
        &mut self,
        bonding: &Bonding,
        pieces: &[[usize; 2]],
    ) -> Result<usize, SimulationError> {
        self.integrator.check_bonding(bonding)?;
        let mut changed = self.integrator.clone();
        changed.rebuild();
        let pairs = changed.pairs_of_pieces(pieces)?;
        let made = changed.join(bonding, &pairs)?;
        self.integrator = changed;
        Ok(made)
    }

    /// Number of bonds that hold.
    pub fn bonds(&self) -> usize {
        self.state().bonds.alive()
    }
}

impl Integrator {
    fn check_bonding(&self, bonding: &Bonding) -> Result<(), SimulationError> {
        let wrong = |what: String| Err(SimulationError::Bonds { what });
        if let Some(what) = bonding.problem() {
            return wrong(what);
        }
        let law = self.properties.contact.adhesion;
        if law.law().acts() {
            return wrong(format!(
                "contact.adhesion = {:?} attracts grains that bonds hold already; take contact.adhesion = \"none\"",
                law.name()
            ));
        }
        if self.properties.attracts() {
            return wrong(
                "the interface energy of the grains attracts what bonds hold already; it must be 0".into(),
            );
        }
        Ok(())
    }

    /// Pieces of different bodies that are nearer than a gap, over the mean diameter of the grains.
    fn pairs_between(&self, gap: f64) -> Vec<Pair> {
        let state = &self.state;
        let pieces = &state.particles[..state.pieces()];
        let near =
            search::find(self.hardware.isa, &state.cell, pieces, gap.max(LEAST_GAP) * self.mean_diameter());
        let other = |rows: [u32; 2]| {
            let [one, two] = rows.map(|row| self.clump_of.get(row as usize).copied().unwrap_or(NO_CLUMP));
            rows[0] != rows[1] && (one == NO_CLUMP || one != two)
        };
        let pairs = near.iter().map(|pair| ([pair.i, pair.j], image_vector(pair.image)));
        pairs.filter(|(rows, _)| other(*rows)).collect()
    }

    /// Touching pieces of each body of several pieces.
    fn pairs_inside(&self) -> Result<Vec<Pair>, SimulationError> {
        let state = &self.state;
        let wrong = |what: String| Err(SimulationError::Bonds { what });
        if !state.has_clumps() {
            return wrong(
                "bonds inside of grains need grains of several pieces, and all grains are spheres".into(),
            );
        }
        let mut pairs = Vec::new();
        for clump in &state.clumps.bodies {
            let pieces = state.clumps.pieces_of(clump);
            for (k, one) in pieces.iter().enumerate() {
                for two in &pieces[k + 1..] {
                    let apart: Vector = std::array::from_fn(|a| two.centre[a] - one.centre[a]);
                    let gap = length(&apart) - one.radius - two.radius;
                    if gap < -OVERLAP * one.radius.min(two.radius) {
                        return wrong(format!(
                            "two pieces of the grain {} overlap by {:e} m; the pieces of an agglomerate may overlap by no more than 1 % of \
                             their radius, since each of them moves by itself",
                            clump.id, -gap
                        ));
                    }
                    if gap <= TOUCH * (one.radius + two.radius) {
                        let image = std::array::from_fn(|a| one.image[a] - two.image[a]);
                        pairs.push(([one.row, two.row], image));
                    }
                }
            }
        }
        Ok(pairs)
    }

    /// Puts pairs into an order that does not depend on where pieces are in memory.
    fn order(&self, pairs: &mut [Pair]) {
        let state = &self.state;
        let order = state.pieces_in_order(&state.bodies_in_order());
        let mut rank = vec![0u32; order.len()];
        for (r, row) in order.into_iter().enumerate() {
            rank[row] = r as u32;
        }
        for (rows, image) in pairs.iter_mut() {
            if rank[rows[0] as usize] > rank[rows[1] as usize] {
                rows.swap(0, 1);
                *image = image.map(|s| -s);
            }
        }
        pairs.sort_unstable_by_key(|(rows, image)| (rows.map(|row| rank[row as usize]), *image));
    }

    /// Lets the pieces of all bodies of several pieces move by themselves. Bodies get new ids, from 1 in the order of those that they had. The
    /// neighbour list is as it was.
    fn release_clumps(&mut self) {
        let state = &mut self.state;
        let order = state.pieces_in_order(&state.bodies_in_order());
        for (k, row) in order.into_iter().enumerate() {
            state.ids[row] = k as u64 + 1;
        }
        let clumps = std::mem::take(&mut state.clumps);
        for clump in &clumps.bodies {
            let pieces = clumps.pieces_of(clump);
            let cubes: f64 = pieces.iter().map(|piece| piece.radius.powi(3)).sum();
            for piece in pieces {
                state.particles[piece.row as usize].set_mass(clump.mass * piece.radius.powi(3) / cubes);
            }
        }
        self.measure_bodies();
    }

    /// Joins pairs that are not joined already.
    fn join(&mut self, bonding: &Bonding, pairs: &[Pair]) -> Result<usize, SimulationError> {
        self.orient();
        let mut records = self.state.bonds.records();
        let joined: HashSet<Pair> = records.iter().flat_map(both_ways).collect();
        let pairs: Vec<&Pair> = pairs.iter().filter(|pair| !joined.contains(*pair)).collect();
        if pairs.is_empty() {
            let what = "there is nothing to bond: no two pieces are near enough that are not bonded already";
            return Err(SimulationError::Bonds { what: what.into() });
        }
        let share = self.share(bonding, &pairs)?;
        let law = self.state.bonds.law_index(bonding);
        let values = bonding.values();
        for (k, pair) in pairs.iter().enumerate() {
            let id = self.state.bonds.made + k as u64;
            records.push(self.record(bonding, &values, pair, share, law, id)?);
        }
        let bonds = &mut self.state.bonds;
        bonds.made += pairs.len() as u64;
        bonds.pack(records);
        let before = bonds.fastest;
        bonds.find_fastest(&self.state.particles);
        self.state.sums.fastest += bonds.fastest - before;
        self.bond_work = BondWork::new(&self.state.bonds);
        self.reset_time_step();
        Ok(pairs.len())
    }

    /// Gives every piece an orientation: that of its body, or none.
    fn orient(&mut self) {
        let state = &mut self.state;
        if state.bonds.orientations.is_empty() {
            state.bonds.orientations = vec![Row4(IDENTITY); state.ids.len()];
        }
        for clump in &state.clumps.bodies {
            for piece in state.clumps.pieces_of(clump) {
                state.bonds.orientations[piece.row as usize] = Row4(clump.orientation);
            }
        }
    }

    /// From the centre of the first piece of a pair to the image of the second, m.
    pub(super) fn branch_of(&self, (rows, image): &Pair) -> Vector {
        let [from, to] = rows.map(|row| self.state.particles[row as usize].position());
        let shift = apply(&self.state.cell.edges, image.map(f64::from));
        std::array::from_fn(|a| to[a] - from[a] + shift[a])
    }

    /// The share of the smaller radius that the radius of bonds between these pairs has.
    fn share(&self, bonding: &Bonding, pairs: &[&Pair]) -> Result<f64, SimulationError> {
        let (content, density) = match bonding.radius {
            BondRadius::Share(share) => return Ok(share),
            BondRadius::Cement { content, density } => (content, density),
        };
        let of = |pair: &&Pair| {
            let radii = pair.0.map(|row| self.state.particles[row as usize].radius());
            (radii, length(&self.branch_of(pair)))
        };
        let bonds: Vec<_> = pairs.iter().map(of).collect();
        let solid = self.state.solid_fraction() * self.state.cell.volume();
        let volume = content * self.mean_density() / density * solid;
        share_of_radius(&bonds, volume).ok_or_else(|| {
            let what = format!(
                "a cement content of {content} is more than the {} necks hold: bonds would be wider than their grains",
                bonds.len()
            );
            SimulationError::Bonds { what }
        })
    }

    /// A bond between the pieces of a pair.
    fn record(
        &self,
        bonding: &Bonding,
        values: &[f64],
        pair: &Pair,
        share: f64,
        law: u8,
        id: u64,
    ) -> Result<BondRecord, SimulationError> {
        let rows = pair.0;
        let [a, b] = rows.map(|row| self.state.particles[row as usize]);
        let branch = self.branch_of(pair);
        let distance = length(&branch);
        let sum = a.radius() + b.radius();
        let shape = BondShape { radius: share * a.radius().min(b.radius()), length: sum.max(distance) };
        let constants = Constants::new(bonding, values, &shape, id)?;
        let mut columns = [0.0; COLUMNS];
        let [of_first, of_second] = bonding.attachment.arms(distance, [a.radius(), b.radius()]);
        (columns[ARMS], columns[ARMS + 1], columns[ALIVE]) = (of_first, of_second, 1.0);
        let frame = frame_along(&branch);
        for k in 0..2 {
            let Row4(q) = self.state.bonds.orientations[rows[k] as usize];
            columns[FRAMES[k]..FRAMES[k] + 4].copy_from_slice(&product(&conjugate(&q), &frame));
        }
        columns[STIFFNESS..STIFFNESS + 4].copy_from_slice(&constants.stiffness);
        columns[LIMIT..ALIVE].copy_from_slice(&constants.limits);
        let inertia = |row: &granum_simd::Row8| 0.4 * row.mass() * row.radius() * row.radius();
        let [normal, shear, bending, twisting] = constants.stiffness;
        let springs = BondStiffness { normal, shear, bending, twisting };
        let of = bonding.dashpots(&springs, [&a, &b].map(|row| [row.mass(), inertia(row)]));
        let dashpots: [f64; DASHPOTS] = [of.normal, of.shear, of.bending, of.twisting];
        let shape = [shape.radius, shape.length];
        Ok(BondRecord { id, law, rows, shape, image: pair.1, columns, dashpots })
    }
}

/// What the law says of a bond.
struct Constants {
    stiffness: [f64; 4],
    limits: [f64; super::law::bond_law::LIMITS],
}

impl Constants {
    fn new(
        bonding: &Bonding,
        values: &[f64],
        shape: &BondShape,
        id: u64,
    ) -> Result<Constants, SimulationError> {
        let law: &dyn BondLaw = bonding.law.law();
        let factor = bonding.scatter.factor(bonding.seed, id, shape.volume());
        let k = law.stiffness(shape, values);
        let stiffness = [k.normal, k.shear, k.bending, k.twisting];
        if !(k.normal > 0.0 && stiffness.iter().all(|k| k.is_finite() && *k >= 0.0)) {
            let what = format!("the law {:?} gives a bond the stiffnesses {stiffness:?}", bonding.law.name());
            return Err(SimulationError::Bonds { what });
        }
        Ok(Constants { stiffness, limits: law.limits(shape, values, factor) })
    }
}

/// The pair that a bond joins, named from either end.
fn both_ways(bond: &BondRecord) -> [Pair; 2] {
    let [i, j] = bond.rows;
    [([i, j], bond.image), ([j, i], bond.image.map(i32::saturating_neg))]
}

impl Bonds {
    /// The place of a law in the list of laws. Each formation of bonds has one of its own, so that bonds know by which they were made; those beyond
    /// [`TYPES`] share that of an earlier one with the same law, if there is one.
    fn law_index(&mut self, bonding: &Bonding) -> u8 {
        let shared = || self.laws.iter().rposition(|law| *law == bonding.law);
        let place = if self.laws.len() < TYPES { None } else { shared() };
        place.unwrap_or_else(|| {
            self.laws.push(bonding.law);
            self.laws.len() - 1
        }) as u8
    }
}
