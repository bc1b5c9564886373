//! One material on two stress paths: drained triaxial compression, and compression at constant volume.

use granum::prelude::*;

const MATERIAL: &str = "
[grains]
count = 200
material.interface_energy = 0
[contact]
normal = \"hertz\"
tangential = \"no-slip\"
[preparation]
solid_fraction = \"none\"
unbalanced_force = 0.01
[recording]
observations_per_state = 4
";

fn test(path: &str) -> Result<RunResult, Box<dyn std::error::Error>> {
    let stage = "axial_strain = 0.04\ninertial_number = 0.005\nstates = 8\n";
    let text = format!("{MATERIAL}\n[[stage]]\npath = {path:?}\n{stage}");
    Ok(Laboratory::here().test(&Case::parse(&text, path)?)?)
}

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in ["drained-triaxial", "undrained-triaxial"] {
        let test = test(path)?;
        let columns = ["axial_strain", "mean_stress", "deviator_stress", "volumetric_strain"];
        let [strain, p, q, volume] = test.record.series.select(columns)?;
        println!("{path}\neps_1    p (kPa)  q (kPa)  eps_v");
        for k in 0..strain.len() {
            println!("{:.4}  {:8.2} {:8.2}  {:+.5}", strain[k], p[k] / 1e3, q[k] / 1e3, volume[k]);
        }
        if path == "undrained-triaxial" {
            assert!(volume.iter().all(|v| v.abs() < 1e-9), "the volume is held");
        } else {
            let lateral = test.record.series.column("stress_33")?;
            assert!((lateral.last().unwrap_or(&0.0) / 20e3 - 1.0).abs() < 0.05, "the lateral stress is held");
        }
    }
    Ok(())
}
