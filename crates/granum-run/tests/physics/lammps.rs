//! The first percent of strain of the test that `data/validation/lammps.csv` contains in full.

use std::path::{Path, PathBuf};

use granum_dem::config::{Grains, Preparation, Recording};
use granum_dem::preparation::{Flow, Progress, SampleSpecification, settle};
use granum_dem::simulation::{Hardware, Simulation};
use granum_io::read_table;
use granum_run::laboratory::{cell, spheres};
use granum_sensors::{Recorder, Sensors};

use super::sample::{compress, properties};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name)
}

/// The packing in `data` is brought to rest, sheared to 1 % and compared with LAMMPS on the same path.
#[test]
fn the_start_of_the_curves_is_that_of_lammps() {
    let packing = granum_io::read_packing(data("packing-5000.csv")).unwrap();
    let properties = properties(0.3, 0.1);
    let simulation = Simulation::new(cell(&packing), &spheres(&packing), properties.clone()).unwrap();
    let grains = Grains::default().with(|grains| grains.material = properties.material);
    let preparation = Preparation::default().with(|preparation| preparation.unbalanced_force = 5e-3);
    let hardware = Hardware { threads: 2, ..Hardware::default() };
    let specification = SampleSpecification {
        grains: &grains,
        contact: &properties.contact,
        preparation: &preparation,
        time_step_factor: 0.2,
        hardware,
    };
    let mut s = settle(simulation, &specification, &mut |_: &Progress| Flow::Continue).unwrap().simulation;
    s.set_hardware(hardware);
    compress(&mut s, 0, 1e-3);
    // The states are those of the stored table: 0, 0.005, 0.01.
    let recording = Recording::default().with(|recording| {
        recording.states = 2;
        recording.observations_per_state = 7;
    });
    let mut recorder = Recorder::new(&Sensors::standard(), &recording, 0.01).unwrap();
    loop {
        if s.state().deviator_strain() >= recorder.next_observation() {
            recorder.observe(&s.assembly());
        }
        if recorder.is_complete() {
            break;
        }
        s.advance(50).unwrap();
    }
    let series = recorder.record().series;
    let table = read_table(data("validation/lammps.csv")).unwrap();
    // The initial states differ slightly, since the two programs brought the packing to rest with different damping.
    for (column, limits) in [
        ("stress_ratio", [1e-3, 0.02, 0.03]),
        ("solid_fraction", [2e-4, 2e-4, 2e-4]),
        ("coordination_number", [0.05, 0.05, 0.05]),
        ("deviator_fabric", [0.003, 0.003, 0.005]),
    ] {
        let (ours, theirs) = (series.values(column).unwrap(), table.column(column).unwrap());
        for (k, limit) in limits.into_iter().enumerate() {
            println!("{column} {k}: {:.5} {:.5}", ours[k], theirs[k]);
            assert!((ours[k] - theirs[k]).abs() < limit, "{column}, state {k}: {} {}", ours[k], theirs[k]);
        }
    }
}
