//! The sand of the tables: equal spheres of glass-like stiffness without adhesion at 100 kPa.

use std::error::Error;
use std::time::Instant;

use granum_dem::simulation::Simulation;
use granum_io::{Case, RunKind};
use granum_point::{Controls, Increment, MaterialPoint, State};
use granum_run::{Laboratory, NoObserver, Source};

/// A sample of the sand.
pub fn sample(grains: usize, seed: u64) -> Result<Simulation, Box<dyn Error>> {
    let text = format!(
        "grains.count = {grains}\ngrains.material.interface_energy = 0\ngrains.material.friction = 0.5\n\
         preparation.seed = {seed}\npreparation.friction = 0.01\npreparation.solid_fraction = 'none'\n\
         preparation.mean_stress = '100 kPa'\npreparation.inertial_number = 1e-3\npreparation.unbalanced_force = 1e-3"
    );
    let case = Case::parse(&text, "sand")?;
    let plan = Laboratory::here().plan(RunKind::Sample, &case, &Source::Case, &mut NoObserver)?;
    Ok(plan.in_memory(&mut NoObserver)?.simulation()?.clone())
}

/// A point of the sand.
pub fn point(grains: usize, seed: u64, controls: Controls) -> Result<MaterialPoint, Box<dyn Error>> {
    Ok(MaterialPoint::new(sample(grains, seed)?, controls)?)
}

/// Part of an undrained axial compression: no change of volume.
pub fn isochoric(axial: f64) -> Increment {
    Increment::from_components([axial, -0.5 * axial, -0.5 * axial, 0.0, 0.0, 0.0])
}

/// Deviator stress `sigma_x - (sigma_y + sigma_z) / 2` and mean stress, Pa.
pub fn q_and_p(state: &State) -> (f64, f64) {
    let stress = state.stress();
    (stress[0][0] - 0.5 * (stress[1][1] + stress[2][2]), state.mean_stress())
}

/// Scatter of samples that differ in their seed, by the number of grains, and the time of a strain of 1 %.
pub fn scatter() -> Result<(), Box<dyn Error>> {
    println!("\nten samples by their seeds, undrained to an axial strain of 1 % in 10 increments");
    println!(
        "| grains | q/p, mean | scatter | p, mean, kPa | scatter | noise of sigma_x, Pa | time of 1 %, s | bytes of a state |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for grains in [300, 1000, 3000] {
        let (mut ratios, mut pressures, mut seconds, mut noises, mut bytes) = (vec![], vec![], 0.0, 0.0, 0);
        for seed in 1..=10 {
            let point = point(grains, seed, Controls::default())?;
            let start = Instant::now();
            let mut state = point.start();
            for _ in 0..10 {
                state = point.advance(&state, &isochoric(1e-3))?.state;
            }
            seconds += 0.1 * start.elapsed().as_secs_f64();
            noises += 0.1 * state.noise()[0][0];
            bytes = state.simulation().ok_or("the point has no grains")?.checkpoint("")?.len();
            let (q, p) = q_and_p(&state);
            ratios.push(q / p);
            pressures.push(1e-3 * p);
        }
        let ([ratio, of_ratio], [pressure, of_pressure]) =
            (mean_and_deviation(&ratios), mean_and_deviation(&pressures));
        println!(
            "| {grains} | {ratio:.3} | {:.1} % | {pressure:.1} | {:.1} % | {noises:.1} | {seconds:.2} | {bytes} |",
            100.0 * of_ratio / ratio,
            100.0 * of_pressure / pressure
        );
    }
    Ok(())
}

/// Mean and standard deviation (n - 1).
pub fn mean_and_deviation(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    [mean, (squares / (count - 1.0)).sqrt()]
}
