//! The global options, which every subcommand receives.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use granum_run::Flow;

use crate::failure::{Failure, Interrupted};
use crate::messages;
use crate::progress::Progress;

/// The global options, and the flag for an interruption by the user.
#[derive(Clone)]
pub struct Context {
    /// Results and errors as JSON.
    pub json: bool,
    /// Replace existing files and folders.
    pub force: bool,
    /// Print more information.
    pub verbose: bool,
    stop: Arc<AtomicBool>,
}

impl Context {
    pub fn new(json: bool, force: bool, verbose: bool, stop: Arc<AtomicBool>) -> Self {
        Context { json, force, verbose, stop }
    }

    /// The same options without permission to replace anything.
    pub fn without_force(&self) -> Context {
        Context { force: false, ..self.clone() }
    }

    /// True after Ctrl-C or SIGTERM: the command should end soon and in good order.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The decision of an observer whether a run continues.
    pub fn flow(&self) -> Flow {
        if self.stopped() { Flow::Stop } else { Flow::Continue }
    }

    /// Returns an error if the user interrupted the program; `left` describes what has been written so far.
    pub fn check_stopped(&self, left: impl FnOnce() -> String) -> Result<(), Failure> {
        if self.stopped() { Err(Interrupted { left: left() }.into()) } else { Ok(()) }
    }

    /// A display of progress that suits the terminal and the options.
    pub fn progress(&self) -> Progress {
        Progress::new(self.json)
    }

    /// Prints a line on the current action if `--verbose` is given.
    pub fn say(&self, text: impl FnOnce() -> String) {
        if self.verbose && !self.json {
            messages::line(text());
        }
    }

    /// Prints a warning that does not end the command.
    pub fn warn(&self, text: &str) {
        if self.json {
            messages::line(serde_json::json!({ "warning": text }));
        } else {
            messages::line(format_args!("warning: {text}"));
        }
    }
}
