//! Samples for the tests of the engine.

use granum_dem::config::Grains;
use granum_dem::random_insertion::random_insertion;
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, Properties, Simulation};

/// Grains that do not touch, always from the same seed.
pub fn dispersed(count: usize, spread: f64, properties: Properties) -> Simulation {
    let grains = Grains::default().with(|grains| (grains.count, grains.spread) = (count, spread));
    let (cell, spheres) = random_insertion(&grains, 0.35, 9).unwrap();
    Simulation::new(cell, &spheres, properties).unwrap()
}

/// The same grains compressed to 20 kPa for a number of steps.
pub fn compressed(
    count: usize,
    spread: f64,
    properties: Properties,
    steps: u64,
    hardware: Hardware,
) -> Simulation {
    let mut s = dispersed(count, spread, properties);
    s.set_hardware(hardware);
    s.set_control(CellControl::isotropic(20e3, 2e4));
    s.advance(steps).unwrap();
    s
}

/// The same extension rate along all axes, 1/s; negative in compression.
#[allow(dead_code)]
pub fn growing(rate: f64) -> CellControl {
    let mut control = CellControl::fixed();
    control.rate = [[-rate, 0.0, 0.0], [0.0, -rate, 0.0], [0.0, 0.0, -rate]];
    control
}
