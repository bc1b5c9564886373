//! Coordination number by size: the grains in five classes of equal number from the smallest to the largest fifth, and the mean
//! number of contacts of each class. Grains of equal size count with the mean number of contacts of all grains of that size, so that
//! it does not matter to which classes they belong.
//!
//! Sizes are the radii of the spheres of equal volume, and all contacts of the pieces of a grain count.
//!
//! In a polydisperse sample small grains have fewer contacts and are more often rattlers; large grains have many contacts.

use granum_core::Part;

use crate::ratio::mean;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// Number of classes.
pub const CLASSES: usize = 5;

/// The sensor.
pub struct CoordinationBySize;

impl Sensor for CoordinationBySize {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "coordination_by_size",
            "mean number of contacts of the grains of each fifth by size",
        )
        .speaking_of(Subject::Bodies)
        .columns([
            SensorColumn::new("coordination_size_1", "1", "mean contacts of a grain of the smallest fifth"),
            SensorColumn::new("coordination_size_2", "1", "mean contacts of a grain of the second fifth"),
            SensorColumn::new("coordination_size_3", "1", "mean contacts of a grain of the third fifth"),
            SensorColumn::new("coordination_size_4", "1", "mean contacts of a grain of the fourth fifth"),
            SensorColumn::new("coordination_size_5", "1", "mean contacts of a grain of the largest fifth"),
        ])
        .needing(&[Part::Radii, Part::Contacts])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        values.extend(coordination_by_size(observation));
    }
}

/// Mean number of contacts of the grains of each class, the smallest first; 0 for a class without grains.
pub fn coordination_by_size(observation: &Observation) -> [f64; CLASSES] {
    let grains = &observation.assembly.bodies;
    let mut degree = vec![0u32; grains.len()];
    for contact in &observation.assembly.contacts {
        for piece in [contact.i, contact.j] {
            let Some(end) = observation.assembly.body_of(piece) else { continue };
            if let Some(degree) = degree.get_mut(end) {
                *degree += 1;
            }
        }
    }
    let mut order: Vec<usize> = (0..grains.len()).collect();
    order.sort_by(|&a, &b| {
        grains[a].equivalent_radius.total_cmp(&grains[b].equivalent_radius).then(a.cmp(&b))
    });
    let mut contacts = Vec::with_capacity(order.len());
    for equal in order.chunk_by(|&a, &b| grains[a].equivalent_radius == grains[b].equivalent_radius) {
        let sum: f64 = equal.iter().map(|&grain| f64::from(degree[grain])).sum();
        contacts.extend(equal.iter().map(|_| mean(sum, equal.len())));
    }
    std::array::from_fn(|class| {
        let edge = |class: usize| class * contacts.len() / CLASSES;
        let own = &contacts[edge(class)..edge(class + 1)];
        mean(own.iter().sum::<f64>() + 0.0, own.len())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{clumps, lattice};
    use granum_core::assembly::{Assembly, Contact, Sphere};

    #[test]
    fn every_fifth_of_a_lattice_has_six() {
        let lattice = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        assert_eq!(coordination_by_size(&Observation::new(&lattice)), [6.0; 5]);
    }

    /// A chain of ten grains of two sizes: its ends, which have one contact, do not decide about the classes.
    #[test]
    fn grains_of_equal_size_count_alike() {
        let grain = |radius: f64| Sphere { radius, ..Default::default() };
        let grains = (0..10).map(|k| grain(if k < 6 { 1.0 } else { 2.0 }));
        let contacts = (1..10).map(|j| Contact { i: j - 1, j, ..Default::default() }).collect();
        let chain = Assembly { contacts, ..Default::default() }.with_spheres(grains);
        let [small, large] = [11.0 / 6.0, 7.0 / 4.0];
        let found = coordination_by_size(&Observation::new(&chain));
        for (found, expected) in found.into_iter().zip([small, small, small, large, large]) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }

    /// A star: the largest of five grains touches all others, the smallest none but it.
    #[test]
    fn a_large_grain_has_the_contacts() {
        let grain = |radius: f64| Sphere { radius, ..Default::default() };
        let grains = vec![grain(3.0), grain(9.0), grain(1.0), grain(2.0), grain(4.0)];
        let to = |j: usize| Contact { i: 1, j, ..Default::default() };
        let contacts = vec![to(0), to(2), to(3), to(4), Contact { i: 0, j: 4, ..Default::default() }];
        let star = Assembly { contacts, ..Default::default() }.with_spheres(grains);
        assert_eq!(coordination_by_size(&Observation::new(&star)), [1.0, 1.0, 2.0, 2.0, 4.0]);
    }

    /// The first clump has two contacts with one neighbour; sizes are those of the spheres of equal volume, 0.6 for the three clumps.
    #[test]
    fn contacts_of_the_pieces_are_those_of_the_grain() {
        let found = coordination_by_size(&Observation::new(&clumps::few()));
        let of_clumps = 7.0 / 3.0;
        for (found, exact) in found.into_iter().zip([0.5, 0.5, of_clumps, of_clumps, of_clumps]) {
            assert!((found - exact).abs() < 1e-15, "{found} {exact}");
        }
    }
}
