//! Liquid of wet grains: its volume in films and in bridges, the number of bridges and their mean volume. These columns are omitted
//! from a series without a law of bridges that share the liquid of films.

use granum_core::Part;

use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct LiquidVolumes;

impl Sensor for LiquidVolumes {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("liquid", "liquid in films on grains and in bridges")
            .speaking_of(Subject::Sample)
            .columns([
                SensorColumn::new("film_volume", "m3", "of the liquid in the films of all grains").optional(),
                SensorColumn::new("bridge_volume", "m3", "of the liquid in all bridges").optional(),
                SensorColumn::new("bridges", "1", "liquid bridges that hold liquid").optional(),
                SensorColumn::new("mean_bridge_volume", "m3", "of the liquid in a bridge").optional(),
            ])
            .needing(&[Part::Liquid])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let liquid = observation.assembly.liquid.unwrap_or_default();
        let mean = if liquid.count == 0 { 0.0 } else { liquid.bridges / liquid.count as f64 };
        values.extend([liquid.films, liquid.bridges, liquid.count as f64, mean]);
    }
}

#[cfg(test)]
mod tests {
    use granum_core::assembly::Liquid;

    use crate::{column_index, lattice, measure_row};

    #[test]
    fn volumes_are_those_of_the_assembly() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        let columns = ["film_volume", "bridge_volume", "bridges", "mean_bridge_volume"]
            .map(|name| column_index(name).unwrap());
        let row = measure_row(&assembly);
        assert_eq!(columns.map(|column| row[column]), [0.0; 4]);
        assembly.liquid = Some(Liquid { films: 3e-15, bridges: 8e-16, count: 4 });
        let row = measure_row(&assembly);
        assert_eq!(columns.map(|column| row[column]), [3e-15, 8e-16, 4.0, 2e-16]);
    }
}
