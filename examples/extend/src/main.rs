//! A test with a contact law, a sensor, a loading path and a packing format that granum does not have: one file each.
//!
//! `cargo run --release`

mod biaxial;
mod fluctuating_speeds;
mod rolling_spring;
mod spheres;

use granum::prelude::*;

const CASE: &str = r#"
[grains.material]
interface_energy = 0
[contact]
normal = "hertz"
tangential = "no-slip"
rolling = "rolling-spring"
rolling_spring_friction = 0.2
[preparation]
solid_fraction = "none"
friction = 0.3
unbalanced_force = 0.01
[recording]
observations_per_state = 4
sensors = ["fluctuating_speeds"]
largest_speed = 3
[[stage]]
path = "biaxial-at-constant-mean"
axial_strain = 0.02
inertial_number = 0.005
states = 8
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Case files that are read with this registry know the law, the path and the sensor by their names, and their parameters by
    // their keys.
    let registry = Registry::standard()
        .with_law(RollingKind::new(&rolling_spring::RollingSpring))?
        .with_path(&biaxial::BIAXIAL)?
        .with_sensor(fluctuating_speeds::FluctuatingSpeeds)?
        .with_packing_format(spheres::Spheres);
    let case = registry.parse_case(CASE, "case")?;
    let laboratory = Laboratory::here().with_registry(registry);

    let file = std::env::temp_dir().join(format!("granum-extend-{}.spheres", std::process::id()));
    laboratory.registry.formats.write_packing(&file, &spheres::loose_lattice(6))?;
    let planned = laboratory.plan(RunKind::Test, &case, &Source::Packing(file.clone()), &mut NoObserver);
    let test = planned.and_then(|planned| planned.in_memory(&mut NoObserver));
    std::fs::remove_file(&file)?;
    let test = test?;

    let columns = ["axial_strain", "lateral_strain_3", "von_mises_ratio", "fluctuating_speed"];
    let [strain, fixed, ratio, speed] = test.record.series.select(columns)?;
    println!("eps_1    q/p    v (m/s)");
    for k in 0..strain.len() {
        println!("{:.4}  {:.3}  {:.2e}", strain[k], ratio[k], speed[k]);
    }
    let bins = test.record.histograms("speeds").first().map_or(0, Histogram::bins);
    assert_eq!(bins, 30, "the case gives the parameter of the sensor");
    let speeds = test.record.histograms("speeds").iter().map(Histogram::total).sum::<u64>();
    let rolled = test.simulation()?.assembly().energy.rolling;
    println!("{speeds} speeds were counted; {rolled:.2e} J were lost by rolling");

    assert!(fixed.iter().all(|strain| strain.abs() < 1e-12), "the path holds axis z");
    assert!(ratio.iter().any(|ratio| *ratio > 0.2), "the sample resists");
    assert!(speed.iter().skip(1).all(|speed| *speed > 0.0), "the sensor measures");
    assert!(speeds > 0 && rolled > 0.0, "the histogram counts, and the law takes energy");
    Ok(())
}
