//! Assemblies of what a program has in memory, by the rules for files.

use granum_core::assembly::{Assembly, Matrix, Sphere, Vector};
use granum_core::{Part, Parts};

use super::contact_table::{ContactOptions, ContactTable};
use super::join::{connect, wrap};
use super::result::{FileContact, FrameCell, ObservedAssembly};
use super::rounding;
use crate::packing::lattice::Images;
use crate::packing::plausible::{self, Found};
use crate::packing::{Implausible, ImplausiblePlace};

/// The places of the two grains of a contact in the list of grains, from 0, and the whole force on the first, N, where it is known.
pub type PairOfGrains = ([usize; 2], Option<Vector>);

impl ObservedAssembly {
    /// The assembly of these grains, each with its place and radius, m, in a periodic cell with these edges (column k is edge k) and a
    /// corner at the origin; without contacts these follow from the overlaps. Rows of contacts are held against the grains as those of a file, but
    /// nothing is refused as undecided: what is doubtful is in [`ObservedAssembly::remarks`]. The grains have ids from 1 in their order. Branch, normal and overlap of a
    /// contact follow from the places of its grains, and so do the parts of its force.
    ///
    /// # Errors
    /// For what cannot belong to one packing, or a contact of a grain that is not there, with its place in the lists.
    pub fn of_arrays(
        grains: &[(Vector, f64)],
        cell: Option<Matrix>,
        contacts: Option<&[PairOfGrains]>,
    ) -> Result<ObservedAssembly, Implausible> {
        let found = |(id, (position, radius)): (u64, &(Vector, f64))| Found {
            id,
            position: *position,
            radius: Some(*radius),
            line: 0,
        };
        let found: Vec<Found> = (1..).zip(grains).map(found).collect();
        plausible::find(cell.map(|edges| ([0.0; 3], edges)), &found)?;
        let grain = |found: &Found| Sphere {
            id: found.id,
            position: found.position,
            radius: found.radius.unwrap_or_default(),
            ..Sphere::default()
        };
        let mut placed: Vec<Sphere> = found.iter().map(grain).collect();
        let mut parts = Parts::new(&[Part::Positions, Part::Radii]);
        if let Some(edges) = cell {
            wrap(&mut placed, &FrameCell { origin: [0.0; 3], edges });
            parts = parts.with(Part::Cell);
        }
        let mut assembly =
            Assembly { cell: cell.unwrap_or_default(), ..Assembly::default() }.with_spheres(placed);
        let mut remarks = Vec::new();
        if let Some(contacts) = contacts {
            let count = grains.len();
            let lost = |places: &[usize; 2]| places.iter().copied().find(|place| *place >= count);
            if let Some((k, place)) =
                contacts.iter().enumerate().find_map(|(k, (places, _))| Some((k, lost(places)?)))
            {
                let message = format!("names the grain {place}; there are {count}, from 0");
                return Err(Implausible::new(ImplausiblePlace::Contact(k), message, ""));
            }
            // Messages name grains by their places in the arrays.
            let pair = |([i, j], force): &PairOfGrains| FileContact {
                first: *i as u64,
                second: *j as u64,
                force: *force,
                ..FileContact::default()
            };
            let pairs: Vec<FileContact> = contacts.iter().map(pair).collect();
            let places: Vec<[usize; 2]> = contacts.iter().map(|(places, _)| *places).collect();
            let rounding = rounding::of_places(assembly.bodies.iter().map(|grain| grain.position));
            let options = ContactOptions::as_given();
            let images = Images::new(&assembly.cell);
            let table =
                ContactTable { assembly: &assembly, parts, images, rounding, body_of: &|_| None, options };
            let held = table.hold(pairs, places)?;
            remarks = held.remarks;
            (assembly.contacts, parts) = connect(&assembly, parts, &held.pairs, &held.places)?;
        }
        let observed = ObservedAssembly { remarks, ..ObservedAssembly::new(assembly, parts, [0.0; 3]) };
        Ok(observed.with_contacts_by_geometry())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::join::{JoinOptions, join};
    use crate::formats::result::Frame;

    const CELL: Matrix = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];

    fn grains() -> Vec<(Vector, f64)> {
        vec![([0.5, 2.0, 2.0], 0.6), ([3.5, 2.0, 2.0], 0.6), ([2.0, 5.0, 2.0], 0.5)]
    }

    #[test]
    fn arrays_are_what_a_file_of_the_same_numbers_is() {
        let force = Some([-3.0, 0.5, 0.0]);
        let made = ObservedAssembly::of_arrays(&grains(), Some(CELL), Some(&[([1, 0], force)])).unwrap();
        let mut frame = Frame { cell: Some(FrameCell::between([0.0; 3], [4.0; 3])), ..Frame::default() };
        frame.knows(&[Part::Positions, Part::Radii]);
        let grain = |(id, (position, radius)): (u64, (Vector, f64))| Sphere {
            id,
            position,
            radius,
            ..Sphere::default()
        };
        frame.grains = (1..).zip(grains()).map(grain).collect();
        frame.contacts = Some(vec![FileContact { first: 2, second: 1, force, ..FileContact::default() }]);
        let read = join(vec![("file".into(), vec![frame])], &JoinOptions::default()).unwrap();
        assert_eq!(read, std::slice::from_ref(&made));
        // Across the boundary, and the third grain in the cell.
        assert!((made.assembly.contacts[0].branch[0] - 1.0).abs() < 1e-12);
        assert_eq!(made.assembly.bodies[2].position, [2.0, 1.0, 2.0]);
    }

    #[test]
    fn what_cannot_be_right_has_its_place_in_the_lists() {
        let found = |grains: &[(Vector, f64)], cell: Matrix, contacts: &[PairOfGrains]| {
            let error = ObservedAssembly::of_arrays(grains, Some(cell), Some(contacts)).unwrap_err();
            (error.at, error.message)
        };
        let (at, message) = found(&grains(), CELL, &[([0, 1], None), ([0, 3], None)]);
        assert_eq!(at, ImplausiblePlace::Contact(1));
        assert_eq!(message, "names the grain 3; there are 3, from 0");
        assert_eq!(found(&grains(), CELL, &[([2, 2], None)]).0, ImplausiblePlace::Contact(0));
        assert_eq!(found(&grains(), [[0.0; 3]; 3], &[]).0, ImplausiblePlace::Cell);
        let with = |change: &dyn Fn(&mut (Vector, f64))| {
            let mut grains = grains();
            change(&mut grains[2]);
            found(&grains, CELL, &[])
        };
        assert_eq!(with(&|grain| grain.1 = -1.0).0, ImplausiblePlace::Radius(2));
        assert_eq!(with(&|grain| grain.1 = 1e-9).0, ImplausiblePlace::Radius(2));
        assert_eq!(with(&|grain| grain.1 = 3.0).0, ImplausiblePlace::Radius(2));
        assert_eq!(with(&|grain| grain.0[1] = 1e12).0, ImplausiblePlace::Position(2));
    }
}
