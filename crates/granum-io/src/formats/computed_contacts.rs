//! Contacts of grains whose data have none: those that overlap touch.

use granum_core::Part;
use granum_core::assembly::{Assembly, Contact, Vector};
use granum_core::geometry::length;

use super::remark::Remark;
use super::result::ObservedAssembly;
use crate::packing::near::{NearGrains, Neighbour};

impl ObservedAssembly {
    /// The same with contacts where the data have none but radii: grains that overlap touch, in any cell or none. Overlaps are known then,
    /// forces are not. How many contacts are inside bodies of several spheres is remarked.
    pub fn with_contacts_by_geometry(mut self) -> ObservedAssembly {
        if self.parts.has(Part::Contacts) || !self.parts.missing(&[Part::Positions, Part::Radii]).is_empty() {
            return self;
        }
        let Assembly { bodies, pieces, .. } = &self.assembly;
        let positions: Vec<Vector> = pieces.iter().map(|piece| piece.position).collect();
        let radii: Vec<f64> = pieces.iter().map(|piece| piece.radius).collect();
        let cell = self.parts.has(Part::Cell).then_some(&self.assembly.cell);
        let mut touching = NearGrains::new(cell, &positions, &radii).touching(0.0);
        if !self.assembly.all_spheres() {
            touching.retain(|(at, near)| pieces[*at].body != pieces[near.grain].body);
        }
        let body = |piece: usize| self.clump_of.get(&bodies[pieces[piece].body].id);
        let inside =
            touching.iter().filter(|(at, near)| body(*at).is_some() && body(*at) == body(near.grain)).count();
        if inside > 0 {
            self.remarks.push(Remark::doubtful(format!(
                "{inside} of the {} contacts computed from the overlaps of spheres {} inside a body",
                touching.len(),
                if inside == 1 { "is" } else { "are" }
            )));
        }
        self.assembly.contacts = touching.into_iter().map(contact).collect();
        self.parts = self.parts.with(Part::Contacts).with(Part::Overlaps);
        self.contacts_are_computed = true;
        self
    }
}

fn contact((i, near): (usize, Neighbour)) -> Contact {
    let distance = length(&near.branch);
    let normal = if distance > 0.0 { near.branch.map(|x| x / distance) } else { [1.0, 0.0, 0.0] };
    Contact { i, j: near.grain, branch: near.branch, normal, approach: near.overlap, ..Contact::default() }
}

#[cfg(test)]
mod tests {
    use granum_core::assembly::Sphere;
    use granum_core::{Part, Parts};

    use super::*;

    fn three(cell: bool) -> ObservedAssembly {
        let grain = |id, x| Sphere { id, position: [x, 1.0, 1.0], radius: 0.5, ..Sphere::default() };
        let mut parts = Parts::new(&[Part::Positions, Part::Radii]);
        let mut assembly = Assembly { ..Assembly::default() }.with_spheres(vec![
            grain(1, 0.2),
            grain(2, 1.1),
            grain(3, 3.4),
        ]);
        if cell {
            assembly.cell = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
            parts = parts.with(Part::Cell);
        }
        ObservedAssembly::new(assembly, parts, [0.0; 3])
    }

    #[test]
    fn grains_that_overlap_touch_in_a_cell_and_without_one() {
        let pairs = |observed: &ObservedAssembly| -> Vec<[usize; 2]> {
            observed.assembly.contacts.iter().map(|contact| [contact.i, contact.j]).collect()
        };
        let open = three(false).with_contacts_by_geometry();
        assert_eq!(pairs(&open), [[0, 1]]);
        assert!(open.contacts_are_computed && open.parts.has(Part::Overlaps));
        assert!((open.assembly.contacts[0].approach - 0.1).abs() < 1e-12);
        let periodic = three(true).with_contacts_by_geometry();
        assert_eq!(pairs(&periodic), [[0, 1], [0, 2]]);
        assert!((periodic.assembly.contacts[1].normal[0] + 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_has_contacts_or_no_radii_stays_and_contacts_inside_bodies_are_said() {
        let mut read = three(false);
        read.parts = read.parts.with(Part::Contacts);
        assert!(!read.with_contacts_by_geometry().contacts_are_computed);
        let mut points = three(false);
        points.parts = Parts::new(&[Part::Positions]);
        assert!(!points.with_contacts_by_geometry().parts.has(Part::Contacts));
        let mut dimer = three(true);
        dimer.clump_of = [(1, 7), (2, 7)].into();
        let dimer = dimer.with_contacts_by_geometry();
        assert_eq!(dimer.assembly.contacts.len(), 2);
        assert!(dimer.remarks[0].text.starts_with("1 of the 2 contacts"), "{:?}", dimer.remarks);
    }
}
