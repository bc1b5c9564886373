//! The lock of a folder, by which one process alone works in it.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::Path;
use std::time::Duration;

use super::process::in_words;
use crate::error::{Error, Result};

/// Longest content of a lock file: a process id.
const LONGEST_LOCK: u64 = 32;
/// How often, and how long each time, a process that finds a folder locked waits for the process id of the holder.
const WAITS: (usize, Duration) = (50, Duration::from_millis(4));

/// Marks a folder as granum's and carries the advisory lock. The file remains when the lock is released: if it were removed,
/// two processes could hold locks on two different files of that name.
pub(crate) const LOCK: &str = ".granum-lock";

/// Takes the lock of a folder until the file is closed, notes this process as the holder, and then calls `tidy`.
///
/// # Errors
/// [`Error::Locked`] if another process has it, [`Error::Content`] if there is another file of its name, [`Error::File`].
pub(super) fn take(path: &Path, tidy: impl FnOnce(&Path) -> io::Result<()>) -> Result<File> {
    let name = path.join(LOCK);
    if fs::symlink_metadata(&name).is_ok() && !is_lock(&name) {
        return Err(Error::content(&name, "is not a lock file of granum; choose another folder"));
    }
    let mut file = OpenOptions::new()
        .create(true)
        .truncate(false)
        .read(true)
        .write(true)
        .open(&name)
        .map_err(Error::file("write", &name))?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            return Err(Error::Locked { path: path.to_path_buf(), holder: holder(&mut file) });
        }
        // Some network file systems have no locks. Who works there is known by other means where several may
        // (`granum-campaign/src/claim/mod.rs`), and a single user is not kept from working.
        Err(TryLockError::Error(source)) if has_no_locks(&source) => {}
        Err(TryLockError::Error(source)) => return Err(Error::file("lock", &name)(source)),
    }
    // The process id of the holder is only for messages; the lock itself is that of the operating system.
    let note = || -> io::Result<()> {
        file.set_len(0)?;
        file.rewind()?;
        writeln!(file, "{}", std::process::id())?;
        tidy(path)
    };
    note().map_err(Error::file("write", &name))?;
    Ok(file)
}

/// True for a lock file as written by granum; a link, or a file with any other content, does not count as one and would
/// otherwise be lost.
pub(super) fn is_lock(name: &Path) -> bool {
    let whole = |kind: fs::Metadata| kind.is_file() && kind.len() <= LONGEST_LOCK;
    fs::symlink_metadata(name).is_ok_and(whole)
        && fs::read(name).is_ok_and(|text| text.iter().all(|b| b.is_ascii_digit() || *b == b'\n'))
}

/// True if a file system answers that it has no locks: `ENOSYS`, `ENOTSUP`, or on Linux `ENOLCK`, as NFS without its lock service does.
pub(super) fn has_no_locks(error: &io::Error) -> bool {
    const NO_LOCKS: i32 = 37;
    error.kind() == io::ErrorKind::Unsupported
        || (cfg!(target_os = "linux") && error.raw_os_error() == Some(NO_LOCKS))
}

/// " (process 4711)", if the lock file contains a process id.
fn holder(file: &mut File) -> String {
    for _ in 0..WAITS.0 {
        // The holder writes its id just after it has got the lock.
        std::thread::sleep(WAITS.1);
        let mut text = String::new();
        let read = file.rewind().and_then(|()| file.take(32).read_to_string(&mut text));
        if let (Ok(_), Ok(process)) = (read, text.trim().parse::<u32>()) {
            return format!(" ({})", in_words(process));
        }
    }
    String::new()
}
