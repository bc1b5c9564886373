//! Synthetic data that resemble real ones, for tests and previews of reports. They are not results.

use std::path::Path;

use granum_core::assembly::{Assembly, Contact, Sphere};
use granum_core::{Column, Table};
use granum_io::run::{Machine, QualityFlag, RunRecord, RunStatus};
use granum_report::{RoleInStudy, RunReport};
use granum_sensors::Record;
use granum_sensors::{Histogram, force_distribution};

/// A generator of pseudo-random numbers in -1..1.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Noise(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A curve that rises to a peak and then softens.
fn peaked(strain: f64, peak: f64, late: f64, rate: f64) -> f64 {
    let rise = 1.0 - (-strain * rate).exp();
    rise * (late + (peak - late) * (-((strain - 0.04) / 0.08).max(0.0).powi(2)).exp())
}

/// A record that resembles the test of a dense sample.
pub fn record(seed: u64, states: usize) -> Record {
    let mut noise = Noise::new(seed);
    let offset = noise.next();
    let strain: Vec<f64> =
        (0..=states).map(|k| 0.3 * (k as f64 + if k == 0 { 0.25 } else { 0.0 }) / states as f64).collect();
    let mut columns: Vec<Column> = Vec::new();
    for column in granum_sensors::columns().filter(|column| !column.optional) {
        let mut drift = 0.0;
        let values = strain
            .iter()
            .map(|&e| {
                drift = 0.85 * drift + 0.15 * noise.next();
                value(column.name, e, drift + 0.15 * offset)
            })
            .collect();
        columns.push(Column::new(column.name, if column.unit == "1" { "" } else { column.unit }, values));
    }
    let count = strain.len();
    let simple = |name: &str, f: &dyn Fn(usize) -> f64| Column::new(name, "", (0..count).map(f).collect());
    columns.push(simple("state", &|k| k as f64));
    columns.push(simple("observations", &|_| 20.0));
    columns.push(simple("forces_below", &|_| 0.0));
    columns.push(simple("forces_above", &|_| 40.0));
    let forces = strain.iter().map(|&e| histogram(e, &mut noise)).collect();
    Record::with_forces(Table::new(columns).expect("columns that fit"), forces)
}

/// The value of a sensor at a strain, with a `noise` of about -0.5..0.5.
fn value(name: &str, e: f64, noise: f64) -> f64 {
    let stress = peaked(e, 0.92, 0.74, 160.0) + 0.03 * noise * (e * 50.0).min(1.0);
    let fabric = 0.105 * (1.0 - (-e * 28.0).exp()) - 0.05 * (e - 0.1).max(0.0) + 0.004 * noise;
    let work = 2.4e-9 * (stress * e * 20e3 * 4.3e-9 / 1e-6 / 8.0) * 1e3;
    let work = work.max(0.0) + 1e-12;
    match name {
        "deviator_strain" => e,
        "stress_ratio" => stress,
        "volumetric_strain" => {
            0.004 * (1.0 - (-e * 90.0).exp()) - 0.045 * (1.0 - (-e * 12.0).exp()) + 0.0008 * noise
        }
        "strong_stress_ratio" => 0.93 * stress,
        "weak_stress_ratio" => 0.07 * stress,
        "normal_stress_ratio" => 0.86 * stress,
        "tangential_stress_ratio" => 0.14 * stress,
        "coordination_number" => 4.78 - 0.75 * (1.0 - (-e * 40.0).exp()) + 0.02 * noise,
        "mechanical_coordination_number" => 5.02 - 0.62 * (1.0 - (-e * 40.0).exp()) + 0.02 * noise,
        "compressive_coordination_number" => 4.52 - 0.75 * (1.0 - (-e * 40.0).exp()) + 0.02 * noise,
        "backbone_coordination_number" => 5.06 - 0.62 * (1.0 - (-e * 40.0).exp()) + 0.02 * noise,
        "rattler_fraction" => 0.05 + 0.03 * (1.0 - (-e * 40.0).exp()) + 0.002 * noise,
        "tensile_fraction" => 0.055 + 0.004 * noise,
        "sliding_fraction" => 0.11 * (1.0 - (-e * 200.0).exp()) + 0.006 * noise,
        "strong_sliding_fraction" => 0.022 * (1.0 - (-e * 200.0).exp()) + 0.003 * noise,
        "deviator_fabric" => fabric,
        "strong_deviator_fabric" => 2.3 * fabric + 0.01 * noise,
        "weak_deviator_fabric" => -0.25 * fabric + 0.005 * noise,
        "strong_fraction" => 0.39 + 0.004 * noise,
        "exponential_decay" => 1.5 + 0.05 * noise,
        "half_gaussian_width" => 1.25 + 0.02 * noise,
        "exponential_advantage" => -0.012 + 0.05 * (1.0 - (-e * 60.0).exp()) + 0.008 * noise,
        "solid_fraction" => 0.6105 - 0.025 * (1.0 - (-e * 12.0).exp()),
        "inertial_number" => 3.64e-4 * (1.0 + 0.01 * noise),
        "unbalanced_force" => 4e-3 * (1.0 + 0.4 * noise),
        "servo_error_rms" => 0.0025 * (1.0 + 0.5 * noise) + 0.02 * (-e * 900.0).exp(),
        "servo_error_largest" => 0.008 * (1.0 + 0.8 * noise) + 0.05 * (-e * 900.0).exp(),
        "largest_overlap" => 1.4e-4 * (1.0 + 0.3 * noise),
        "boundary_work" => work,
        "friction_loss" => 0.71 * work,
        "tangential_work" => 0.83 * work,
        "micro_slip_loss" => 0.116 * work,
        "damping_loss" => 0.09 * work,
        "adhesion_made_loss" => 0.05 * work,
        "adhesion_broken_loss" => 0.01 * work,
        "elastic_normal_energy" => 3e-12 + 0.0199 * work,
        "elastic_tangential_energy" => 1e-12 + 0.004 * work,
        "kinetic_energy" => 1e-4 * work,
        "mean_stress" => 2e4 * (1.0 + 0.003 * noise),
        name if name.starts_with("rose_force_") => {
            let angle: f64 = name[11..].parse().unwrap_or(0.0);
            1.0 + 0.5 * stress * (2.0 * angle.to_radians()).cos() + 0.15 * stress
        }
        name if name.starts_with("rose_") => {
            let angle: f64 = name[5..].parse().unwrap_or(0.0);
            1.0 + 3.0 * fabric * (3.0 * angle.to_radians().cos().powi(2) - 1.0) + 0.02 * noise
        }
        _ => 0.0,
    }
}

/// A histogram of forces with a small tensile part, a shoulder below the mean and an exponential tail.
fn histogram(strain: f64, noise: &mut Noise) -> Histogram {
    let mut histogram = force_distribution::bins(0.25, 6.0).empty();
    let decay = 1.42 - 0.12 * (1.0 - (-strain * 60.0).exp());
    for bin in 0..histogram.bins() {
        let f = histogram.centre(bin);
        let density = if f < 0.0 {
            0.15 * (f / 0.12).exp()
        } else {
            1.05 * (1.0 - 0.45 * (-f * 3.0).exp()) * (-decay * (f - 0.35).max(0.0)).exp()
        };
        let expected = 240_000.0 * 0.25 * 0.62 * density;
        histogram.counts[bin] = (expected + noise.next() * 1.7 * expected.sqrt()).max(0.0).round() as u64;
    }
    histogram.above = 40;
    histogram
}

/// The packing of 5000 grains in `data` with Hertzian contact forces, which are larger along axis 1 if `bias` is positive.
pub fn assembly(bias: f64) -> Assembly {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/packing-5000.csv");
    let packing = granum_io::read_packing(path).expect("the shipped packing can be read");
    let grains: Vec<Sphere> = (packing.grains.iter())
        .map(|grain| Sphere {
            id: grain.id,
            position: packing.from_corner(grain),
            radius: grain.radius,
            ..Default::default()
        })
        .collect();
    let edge: [f64; 3] = std::array::from_fn(|k| packing.cell[k][k]);
    let mut contacts = Vec::new();
    for i in 0..grains.len() {
        for j in i + 1..grains.len() {
            let branch: [f64; 3] = std::array::from_fn(|k| {
                let d = grains[j].position[k] - grains[i].position[k];
                d - edge[k] * (d / edge[k]).round()
            });
            let square: f64 = branch.iter().map(|b| b * b).sum();
            let reach = grains[i].radius + grains[j].radius;
            if square < reach * reach {
                let distance = square.sqrt();
                let normal = branch.map(|b| b / distance);
                let approach = reach - distance;
                let hertz = approach.powf(1.5) * (1.0 + bias * (3.0 * normal[0] * normal[0] - 1.0));
                contacts.push(Contact {
                    i,
                    j,
                    branch,
                    normal,
                    approach,
                    normal_force: hertz,
                    ..Default::default()
                });
            }
        }
    }
    Assembly { cell: packing.cell, contacts, ..Default::default() }.with_spheres(grains)
}

/// A run with all data that a report can show.
pub fn run(role: RoleInStudy, seed: u64) -> RunReport {
    let mut run = RunReport {
        name: format!("{}-{seed}", role.word()),
        role,
        record: record(seed, 120),
        run: RunRecord {
            granum_version: "0.1.0".into(),
            status: RunStatus::Finished,
            grains: 5000,
            steps: [("test".to_owned(), 420_000)].into(),
            wall_seconds: [("test".to_owned(), 211.0)].into(),
            machine: Machine::here("AVX2", 2),
            quality: vec![
                QualityFlag::at_most("servo_error_rms", 0.0026, 0.01, "shear more slowly"),
                QualityFlag::at_most("servo_error_largest", 0.0097, 0.03, "shear more slowly"),
                QualityFlag::at_most("inertial_number", 3.7e-4, 1e-3, "shear more slowly"),
                QualityFlag::at_most("energy_gap", 0.022, 1e-3, "shorten the time step"),
            ],
            ..Default::default()
        },
        ..Default::default()
    };
    run.case.preparation.seed = seed;
    run
}
