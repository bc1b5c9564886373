//! Ctrl-C, SIGTERM and the loss of the terminal (SIGHUP): the first signal requests a clean stop, a second Ctrl-C or SIGTERM
//! ends the program at once.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Exit status of a program that was interrupted, by the convention of shells.
pub const INTERRUPTED: u8 = 130;

/// Installs the signal handlers and returns the flag that the first signal sets, with a warning for each signal that cannot
/// be caught and ends the program as usual.
pub fn install() -> (Arc<AtomicBool>, Vec<String>) {
    let stop = Arc::new(AtomicBool::new(false));
    let mut warnings = Vec::new();
    for signal in [SIGINT, SIGTERM] {
        // The order matters: the handler that ends the program if the flag is set must run before the one that sets the
        // flag.
        let second = flag::register_conditional_shutdown(signal, INTERRUPTED.into(), stop.clone());
        let first = flag::register(signal, stop.clone());
        if let Err(error) = second.and(first) {
            warnings.push(not_caught(signal, &error));
        }
    }
    // A terminal that is closed may send its signal twice, from the shell and from the system; the second says nothing new.
    #[cfg(target_os = "linux")]
    if !hang_up_is_ignored()
        && let Err(error) = flag::register(signal_hook::consts::SIGHUP, stop.clone())
    {
        warnings.push(not_caught(signal_hook::consts::SIGHUP, &error));
    }
    (stop, warnings)
}

fn not_caught(signal: i32, error: &std::io::Error) -> String {
    format!(
        "signal {signal} cannot be caught ({error}); an interruption will end the program without saving a checkpoint"
    )
}

/// True if the program was started with SIGHUP ignored, as `nohup` does: it is to survive the loss of its terminal. Only
/// Linux reports this in a file; elsewhere SIGHUP keeps the effect with which the program was started.
#[cfg(target_os = "linux")]
fn hang_up_is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    ignores(&status, signal_hook::consts::SIGHUP)
}

/// True if a signal is in the set of ignored signals in the text of `/proc/PID/status`, a hexadecimal number whose lowest bit
/// is signal 1.
#[cfg(target_os = "linux")]
fn ignores(status: &str, signal: i32) -> bool {
    let set = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let set = set.and_then(|set| u64::from_str_radix(set.trim(), 16).ok());
    set.is_some_and(|set| set >> (signal - 1) & 1 == 1)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_known_from_their_set() {
        let status = "Name:\tgranum\nSigBlk:\t0000000000000001\nSigIgn:\t0000000000001001\nSigCgt:\t0000000000000002\n";
        assert_eq!([1, 2, 13].map(|signal| ignores(status, signal)), [true, false, true]);
        assert!(!ignores("Name:\tgranum\n", 1));
    }
}
