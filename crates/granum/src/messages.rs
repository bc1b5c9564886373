//! Messages to the user on standard error: progress, notes, warnings and errors. Everything that the program writes there is
//! written here, except the bar on a terminal, which `indicatif` draws.
//!
//! Messages can be lost: the disk is full to which they are redirected, nobody reads the pipe, the terminal has gone away.
//! The loss never ends a computation. What happened is in the exit status and in the record of a run.

use std::fmt::Display;
use std::io::{self, Write};

use granum_io::safe_text;

/// Writes a line, or several. Names of files, tests or values in it are shown, whatever they hold.
pub fn line(text: impl Display) {
    write(&format!("{}\n", safe_text::terminal(&text.to_string())));
}

/// Writes text that ends its lines itself and may be coloured. It is written at once, so that lines of several processes are not mixed.
pub fn write(text: &str) {
    let mut error = io::stderr().lock();
    // There is no place where the loss of a message could be reported.
    let _ = error.write_all(text.as_bytes()).and_then(|()| error.flush());
}
