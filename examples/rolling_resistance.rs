//! The effect of rolling resistance on the strength of a sample.

use granum::prelude::*;

fn peak(rolling: &str) -> Result<f64, Box<dyn std::error::Error>> {
    let text = format!(
        "grains.count = 200\ngrains.material.interface_energy = 0\ncontact.normal = \"hertz\"\ncontact.tangential = \"no-slip\"\n\
         preparation.solid_fraction = \"none\"\npreparation.unbalanced_force = 0.01\nshear.deviator_strain = 0.08\n\
         shear.inertial_number = 0.005\nrecording.states = 16\n{rolling}"
    );
    let test = Laboratory::here().test(&Case::parse(&text, "case")?)?;
    Ok(test.record.series.column("stress_ratio")?.iter().fold(0.0, |most, ratio| most.max(*ratio)))
}

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let free = peak("")?;
    let resisted = peak("contact.rolling = \"elastic-plastic\"\ncontact.rolling_friction = 0.5\n")?;
    println!("peak q/p: {free:.3} where grains roll freely, {resisted:.3} with a rolling friction of 0.5");
    assert!(resisted > free);
    Ok(())
}
