//! Runs the program under limits and tells how it ended.

use std::ffi::OsString;
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Most bytes of an output that are kept.
const KEPT: u64 = 4 << 20;
/// Time between two looks at a process.
const LOOK: Duration = Duration::from_millis(3);

/// The program and the limits of one of its processes.
#[derive(Clone, Debug)]
pub struct Program {
    pub path: PathBuf,
    /// Wall time after which a command hangs.
    pub longest: Duration,
    /// Address space, MiB.
    pub memory: u64,
}

/// What a command is subjected to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Time after which the command is asked to end (SIGTERM), for one that may rightly go on for long.
    pub stop_after: Option<Duration>,
    /// Largest file that can be written, in blocks of 512 bytes: acts as a full disk.
    pub blocks: Option<u32>,
    /// Standard output or error on a device that is full, or a pipe that nobody reads.
    pub lost: Option<Lost>,
}

#[derive(Clone, Copy, Debug)]
pub enum Lost {
    OutputFull,
    ErrorFull,
    OutputUnread,
    ErrorUnread,
}

/// How a command ended.
#[derive(Debug)]
pub struct Ended {
    pub line: String,
    pub status: ExitStatus,
    pub output: String,
    pub error: String,
    pub seconds: f64,
    /// It was killed because it did not end in time.
    pub hung: bool,
    /// It was asked to end.
    pub stopped: bool,
}

impl Ended {
    pub fn code(&self) -> Option<i32> {
        self.status.code()
    }

    pub fn succeeded(&self) -> bool {
        self.code() == Some(0)
    }
}

/// A process that was started, with what reads its outputs.
pub struct Running {
    line: String,
    child: Child,
    readers: [Option<JoinHandle<String>>; 2],
    begun: Instant,
}

impl Program {
    /// Starts a command in a folder.
    pub fn start(&self, folder: &Path, words: &[OsString], limits: Limits) -> std::io::Result<Running> {
        let shown: Vec<String> = words.iter().map(shown).collect();
        let line = format!("granum {}", shown.join(" "));
        let mut script = format!("ulimit -v {}; ", self.memory * 1024);
        if let Some(blocks) = limits.blocks {
            script += &format!("trap '' XFSZ; ulimit -f {blocks}; ");
        }
        // The shell becomes the program, so that signals arrive there.
        script += "exec \"$0\" \"$@\"";
        let full = || -> std::io::Result<Stdio> {
            Ok(std::fs::OpenOptions::new().write(true).open("/dev/full")?.into())
        };
        let mut command = Command::new("sh");
        command.arg("-c").arg(script).arg(&self.path).args(words).current_dir(folder).stdin(Stdio::null());
        // Every thread of a program would otherwise reserve 64 MiB of addresses, which says nothing about its use of memory.
        command.env("MALLOC_ARENA_MAX", "2").env("RAYON_NUM_THREADS", "2").env("NO_COLOR", "1");
        let lost = limits.lost;
        command.stdout(if matches!(lost, Some(Lost::OutputFull)) { full()? } else { Stdio::piped() });
        command.stderr(if matches!(lost, Some(Lost::ErrorFull)) { full()? } else { Stdio::piped() });
        let mut child = command.spawn()?;
        let (mut output, mut error) = (child.stdout.take(), child.stderr.take());
        match lost {
            Some(Lost::OutputUnread) => drop(output.take()),
            Some(Lost::ErrorUnread) => drop(error.take()),
            _ => {}
        }
        let readers = [output.map(reader), error.map(reader)];
        Ok(Running { line, child, readers, begun: Instant::now() })
    }

    /// Runs a command to its end or to its limits.
    pub fn run(&self, folder: &Path, words: &[OsString], limits: Limits) -> std::io::Result<Ended> {
        let mut running = self.start(folder, words, limits)?;
        let mut stopped = false;
        loop {
            if let Some(status) = running.child.try_wait()? {
                return Ok(running.ended(status, false, stopped));
            }
            let time = running.begun.elapsed();
            if limits.stop_after.is_some_and(|after| time > after) && !stopped {
                running.signal("TERM");
                stopped = true;
            }
            if time > self.longest + limits.stop_after.unwrap_or_default() {
                running.child.kill()?;
                let status = running.child.wait()?;
                return Ok(running.ended(status, true, stopped));
            }
            std::thread::sleep(LOOK);
        }
    }
}

impl Running {
    /// Sends a signal.
    pub fn signal(&self, name: &str) {
        let process = self.child.id().to_string();
        // A process that has just ended is no failure.
        let _ = Command::new("kill").args([&format!("-{name}"), &process]).stderr(Stdio::null()).status();
    }

    /// Waits for the end, and kills a process that has not ended after some time.
    pub fn wait(mut self, longest: Duration) -> std::io::Result<Ended> {
        let begun = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait()? {
                return Ok(self.ended(status, false, false));
            }
            if begun.elapsed() > longest {
                self.child.kill()?;
                let status = self.child.wait()?;
                return Ok(self.ended(status, true, false));
            }
            std::thread::sleep(LOOK);
        }
    }

    fn ended(self, status: ExitStatus, hung: bool, stopped: bool) -> Ended {
        let [output, error] = self
            .readers
            .map(|reader| reader.map_or_else(String::new, |reader| reader.join().unwrap_or_default()));
        Ended {
            line: self.line,
            status,
            output,
            error,
            seconds: self.begun.elapsed().as_secs_f64(),
            hung,
            stopped,
        }
    }
}

fn reader(mut stream: impl Read + Send + 'static) -> JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = stream.by_ref().take(KEPT).read_to_end(&mut bytes);
        // What is not kept is read all the same: the program must not wait for its reader.
        let _ = std::io::copy(&mut stream, &mut std::io::sink());
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// A word of a command line, readable also where it has spaces, line breaks or bytes that are no text.
fn shown(word: &OsString) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+".contains(c);
    match word.to_str() {
        Some(text) if !text.is_empty() && text.chars().all(plain) => text.to_string(),
        _ => format!("{word:?}"),
    }
}

/// The signal that ended a process, if one did.
pub fn signal_of(status: ExitStatus) -> Option<i32> {
    status.signal()
}
