//! The bonds of a simulation, in batches of eight, and those that ruptured.

use granum_core::assembly::BrokenBond;
use granum_simd::{LANES, Row4, Row8};
use serde::{Deserialize, Serialize};

use super::law::bond_law::LIMITS;
use super::law::kind::BondKind;
use crate::rows;

/// The columns of numbers that a batch of bonds has.
pub(super) mod column {
    use super::LIMITS;

    /// Distances of the point of attachment from the centres, m.
    pub(in crate::bond) const ARMS: usize = 0;
    /// The frame in the axes of piece i, and in those of piece j.
    pub(in crate::bond) const FRAMES: [usize; 2] = [2, 6];
    /// Stiffnesses: normal, shear, bending, twisting.
    pub(in crate::bond) const STIFFNESS: usize = 10;
    /// Constants of the law of rupture.
    pub(in crate::bond) const LIMIT: usize = 14;
    /// One where there is a bond, zero where there is none any more.
    pub(in crate::bond) const ALIVE: usize = LIMIT + LIMITS;
    /// Number of columns.
    pub(in crate::bond) const COLUMNS: usize = ALIVE + 1;
    /// Number of columns of dashpots, in the order of the stiffnesses.
    pub(in crate::bond) const DASHPOTS: usize = 4;
}
use column::{ALIVE, COLUMNS, DASHPOTS, STIFFNESS};

/// Energies of bonds since the start of a phase, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct BondLedger {
    /// Lost in the dashpots.
    pub(crate) damping: f64,
    /// Stored in bonds that ruptured by tension, and by shear.
    pub(crate) broken: [f64; 2],
}

/// One bond, outside of its batch.
#[derive(Clone, Copy)]
pub(super) struct BondRecord {
    pub(super) id: u64,
    pub(super) law: u8,
    pub(super) rows: [u32; 2],
    pub(super) shape: [f64; 2],
    /// Edges of the cell between the first piece and the image of the second.
    pub(super) image: [i32; 3],
    pub(super) columns: [f64; COLUMNS],
    pub(super) dashpots: [f64; DASHPOTS],
}

/// The bonds of a simulation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Bonds {
    /// Number of bonds that were ever made: the next one has this number.
    pub(super) made: u64,
    /// The laws, of which a checkpoint has the names.
    #[serde(skip)]
    pub(super) laws: Vec<BondKind>,
    /// The law of each batch.
    pub(super) law: Vec<u8>,
    /// Numbers of the bonds.
    pub(super) ids: Vec<[u64; LANES]>,
    /// Rows of the two pieces of each.
    pub(super) rows: Vec<[[u32; LANES]; 2]>,
    /// [`column`]s, by batch.
    #[serde(with = "rows::eight")]
    pub(super) columns: Vec<Row8>,
    /// Edges of the cell between the first piece of each and the image of the second, by batch.
    pub(super) images: Vec<[[i32; LANES]; 3]>,
    /// Dashpots, by batch.
    #[serde(with = "rows::eight")]
    pub(super) dashpots: Vec<Row8>,
    /// Radius and length of each, m, by batch.
    #[serde(with = "rows::eight")]
    pub(super) shapes: Vec<Row8>,
    /// Orientation of every piece; empty as long as there are no bonds.
    #[serde(with = "rows::four")]
    pub(super) orientations: Vec<Row4>,
    /// Bonds that ruptured, in the order in which they did.
    pub(super) broken: Vec<BrokenBond>,
    pub(super) ledger: BondLedger,
    /// Number of phases that began since the first bond was made.
    pub(super) phase: u32,
    /// Largest stiffness over mass of a bond, for the time step, 1/s2.
    pub(super) fastest: f64,
}

impl Bonds {
    /// True if there never were bonds.
    pub(crate) fn is_empty(&self) -> bool {
        self.made == 0
    }

    pub(super) fn batches(&self) -> usize {
        self.law.len()
    }

    /// Number of bonds that hold.
    pub(crate) fn alive(&self) -> usize {
        (0..self.batches()).map(|b| self.columns_of(b)[ALIVE].0.iter().filter(|x| **x > 0.0).count()).sum()
    }

    /// The columns of a batch.
    pub(super) fn columns_of(&self, batch: usize) -> &[Row8] {
        &self.columns[batch * COLUMNS..(batch + 1) * COLUMNS]
    }

    /// The dashpots of a bond.
    fn dashpots_of(&self, batch: usize, lane: usize) -> [f64; DASHPOTS] {
        std::array::from_fn(|k| self.dashpots[batch * DASHPOTS + k].0[lane])
    }

    pub(super) fn is_alive(&self, batch: usize, lane: usize) -> bool {
        self.columns_of(batch)[ALIVE].0[lane] > 0.0
    }

    /// Begins a phase, whose energies are counted from zero.
    pub(crate) fn reset_phase(&mut self) {
        self.ledger = BondLedger::default();
        self.phase += u32::from(!self.is_empty());
    }

    /// The bond in a lane.
    fn record(&self, batch: usize, lane: usize) -> BondRecord {
        BondRecord {
            id: self.ids[batch][lane],
            law: self.law[batch],
            rows: self.rows[batch].map(|rows| rows[lane]),
            shape: [0, 1].map(|k| self.shapes[2 * batch + k].0[lane]),
            image: self.images[batch].map(|edges| edges[lane]),
            columns: std::array::from_fn(|c| self.columns_of(batch)[c].0[lane]),
            dashpots: self.dashpots_of(batch, lane),
        }
    }

    /// The bonds that hold.
    pub(super) fn records(&self) -> Vec<BondRecord> {
        let lanes = (0..self.batches()).flat_map(|b| (0..LANES).map(move |l| (b, l)));
        lanes.filter(|(b, l)| self.is_alive(*b, *l)).map(|(b, l)| self.record(b, l)).collect()
    }

    /// Takes these bonds in place of those it has: law by law, in the order of the rows of their pieces, so that neighbours in space are
    /// neighbours in memory.
    pub(super) fn pack(&mut self, mut records: Vec<BondRecord>) {
        records.sort_unstable_by_key(|bond| {
            let [i, j] = bond.rows;
            (bond.law, i.min(j), i.max(j), bond.id)
        });
        self.law.clear();
        self.ids.clear();
        self.rows.clear();
        self.columns.clear();
        self.images.clear();
        self.dashpots.clear();
        self.shapes.clear();
        for of_law in records.chunk_by(|a, b| a.law == b.law) {
            for eight in of_law.chunks(LANES) {
                self.push_batch(eight);
            }
        }
    }

    /// Adds a batch of up to eight bonds. The other lanes join the first row with itself by nothing.
    fn push_batch(&mut self, bonds: &[BondRecord]) {
        let mut columns = [Row8::default(); COLUMNS];
        columns[column::FRAMES[0]] = Row8([1.0; LANES]);
        columns[column::FRAMES[1]] = Row8([1.0; LANES]);
        let (mut rows, mut ids, mut shapes) = ([[0; LANES]; 2], [0; LANES], [Row8::default(); 2]);
        let (mut images, mut dashpots) = ([[0; LANES]; 3], [Row8::default(); DASHPOTS]);
        for (lane, bond) in bonds.iter().enumerate() {
            ids[lane] = bond.id;
            for k in 0..2 {
                rows[k][lane] = bond.rows[k];
                shapes[k].0[lane] = bond.shape[k];
            }
            for (image, edges) in images.iter_mut().zip(bond.image) {
                image[lane] = edges;
            }
            let all =
                columns.iter_mut().chain(&mut dashpots).zip(bond.columns.into_iter().chain(bond.dashpots));
            for (column, value) in all {
                column.0[lane] = value;
            }
        }
        self.law.push(bonds[0].law);
        self.ids.push(ids);
        self.rows.push(rows);
        self.columns.extend_from_slice(&columns);
        self.images.push(images);
        self.dashpots.extend_from_slice(&dashpots);
        self.shapes.extend_from_slice(&shapes);
    }

    /// Follows the rows of the pieces to other images of the cell, which were moved by these numbers of edges.
    pub(crate) fn wrap(&mut self, moved: &[[i32; 3]]) {
        for batch in 0..self.batches() {
            let rows = self.rows[batch];
            for lane in 0..LANES {
                let [i, j] = rows.map(|rows| moved[rows[lane] as usize]);
                for a in 0..3 {
                    // Numbers of a forged checkpoint may be too large to be added.
                    let image = &mut self.images[batch][a][lane];
                    *image = image.saturating_add(j[a].saturating_sub(i[a]));
                }
            }
        }
    }

    /// Takes the new rows of all pieces after the rows were sorted, and forgets the bonds that ruptured.
    pub(crate) fn renumber(&mut self, new_place: Option<&[u32]>) {
        let mut records = self.records();
        if let Some(new_place) = new_place {
            for bond in &mut records {
                bond.rows = bond.rows.map(|row| new_place[row as usize]);
            }
            let old = std::mem::take(&mut self.orientations);
            self.orientations = old.clone();
            for (row, to) in old.into_iter().zip(new_place) {
                self.orientations[*to as usize] = row;
            }
        }
        self.pack(records);
    }

    /// True if a bond was put into a lane, whether it still holds or not.
    pub(super) fn is_filled(&self, batch: usize, lane: usize) -> bool {
        self.shapes[2 * batch].0[lane] > 0.0
    }

    /// True if a bond of the list ruptured.
    pub(crate) fn has_dead(&self) -> bool {
        let dead =
            |batch: usize| (0..LANES).any(|lane| self.is_filled(batch, lane) && !self.is_alive(batch, lane));
        (0..self.batches()).any(dead)
    }

    /// True if any bond has dashpots.
    pub(super) fn is_damped(&self) -> bool {
        self.dashpots.iter().any(|row| row.0.iter().any(|x| *x > 0.0))
    }

    /// Scales the dashpots with the root of the masses of the grains.
    pub(crate) fn scale(&mut self, masses: f64) {
        let root = masses.sqrt();
        self.dashpots.iter_mut().flat_map(|row| &mut row.0).for_each(|x| *x *= root);
        self.fastest /= masses;
    }

    /// Largest stiffness over mass of a bond for the time step, 1/s2: of `k_s A`, `k_n A / 3` and `(k_n I + k_s J / 2)/R^2` the largest, over
    /// the smaller mass; with dashpots more.
    pub(super) fn find_fastest(&mut self, particles: &[Row8]) {
        use crate::particle_row::ParticleRow;
        let mut fastest = 0.0f64;
        for batch in 0..self.batches() {
            let columns = self.columns_of(batch);
            for lane in (0..LANES).filter(|lane| self.is_alive(batch, *lane)) {
                let [normal, shear, bending, twisting] =
                    std::array::from_fn(|k| columns[STIFFNESS + k].0[lane]);
                let [i, j] = self.rows[batch].map(|rows| &particles[rows[lane] as usize]);
                let (radius, mass) = (i.radius().min(j.radius()), i.mass().min(j.mass()));
                let turning = (bending + 0.5 * twisting) / (radius * radius);
                let stiffness = shear.max(normal / 3.0).max(turning);
                // The damping ratio, from the dashpot in tension.
                let effective = i.mass() * j.mass() / (i.mass() + j.mass());
                let ratio = 0.5 * self.dashpots_of(batch, lane)[0] / (effective * normal).sqrt();
                fastest = fastest.max(stiffness / mass * stiffening(ratio));
            }
        }
        self.fastest = fastest;
    }
}

/// The factor on the stiffness that stands for dashpots of a damping ratio in the choice of the time step: for twelve contacts a grain the
/// stable step falls by `sqrt(1 + x^2) - x`, `x = zeta sqrt(20)`.
fn stiffening(damping_ratio: f64) -> f64 {
    let x = damping_ratio * 20.0f64.sqrt();
    let share = (1.0 + x * x).sqrt() - x;
    1.0 / (share * share)
}
