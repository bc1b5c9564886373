//! Coordination numbers: contacts per grain, by several definitions.
//!
//! With N_k contacts, N grains, and N_0 and N_1 grains with no contact and with one contact:
//! - coordination number `Z = 2 N_k / N`;
//! - mechanical coordination number `Z_m = (2 N_k - N_1) / (N - N_0 - N_1)` (Thornton 2000): the mean number of contacts of
//!   the grains that have at least two;
//! - compressive coordination number: Z of the contacts in compression only, which carry load;
//! - backbone coordination number: Z after the grains with fewer than two contacts have been removed together with their
//!   contacts, repeatedly until none is left.
//!
//! Rattlers are the grains with fewer than two contacts: N_0 + N_1.
//!
//! Two grains of several pieces can touch at several places, and a grain that touches one neighbour only cannot be in equilibrium by its
//! contact forces, at however many places. Where grains have several pieces, a rattler is therefore a grain that touches fewer than two others: Z
//! counts contacts, `Z_m = (2 N_k - C_1) / (N - N_0 - N_1)` with the C_1 contacts of the N_1 grains with one neighbour, and the backbone is what is
//! left after the removal of such grains.

use granum_core::{Assembly, Part};

use crate::ratio::mean;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct CoordinationNumbers;

impl Sensor for CoordinationNumbers {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("coordination", "mean number of contacts per grain, by several definitions")
            .speaking_of(Subject::Bodies)
            .columns([
                SensorColumn::new("coordination_number", "1", "Z = 2 N_k / N over all grains"),
                SensorColumn::new(
                    "mechanical_coordination_number",
                    "1",
                    "Z_m of Thornton (2000): over grains with two contacts or more",
                ),
                SensorColumn::new(
                    "compressive_coordination_number",
                    "1",
                    "Z of the contacts in compression only",
                )
                .needing(&[Part::NormalForces]),
                SensorColumn::new(
                    "backbone_coordination_number",
                    "1",
                    "Z after grains with fewer than two contacts are removed until none is left",
                ),
                SensorColumn::new(
                    "rattler_fraction",
                    "1",
                    "grains with fewer than two contacts over all grains",
                ),
                SensorColumn::new("contacts", "1", "number N_k of contacts"),
            ])
            .needing(&[Part::Contacts])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let z = Coordination::from_observation(observation);
        values.extend([
            z.all,
            z.mechanical,
            z.compressive,
            z.backbone,
            z.rattler_fraction,
            observation.assembly.contacts.len() as f64,
        ]);
    }
}

/// Coordination numbers of an assembly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coordination {
    /// Z = 2 N_k / N.
    pub all: f64,
    /// Z_m (Thornton 2000).
    pub mechanical: f64,
    /// Z of the contacts in compression.
    pub compressive: f64,
    /// Z of the grains that are left after repeated removal of the rattlers.
    pub backbone: f64,
    /// (N_0 + N_1) / N.
    pub rattler_fraction: f64,
}

impl Coordination {
    /// Computes the coordination numbers; 0 where there is no grain to divide by.
    pub fn from_observation(observation: &Observation) -> Self {
        let assembly = observation.assembly;
        let grains = assembly.bodies.len();
        let (links, compressive) = links(assembly);
        let (mut neighbours, mut contacts) = (vec![0u32; grains], vec![0usize; grains]);
        for ([i, j], count) in &links {
            for grain in [*i as usize, *j as usize] {
                neighbours[grain] += 1;
                contacts[grain] += *count;
            }
        }
        let count: usize = links.iter().map(|(_, count)| count).sum();
        let alone = neighbours.iter().filter(|&&n| n == 0).count();
        let single = neighbours.iter().filter(|&&n| n == 1).count();
        let of_single: usize =
            neighbours.iter().zip(&contacts).filter(|(n, _)| **n == 1).map(|(_, own)| own).sum();
        Coordination {
            all: mean(2.0 * count as f64, grains),
            mechanical: mean((2 * count - of_single) as f64, grains - alone - single),
            compressive: mean(2.0 * compressive as f64, grains),
            backbone: backbone(links, neighbours),
            rattler_fraction: mean((alone + single) as f64, grains),
        }
    }
}

/// Two grains that touch, and the number of their contacts.
type Link = ([u32; 2], usize);

/// The links of all grains, and the number of contacts in compression. Every contact of spheres is a link of its own; the contacts of two
/// grains of several pieces are one. A contact with a grain that does not exist (in a file of another code) is not counted.
fn links(assembly: &Assembly) -> (Vec<Link>, usize) {
    let mut links: Vec<Link> = Vec::with_capacity(assembly.contacts.len());
    let mut compressive = 0;
    for contact in &assembly.contacts {
        let Some([i, j]) = assembly.bodies_of(contact) else { continue };
        compressive += usize::from(contact.normal_force > 0.0);
        links.push(([i as u32, j as u32], 1));
    }
    if !assembly.all_spheres() {
        let link = |([i, j], count): ([usize; 2], usize)| ([i as u32, j as u32], count);
        links = assembly.pairs_of_bodies().into_iter().map(link).collect();
    }
    (links, compressive)
}

/// Coordination number of the contacts that are left after grains with fewer than two neighbours have been removed until none
/// is left.
fn backbone(mut left: Vec<Link>, mut neighbours: Vec<u32>) -> f64 {
    loop {
        let before = left.len();
        left.retain(|(pair, _)| {
            let [i, j] = pair.map(|g| g as usize);
            let kept = neighbours[i] >= 2 && neighbours[j] >= 2;
            if !kept {
                neighbours[i] -= 1;
                neighbours[j] -= 1;
            }
            kept
        });
        if left.len() == before {
            let grains = neighbours.iter().filter(|&&n| n >= 2).count();
            let contacts: usize = left.iter().map(|(_, count)| count).sum();
            return mean(2.0 * contacts as f64, grains);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{clumps, lattice};
    use granum_core::assembly::{Contact, Sphere};

    #[test]
    fn lattices_have_six_and_twelve() {
        for (assembly, z) in [
            (lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4), 6.0),
            (lattice::face_centred_cubic(3, 1e-4, 1e-4, 1e-4), 12.0),
        ] {
            let c = Coordination::from_observation(&Observation::new(&assembly));
            assert_eq!(
                c,
                Coordination { all: z, mechanical: z, compressive: z, backbone: z, rattler_fraction: 0.0 }
            );
        }
    }

    /// A ring of three grains with a tail of two, and one isolated grain.
    #[test]
    fn rattlers_are_counted_by_each_definition() {
        let grains = vec![Sphere { radius: 1.0, ..Default::default() }; 6];
        let contacts = [(0, 1), (1, 2), (0, 2), (2, 3), (3, 4)].map(|(i, j)| Contact {
            i,
            j,
            normal_force: if j == 4 { -1.0 } else { 2.0 },
            ..Default::default()
        });
        let assembly = Assembly { contacts: contacts.to_vec(), ..Default::default() }.with_spheres(grains);
        let c = Coordination::from_observation(&Observation::new(&assembly));
        assert!((c.all - 10.0 / 6.0).abs() < 1e-15);
        assert!((c.mechanical - 9.0 / 4.0).abs() < 1e-15, "grains 0 to 3 have 2, 2, 3 and 2 contacts");
        assert!((c.compressive - 8.0 / 6.0).abs() < 1e-15);
        assert!((c.backbone - 2.0).abs() < 1e-15, "the ring is left");
        assert!((c.rattler_fraction - 2.0 / 6.0).abs() < 1e-15);
    }

    /// A clump with two contacts with its only neighbour is a rattler, and so is a sphere with one; what is left of the chain falls apart.
    #[test]
    fn a_clump_with_one_neighbour_is_a_rattler() {
        let c = Coordination::from_observation(&Observation::new(&clumps::few()));
        assert_eq!(c.all, 8.0 / 5.0);
        assert_eq!(c.mechanical, 5.0 / 2.0, "the two in the middle have three and two contacts");
        assert_eq!((c.compressive, c.backbone, c.rattler_fraction), (6.0 / 5.0, 0.0, 3.0 / 5.0));
        // A ring: the first touches the third by two contacts, too.
        let mut ring = clumps::few();
        let closing = |i: usize, j: usize| Contact { i, j, ..Contact::default() };
        ring.contacts.extend([closing(0, 4), closing(1, 5)]);
        let c = Coordination::from_observation(&Observation::new(&ring));
        assert_eq!((c.all, c.backbone, c.rattler_fraction), (12.0 / 5.0, 10.0 / 3.0, 2.0 / 5.0));
    }
}
