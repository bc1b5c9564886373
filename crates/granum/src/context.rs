//! What every subcommand needs to know of how it was called.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use granum_run::Flow;

use crate::failure::{Failure, Interrupted};
use crate::progress::Progress;

/// The options that hold everywhere, and the wish of the user to stop.
#[derive(Clone)]
pub struct Context {
    /// Results and errors as JSON.
    pub json: bool,
    /// Replace what is there.
    pub force: bool,
    /// Say more.
    pub verbose: bool,
    stop: Arc<AtomicBool>,
}

impl Context {
    pub fn new(json: bool, force: bool, verbose: bool, stop: Arc<AtomicBool>) -> Self {
        Context { json, force, verbose, stop }
    }

    /// The same without leave to replace anything.
    pub fn without_force(&self) -> Context {
        Context { force: false, ..self.clone() }
    }

    /// True once Ctrl-C or SIGTERM came: finish in good order and soon.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// What an observer of a run asks for.
    pub fn flow(&self) -> Flow {
        if self.stopped() { Flow::Stop } else { Flow::Continue }
    }

    /// An error if the user wants to stop; `left` says what stands where.
    pub fn check_stopped(&self, left: impl FnOnce() -> String) -> Result<(), Failure> {
        if self.stopped() { Err(Interrupted { left: left() }.into()) } else { Ok(()) }
    }

    /// A display of progress that suits the terminal and the options.
    pub fn progress(&self) -> Progress {
        Progress::new(self.json)
    }

    /// A line for people on what is done, with `--verbose`.
    pub fn say(&self, text: impl FnOnce() -> String) {
        if self.verbose && !self.json {
            eprintln!("{}", text());
        }
    }

    /// A warning that does not end the command.
    pub fn warn(&self, text: &str) {
        if self.json {
            eprintln!("{}", serde_json::json!({ "warning": text }));
        } else {
            eprintln!("warning: {text}");
        }
    }
}
