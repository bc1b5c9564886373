//! The serial work of bonds in a step: the sums of the blocks, and the list of the bonds that ruptured.

use granum_core::assembly::{BrokenBond, Rupture};
use granum_core::geometry::{apply, invert};
use granum_simd::LANES;

use super::stage::bond_stage;
use super::work::BondWork;
use crate::integrator::Integrator;
use crate::kernel::Views;
use crate::particle_row::ParticleRow;

impl Integrator {
    /// Follows the bonds to the new rows of their pieces, if the rows were sorted, and leaves out those that ruptured.
    pub(crate) fn renew_bonds(&mut self, new_place: Option<&[u32]>) {
        let bonds = &mut self.state.bonds;
        if bonds.is_empty() || (new_place.is_none() && !bonds.has_dead()) {
            return;
        }
        bonds.renumber(new_place);
        bonds.find_fastest(&self.state.particles);
        self.bond_work = BondWork::new(&self.state.bonds);
    }

    /// Computes the forces of the bonds in the present geometry, without a team, and adds them to those of the contacts.
    pub(crate) fn bond_forces(&mut self, views: &Views) {
        bond_stage(self.hardware.isa, views, 0..views.bonds.blocks()[0], true);
    }

    /// Adds what the bonds did in this step to the sums over the contacts and to the energies.
    pub(crate) fn add_bonds(&mut self) {
        if self.state.bonds.is_empty() {
            return;
        }
        let mut ruptured = false;
        for block in &self.bond_work.sums {
            let (sums, ledger) = (&mut self.state.sums, &mut self.state.bonds.ledger);
            for (sum, part) in sums.virial.iter_mut().zip(block.virial) {
                *sum += part;
            }
            sums.boundary_power += block.power;
            sums.stiffness += block.stiffness;
            sums.normal_force += block.normal_force;
            ledger.damping += block.damping;
            for (sum, part) in ledger.broken.iter_mut().zip(block.broken) {
                *sum += part;
            }
            ruptured |= block.ruptured;
        }
        self.state.sums.fastest += self.state.bonds.fastest;
        if ruptured {
            self.list_ruptures();
        }
    }

    /// Takes the bonds that ruptured in this step into their list, in the order of their numbers.
    fn list_ruptures(&mut self) {
        let mut found = Vec::new();
        for batch in 0..self.state.bonds.batches() {
            let ruptures = std::mem::take(&mut self.bond_work.ruptures[batch]);
            for lane in 0..LANES {
                let rupture = match (ruptures.tension >> lane & 1, ruptures.shear >> lane & 1) {
                    (1, _) => Rupture::Tension,
                    (_, 1) => Rupture::Shear,
                    _ => continue,
                };
                found.push(self.broken(batch, lane, rupture, ruptures.energy[lane]));
            }
        }
        found.sort_unstable_by_key(|bond| bond.id);
        self.state.bonds.broken.append(&mut found);
    }

    /// What is kept of a bond that ruptured.
    fn broken(&self, batch: usize, lane: usize, rupture: Rupture, energy: f64) -> BrokenBond {
        let (state, bonds) = (&self.state, &self.state.bonds);
        let rows = bonds.rows[batch].map(|rows| rows[lane] as usize);
        let inverse = invert(&state.cell.edges);
        let [from, to] = rows.map(|row| apply(&inverse, state.particles[row].position()));
        let shift = bonds.images[batch].map(|edges| f64::from(edges[lane]));
        let across: [f64; 3] = std::array::from_fn(|a| to[a] + shift[a] - from[a]);
        let branch = apply(&state.cell.edges, across);
        let length = granum_core::geometry::length(&branch);
        BrokenBond {
            id: bonds.ids[batch][lane],
            bodies: rows.map(|row| state.ids[row]),
            rupture,
            energy,
            time: state.time + state.dt,
            phase: bonds.phase,
            place: std::array::from_fn(|a| {
                let middle = from[a] + 0.5 * across[a];
                middle - middle.floor()
            }),
            normal: branch.map(|x| x / length),
            radius: bonds.shapes[2 * batch].0[lane],
        }
    }
}
