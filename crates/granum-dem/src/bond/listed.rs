//! Pairs of pieces that a file lists as bonded. They wait in the simulation until a set of bonds takes them.

use granum_core::geometry::{apply, invert, length};

use super::bonding::Bonding;
use super::formation::Pair;
use super::listed_pair::ListedPair;
use crate::assembly::Vector;
use crate::clump::clumps::NO_CLUMP;
use crate::integrator::Integrator;
use crate::particle_row::ParticleRow;
use crate::simulation::Simulation;
use crate::simulation_error::SimulationError;

/// Largest gap between two pieces that a list names, over the mean diameter: that of bonds between grains.
const WIDEST: f64 = 1.0;
/// So many types are named in a message.
const MOST_NAMED: usize = 8;

impl Simulation {
    /// Takes a list of pairs, in place of the one before, from which sets of bonds of [`BondPlaces::Listed`](super::BondPlaces::Listed) are
    /// made. Nothing is bonded yet.
    ///
    /// # Errors
    /// If a pair names a piece that does not exist, or one piece twice.
    pub fn list_pairs(&mut self, pairs: Vec<ListedPair>) -> Result<(), SimulationError> {
        let state = &mut self.integrator.state;
        let count = state.pieces();
        if let Some(pair) = pairs.iter().find(|pair| !pair.is_possible(count)) {
            let what = format!(
                "the list of pairs names the pieces {:?}; two different pieces of {count}, counted from 0, can be bonded",
                pair.pieces
            );
            return Err(SimulationError::Bonds { what });
        }
        state.listed_pairs = pairs;
        Ok(())
    }

    /// The pairs that a file lists as bonded, whether they are bonded yet or not.
    pub fn listed_pairs(&self) -> &[ListedPair] {
        &self.state().listed_pairs
    }

    /// Checks that bonds of a definition can be made of the pairs that are listed, before the sample is prepared.
    ///
    /// # Errors
    /// If no pair is listed, or none of the type that the definition asks for.
    pub fn check_listed(&self, bonding: &Bonding) -> Result<(), SimulationError> {
        chosen(self.listed_pairs(), bonding.kind).map(|_| ())
    }
}

/// The pairs of a type, or all.
fn chosen(listed: &[ListedPair], kind: Option<u32>) -> Result<Vec<&ListedPair>, SimulationError> {
    let pairs: Vec<&ListedPair> =
        listed.iter().filter(|pair| kind.is_none_or(|kind| pair.kind == kind)).collect();
    if !pairs.is_empty() {
        return Ok(pairs);
    }
    let what = match kind {
        _ if listed.is_empty() => {
            "places = \"file\" takes the pairs that a packing lists as bonded, and this sample is of none that lists any; take a packing with \
             bonds (--packing, a LAMMPS data file with the section Bonds), or places = \"between\""
                .to_string()
        }
        kind => {
            let mut kinds: Vec<u32> = listed.iter().map(|pair| pair.kind).collect();
            kinds.sort_unstable();
            kinds.dedup();
            let named: Vec<String> = kinds.iter().take(MOST_NAMED).map(u32::to_string).collect();
            let more = if kinds.len() > MOST_NAMED { ", ..." } else { "" };
            format!(
                "type = {} is none of the types of bonds that the packing lists; it has {}{more}",
                kind.unwrap_or_default(),
                named.join(", ")
            )
        }
    };
    Err(SimulationError::Bonds { what })
}

impl Integrator {
    /// Pairs of pieces, as indices of the pieces of an assembly, with the nearest image of the second.
    pub(super) fn pairs_of_pieces(&self, pieces: &[[usize; 2]]) -> Result<Vec<Pair>, SimulationError> {
        let state = &self.state;
        let order = state.pieces_in_order(&state.bodies_in_order());
        let inverse = invert(&state.cell.edges);
        let mut pairs = Vec::with_capacity(pieces.len());
        for pair in pieces {
            let [Some(i), Some(j)] = pair.map(|piece| order.get(piece).copied()) else {
                let what = format!(
                    "there is no pair of pieces {pair:?}; there are {} pieces, counted from 0",
                    order.len()
                );
                return Err(SimulationError::Bonds { what });
            };
            let apart: Vector =
                std::array::from_fn(|a| state.particles[j].position()[a] - state.particles[i].position()[a]);
            let image = apply(&inverse, apart).map(|share| (-share.round()) as i32);
            pairs.push(([i as u32, j as u32], image));
        }
        Ok(pairs)
    }

    /// The listed pairs that a definition asks for, at their nearest images.
    pub(super) fn pairs_listed(&self, bonding: &Bonding) -> Result<Vec<Pair>, SimulationError> {
        let state = &self.state;
        let pieces: Vec<[usize; 2]> =
            chosen(&state.listed_pairs, bonding.kind)?.into_iter().map(|pair| pair.pieces).collect();
        let pairs = self.pairs_of_pieces(&pieces)?;
        let widest = WIDEST * self.mean_diameter();
        let lowest = state.cell.heights().into_iter().fold(f64::INFINITY, f64::min);
        for (pair, pieces) in pairs.iter().zip(&pieces) {
            let wrong = |why: String| {
                let [one, two] = pair.0.map(|row| state.ids[row as usize]);
                let [i, j] = pieces.map(|piece| piece + 1);
                let what = format!("the bond between the spheres {i} and {j} (grains {one} and {two}) {why}");
                Err(SimulationError::Bonds { what })
            };
            let [one, two] = pair.0.map(|row| self.clump_of.get(row as usize).copied().unwrap_or(NO_CLUMP));
            if one == two && one != NO_CLUMP {
                return wrong("is inside of one rigid grain; a rigid grain needs no bonds".into());
            }
            let distance = length(&self.branch_of(pair));
            let gap =
                distance - pair.0.iter().map(|row| state.particles[*row as usize].radius()).sum::<f64>();
            if gap > widest || distance > 0.5 * lowest {
                return wrong(format!(
                    "would bridge a gap of {gap:.3e} m; at most {widest:.3e} m, the mean diameter, and a length of half the width of the cell are \
                     possible"
                ));
            }
        }
        Ok(pairs)
    }
}

#[cfg(test)]
mod tests {
    use granum_core::cell::Cell;

    use super::*;
    use crate::bond::{BondPlaces, BondRadius};
    use crate::config::{ContactModel, Material};
    use crate::properties::Properties;
    use crate::simulation::InitialSphere;

    /// Four spheres in a row across the face of the cell, of which the first three touch.
    fn row() -> Simulation {
        let sphere = |id: u64, x: f64| InitialSphere { id, position: [x, 5e-3, 5e-3], radius: 0.5e-3 };
        let spheres = [sphere(1, 8.5e-3), sphere(2, 9.5e-3), sphere(3, 0.5e-3), sphere(4, 2.0e-3)];
        let material = Material { interface_energy: 0.0, ..Material::default() };
        let properties = Properties::new(material, ContactModel::default());
        Simulation::new(Cell::cuboid([10e-3; 3]), &spheres, properties).unwrap()
    }

    fn listed(kind: Option<u32>) -> Bonding {
        Bonding::default().with(|bonding| {
            bonding.places = BondPlaces::Listed;
            bonding.radius = BondRadius::Share(0.8);
            bonding.kind = kind;
        })
    }

    fn pair(i: usize, j: usize, kind: u32) -> ListedPair {
        ListedPair { pieces: [i, j], kind }
    }

    #[test]
    fn listed_pairs_are_bonded_by_type_across_faces_and_gaps_and_survive_a_checkpoint() {
        let mut s = row();
        s.list_pairs(vec![pair(2, 1, 1), pair(2, 3, 2), pair(0, 1, 1)]).unwrap();
        // They are part of a checkpoint before any bond is made, and after.
        let (mut s, _) = Simulation::restore(&s.checkpoint("").unwrap()).unwrap();
        assert_eq!(s.bond(&listed(Some(2))).unwrap(), 1);
        let (mut s, _) = Simulation::restore(&s.checkpoint("").unwrap()).unwrap();
        assert_eq!(s.listed_pairs().len(), 3);
        // Pairs that are joined already are not joined again.
        assert_eq!(s.bond(&listed(None)).unwrap(), 2);
        let bonds = s.assembly().bonds;
        let ends: Vec<[usize; 2]> = bonds.iter().map(|bond| [bond.i, bond.j]).collect();
        assert_eq!(ends, [[2, 3], [0, 1], [1, 2]]);
        // The unstressed length is the distance where there is a gap.
        assert!((bonds[0].length - 1.5e-3).abs() < 1e-12 && (bonds[2].branch[0] - 1e-3).abs() < 1e-12);
    }

    #[test]
    fn impossible_lists_are_refused_by_name() {
        let said = |result: Result<usize, SimulationError>| result.unwrap_err().to_string();
        let mut s = row();
        assert!(said(s.bond(&listed(None))).contains("of none that lists any"), "no list");
        for wrong in [pair(1, 1, 1), pair(0, 4, 1)] {
            let told = s.list_pairs(vec![wrong]).unwrap_err().to_string();
            assert!(told.contains("two different pieces of 4, counted from 0"), "{told}");
        }
        s.list_pairs(vec![pair(0, 1, 1), pair(0, 3, 3)]).unwrap();
        let told = said(s.bond(&listed(Some(2))));
        assert!(told.contains("type = 2 is none of the types") && told.contains("it has 1, 3"), "{told}");
        let told = said(s.bond(&listed(None)));
        assert!(
            told.contains("between the spheres 1 and 4") && told.contains("bridge a gap of 2.5"),
            "{told}"
        );
        assert_eq!(s.bonds(), 0);
    }
}
