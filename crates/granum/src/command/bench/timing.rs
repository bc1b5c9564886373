//! The time of a call.

use std::time::Instant;

use crate::context::Context;
use crate::failure::Failure;

/// Shortest time of one call, s, measured for about `seconds`.
pub fn best(
    context: &Context,
    seconds: f64,
    mut call: impl FnMut() -> Result<(), Failure>,
) -> Result<f64, Failure> {
    let clock = Instant::now();
    let mut least = f64::INFINITY;
    while least.is_infinite() || clock.elapsed().as_secs_f64() < seconds {
        context.check_stopped(|| "nothing was written".into())?;
        let start = Instant::now();
        call()?;
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(least)
}
