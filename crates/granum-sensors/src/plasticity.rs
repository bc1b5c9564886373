//! Energy lost by plastic deformation of contacts since the start of the phase, with a normal law that has a history. The column
//! is omitted from a series without such a law.
//!
//! The energy balance of [`crate::energy`] then includes `plastic_loss`; the energy that would be recovered in unloading is part of
//! `elastic_normal_energy`.

use granum_core::Part;

use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Values};

/// The sensor.
pub struct Plasticity;

impl Sensor for Plasticity {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("plasticity", "energy lost by plastic deformation of contacts")
            .columns([
                SensorColumn::new("plastic_loss", "J", "lost by plastic deformation of contacts").optional()
            ])
            .needing(&[Part::EnergyBalance])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        values.push(observation.assembly.energy.plastic_loss);
    }
}

#[cfg(test)]
mod tests {
    use crate::{column_index, lattice, measure_row};

    #[test]
    fn the_loss_is_that_of_the_engine() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        assembly.energy.plastic_loss = 3e-9;
        assert_eq!(measure_row(&assembly)[column_index("plastic_loss").unwrap()], 3e-9);
    }
}
