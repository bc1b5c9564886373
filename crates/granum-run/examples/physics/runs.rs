//! Samples and tests of the studies: friction 0.3, 20 kPa; Hertz without micro-slip, or the laws of the paper.

use std::error::Error;

use granum_core::{Table, parallel};
use granum_dem::config::{
    ContactModel, Grains, Material, NormalKind, Preparation, Rate, Recording, Shear, TangentialKind,
};
use granum_dem::loading::{begin, follow, preset};
use granum_dem::observer::{NoObserver, SimulationObserver};
use granum_dem::preparation::{SampleSpecification, prepare, settle};
use granum_dem::simulation::{Properties, Simulation};
use granum_run::laboratory::{cell, spheres};
use granum_sensors::{Recorder, Sensors};

/// Mean stress, Pa.
pub const MEAN_STRESS: f64 = 20e3;

/// The columns that are compared.
pub const CURVES: [&str; 5] = [
    "stress_ratio",
    "solid_fraction",
    "coordination_number",
    "mechanical_coordination_number",
    "deviator_fabric",
];

/// Contact laws and grains of a study.
#[derive(Clone, Copy)]
pub enum Laws {
    /// Hertz without micro-slip and adhesion.
    Plain,
    /// JKR and Mindlin-Deresiewicz with the interface energy of the paper.
    Paper,
}

impl Laws {
    fn contact(self) -> ContactModel {
        match self {
            Laws::Plain => ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1),
            Laws::Paper => ContactModel::default(),
        }
    }

    fn grains(self, count: usize) -> Grains {
        let material = match self {
            Laws::Plain => Material::default().with(|material| material.interface_energy = 0.0),
            Laws::Paper => Material::default(),
        };
        Grains::default().with(|grains| {
            grains.count = count;
            grains.material = material;
        })
    }
}

/// A sample from a loose random state, compacted with a given friction coefficient.
pub fn sample(laws: Laws, count: usize, friction: f64, seed: u64) -> Result<Simulation, Box<dyn Error>> {
    let (contact, grains) = (laws.contact(), laws.grains(count));
    let preparation = Preparation::default().with(|preparation| {
        preparation.seed = seed;
        preparation.friction = Some(friction);
        preparation.solid_fraction = None;
        preparation.inertial_number = 2e-3;
        preparation.unbalanced_force = 2e-3;
    });
    Ok(prepare(&SampleSpecification::new(&grains, &contact, &preparation), &mut NoObserver)?.simulation)
}

/// A packing of another program, brought to rest.
pub fn packed(path: &std::path::Path) -> Result<Simulation, Box<dyn Error>> {
    let packing = granum_io::read_packing(path)?;
    let (contact, grains) = (Laws::Plain.contact(), Laws::Plain.grains(packing.grains.len()));
    let preparation = Preparation::default();
    let properties = Properties::new(grains.material, contact);
    let simulation = Simulation::new(cell(&packing), &spheres(&packing), properties)?;
    Ok(settle(simulation, &SampleSpecification::new(&grains, &contact, &preparation), &mut NoObserver)?
        .simulation)
}

/// Settings of a test.
#[derive(Clone, Copy)]
pub struct Test {
    pub inertial_number: f64,
    pub deviator_strain: f64,
    pub time_step_factor: f64,
    pub states: usize,
}

impl Default for Test {
    fn default() -> Self {
        Test { inertial_number: 1e-3, deviator_strain: 0.1, time_step_factor: 0.2, states: 20 }
    }
}

/// Number of samples that are averaged for a state.
const OBSERVATIONS: usize = 7;

/// The measurements of a test at constant mean stress.
pub fn sheared(sample: &Simulation, test: Test) -> Result<Table, Box<dyn Error>> {
    let mut simulation = sample.clone();
    simulation.set_time_step_factor(test.time_step_factor);
    let shear = Shear::default().with(|shear| {
        shear.rate = Rate::InertialNumber(test.inertial_number);
        shear.mean_stress = Some(MEAN_STRESS);
        shear.deviator_strain = test.deviator_strain;
    });
    let recording = Recording::default().with(|recording| {
        recording.states = test.states;
        recording.observations_per_state = OBSERVATIONS;
    });
    let mut observer = SeriesObserver(Recorder::new(&Sensors::standard(), &recording, test.deviator_strain)?);
    let stage = preset::antony2006(&shear, &recording, MEAN_STRESS);
    let mut stage_progress = begin(&stage, &mut simulation)?;
    follow(&stage, &mut stage_progress, &mut simulation, &mut observer)?;
    Ok(observer.0.record().series)
}

/// The tables of runs with the seeds 1, 2, ..., in the order of the seeds; one run on each core.
pub fn of_seeds(
    seeds: usize,
    run: impl Fn(u64) -> Result<Table, Box<dyn Error>> + Sync,
) -> Result<Vec<Table>, Box<dyn Error>> {
    let one = |k: usize| run(k as u64 + 1).map_err(|error| error.to_string());
    Ok(parallel::map(seeds, 0, one)?)
}

struct SeriesObserver(Recorder);

impl SimulationObserver for SeriesObserver {
    fn next_observation(&self) -> f64 {
        self.0.next_observation()
    }
    fn observe(&mut self, state: &dyn granum_core::ObservedState) {
        self.0.observe(&state.assembly());
    }
}

/// Values of a column at the states whose strain lies in a range.
pub fn within(series: &Table, column: &str, range: std::ops::Range<f64>) -> Result<Vec<f64>, Box<dyn Error>> {
    let strain = series.column("deviator_strain")?;
    let values = series.column(column)?;
    Ok(strain.iter().zip(values).filter(|(e, _)| range.contains(e)).map(|(_, &v)| v).collect())
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Root mean square of the differences between two curves.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum();
    (square / a.len().min(b.len()) as f64).sqrt()
}

/// Sample standard deviation, with `n - 1` in the denominator.
pub fn deviation(values: &[f64]) -> f64 {
    let m = mean(values);
    (values.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)).sqrt()
}
