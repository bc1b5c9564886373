//! How a perturbation of 1e-10 grows: runs that differ only in the first increment, by this share of it.

use std::error::Error;

use granum_point::{Controls, Increment, State};

use crate::sand::{isochoric, mean_and_deviation, point, q_and_p};

/// Axial strains of the rows.
const AT: [f64; 8] = [1e-5, 1e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2];
/// Strain of the perturbation.
const PERTURBATION: f64 = 1e-10;

/// Ratios q/p of a path at the strains of the rows.
pub fn path(point: &granum_point::MaterialPoint, from: &State) -> Result<Vec<f64>, Box<dyn Error>> {
    let (mut state, mut reached, mut ratios) = (from.clone(), 0.0, Vec::new());
    for strain in AT {
        state = point.advance(&state, &isochoric(strain - reached))?.state;
        reached = strain;
        let (q, p) = q_and_p(&state);
        ratios.push(q / p);
    }
    Ok(ratios)
}

pub fn table() -> Result<(), Box<dyn Error>> {
    println!(
        "\nten undrained paths after strains of k x {PERTURBATION:e}, k = 0 to 9: standard deviation of q/p over its mean"
    );
    println!("| axial strain | 300 grains | 1000 grains | 3000 grains |");
    println!("|---|---|---|---|");
    let mut columns = Vec::new();
    for grains in [300, 1000, 3000] {
        let point = point(grains, 1, Controls::default())?;
        let mut runs = Vec::new();
        for k in 0..10 {
            let nudge = Increment::from_components([PERTURBATION * f64::from(k), 0.0, 0.0, 0.0, 0.0, 0.0]);
            // The first one is strained and held as the others are.
            let nudge = if k == 0 { Increment::from_components([1e-16; 6]) } else { nudge };
            runs.push(path(&point, &point.advance(&point.start(), &nudge)?.state)?);
        }
        let of_row = |row: usize| {
            let [mean, deviation] = mean_and_deviation(&runs.iter().map(|run| run[row]).collect::<Vec<_>>());
            deviation / mean.abs()
        };
        columns.push((0..AT.len()).map(of_row).collect::<Vec<_>>());
    }
    for (row, strain) in AT.iter().enumerate() {
        let cells: Vec<String> = columns.iter().map(|column| format!("{:.1e}", column[row])).collect();
        println!("| {strain:e} | {} |", cells.join(" | "));
    }
    Ok(())
}
