//! Sliding pairs of grains. Two grains of several pieces that touch at several places slide along each other only where all of their
//! contacts are at the friction limit; where some hold, the pair turns about these. Compare the [sliding fraction](crate::sliding) of
//! the contacts.

use granum_core::Part;

use crate::ratio::mean;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct PairSliding;

impl Sensor for PairSliding {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("pair_sliding", "pairs of grains whose contacts are at the friction limit")
            .speaking_of(Subject::Bodies)
            .columns([
                SensorColumn::new(
                    "sliding_pair_fraction",
                    "1",
                    "pairs of which every contact slides over all pairs",
                ),
                SensorColumn::new(
                    "partly_sliding_pair_fraction",
                    "1",
                    "pairs of which some contacts slide and others do not over all pairs",
                ),
            ])
            .needing(&[Part::Contacts, Part::Sliding])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let (mut pairs, mut whole, mut partly) = (0, 0, 0);
        for pair in observation.pairs() {
            let sliding = pair.contacts().filter(|contact| contact.sliding).count();
            pairs += 1;
            whole += usize::from(sliding == pair.count());
            partly += usize::from(sliding > 0 && sliding < pair.count());
        }
        values.extend([mean(whole as f64, pairs), mean(partly as f64, pairs)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clumps;
    use crate::sensor::measured;

    #[test]
    fn a_pair_slides_where_all_of_its_contacts_do() {
        let mut assembly = clumps::few();
        let third = 1.0 / 3.0;
        assert_eq!(measured(&PairSliding, &assembly), [third, third]);
        assembly.contacts[1].sliding = true;
        assert_eq!(measured(&PairSliding, &assembly), [2.0 * third, 0.0]);
        assembly.contacts.iter_mut().for_each(|contact| contact.sliding = false);
        assert_eq!(measured(&PairSliding, &assembly), [0.0; 2]);
    }
}
