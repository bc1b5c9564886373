//! Pairs of grains that touch, each with its contacts. Two spheres have one contact; two grains of several pieces can have several, which
//! together are what the one grain does to the other.
//!
//! The resultant normal force of a pair is the sum of the normal forces of its contacts as vectors, `sum N n`. Its size
//! `N_p = |sum N n|`, with the sign of `sum N`, is N itself where there is one contact.

use granum_core::assembly::{Assembly, Contact, Vector};
use granum_core::geometry::length;

/// The indices of two bodies, the smaller one first, and of one of their contacts.
type Member = ([usize; 2], usize);

/// The pairs of bodies that touch, in the order of their indices. Two images of a body that touch another are one pair.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pairs(Vec<Member>);

impl Pairs {
    /// Finds the pairs. A contact with a piece that does not exist (in a file of another code) belongs to none.
    pub fn from_assembly(assembly: &Assembly) -> Pairs {
        let member = |(contact, of): (usize, &Contact)| {
            let [i, j] = assembly.bodies_of(of)?;
            Some(([i.min(j), i.max(j)], contact))
        };
        let mut members: Vec<Member> = assembly.contacts.iter().enumerate().filter_map(member).collect();
        members.sort_unstable();
        Pairs(members)
    }

    /// The pairs of this assembly, of which they were found.
    pub fn each<'a>(&'a self, assembly: &'a Assembly) -> impl Iterator<Item = Pair<'a>> {
        self.0.chunk_by(|a, b| a.0 == b.0).map(move |members| Pair { members, assembly })
    }
}

/// Two bodies that touch.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    members: &'a [Member],
    assembly: &'a Assembly,
}

impl<'a> Pair<'a> {
    /// The number of its contacts, one or more.
    pub fn count(&self) -> usize {
        self.members.len()
    }

    /// Its contacts, in their order in the assembly.
    pub fn contacts(&self) -> impl Iterator<Item = &'a Contact> {
        let assembly = self.assembly;
        self.members.iter().filter_map(|(_, contact)| assembly.contacts.get(*contact))
    }

    /// The branch vector between the centres of its bodies, m, as its first contact has it.
    pub fn branch(&self) -> Vector {
        self.contacts().next().map_or([0.0; 3], |contact| self.assembly.branch_of_bodies(contact))
    }

    /// Its resultant normal force `N_p = |sum N n|`, with the sign of `sum N`, N.
    pub fn normal_force(&self) -> f64 {
        let (mut sum, mut resultant) = (0.0, [0.0; 3]);
        for contact in self.contacts() {
            sum += contact.normal_force;
            // Normals point away from the body with the smaller index.
            let along = if self.is_reversed(contact) { -contact.normal_force } else { contact.normal_force };
            resultant = std::array::from_fn(|a| resultant[a] + along * contact.normal[a]);
        }
        let size = length(&resultant);
        if sum < 0.0 { -size } else { size }
    }

    fn is_reversed(&self, contact: &Contact) -> bool {
        self.assembly.bodies_of(contact).is_some_and(|[i, j]| i > j)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clumps;

    #[test]
    fn contacts_are_gathered_by_the_grains_that_they_join() {
        let assembly = clumps::few();
        let found = Pairs::from_assembly(&assembly);
        let counts: Vec<usize> = found.each(&assembly).map(|pair| pair.count()).collect();
        assert_eq!(counts, [2, 1, 1]);
        let known = assembly.pairs_of_bodies();
        assert_eq!(counts, known.iter().map(|(_, count)| *count).collect::<Vec<_>>());
        let branches: Vec<Vector> = found.each(&assembly).map(|pair| pair.branch()).collect();
        for (branch, exact) in branches.iter().zip([[0.0, 1.0, 0.0], [1.5, 0.5, 0.0], [1.0, 0.5, 0.0]]) {
            assert!((0..3).all(|a| (branch[a] - exact[a]).abs() < 1e-15), "{branch:?}");
        }
    }

    /// Two contacts at a right angle with forces of 3 and 4 give 5, also where one is written from the other end.
    #[test]
    fn the_resultant_is_a_sum_of_vectors() {
        let mut assembly = clumps::few();
        let force = |assembly: &Assembly| -> f64 {
            Pairs::from_assembly(assembly).each(assembly).next().unwrap().normal_force()
        };
        assert!((force(&assembly) - 4.0).abs() < 1e-15);
        assembly.contacts[1].normal_force = 4.0;
        assembly.contacts[1].normal = [1.0, 0.0, 0.0];
        assert!((force(&assembly) - 5.0).abs() < 1e-15);
        let turned = &mut assembly.contacts[1];
        (turned.i, turned.j, turned.normal) = (turned.j, turned.i, [-1.0, 0.0, 0.0]);
        assert!((force(&assembly) - 5.0).abs() < 1e-15);
        assembly.contacts[1].normal_force = -4.0;
        assert!((force(&assembly) + 5.0).abs() < 1e-15, "together they pull");
    }
}
