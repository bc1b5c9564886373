//! Measures the time of one observation of an assembly as large as that of the paper (5324 grains, some 13,000 contacts): that of
//! the sensors that every test records, and what each further sensor adds.
//!
//! `cargo run --release -p granum-sensors --example observation_time`

use std::time::Instant;

use granum_core::assembly::{Assembly, Contact, Sphere, Vector};
use granum_dem::config::Recording;
use granum_sensors::{Recorder, SensorError, Sensors};

fn main() -> Result<(), SensorError> {
    let assembly = disordered(11);
    println!(
        "{} grains, {} contacts; milliseconds an observation",
        assembly.bodies.len(),
        assembly.contacts.len()
    );
    let sensors = Sensors::standard();
    let usual = time(&assembly, &sensors, None)?;
    println!("{:32} {:8.3}", "those of every test", 1e3 * usual);
    for sensor in sensors.descriptions() {
        let recorded = sensors.recorded(sensor.name)?;
        if recorded != "in every test" {
            let with = time(&assembly, &sensors, Some(sensor.name))?;
            println!("{:32} {:+8.3}", sensor.name, 1e3 * (with - usual));
        }
    }
    Ok(())
}

/// Seconds an observation, the least of five goes.
fn time(assembly: &Assembly, sensors: &Sensors, name: Option<&str>) -> Result<f64, SensorError> {
    let observations = 40;
    let recording = Recording::default().with(|recording| {
        recording.states = observations;
        recording.observations_per_state = 1;
        recording.sensors = name.into_iter().map(String::from).collect();
        recording.parameters = [("critical_void_ratio".to_string(), 0.7)].into();
    });
    let mut least = f64::INFINITY;
    for _ in 0..5 {
        let mut recorder = Recorder::new(sensors, &recording, 1.0)?;
        let mut assembly = assembly.clone();
        let start = Instant::now();
        for k in 0..observations {
            assembly.strain[0][0] = (k as f64 + 0.5) / observations as f64;
            recorder.observe(&assembly);
        }
        least = least.min(start.elapsed().as_secs_f64() / observations as f64);
    }
    Ok(least)
}

/// A face-centred lattice of grains that are moved a little from their places, with contacts between two fifths of the
/// neighbours.
fn disordered(n: usize) -> Assembly {
    let part = |k: usize, step: f64| (k as f64 * step).rem_euclid(1.0);
    let edge = 1.02e-4 * 2f64.sqrt();
    let basis = [[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];
    let place = |k: usize| -> Vector {
        let (cube, offset) = (k / 4, basis[k % 4]);
        let corner = [cube % n, cube / n % n, cube / (n * n)];
        let shift = [part(k, 0.618_034), part(k, 0.754_878), part(k, 0.569_84)];
        std::array::from_fn(|a| (corner[a] as f64 + offset[a]) * edge + 5e-6 * shift[a])
    };
    let grains: Vec<Sphere> = (0..4 * n * n * n)
        .map(|k| Sphere {
            id: k as u64 + 1,
            position: place(k),
            radius: 5e-5,
            mass: 1e-9,
            ..Default::default()
        })
        .collect();
    let length = n as f64 * edge;
    let mut contacts = Vec::new();
    for i in 0..grains.len() {
        for j in i + 1..grains.len() {
            let branch: Vector = std::array::from_fn(|a| {
                let x = grains[j].position[a] - grains[i].position[a];
                x - length * (x / length).round()
            });
            let distance = branch.iter().map(|x| x * x).sum::<f64>().sqrt();
            if distance < 1.1e-4 && part(i * 31 + j, 0.618_034) < 0.41 {
                contacts.push(Contact {
                    i,
                    j,
                    normal: branch.map(|x| x / distance),
                    branch,
                    normal_force: 4e-4 * part(i + 3 * j, 0.569_84),
                    tangential_force: [1e-5, 2e-5, -1e-5],
                    ..Default::default()
                });
            }
        }
    }
    let cell = [[length, 0.0, 0.0], [0.0, length, 0.0], [0.0, 0.0, length]];
    Assembly { cell, contacts, ..Default::default() }.with_spheres(grains)
}
