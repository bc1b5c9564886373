//! A sensor with a column, a histogram and a parameter: the root mean square of the fluctuating velocities, and the distribution of
//! the speeds over it up to `recording.largest_speed`.

use granum::prelude::*;

pub struct FluctuatingSpeeds;

/// Case files know it from the moment when the sensor is added.
const LARGEST_SPEED: SensorParameter = SensorParameter::new(
    "largest_speed",
    Dimension::NUMBER,
    4.0,
    [0.5, 100.0],
    "Largest speed with a bin of its own",
);

impl Sensor for FluctuatingSpeeds {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("fluctuating_speeds", "fluctuating motion of the grains")
            .speaking_of(Subject::Bodies)
            .columns([SensorColumn::new("fluctuating_speed", "m/s", "root mean square of v'")])
            .parameters([LARGEST_SPEED])
            .needing(&[Part::Velocities])
    }

    fn histograms(&self, recording: &Recording) -> Vec<Bins> {
        let largest = LARGEST_SPEED.value(recording).unwrap_or(4.0);
        vec![Bins::new("speeds", "speed", "1").width(0.1).range(0.0, largest)]
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let grains = &observation.assembly.bodies;
        let squares = || grains.iter().map(|grain| grain.velocity.map(|v| v * v).iter().sum::<f64>());
        let mean = squares().fold(0.0, |sum, square| sum + square) / grains.len().max(1) as f64;
        values.push(mean.sqrt());
        if mean > 0.0 {
            values.count(0, squares().map(|square| (square / mean).sqrt()));
        }
    }
}
