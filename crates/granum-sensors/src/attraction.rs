//! Attraction by an adhesion law, at contacts and between separated grains (for instance by liquid bridges): its energy, its
//! losses since the start of the phase, and the number of separated pairs on which it acts. These columns are omitted from a
//! series without such a law.
//!
//! The energy balance of [`crate::energy`] then includes `change of attraction_energy + attraction_loss`.

use granum_core::Part;
use granum_core::energy::MechanismGroup;

use crate::energy::mechanism_columns;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Attraction;

impl Sensor for Attraction {
    fn description(&self) -> SensorDescription {
        let energy = SensorColumn::new(
            "attraction_energy",
            "J",
            "of the attraction of all pairs, zero where they just touch",
        );
        let pairs =
            SensorColumn::new("pairs_apart", "1", "pairs of grains that attract each other without touching");
        let columns =
            [energy].into_iter().chain(mechanism_columns(MechanismGroup::Attraction)).chain([pairs]);
        SensorDescription::new(
            "attraction",
            "energy of additional adhesion, and number of separated pairs that it attracts",
        )
        .speaking_of(Subject::Contacts)
        .columns(columns.map(SensorColumn::optional))
        .needing(&[Part::Contacts, Part::ContactEnergies, Part::EnergyBalance])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let assembly = observation.assembly;
        let pairs = assembly.contacts.iter().chain(&assembly.apart);
        let energy: f64 = pairs.map(|pair| pair.attraction_energy).sum();
        // The sum over no contacts is minus zero.
        values.push(energy + 0.0);
        values.extend(MechanismGroup::Attraction.values(&assembly.energy));
        values.push(assembly.apart.len() as f64);
    }
}

#[cfg(test)]
mod tests {
    use crate::{column_index, lattice, measure_row};

    /// A separated pair contributes its energy and its force, but is not a contact.
    #[test]
    fn pairs_apart_have_a_part_in_the_stress() {
        let assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        let at = |name: &str| column_index(name).unwrap();
        let before = measure_row(&assembly);
        let mut wet = assembly.clone();
        let mut pair = wet.contacts[0];
        (pair.normal_force, pair.attraction_energy, pair.approach) = (-1e-6, 2e-12, -1e-7);
        (pair.tangential_force, pair.normal_energy) = ([0.0; 3], 0.0);
        wet.apart.push(pair);
        let after = measure_row(&wet);
        assert_eq!(after[at("attraction_energy")], 2e-12);
        assert_eq!(after[at("pairs_apart")], 1.0);
        assert_eq!(after[at("coordination_number")], before[at("coordination_number")]);
        let length = pair.branch.iter().map(|x| x * x).sum::<f64>().sqrt();
        let pull = -1e-6 * length / (3.0 * wet.volume());
        let change = after[at("mean_stress")] - before[at("mean_stress")];
        assert!((change / pull - 1.0).abs() < 1e-6, "{change} {pull}");
    }
}
