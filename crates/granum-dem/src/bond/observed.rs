//! The bonds of an assembly.

use granum_core::assembly::{Assembly, Bond};
use granum_simd::vectors::scale;
use granum_simd::{LANES, Row4};

use super::bonds::column::{ARMS, FRAMES, LIMIT, STIFFNESS};
use super::channels::BOND_CHANNELS;
use super::law::bond_law::{BondLoads, LIMITS};
use super::motion::{Ends, Strained, in_space, strained};
use crate::particle_row::ParticleRow;
use crate::state::State;

impl State {
    /// Gives an assembly the bonds of this state. The rank of a row is the index of its piece there.
    pub(crate) fn add_bonds_to(&self, rank: &[usize], out: &mut Assembly) {
        out.bonds.clear();
        out.broken_bonds.clear();
        if self.bonds.is_empty() {
            return;
        }
        let bonds = &self.bonds;
        for batch in 0..bonds.batches() {
            for lane in (0..LANES).filter(|lane| bonds.is_alive(batch, *lane)) {
                out.bonds.push(self.observed_bond(batch, lane, rank));
            }
        }
        out.bonds.sort_unstable_by_key(|bond| bond.id);
        out.broken_bonds.extend_from_slice(&bonds.broken);
        let ledger = &bonds.ledger;
        for (key, energy) in BOND_CHANNELS.iter().zip([ledger.damping, ledger.broken[0], ledger.broken[1]]) {
            if energy != 0.0 {
                out.energy.channels.insert(key.key.to_string(), energy);
            }
        }
    }

    /// Where the ends of a bond are.
    fn ends_of(&self, batch: usize, lane: usize) -> Ends<f64> {
        let (bonds, columns) = (&self.bonds, self.bonds.columns_of(batch));
        let rows = bonds.rows[batch].map(|rows| rows[lane] as usize);
        let [a, b] = rows.map(|row| self.particles[row].position());
        let image = granum_core::geometry::apply(
            &self.cell.edges,
            bonds.images[batch].map(|edges| f64::from(edges[lane])),
        );
        Ends {
            orientations: rows.map(|row| {
                let Row4(q) = bonds.orientations[row];
                q
            }),
            frames: FRAMES.map(|at| std::array::from_fn(|k| columns[at + k].0[lane])),
            arms: [columns[ARMS].0[lane], columns[ARMS + 1].0[lane]],
            branch: std::array::from_fn(|k| b[k] - a[k] + image[k]),
        }
    }

    fn observed_bond(&self, batch: usize, lane: usize, rank: &[usize]) -> Bond {
        let (bonds, columns) = (&self.bonds, self.bonds.columns_of(batch));
        let ends = self.ends_of(batch, lane);
        let Strained { axes, displacement: u, rotation: phi, .. } = strained(&ends);
        let [normal, shear, bending, twisting] = std::array::from_fn(|k| columns[STIFFNESS + k].0[lane]);
        let force = [normal * u[0], shear * u[1], shear * u[2]];
        let couple = [twisting * phi[0], bending * phi[1], bending * phi[2]];
        let energy = 0.5 * (0..3).map(|k| force[k] * u[k] + couple[k] * phi[k]).sum::<f64>();
        let loads = BondLoads {
            tension: [force[0]; LANES],
            shear: [libm::hypot(force[1], force[2]); LANES],
            bending: [libm::hypot(couple[1], couple[2]); LANES],
            twisting: [couple[0].abs(); LANES],
        };
        let limits: [[f64; LANES]; LIMITS] = std::array::from_fn(|k| [columns[LIMIT + k].0[lane]; LANES]);
        let law = bonds.laws[bonds.law[batch] as usize].law();
        let [tension, by_shear] = law.utilisation(&loads, &limits).map(|row| row[0]);
        let [i, j] = bonds.rows[batch].map(|rows| rank[rows[lane] as usize]);
        // By index, so that the order of the ends does not depend on the order in memory.
        let (sign, [i, j]) = if i <= j { (1.0, [i, j]) } else { (-1.0, [j, i]) };
        Bond {
            id: bonds.ids[batch][lane],
            i,
            j,
            branch: scale(sign, ends.branch),
            normal: scale(sign, axes[0]),
            radius: bonds.shapes[2 * batch].0[lane],
            length: bonds.shapes[2 * batch + 1].0[lane],
            normal_force: -force[0],
            shear_force: scale(sign, in_space(&axes, &[0.0, force[1], force[2]])),
            twisting_couple: couple[0],
            bending_couple: scale(sign, in_space(&axes, &[0.0, couple[1], couple[2]])),
            energy,
            utilisation: tension.max(by_shear),
            kind: u32::from(bonds.law[batch]) + 1,
        }
    }
}
