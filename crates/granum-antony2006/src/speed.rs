//! Computing time of the networks compared with DEM.
//!
//! The paper states that the networks are 5 to 10 times faster. Here the wall time of one DEM test, for the shear alone, is
//! compared with the wall time in which the trained networks of all mappings predict every recorded state of such a test.
//! The report also states what this factor does not include: the training, the DEM runs for the training, and the fact
//! that the networks need the soft sensors of the test that they predict, which would have to be measured in a laboratory
//! without DEM.

use std::hint::black_box;

use granum_core::clock::Instant;
use granum_learn::Result;
use granum_learn::dataset::{Dataset, RunStates};
use granum_learn::study::{MemberRole, Study};
use granum_learn::surrogate::RunInputs;

use crate::evaluation::training_seconds;
use crate::size_study::median;
use crate::summary::SpeedSummary;

/// Measures the time in which the networks predict every state of a run, `repetitions` times (at least once), and compares
/// the median with the wall time of the DEM test.
///
/// # Errors
/// If a state contains a value that is not finite.
pub fn measure(study: &Study, run: &RunStates, dem_seconds: f64, repetitions: usize) -> Result<SpeedSummary> {
    let states = Dataset::new(vec![run.clone()])?;
    let networks = study.members().filter(|member| member.role == MemberRole::Asked);
    let asked = networks.map(|member| {
        let surrogate = member.surrogate.as_ref();
        Ok((surrogate, RunInputs::from_dataset(&states, surrogate.columns())?))
    });
    let asked = asked.collect::<Result<Vec<_>>>()?;
    let repetitions = repetitions.max(1);
    let mut seconds = Vec::with_capacity(repetitions);
    for _ in 0..repetitions {
        let start = Instant::now();
        for (surrogate, inputs) in &asked {
            black_box(surrogate.means(black_box(inputs))?);
        }
        seconds.push(start.elapsed().as_secs_f64());
    }
    let network_seconds = median(&seconds).unwrap_or(0.0);
    Ok(SpeedSummary {
        dem_seconds,
        network_seconds,
        factor: if network_seconds > 0.0 { dem_seconds / network_seconds } else { 0.0 },
        training_seconds: training_seconds(study),
        states: run.rows(),
        repetitions,
    })
}
