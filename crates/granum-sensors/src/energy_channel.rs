//! Energy in a channel that a contact law declares, since the start of the phase: a sensor with one column for each channel of the
//! laws that a program knows, named by the key of the channel. The column is omitted from a series without such a law.
//!
//! The energy balance of [`crate::energy`] then includes the column. So does Luding's law with `plastic_loss`; the energy that would be
//! recovered in unloading is part of `elastic_normal_energy`.

use granum_core::Part;
use granum_dem::contact::EnergyChannel;

use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Values};

/// The sensor of a channel.
pub struct ChannelEnergy(pub EnergyChannel);

impl Sensor for ChannelEnergy {
    fn description(&self) -> SensorDescription {
        let EnergyChannel { key, meaning, sensor, .. } = self.0;
        let short = meaning.strip_prefix("energy ").unwrap_or(meaning);
        SensorDescription::new(sensor, meaning)
            .columns([SensorColumn::new(key, "J", short).optional()])
            .needing(&[Part::EnergyBalance])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        values.push(observation.assembly.energy.channel(self.0.key));
    }
}

#[cfg(test)]
mod tests {
    use granum_dem::contact::choice::registry::Laws;
    use granum_dem::contact::law::energy_channel::TAKEN_KEYS;

    use crate::{column_index, columns, lattice, measure_row};

    #[test]
    fn the_loss_is_that_of_the_engine() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        let column = column_index("plastic_loss").unwrap();
        assert_eq!(measure_row(&assembly)[column], 0.0);
        assembly.energy.channels.insert("plastic_loss".into(), 3e-9);
        assert_eq!(measure_row(&assembly)[column], 3e-9);
    }

    /// A channel of a law cannot have the name of a column that every test has.
    #[test]
    fn energies_of_every_simulation_cannot_be_channels() {
        let channels: Vec<&str> = Laws::standard().channels().iter().map(|channel| channel.key).collect();
        let energies = columns().map(|column| column.name).filter(|name| {
            (name.ends_with("_loss") || name.ends_with("_energy")) && !channels.contains(name)
        });
        assert_eq!(energies.filter(|name| !TAKEN_KEYS.contains(name)).collect::<Vec<_>>(), [""; 0]);
        assert_eq!(channels, ["plastic_loss"]);
    }
}
