//! The global options, which every subcommand receives.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use granum_campaign::scheduler::Schedulers;
use granum_io::case::Vocabulary;
use granum_io::{Formats, Packing, Reading, Run};
use granum_learn::SurrogateMethods;
use granum_run::{Flow, RunRegistry};

use crate::failure::{Failure, Interrupted};
use crate::messages;
use crate::progress::Progress;
use crate::registry::Registry;

/// The global options, and the flag for an interruption by the user.
#[derive(Clone)]
pub struct Context {
    /// Results and errors as JSON.
    pub json: bool,
    /// Replace existing files and folders.
    pub force: bool,
    /// Print more information.
    pub verbose: bool,
    /// Input files may name files outside their own folders.
    pub allow_outside: bool,
    /// The file that starts this program, if it is known.
    program: Option<PathBuf>,
    registry: Arc<Registry>,
    stop: Arc<AtomicBool>,
    /// The warnings so far, which the JSON of the result or of the error contains.
    warnings: Arc<Mutex<Vec<String>>>,
}

impl Context {
    pub fn new(registry: Registry, json: bool, force: bool, verbose: bool, stop: Arc<AtomicBool>) -> Self {
        let (registry, warnings) = (Arc::new(registry), Arc::default());
        Context { json, force, verbose, allow_outside: false, program: None, registry, stop, warnings }
    }

    /// The same options; input files may name files outside their own folders if `allow_outside` is true.
    pub fn allowing_outside(self, allow_outside: bool) -> Context {
        Context { allow_outside, ..self }
    }

    /// The same options of a program that a file starts.
    pub fn started_by(self, program: Option<PathBuf>) -> Context {
        Context { program, ..self }
    }

    /// The file of this program, which a coordinator starts for each run.
    pub fn program(&self) -> Result<PathBuf, Failure> {
        self.program.clone().ok_or_else(|| Failure::new("cannot find the file of this program"))
    }

    /// How case files are read.
    pub fn reading(&self) -> Reading {
        self.registry.reading().with_outside(self.allow_outside)
    }

    /// The laws, paths and sensors that the program knows by name.
    pub fn vocabulary(&self) -> &Vocabulary {
        &self.registry.runs.vocabulary
    }

    /// The methods of surrogates that the program knows by name.
    pub fn methods(&self) -> &SurrogateMethods {
        &self.registry.methods
    }

    /// The schedulers of campaigns that the program knows by name.
    pub fn schedulers(&self) -> &Schedulers {
        &self.registry.schedulers
    }

    /// What runs know by name.
    pub fn run_registry(&self) -> RunRegistry {
        let mut registry = self.registry.runs.clone();
        registry.formats = self.formats();
        registry
    }

    /// The formats by which data are read.
    pub fn formats(&self) -> Formats {
        self.registry.runs.formats.clone().allowing_outside(self.allow_outside)
    }

    /// The run in a folder.
    pub fn run_at(&self, folder: impl AsRef<Path>) -> granum_io::Result<Run> {
        self.registry.run_at(folder)
    }

    /// The same options with permission to replace, as for a check after which nothing is written.
    pub fn with_force(&self) -> Context {
        Context { force: true, ..self.clone() }
    }

    /// The same options with warnings and remarks that are kept for themselves and not printed.
    pub fn keeping_messages(&self) -> Context {
        Context { json: true, warnings: Arc::default(), ..self.clone() }
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

    /// A warning that does not end the command: it is printed at once, or with `--json` becomes part of the JSON at the end.
    pub fn warn(&self, text: &str) {
        self.tell("warning", text);
    }

    /// A remark that a user should know although nothing is wrong. With `--json` it stands among the warnings.
    pub fn note(&self, text: &str) {
        self.tell("note", text);
    }

    /// A remark on data that were read: a warning if numbers may be wrong because of it.
    pub fn tell_remark(&self, text: &str, doubtful: bool) {
        if doubtful { self.warn(text) } else { self.note(text) }
    }

    /// Reads a packing, and tells what of its file a packing has no place for.
    pub fn read_packing(&self, path: &Path) -> granum_io::Result<Packing> {
        let packing = self.formats().read_packing(path)?;
        packing.remarks.iter().for_each(|remark| self.tell_remark(&remark.text, remark.doubtful));
        Ok(packing)
    }

    /// A warning that the readable text of the result contains: only the JSON needs it in its list.
    pub fn warn_in_json(&self, text: &str) {
        if self.json {
            self.warn(text);
        }
    }

    fn tell(&self, kind: &str, text: &str) {
        if self.json {
            self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_string());
        } else {
            messages::line(format_args!("{kind}: {text}"));
        }
    }

    /// The warnings and remarks so far, if they are to stand in JSON.
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
