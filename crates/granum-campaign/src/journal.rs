//! The journal of a campaign: a line of JSON for each thing that happened to a run.
//!
//! It is an index: what is true of a run is in its folder, and a journal that was lost, cut short or damaged is made again from the
//! folders. It is therefore only ever appended to, a line at a time, without locks and without waiting for the disk; a line that cannot be
//! read is passed over. Any program reads it: `jq`, pandas (`read_json(lines=True)`), DuckDB (`read_json`).

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::time::SystemTime;

use granum_io::{Error, QualityFlag, Result, RunRecord};
use granum_run::queue::Outcome;
use serde::{Deserialize, Serialize};

use crate::clock::utc;

/// The file of the journal.
pub const JOURNAL: &str = "journal.jsonl";
/// A larger journal is not read.
const LARGEST: u64 = 1 << 32;

/// A line of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JournalLine {
    /// When it happened, by the clock of the machine, in UTC. Nothing is decided by it.
    pub time: String,
    /// Name of the run.
    pub run: String,
    /// What happened.
    #[serde(flatten)]
    pub event: JournalEvent,
}

/// What happened to a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum JournalEvent {
    /// It was begun or continued.
    Begun,
    /// It was stopped in good order.
    Interrupted,
    /// It is finished.
    Finished {
        /// The checks that it did not pass.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        flags: Vec<FailedCheck>,
        /// Seconds of work, over all parts.
        seconds: f64,
    },
    /// It failed.
    Failed {
        /// Why.
        reason: String,
        /// True if the reason lies in its case, so that it would fail again.
        lasting: bool,
    },
}

/// A check that a run did not pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailedCheck {
    /// Its name.
    pub name: String,
    /// The value that was found; `None` if it is no number.
    pub value: Option<f64>,
    /// The limit.
    pub limit: f64,
}

impl JournalEvent {
    /// The event of a finished run.
    pub fn finished(record: &RunRecord) -> JournalEvent {
        let failed = |flag: &QualityFlag| FailedCheck {
            name: flag.name.clone(),
            value: flag.value.is_finite().then_some(flag.value),
            limit: flag.limit,
        };
        JournalEvent::Finished {
            flags: record.quality.iter().filter(|flag| !flag.passed).map(failed).collect(),
            seconds: record.wall_seconds.values().sum(),
        }
    }

    /// The event of a run that ended so; `None` if nothing happened to it.
    pub fn of_outcome(outcome: &Outcome) -> Option<JournalEvent> {
        match outcome {
            Outcome::Finished { record, .. } => Some(JournalEvent::finished(record)),
            Outcome::Interrupted(_) => Some(JournalEvent::Interrupted),
            Outcome::Failed(error) => {
                Some(JournalEvent::Failed { reason: error.to_string(), lasting: error.is_lasting() })
            }
            Outcome::WithoutSample { .. } => {
                Some(JournalEvent::Failed { reason: outcome.failure().unwrap_or_default(), lasting: false })
            }
            _ => None,
        }
    }
}

/// Where the lines of a journal go, and the clock: what a test replaces to see what happens if they fail.
pub(crate) trait Medium: Send {
    /// Appends bytes, perhaps not all of them; returns how many.
    fn append(&mut self, bytes: &[u8]) -> io::Result<usize>;
    /// The time by the clock of the machine.
    fn now(&self) -> SystemTime;
}

/// A file and the clock of the machine.
struct OnDisk(File);

impl Medium for OnDisk {
    fn append(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn now(&self) -> SystemTime {
        SystemTime::now()
    }
}

/// Appends lines to a file.
pub struct LineWriter {
    medium: Box<dyn Medium>,
    /// True if the file ends within a line.
    torn: bool,
}

impl LineWriter {
    /// Opens a file, or creates it.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn open(path: &Path) -> Result<LineWriter> {
        let open = || -> io::Result<LineWriter> {
            let mut file = OpenOptions::new().create(true).append(true).read(true).open(path)?;
            let mut last = [b'\n'];
            if file.seek(SeekFrom::End(0))? > 0 {
                file.seek(SeekFrom::End(-1))?;
                file.read_exact(&mut last)?;
            }
            Ok(LineWriter { medium: Box::new(OnDisk(file)), torn: last != [b'\n'] })
        };
        open().map_err(Error::file("write", path))
    }

    #[cfg(test)]
    pub(crate) fn on(medium: Box<dyn Medium>) -> LineWriter {
        LineWriter { medium, torn: false }
    }

    /// Appends a line with the time at its beginning, made of what `line` makes of the time.
    ///
    /// # Errors
    /// As the system reports it. What was written of the line is passed over by readers, and the next line begins anew.
    pub fn append(&mut self, line: impl FnOnce(&str) -> String) -> io::Result<()> {
        let mut text = line(&utc(self.medium.now()));
        text.push('\n');
        if self.torn {
            text.insert(0, '\n');
        }
        let mut rest = text.as_bytes();
        while !rest.is_empty() {
            match self.medium.append(rest) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(count) => {
                    rest = &rest[count.min(rest.len())..];
                    self.torn = !rest.is_empty();
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Appends an event to a journal.
    ///
    /// # Errors
    /// As [`LineWriter::append`].
    pub fn note(&mut self, run: &str, event: JournalEvent) -> io::Result<()> {
        let line = |time: &str| JournalLine { time: time.to_string(), run: run.to_string(), event };
        self.append(|time| serde_json::to_string(&line(time)).unwrap_or_default())
    }
}

/// The last event of each run, as far as the journal of a folder can be read.
pub fn last_events(folder: &Path) -> BTreeMap<String, JournalEvent> {
    last_events_in(&folder.join(JOURNAL))
}

/// The last event of each run, as far as a file can be read; none if there is no such file.
pub(crate) fn last_events_in(file: &Path) -> BTreeMap<String, JournalEvent> {
    let bytes = granum_core::input::read(file, LARGEST).unwrap_or_default();
    events_in(&bytes)
}

fn events_in(bytes: &[u8]) -> BTreeMap<String, JournalEvent> {
    let lines = bytes
        .split(|byte| *byte == b'\n')
        .filter_map(|line| serde_json::from_slice::<JournalLine>(line).ok());
    lines.map(|line| (line.run, line.event)).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};
    use std::time::Duration;

    use super::*;

    /// A disk and a clock that fail as a seed decides: writes that fail, short writes, a clock that jumps.
    #[derive(Clone)]
    struct Faulty {
        bytes: Arc<Mutex<Vec<u8>>>,
        random: u64,
    }

    impl Faulty {
        fn draw(&mut self, below: u64) -> u64 {
            self.random =
                self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.random >> 33) % below
        }
    }

    impl Medium for Faulty {
        fn append(&mut self, bytes: &[u8]) -> io::Result<usize> {
            match self.draw(4) {
                0 => Err(io::Error::other("the disk is full")),
                1 => {
                    let count = self.draw(bytes.len() as u64 + 1) as usize;
                    self.bytes.lock().unwrap().extend(&bytes[..count]);
                    Ok(count)
                }
                2 => Err(io::ErrorKind::Interrupted.into()),
                _ => {
                    self.bytes.lock().unwrap().extend(bytes);
                    Ok(bytes.len())
                }
            }
        }

        fn now(&self) -> SystemTime {
            // Between 1970 and far ahead, and not in order.
            SystemTime::UNIX_EPOCH + Duration::from_secs(self.random >> 20)
        }
    }

    /// Whatever fails, a line that was taken without an error is read, and what was not does no harm to the others.
    #[test]
    fn no_fault_of_the_disk_or_the_clock_harms_other_lines() {
        let mut lost = 0;
        for seed in 0..200 {
            let bytes: Arc<Mutex<Vec<u8>>> = Arc::default();
            let mut writer = LineWriter::on(Box::new(Faulty { bytes: bytes.clone(), random: seed }));
            let (mut wanted, mut all) = (BTreeMap::new(), BTreeMap::new());
            for k in 0..30 {
                let run = format!("run {k}");
                let event = match k % 3 {
                    0 => JournalEvent::Begun,
                    1 => JournalEvent::Failed { reason: format!("reason\n{k}"), lasting: k % 2 == 0 },
                    _ => JournalEvent::Finished {
                        flags: vec![FailedCheck { name: "x".into(), value: None, limit: 1.0 }],
                        seconds: 0.5,
                    },
                };
                all.insert(run.clone(), event.clone());
                match writer.note(&run, event.clone()) {
                    Ok(()) => drop(wanted.insert(run, event)),
                    Err(_) => lost += 1,
                }
            }
            let found = events_in(&bytes.lock().unwrap());
            // Of a line that was reported as lost all but its end may have been written.
            assert!(wanted.iter().all(|(run, event)| found.get(run) == Some(event)), "seed {seed}");
            assert!(found.iter().all(|(run, event)| all.get(run) == Some(event)), "seed {seed}");
        }
        assert!(lost > 500, "{lost}");
    }

    #[test]
    fn a_journal_that_was_cut_anywhere_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(JOURNAL);
        let mut writer = LineWriter::open(&path).unwrap();
        for name in ["a", "b"] {
            writer.note(name, JournalEvent::Begun).unwrap();
        }
        let whole = std::fs::read(&path).unwrap();
        for length in 0..=whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            LineWriter::open(&path).unwrap().note("c", JournalEvent::Interrupted).unwrap();
            let events = last_events(folder.path());
            let complete = whole[..length].iter().filter(|byte| **byte == b'\n').count();
            // A line that lacks only its end is whole.
            assert!(events.len() > complete, "{length}: {events:?}");
            assert_eq!(events["c"], JournalEvent::Interrupted);
        }
        assert!(last_events(&folder.path().join("nowhere")).is_empty());
    }
}
