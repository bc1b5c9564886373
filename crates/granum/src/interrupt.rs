//! Ctrl-C and SIGTERM: the first requests a clean stop, the second ends the program at once.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Exit status of a program that was interrupted, by the convention of shells.
pub const INTERRUPTED: u8 = 130;

/// Installs the signal handlers and returns the flag that the first signal sets. If signals cannot be caught, they end the
/// program as usual.
pub fn install() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // The order matters: the handler that ends the program if the flag is set must run before the one that sets the
        // flag.
        let second = flag::register_conditional_shutdown(signal, INTERRUPTED.into(), stop.clone());
        let first = flag::register(signal, stop.clone());
        if let Err(error) = second.and(first) {
            eprintln!(
                "warning: signal {signal} cannot be caught ({error}); an interruption will end the program without \
                 saving a checkpoint"
            );
        }
    }
    stop
}
