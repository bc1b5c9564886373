//! One path in 10, 100 and 1000 increments.

use std::error::Error;
use std::time::Instant;

use granum_point::{Controls, State};

use crate::sand::{isochoric, point, q_and_p};

/// The strain of the path.
const END: f64 = 0.01;

pub fn table() -> Result<(), Box<dyn Error>> {
    println!("\none undrained path to an axial strain of {END}, cut in parts; 300 grains");
    println!(
        "| relaxation, steps | parts | length of the cell over its first | q/p at 0.1 % | q/p at the end | p at the end, kPa | steps | time, s |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for relaxation in [0, 50, 400] {
        let controls = Controls::default().with(|controls| {
            controls.relaxation = relaxation;
            controls.averaging = relaxation;
        });
        let point = point(300, 1, controls)?;
        for parts in [10u32, 100, 1000] {
            let start = Instant::now();
            let mut state = point.start();
            let (mut early, mut steps) = (0.0, 0);
            for k in 1..=parts {
                let answer = point.advance(&state, &isochoric(END / f64::from(parts)))?;
                steps += answer.steps;
                state = answer.state;
                if k == parts / 10 {
                    let (q, p) = q_and_p(&state);
                    early = q / p;
                }
            }
            let (q, p) = q_and_p(&state);
            let edge = |state: &State| state.cell().map_or(f64::NAN, |edges| edges[0][0]);
            let length = edge(&state) / edge(&point.start());
            println!(
                "| {relaxation} | {parts} | {length:.13} | {early:.4} | {:.4} | {:.2} | {steps} | {:.2} |",
                q / p,
                1e-3 * p,
                start.elapsed().as_secs_f64()
            );
        }
    }
    Ok(())
}
