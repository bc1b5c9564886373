//! The critical state: dense and loose samples of one material reach the same state.

use std::error::Error;

use super::runs::{CURVES, Laws, Test, mean, sample, sheared, within};

/// Compares samples that were compacted without friction and with the friction of the material, two seeds each.
pub fn study() -> Result<(), Box<dyn Error>> {
    const END: f64 = 0.5;
    let test = Test { inertial_number: 1e-3, deviator_strain: END, states: 50, ..Test::default() };
    println!(
        "at the start; largest q/p; means beyond a deviator strain of 0.3; of {CURVES:?}, <f^2> and tails"
    );
    for (name, friction) in [("dense", 0.0), ("loose", 0.3)] {
        for seed in [1, 2] {
            let run = sheared(&sample(Laws::Plain, 1000, friction, seed)?, test)?;
            let mut line = format!("{name} {seed}: start");
            for column in &CURVES[1..4] {
                line += &format!(" {:.4}", within(&run, column, -1.0..1e-6)?[0]);
            }
            let largest = within(&run, CURVES[0], 0.0..1.0)?.into_iter().fold(0.0, f64::max);
            line += &format!("; peak {largest:.3}; late");
            let tail =
                ["mean_square_force", "exponential_decay", "half_gaussian_width", "exponential_advantage"];
            for column in CURVES.iter().chain(&tail) {
                line += &format!(" {:.4}", mean(&within(&run, column, 0.3..1.0)?));
            }
            println!("{line}");
        }
    }
    Ok(())
}
