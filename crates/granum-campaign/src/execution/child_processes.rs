//! Runs in processes of their own, so that one that crashes, is killed or runs out of memory takes no other with it.
//!
//! The process of a run has a pipe of the coordinator as its standard input. When the coordinator closes it, the run ends in good order;
//! and so it does when the coordinator is killed, since the system then closes the pipe.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use granum_dem::observer::Flow;
use granum_io::{Run, RunRecord, RunStatus};
use granum_run::queue::{Executor, QueueObserver, QueuedRun, RunError};

use crate::message::{End, Message};

/// How often the coordinator asks whether a run is to stop.
const ASK_EVERY: Duration = Duration::from_millis(100);
/// How long after a process was ended by an interruption the coordinator may learn of the same interruption.
const SIGNAL_IS_KNOWN_WITHIN: Duration = Duration::from_secs(1);
/// How often a run is tried.
const TRIES: usize = 2;
/// Longest end of the standard error of a process that is kept.
const LONGEST_ERROR: usize = 4000;

/// Executes each run by a process of its own: the program with `campaign run DIR NAME --watched` and further arguments.
pub struct ChildProcesses {
    program: PathBuf,
    folder: PathBuf,
    arguments: Vec<OsString>,
    followed: Mutex<BTreeMap<usize, Followed>>,
}

/// What is known of the process of a run, by its number in the queue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Followed {
    /// The completed share of the run.
    pub(super) share: f64,
    /// Seconds from the start of the process to the first sign of its test.
    pub(super) test_begun: Option<f64>,
    /// Seconds from the start of the process to its end.
    pub(super) seconds: f64,
    /// Largest memory, bytes.
    pub(super) memory: Option<u64>,
}

/// How the process of a run ended.
enum Ended {
    /// As its last message says.
    Told(End),
    /// Before it could say how.
    Untold {
        /// Why, as far as its status and its last words say.
        reason: String,
        /// True if Ctrl-C or SIGTERM ended it, which may have been sent to all processes of the campaign.
        interrupted: bool,
    },
}

impl ChildProcesses {
    /// Runs of the campaign in a folder by this program, with further arguments such as the interval of checkpoints.
    pub fn new(program: PathBuf, folder: &Path, arguments: Vec<OsString>) -> ChildProcesses {
        ChildProcesses { program, folder: folder.to_path_buf(), arguments, followed: Mutex::default() }
    }

    /// What is known of the process of a run.
    pub(super) fn followed(&self, number: usize) -> Option<Followed> {
        self.followed.lock().unwrap_or_else(PoisonError::into_inner).get(&number).copied()
    }

    fn note(&self, number: usize, change: impl FnOnce(&mut Followed)) {
        let mut followed = self.followed.lock().unwrap_or_else(PoisonError::into_inner);
        change(followed.entry(number).or_default());
    }

    fn start(&self, run: &QueuedRun) -> std::io::Result<Child> {
        let mut command = Command::new(&self.program);
        command.args(["campaign", "run"]).arg("--watched").args(&self.arguments);
        command.arg("--").arg(&self.folder).arg(&run.name);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()
    }

    /// One try.
    fn attempt(
        &self,
        number: usize,
        run: &QueuedRun,
        observer: &dyn QueueObserver,
    ) -> Result<Ended, RunError> {
        let cannot = |what: &str, error: std::io::Error| {
            RunError::Process(format!("{what} {}: {error}", self.program.display()))
        };
        let begun = Instant::now();
        self.note(number, |followed| *followed = Followed::default());
        let mut child = self.start(run).map_err(|error| cannot("cannot start", error))?;
        let errors = child.stderr.take().map(|stderr| thread::spawn(move || last_of(stderr)));
        let lines = child.stdout.take().map(lines_of);
        let mut input = child.stdin.take();
        let mut end = None;
        if let Some(lines) = lines {
            end = self.follow(number, begun, &lines, observer, || drop(input.take()));
        }
        let status = child.wait().map_err(|error| cannot("cannot wait for", error))?;
        let told = errors.and_then(|thread| thread.join().ok()).unwrap_or_default();
        Ok(match end {
            Some(end) => Ended::Told(end),
            None => {
                Ended::Untold { reason: why(status, &told), interrupted: is_ended_by_interruption(status) }
            }
        })
    }

    /// Follows the messages of a process until it closes its output; returns how it says that the run ended.
    fn follow(
        &self,
        number: usize,
        begun: Instant,
        lines: &Receiver<String>,
        observer: &dyn QueueObserver,
        mut stop: impl FnMut(),
    ) -> Option<End> {
        let mut end = None;
        loop {
            let flow = match lines.recv_timeout(ASK_EVERY) {
                Ok(line) => match Message::read(&line) {
                    Some(Message::Progress { share, in_test }) => {
                        let seconds = begun.elapsed().as_secs_f64();
                        self.note(number, |followed| {
                            (followed.share, followed.seconds) = (share, seconds);
                            followed.test_begun = followed.test_begun.or(in_test.then_some(seconds));
                        });
                        observer.share(number, share)
                    }
                    Some(Message::Warning { text }) => {
                        observer.warn(number, &text);
                        observer.flow()
                    }
                    Some(Message::Ended { end: how, memory }) => {
                        let seconds = begun.elapsed().as_secs_f64();
                        self.note(number, |followed| {
                            followed.memory = memory;
                            if how == End::Finished {
                                followed.seconds = seconds;
                            }
                        });
                        end = Some(how);
                        observer.flow()
                    }
                    None => observer.flow(),
                },
                Err(RecvTimeoutError::Timeout) => observer.flow(),
                Err(RecvTimeoutError::Disconnected) => return end,
            };
            if flow == Flow::Stop {
                stop();
            }
        }
    }
}

impl Executor for ChildProcesses {
    fn execute(
        &self,
        number: usize,
        run: &QueuedRun,
        observer: &dyn QueueObserver,
    ) -> Result<RunRecord, RunError> {
        let mut reason = String::new();
        for attempt in 1..=TRIES {
            match self.attempt(number, run, observer)? {
                Ended::Told(End::Finished) => {
                    return Ok(Run::at(&run.folder).and_then(|run| run.record())?);
                }
                Ended::Told(End::Interrupted) => return stopped(run),
                // Ctrl-C reaches all processes, also one that has only just begun and knows of no good order yet.
                Ended::Untold { interrupted, .. } if is_to_end(observer, interrupted) => return stopped(run),
                Ended::Told(End::Failed { reason, lasting: true }) => return Err(RunError::Lasting(reason)),
                Ended::Told(End::Failed { reason: why, .. }) | Ended::Untold { reason: why, .. } => {
                    reason = why;
                }
            }
            if observer.flow() == Flow::Stop {
                break;
            }
            if attempt < TRIES {
                observer.warn(number, &format!("{reason}; it is tried again"));
            }
        }
        Err(RunError::Process(format!("{reason} (tried {TRIES} times)")))
    }
}

/// True if the campaign is to end. A signal that was sent to all processes may end that of a run before the coordinator has taken
/// note of it; so this waits for a moment after an interruption.
fn is_to_end(observer: &dyn QueueObserver, interrupted: bool) -> bool {
    let since = Instant::now();
    while observer.flow() != Flow::Stop {
        if !interrupted || since.elapsed() > SIGNAL_IS_KNOWN_WITHIN {
            return false;
        }
        thread::sleep(Duration::from_millis(5));
    }
    true
}

/// The record of a run that was stopped; it may have none yet, or that of a moment before.
fn stopped(run: &QueuedRun) -> Result<RunRecord, RunError> {
    let record = Run::at(&run.folder).and_then(|run| run.record());
    let is_stopped =
        |record: &RunRecord| matches!(record.status, RunStatus::Interrupted | RunStatus::Finished);
    record.ok().filter(is_stopped).ok_or(RunError::NotBegun)
}

/// The lines of a stream, which ends when its process does.
fn lines_of(stream: impl Read + Send + 'static) -> Receiver<String> {
    let (send, receive) = mpsc::channel();
    thread::spawn(move || {
        // A line that is no text is no message.
        for line in BufReader::new(stream).split(b'\n').map_while(Result::ok) {
            if send.send(String::from_utf8_lossy(&line).into_owned()).is_err() {
                break;
            }
        }
    });
    receive
}

/// The end of a stream as text.
fn last_of(mut stream: impl Read) -> String {
    let (mut kept, mut buffer) = (Vec::new(), [0; 1 << 12]);
    while let Ok(count @ 1..) = stream.read(&mut buffer) {
        kept.extend_from_slice(&buffer[..count]);
        let excess = kept.len().saturating_sub(LONGEST_ERROR);
        kept.drain(..excess);
    }
    String::from_utf8_lossy(&kept).trim().to_string()
}

/// Why a process ended that did not say how its run ended.
fn why(status: ExitStatus, told: &str) -> String {
    let how = how_it_ended(status);
    match told.lines().rfind(|line| !line.trim().is_empty()) {
        Some(line) => format!("{how}: {}", line.trim()),
        None => how,
    }
}

#[cfg(unix)]
fn how_it_ended(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match status.signal() {
        Some(9) => "its process was killed by signal 9; the system does so when memory runs out".into(),
        Some(signal) => format!("its process was ended by signal {signal}"),
        None => by_code(status),
    }
}

/// True if Ctrl-C (SIGINT, 2) or SIGTERM (15) ended a process.
#[cfg(unix)]
fn is_ended_by_interruption(status: ExitStatus) -> bool {
    use std::os::unix::process::ExitStatusExt;
    matches!(status.signal(), Some(2 | 15))
}

#[cfg(not(unix))]
fn is_ended_by_interruption(_: ExitStatus) -> bool {
    false
}

#[cfg(not(unix))]
fn how_it_ended(status: ExitStatus) -> String {
    by_code(status)
}

fn by_code(status: ExitStatus) -> String {
    match status.code() {
        Some(code) => format!("its process ended with exit code {code}"),
        None => "its process ended".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run that was stopped before it had a record has not failed.
    #[test]
    fn a_run_that_was_stopped_at_its_beginning_has_not_begun() {
        let folder = tempfile::tempdir().unwrap();
        let run = QueuedRun::test(
            "a",
            granum_io::Case::default(),
            granum_run::laboratory::Source::Case,
            folder.path().join("a"),
        );
        assert!(matches!(stopped(&run), Err(RunError::NotBegun)));
    }

    /// A process that is ended by Ctrl-C before it can catch it, while the coordinator learns of the same Ctrl-C a moment later, is
    /// neither tried again nor told.
    #[cfg(unix)]
    #[test]
    fn a_signal_that_reaches_the_process_of_a_run_first_ends_it_in_good_order() {
        use std::os::unix::fs::PermissionsExt;

        struct StoppedSoon(Instant, Mutex<Vec<String>>);
        impl QueueObserver for StoppedSoon {
            fn flow(&self) -> Flow {
                if self.0.elapsed() < Duration::from_millis(200) { Flow::Continue } else { Flow::Stop }
            }
            fn warn(&self, _: usize, text: &str) {
                self.1.lock().unwrap().push(text.to_string());
            }
        }

        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("program");
        for (signal, is_told) in [("INT", false), ("TERM", false), ("KILL", true)] {
            std::fs::write(&program, format!("#!/bin/sh\nkill -{signal} $$\n")).unwrap();
            std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
            let run = QueuedRun::test(
                "a",
                granum_io::Case::default(),
                granum_run::laboratory::Source::Case,
                folder.path().join("a"),
            );
            let observer = StoppedSoon(Instant::now(), Mutex::default());
            let processes = ChildProcesses::new(program.clone(), folder.path(), Vec::new());
            let ended = processes.execute(0, &run, &observer);
            let warnings = observer.1.into_inner().unwrap();
            assert_eq!(matches!(ended, Err(RunError::NotBegun)), !is_told, "{signal}: {ended:?}");
            assert_eq!(warnings.is_empty(), !is_told, "{signal}: {warnings:?}");
        }
    }

    #[test]
    fn only_the_end_of_a_long_stream_is_kept() {
        let text = format!("{}the last line\n", "x".repeat(3 * LONGEST_ERROR));
        let kept = last_of(text.as_bytes());
        assert!(kept.ends_with("the last line") && kept.len() <= LONGEST_ERROR, "{}", kept.len());
    }
}
