//! Contacts of a pair of grains: grains of several pieces can touch at several places.
//!
//! With N_c contacts, N_p pairs of grains that touch and N grains, the mean number of contacts of a pair is `N_c / N_p`, and the mean
//! number of neighbours that a grain touches is `Z_b = 2 N_p / N`, while the [coordination number](crate::coordination) `Z = 2 N_c / N`
//! counts contacts. A pair of one contact transmits a force, one of two also a couple about most axes, and one of three about every
//! axis, so that pairs are told apart by their number of contacts, as those of polyhedra are by faces, edges and corners (Azema, Radjai and
//! Saussine 2009).

use granum_core::Part;

use crate::ratio::{mean, ratio};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct ContactsPerPair;

impl Sensor for ContactsPerPair {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "contacts_per_pair",
            "at how many places two grains touch, and neighbours per grain",
        )
        .speaking_of(Subject::Bodies)
        .columns([
            SensorColumn::new("contacts_per_pair", "1", "mean number of contacts of two grains that touch"),
            SensorColumn::new("pairs_of_one_contact", "1", "pairs that touch at one place over all pairs"),
            SensorColumn::new("pairs_of_two_contacts", "1", "pairs with two contacts over all pairs"),
            SensorColumn::new("pairs_of_three_contacts", "1", "pairs with three contacts over all pairs"),
            SensorColumn::new("pairs_of_more_contacts", "1", "pairs with more contacts over all pairs"),
            SensorColumn::new(
                "neighbour_coordination_number",
                "1",
                "Z_b = 2 N_p / N: mean number of grains that a grain touches",
            ),
            SensorColumn::new("pairs", "1", "number N_p of pairs of grains that touch"),
        ])
        .needing(&[Part::Contacts])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let mut with = [0usize; 4];
        let mut contacts = 0;
        for pair in observation.pairs() {
            contacts += pair.count();
            with[pair.count().min(4) - 1] += 1;
        }
        let pairs: usize = with.iter().sum();
        values.push(mean(contacts as f64, pairs));
        values.extend(with.map(|count| mean(count as f64, pairs)));
        values.push(ratio(2.0 * pairs as f64, observation.assembly.bodies.len() as f64));
        values.push(pairs as f64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::measured;
    use crate::{clumps, lattice};

    #[test]
    fn three_pairs_of_clumps_with_two_contacts_and_one() {
        let third = 1.0 / 3.0;
        let exact = [4.0 * third, 2.0 * third, third, 0.0, 0.0, 6.0 / 5.0, 3.0];
        let row = measured(&ContactsPerPair, &clumps::few());
        assert!(row.iter().zip(exact).all(|(value, exact)| (value - exact).abs() < 1e-15), "{row:?}");
    }

    #[test]
    fn many_contacts_of_one_pair_are_counted_together() {
        let mut assembly = clumps::few();
        for count in 3..=5 {
            assembly.contacts.push(assembly.contacts[0]);
            let row = measured(&ContactsPerPair, &assembly);
            let shares = if count == 3 { [1.0, 0.0] } else { [0.0, 1.0] };
            assert_eq!(row[3..5], shares.map(|share| share / 3.0), "{count} contacts: {row:?}");
        }
    }

    #[test]
    fn spheres_have_one_contact_a_pair() {
        let lattice = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        assert_eq!(measured(&ContactsPerPair, &lattice), [1.0, 1.0, 0.0, 0.0, 0.0, 6.0, 81.0]);
    }
}
