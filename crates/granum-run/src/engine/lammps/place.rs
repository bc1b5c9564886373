//! The folder in which LAMMPS works, inside the folder of its run.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use granum_io::atomic::write_atomically;
use granum_io::{Error, Result};

use crate::lammps_deck::CURVE;
use crate::lammps_deck::hooks::COMPLETE;
use crate::lammps_deck::names::{CONTACTS, EVENTS, GRAINS, REQUEST, RESTART, STATE};

/// Name of the folder in the folder of a run.
pub(super) const FOLDER: &str = "lammps";
/// The command that began the run.
const COMMAND: &str = "command.json";
/// The state of the recorder beside a restart file; the number of the step follows.
const PROGRESS: &str = "progress.";
/// A file that LAMMPS holds open as long as it runs.
const LOCK: &str = "lock";
/// What LAMMPS prints.
pub(super) const OUTPUT: &str = "output.txt";
/// Beginning of the names of its logs; the number of the step at which it began follows.
pub(super) const LOG: &str = "log.";

/// The folder in which LAMMPS works.
#[derive(Clone, Debug)]
pub(super) struct Place(PathBuf);

/// What LAMMPS is asked for after its next row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Request {
    /// To go on.
    Go,
    /// To write a restart file.
    Save,
    /// To write one and to quit.
    Stop,
}

impl Request {
    fn word(self) -> &'static str {
        match self {
            Request::Go => "go",
            Request::Save => "save",
            Request::Stop => "stop",
        }
    }
}

impl Place {
    /// That in the folder of a run, which is created.
    pub(super) fn create(folder: &Path) -> Result<Place> {
        let path = folder.join(FOLDER);
        if fs::symlink_metadata(&path).is_ok_and(|kind| kind.is_symlink()) {
            let what = "is a symbolic link; LAMMPS must stay in the folder of its run, so replace it by a folder or remove it";
            return Err(Error::content(&path, what));
        }
        fs::create_dir_all(&path).map_err(Error::file("create", &path))?;
        Ok(Place(path))
    }

    /// The folder.
    pub(super) fn path(&self) -> &Path {
        &self.0
    }

    /// A file in it.
    pub(super) fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// The files of the events.
    pub(super) fn events(&self) -> PathBuf {
        self.file(EVENTS)
    }

    /// The dumps of grains and contacts of a step.
    pub(super) fn dumps(&self, step: u64) -> [PathBuf; 2] {
        [GRAINS, CONTACTS].map(|name| self.file(&format!("{name}{step}")))
    }

    /// Asks LAMMPS for something.
    pub(super) fn request(&self, request: Request) -> Result<()> {
        let command = format!("variable request string {}\n", request.word());
        write_atomically(&self.file(REQUEST), |file| file.write_all(command.as_bytes()))
    }

    /// Keeps the command by which the run began.
    pub(super) fn write_command(&self, command: &[String]) -> Result<()> {
        let text = serde_json::to_string(command).unwrap_or_default();
        write_atomically(&self.file(COMMAND), |file| file.write_all(text.as_bytes()))
    }

    /// The command by which the run in a folder began.
    pub(super) fn command_of(folder: &Path) -> Option<Vec<String>> {
        let text = fs::read_to_string(folder.join(FOLDER).join(COMMAND)).ok()?;
        serde_json::from_str(&text).ok().filter(|command: &Vec<String>| !command.is_empty())
    }

    /// When the last restart file of the run in a folder was written, if it has one.
    pub(super) fn last_restart_of(folder: &Path) -> Option<SystemTime> {
        let place = Place(folder.join(FOLDER));
        let step = place.path().is_dir().then(|| place.restarts().ok()).flatten()?.into_iter().next()?;
        fs::metadata(place.progress(step)).and_then(|file| file.modified()).ok()
    }

    /// Removes everything, to begin anew.
    pub(super) fn clear(&self) -> Result<()> {
        for path in self.files()? {
            if path.file_name().is_some_and(|name| name != LOCK) {
                remove(&path)?;
            }
        }
        Ok(())
    }

    /// Removes the dumps of a step.
    pub(super) fn remove_dump(&self, step: u64) -> Result<()> {
        self.dumps(step).iter().try_for_each(|path| remove(path))
    }

    /// Removes all dumps.
    pub(super) fn remove_dumps(&self) -> Result<()> {
        for name in [GRAINS, CONTACTS] {
            for (path, _) in self.numbered(name)? {
                remove(&path)?;
            }
        }
        Ok(())
    }

    /// The file of the state of the recorder at a step.
    pub(super) fn progress(&self, step: u64) -> PathBuf {
        self.file(&format!("{PROGRESS}{step}"))
    }

    /// The steps at which both LAMMPS and the recorder can go on, the last one first.
    pub(super) fn restarts(&self) -> Result<Vec<u64>> {
        let mut steps: Vec<u64> = self.numbered(PROGRESS)?.into_iter().map(|(_, step)| step).collect();
        steps.retain(|step| self.is_restart(*step));
        steps.sort_unstable();
        steps.reverse();
        Ok(steps)
    }

    /// True if LAMMPS has written a whole restart file of a step.
    pub(super) fn is_restart(&self, step: u64) -> bool {
        let state = fs::read_to_string(self.file(&format!("{STATE}{step}"))).unwrap_or_default();
        state.trim_end().ends_with(COMPLETE) && self.file(&format!("{RESTART}{step}")).is_file()
    }

    /// Removes the restart files of other steps than these.
    pub(super) fn keep_restarts(&self, steps: &[u64]) -> Result<()> {
        for name in [PROGRESS, RESTART, STATE] {
            for (path, step) in self.numbered(name)? {
                if !steps.contains(&step) {
                    remove(&path)?;
                }
            }
        }
        Ok(())
    }

    /// Cuts what a run wrote after a restart file off its events and its curve.
    pub(super) fn cut_to(&self, events: u64, step: u64) -> Result<()> {
        let path = self.events();
        let open = OpenOptions::new().write(true).open(&path);
        open.and_then(|file| file.set_len(events)).map_err(Error::file("shorten", &path))?;
        let path = self.file(CURVE);
        let Ok(text) = fs::read_to_string(&path) else { return Ok(()) };
        let is_earlier = |line: &&str| {
            let at = line.split(',').nth(1).and_then(|word| word.parse::<u64>().ok());
            at.is_none_or(|at| at <= step)
        };
        let kept: String = text.lines().filter(is_earlier).map(|line| format!("{line}\n")).collect();
        write_atomically(&path, |file| file.write_all(kept.as_bytes()))
    }

    /// The lock that LAMMPS holds while it runs; `None` if one that was started before holds it.
    pub(super) fn lock(&self) -> Result<Option<File>> {
        let path = self.file(LOCK);
        let open = OpenOptions::new().create(true).read(true).write(true).truncate(false).open(&path);
        let file = open.map_err(Error::file("open", &path))?;
        match file.try_lock() {
            Ok(()) => Ok(Some(file)),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(error)) => Err(Error::file("lock", &path)(error)),
        }
    }

    fn files(&self) -> Result<Vec<PathBuf>> {
        let read = fs::read_dir(&self.0).map_err(Error::file("read", &self.0))?;
        Ok(read.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_file()).collect())
    }

    /// The files with such a beginning and a number after it.
    fn numbered(&self, name: &str) -> Result<Vec<(PathBuf, u64)>> {
        let number = |path: &PathBuf| {
            let file = path.file_name()?.to_str()?;
            file.strip_prefix(name)?.parse().ok()
        };
        Ok(self
            .files()?
            .into_iter()
            .filter_map(|path| number(&path).map(|step| (path.clone(), step)))
            .collect())
    }
}

fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Error::file("remove", path)(error)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_restart_needs_all_its_three_files() {
        let base = tempfile::tempdir().unwrap();
        let place = Place::create(base.path()).unwrap();
        let write = |name: &str, text: &str| fs::write(place.file(name), text).unwrap();
        for step in [100, 200, 300] {
            write(&format!("progress.{step}"), "{}");
            write(&format!("restart.{step}"), "binary");
            // The last one was cut short.
            write(
                &format!("state.{step}"),
                if step == 300 { "variable x equal 1\n" } else { "# complete\n" },
            );
        }
        assert_eq!(place.restarts().unwrap(), [200, 100]);
        place.keep_restarts(&[200]).unwrap();
        assert_eq!(place.restarts().unwrap(), [200]);
        assert!(!place.file("restart.300").exists() && !place.file("state.100").exists());
        write("events", "row,1\nrow,2\n");
        write("curve.csv", "stage,step\n1,100\n1,200\n1,250\n");
        place.cut_to(6, 200).unwrap();
        assert_eq!(fs::read_to_string(place.events()).unwrap(), "row,1\n");
        assert_eq!(fs::read_to_string(place.file("curve.csv")).unwrap(), "stage,step\n1,100\n1,200\n");
        // Who holds the lock keeps others out, and clearing the folder does not let go of it.
        let held = place.lock().unwrap().unwrap();
        assert!(place.lock().unwrap().is_none());
        place.clear().unwrap();
        assert!(place.lock().unwrap().is_none() && !place.events().exists());
        drop(held);
        // A process that another test starts at this moment has the lock too until it has become that program.
        let is_free = || place.lock().unwrap().is_some();
        let until = std::time::Instant::now() + std::time::Duration::from_secs(10);
        while !is_free() {
            assert!(std::time::Instant::now() < until, "the lock was not let go of");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }
}
