//! Ctrl-C and SIGTERM: the first asks for a stop in good order, the second ends the program at once.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Status of a program that was interrupted, as shells know it.
pub const INTERRUPTED: u8 = 130;

/// The flag that the first signal sets. Where signals cannot be caught, they end the program as ever.
pub fn install() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // Order matters: a signal that finds the flag set ends the program, only then is the flag set.
        let second = flag::register_conditional_shutdown(signal, INTERRUPTED.into(), stop.clone());
        let first = flag::register(signal, stop.clone());
        if let Err(error) = second.and(first) {
            eprintln!(
                "warning: signal {signal} cannot be caught ({error}); an interruption will not be in good order"
            );
        }
    }
    stop
}
