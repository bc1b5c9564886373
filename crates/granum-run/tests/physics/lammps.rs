//! The start of the tests that `data/validation` contains in full.

use granum_io::RunKind;

use std::path::{Path, PathBuf};

use granum_dem::config::{Grains, Preparation, Recording};
use granum_dem::preparation::{SampleSpecification, settle};
use granum_dem::simulation::{Hardware, Simulation};
use granum_io::{Case, Table, read_table};
use granum_run::laboratory::{cell, spheres};
use granum_run::{Laboratory, NoObserver, Source};
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
        hardware,
        ..SampleSpecification::new(&grains, &properties.contact, &preparation)
    };
    let mut s = settle(simulation, &specification, &mut NoObserver).unwrap().simulation;
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

/// The value of a column in the row of a stored curve whose axial strain is in a range.
fn stored(table: &Table, column: &str, range: &std::ops::Range<f64>) -> f64 {
    let mut values = table.column("axial_strain").unwrap().iter().zip(table.column(column).unwrap());
    *values.find(|(strain, _)| range.contains(strain)).unwrap().1
}

/// Mean over a range of the axial strain of the polygon through the rows of a table.
fn mean(table: &Table, column: &str, range: &std::ops::Range<f64>) -> f64 {
    let [strains, values] = ["axial_strain", column].map(|name| table.column(name).unwrap());
    let (mut sum, mut width) = (0.0, 0.0);
    for (strain, value) in strains.windows(2).zip(values.windows(2)) {
        let [first, last] = [0, 1].map(|k| strain[k].clamp(range.start, range.end));
        if first != last {
            let share = (0.5 * (first + last) - strain[0]) / (strain[1] - strain[0]);
            width += last - first;
            sum += (last - first) * (value[0] + share * (value[1] - value[0]));
        }
    }
    sum / width
}

/// 0.4 % of axial strain at constant volume, in which p rises severalfold, with and without resistance to rolling, against LAMMPS with the
/// deck of the same case.
#[test]
fn the_start_of_undrained_paths_is_that_of_lammps() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../benches/peers/lammps/sand.toml");
    let path = [("axial_strain", "0.004"), ("states", "32"), ("inertial_number", "3e-3")];
    let case = Case::read(file).unwrap().with_path("undrained-triaxial", &path).unwrap();
    let constant = [("rolling_stiffness", "800"), ("rolling_viscosity", "1.05e-3")];
    // The elastic-plastic law has the stiffness of each contact in granum, and one stiffness in LAMMPS.
    for (name, rolling, parameters, in_ratio) in [
        ("undrained", "none", &constant[..0], 0.005),
        ("undrained-rolling", "elastic-plastic", &constant[..0], 0.015),
        ("undrained-sds", "spring-dashpot-slider", &constant[..], 0.001),
    ] {
        let mut case = case.clone();
        case.set("contact.rolling", rolling).unwrap();
        for (key, value) in parameters {
            case.set(&format!("contact.{key}"), value).unwrap();
        }
        case.preparation.unbalanced_force = 5e-3;
        let source = Source::Packing(data("packing-5000.csv"));
        let planned = Laboratory::here().plan(RunKind::Test, &case, &source, &mut NoObserver).unwrap();
        let test = planned.in_memory(&mut NoObserver).unwrap();
        let copies = [1, 2]
            .map(|copy| read_table(data(&format!("validation/paths/{name}-lammps-{copy}.csv"))).unwrap());
        for (column, relative) in
            [("stress_ratio", in_ratio), ("mean_stress", 0.015), ("coordination_number", 0.005)]
        {
            for k in 1..4 {
                // The rows of the stored curves are means over 0.001 of strain.
                let range = 0.001 * f64::from(k)..0.001 * f64::from(k + 1);
                let ours = mean(&test.record.series, column, &range);
                let theirs = 0.5 * copies.iter().map(|copy| stored(copy, column, &range)).sum::<f64>();
                println!("{name} {column} {range:?}: granum {ours:.5}, LAMMPS {theirs:.5}");
                assert!((ours / theirs - 1.0).abs() < relative, "{name} {column} {range:?}: {ours} {theirs}");
            }
        }
    }
}
