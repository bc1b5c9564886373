//! Cost and error of the ways to find a stiffness, along an undrained path.

use std::error::Error;
use std::time::Instant;

use granum_point::{Controls, Increment, MaterialPoint, State, Tangent};
use granum_run::stiffness::Tensor;

use crate::sand::{isochoric, point};

/// Ways that are compared.
const WAYS: [(&str, Tangent); 6] = [
    ("affine", Tangent::Affine),
    ("elastic", Tangent::Elastic),
    ("probes of 1e-6", Tangent::Probes { strain: 1e-6 }),
    ("probes of 1e-5", Tangent::Probes { strain: 1e-5 }),
    ("probes of 1e-4", Tangent::Probes { strain: 1e-4 }),
    ("secant", Tangent::Secant),
];

/// Error of the change of stress that a stiffness foresees for the next increment, over that change.
fn error(
    point: &MaterialPoint,
    state: &State,
    next: &Increment,
    stiffness: &Tensor,
) -> Result<f64, Box<dyn Error>> {
    let (before, after) = (state.stress(), point.advance(state, next)?.stress());
    let foreseen = stiffness.stress(next.strain());
    let (mut missed, mut size) = (0.0, 0.0);
    for (k, [r, c]) in granum_dem::servo::PLACES.into_iter().enumerate() {
        let change = 0.5 * (after[r][c] + after[c][r] - before[r][c] - before[c][r]);
        missed += (foreseen[k] - change) * (foreseen[k] - change);
        size += change * change;
    }
    Ok((missed / size).sqrt())
}

pub fn table() -> Result<(), Box<dyn Error>> {
    let point = point(300, 1, Controls::default())?;
    println!(
        "\nerror of the foreseen change of stress in the next axial increment of 1e-4, over that change; 300 grains, undrained"
    );
    println!("| stiffness | time, s | at the start | at 0.1 % | at 0.5 % | at 1 % | unloading at 1 % |");
    println!("|---|---|---|---|---|---|---|");
    let mut states = vec![point.start()];
    let mut state = point.start();
    for k in 1..=100 {
        state = point.advance(&state, &isochoric(1e-4))?.state;
        if [10, 50, 100].contains(&k) {
            states.push(state.clone());
        }
    }
    for (name, way) in WAYS {
        let (mut cells, mut seconds) = (Vec::new(), 0.0);
        for state in &states {
            let start = Instant::now();
            let stiffness = point.tangent(state, way)?;
            seconds += start.elapsed().as_secs_f64() / states.len() as f64;
            cells.push(format!("{:.0} %", 100.0 * error(&point, state, &isochoric(1e-4), &stiffness)?));
        }
        let stiffness = point.tangent(&state, way)?;
        cells.push(format!("{:.0} %", 100.0 * error(&point, &state, &isochoric(-1e-4), &stiffness)?));
        println!("| {name} | {seconds:.4} | {} |", cells.join(" | "));
    }
    Ok(())
}
