//! Drained triaxial compression along z by the servo of the engine, beside which a host's test of the same sample can be laid: ten runs that
//! differ by a first strain of up to 1e-9.

use std::error::Error;

use granum_dem::loading::{Control, Drive, Measure, Speed, Stage, Target, Until, begin, follow};
use granum_dem::observer::NoObserver;
use granum_io::Case;
use granum_point::{Controls, Increment, MaterialPoint};

use crate::sand::mean_and_deviation;

/// Axial strains of the rows.
const AT: [f64; 4] = [5e-4, 1e-3, 1.5e-3, 2e-3];
const PRESSURE: f64 = 100e3;

pub fn table() -> Result<(), Box<dyn Error>> {
    println!(
        "\ndrained triaxial compression along z at 100 kPa of the sample of examples/fem/sand.toml, by the servo of the engine"
    );
    println!(
        "| axial strain | axial stress, mean of ten runs, kPa | standard deviation, kPa | lateral strain |"
    );
    println!("|---|---|---|---|");
    let point = MaterialPoint::from_case(&Case::read("examples/fem/sand.toml")?, Controls::default())?;
    let isotropic = [[PRESSURE, 0.0, 0.0], [0.0, PRESSURE, 0.0], [0.0, 0.0, PRESSURE]];
    let start = point.at_stress(&point.start(), &isotropic)?.state;
    let (mut axial, mut lateral) = (vec![Vec::new(); AT.len()], vec![Vec::new(); AT.len()]);
    for k in 0..10 {
        let nudge = Increment::from_components([0.0, 0.0, 1e-10 * f64::from(k) + 1e-16, 0.0, 0.0, 0.0]);
        let nudged = point.advance(&start, &nudge)?.state;
        let mut simulation = nudged.simulation().ok_or("the point has no grains")?.clone();
        simulation.fix_time_step(None);
        simulation.reset_phase(0.0);
        let (held, none) = (Drive::Stress(Target::held(PRESSURE)), Drive::Stress(Target::held(0.0)));
        let speed = Speed::InertialNumber { number: 1e-3, at: None };
        let control = Control::new(speed, [held, held, Drive::Rate(1.0), none, none, none]);
        for (row, value) in AT.into_iter().enumerate() {
            let until = vec![Until::Reaches { measure: Measure::Strain(2), value }];
            let stage = Stage::new("compression", control, until);
            let mut progress = begin(&stage, &mut simulation)?;
            follow(&stage, &mut progress, &mut simulation, &mut NoObserver)?;
            axial[row].push(1e-3 * simulation.state().stress()[2][2]);
            let strain = simulation.state().strain();
            lateral[row].push(0.5 * (strain[0][0] + strain[1][1]));
        }
    }
    for (row, strain) in AT.iter().enumerate() {
        let [mean, deviation] = mean_and_deviation(&axial[row]);
        let [side, _] = mean_and_deviation(&lateral[row]);
        println!("| {strain:e} | {mean:.2} | {deviation:.2} | {side:.3e} |");
    }
    Ok(())
}
