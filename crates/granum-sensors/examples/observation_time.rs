//! Measures the time of one observation of an assembly as large as that of the paper: 5000 grains, 13000 contacts.
//!
//! `cargo run --release -p granum-sensors --example observation_time`

use granum_core::assembly::{Assembly, Contact, Grain};
use granum_dem::config::Recording;
use granum_sensors::{Recorder, Sensors};
use std::time::Instant;

fn main() {
    let grains = 5000;
    let contacts = 13_000;
    let angle = |k: usize, step: f64| (k as f64 * step).rem_euclid(1.0);
    let mut assembly = Assembly {
        cell: [[2e-3, 0.0, 0.0], [0.0, 2e-3, 0.0], [0.0, 0.0, 2e-3]],
        grains: (0..grains).map(|_| Grain { radius: 5e-5, mass: 1e-9, ..Default::default() }).collect(),
        contacts: (0..contacts)
            .map(|k| {
                let cosine = 2.0 * angle(k, 0.618_034) - 1.0;
                let sine = (1.0 - cosine * cosine).sqrt();
                let azimuth = std::f64::consts::TAU * angle(k, 0.754_878);
                let normal = [cosine, sine * azimuth.cos(), sine * azimuth.sin()];
                Contact {
                    i: k % grains,
                    j: (k * 7 + 1) % grains,
                    normal,
                    branch: normal.map(|x| x * 1e-4),
                    normal_force: 4e-4 * angle(k, 0.569_84),
                    tangential_force: [1e-5, 2e-5, -1e-5],
                    ..Default::default()
                }
            })
            .collect(),
        ..Default::default()
    };
    let observations = 1000;
    let recording = Recording::default().with(|recording| {
        recording.states = observations;
        recording.observations_per_state = 1;
    });
    let Ok(mut recorder) = Recorder::new(&Sensors::standard(), &recording, 1.0) else { return };
    let start = Instant::now();
    for k in 0..observations {
        assembly.strain[0][0] = (k as f64 + 0.5) / observations as f64;
        recorder.observe(&assembly);
    }
    let taken = start.elapsed().as_secs_f64() / observations as f64;
    println!(
        "{} states recorded, {:.0} microseconds an observation",
        recorder.record().series.rows(),
        1e6 * taken
    );
}
