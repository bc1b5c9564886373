//! The process that holds a claim, and whether it goes on.

use std::fs;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use granum_io::process::is_suspended;
use serde::{Deserialize, Serialize};

/// What tells whether another process sees the same processes: the start of the machine and the name space of its processes. Empty where
/// the system does not tell it.
static MACHINE: LazyLock<String> = LazyLock::new(|| {
    let space =
        fs::read_link("/proc/self/ns/pid").map_or_else(|_| String::new(), |name| name.display().to_string());
    let start = line("/proc/sys/kernel/random/boot_id");
    if space.is_empty() || start.is_empty() { String::new() } else { format!("{start} {space}") }
});

/// The process that holds a claim.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Owner {
    /// Name of its machine.
    pub(super) host: String,
    /// Its number there.
    pub(super) process: u32,
    /// When it began, as the system tells it: a later process may get the same number.
    #[serde(default)]
    pub(super) began: String,
    /// What tells whether another process sees the same processes.
    #[serde(default)]
    pub(super) machine: String,
    /// Distinguishes the claims of one process.
    #[serde(default)]
    pub(super) number: u64,
}

impl Owner {
    /// This process, with a number of its own for each claim.
    pub(super) fn here() -> Owner {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let process = std::process::id();
        Owner {
            host: line("/proc/sys/kernel/hostname"),
            process,
            began: begin_of(process).unwrap_or_default(),
            machine: MACHINE.clone(),
            number: NUMBER.fetch_add(1, Ordering::Relaxed),
        }
    }

    /// True if it is a process of this machine, which therefore sees whether it goes on.
    fn is_here(&self) -> bool {
        !self.machine.is_empty() && self.machine == *MACHINE
    }

    /// True if its process has ended for certain, which is known on its machine only.
    pub(super) fn has_ended(&self) -> bool {
        self.is_here() && begin_of(self.process).is_none_or(|began| began != self.began)
    }

    /// It in words: `process 4711 on node12`, and whether it is suspended, as far as this machine sees it.
    pub(super) fn in_words(&self) -> String {
        let Owner { host, process, .. } = self;
        match self.is_here() && is_suspended(*process) {
            true => format!(
                "process {process} on {host}, which is suspended (kill -CONT {process} lets it go on, kill -KILL {process} ends it)"
            ),
            false => format!("process {process} on {host}"),
        }
    }

    /// True if its process goes on for certain.
    pub(super) fn is_seen_alive(&self) -> bool {
        self.is_here() && !self.has_ended()
    }
}

/// The line that a file of the system has.
fn line(path: &str) -> String {
    fs::read_to_string(path).map_or_else(|_| String::new(), |text| text.trim().into())
}

/// When a process of this machine began, in ticks since the start of the machine; `None` if there is none.
fn begin_of(process: u32) -> Option<String> {
    let text = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name of the program stands in parentheses and may contain anything. A process that has ended and is not yet waited for is none.
    let mut rest = text[text.rfind(')')? + 1..].split_whitespace();
    let state = rest.next()?;
    if matches!(state, "Z" | "X") { None } else { rest.nth(18).map(str::to_string) }
}
