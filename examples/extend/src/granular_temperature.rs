//! A sensor with a column and a histogram: granular temperature `T_g = <v'^2> / 3` of the fluctuating velocities, and the
//! distribution of the speeds over their root mean square.

use granum::prelude::*;

pub struct GranularTemperature;

impl Sensor for GranularTemperature {
    fn description(&self) -> Description {
        Description::new("granular_temperature", "fluctuating motion of the grains")
            .columns([SensorColumn::new("granular_temperature", "m2/s2", "T_g = <v'^2> / 3")])
            .needing(&[Part::Velocities])
    }

    fn histograms(&self, _: &Recording) -> Vec<Bins> {
        vec![Bins::new("speeds", "speed", "1").width(0.1).range(0.0, 4.0)]
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let grains = &observation.assembly.grains;
        let squares = || grains.iter().map(|grain| grain.velocity.map(|v| v * v).iter().sum::<f64>());
        let mean = squares().fold(0.0, |sum, square| sum + square) / grains.len().max(1) as f64;
        values.push(mean / 3.0);
        if mean > 0.0 {
            values.count(0, squares().map(|square| (square / mean).sqrt()));
        }
    }
}
