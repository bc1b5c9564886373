//! Output folders: nothing is replaced unless requested, and only one process at a time works in a folder.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::aside;
use crate::atomic::{UNFINISHED, remove_unfinished};
use crate::error::{Error, Result};

/// Largest length of a name that may come from a file.
const LONGEST_NAME: usize = 100;
const LINK: &str =
    "is a symbolic link; output must stay in its folder, so replace it by a folder or remove it";
/// Longest content of a lock file: a process id.
const LONGEST_LOCK: u64 = 32;
/// Files by one of which a folder is known as granum's if its lock file was not copied with it.
const RECORDS: [&str; 6] =
    ["run.json", "runs.json", "campaign.json", "training.json", "study.json", "reproduction.json"];
/// Largest of them that is looked into.
const LARGEST_RECORD: u64 = 1 << 24;
/// How often, and how long each time, a process that finds a folder locked waits for the process id of the holder.
const WAITS: (usize, Duration) = (50, Duration::from_millis(4));

/// Marks a folder as granum's and carries the advisory lock. The file remains when the lock is released: if it were removed,
/// two processes could hold locks on two different files of that name.
pub(crate) const LOCK: &str = ".granum-lock";

/// A folder that is used by this process alone, until the value is dropped.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Holds the lock as long as it is open.
    _lock: File,
}

impl OutputFolder {
    /// Creates a folder, or takes over an empty one. With `force`, a folder that granum wrote before is also accepted; its
    /// content remains until [`OutputFolder::clear`] is called or a file of the same name is written.
    ///
    /// # Errors
    /// [`Error::Content`] if it contains files that are not granum's; [`Error::Exists`] if it is granum's and `force` is not
    /// set; [`Error::Locked`] if another process is using it; [`Error::File`] if it cannot be created.
    pub fn create(path: impl AsRef<Path>, force: bool) -> Result<OutputFolder> {
        let path = path.as_ref();
        if force {
            refuse_link(path)?;
        }
        fs::create_dir_all(path).map_err(Error::file("create the folder", path))?;
        // Checked before there is a lock file, so that a foreign folder is left unchanged.
        let granum = is_granums(path);
        if !granum && !is_empty(path)? {
            return Err(Error::content(
                path,
                "contains files that granum did not write; choose another folder",
            ));
        }
        let folder = OutputFolder::lock(path)?;
        if !force && !is_empty(path)? {
            return Err(Error::Exists(path.to_path_buf()));
        }
        Ok(folder)
    }

    /// Opens a folder that granum wrote before, to continue in it.
    ///
    /// # Errors
    /// [`Error::Content`] if it is not granum's; [`Error::Locked`] if another process is using it.
    pub fn open(path: impl AsRef<Path>) -> Result<OutputFolder> {
        let path = path.as_ref();
        if !path.is_dir() {
            return Err(Error::content(path, "there is no such folder"));
        }
        if !is_granums(path) {
            let message = format!(
                "is not a folder that granum wrote: it has neither {LOCK} nor one of {} that can be read; copy folders with all \
                 of their files",
                RECORDS.join(", ")
            );
            return Err(Error::content(path, message));
        }
        OutputFolder::lock(path)
    }

    /// True if the folder is free: it does not exist, or contains nothing except what a process left that was killed at its
    /// start.
    pub fn is_free(path: impl AsRef<Path>) -> bool {
        let path = path.as_ref();
        !path.is_dir() || is_empty(path).unwrap_or(false)
    }

    /// True if the folder was written by granum.
    pub fn is_granums(path: impl AsRef<Path>) -> bool {
        is_granums(path.as_ref())
    }

    /// True if a process is using the folder; nothing is created or changed.
    pub fn is_in_use(path: impl AsRef<Path>) -> bool {
        let name = path.as_ref().join(LOCK);
        let held = |file: File| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
        is_lock(&name) && File::open(name).is_ok_and(held)
    }

    /// Opens a folder of granum's to continue in it, or creates it.
    ///
    /// # Errors
    /// As for [`OutputFolder::open`] and [`OutputFolder::create`].
    pub fn open_or_create(path: impl AsRef<Path>) -> Result<OutputFolder> {
        let path = path.as_ref();
        if is_granums(path) { OutputFolder::open(path) } else { OutputFolder::create(path, false) }
    }

    fn lock(path: &Path) -> Result<OutputFolder> {
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
        let mut note = || -> std::io::Result<()> {
            file.set_len(0)?;
            file.rewind()?;
            writeln!(file, "{}", std::process::id())?;
            remove_unfinished(path)
        };
        note().map_err(Error::file("write", &name))?;
        aside::recover(path)?;
        Ok(OutputFolder { path: path.to_path_buf(), _lock: file })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Creates a folder inside.
    ///
    /// # Errors
    /// As for [`inner_folder`].
    pub fn subfolder(&self, name: &str) -> Result<PathBuf> {
        inner_folder(&self.path, name)
    }

    /// Rejects a folder that contains links in place of its inner folders: files written there would end up elsewhere.
    ///
    /// # Errors
    /// [`Error::Content`] with the name of the link.
    pub fn refuse_links(&self, names: &[&str]) -> Result<()> {
        let link = |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|kind| kind.is_symlink());
        match names.iter().map(|name| self.path.join(name)).find(link) {
            Some(path) => Err(Error::content(&path, LINK)),
            None => Ok(()),
        }
    }

    /// Replaces files of these names (relative, inner folders included) by what `write` writes: the old ones are moved out of the
    /// way, and go once `write` has succeeded. If one of them cannot be moved, if `write` fails, or if the process is killed, the
    /// old files are where they were, in the last case from the next time on that the folder is opened.
    ///
    /// # Errors
    /// [`Error::File`] if a file cannot be moved, and the errors of `write`.
    pub fn replace<T, E: From<Error>>(
        &self,
        names: &[String],
        write: impl FnOnce() -> std::result::Result<T, E>,
    ) -> std::result::Result<T, E> {
        aside::set_aside(&self.path, names)?;
        match write() {
            Ok(written) => {
                aside::settle(&self.path)?;
                Ok(written)
            }
            Err(error) => {
                aside::recover(&self.path)?;
                Err(error)
            }
        }
    }

    /// Removes files and folders of these names, if they exist. Links are removed, not followed.
    ///
    /// # Errors
    /// [`Error::File`] if one cannot be removed.
    pub fn clear(&self, names: &[&str]) -> Result<()> {
        for name in names {
            let path = self.path.join(name);
            let Ok(kind) = fs::symlink_metadata(&path) else { continue };
            let removed = if kind.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            removed.map_err(Error::file("remove", &path))?;
        }
        Ok(())
    }

    /// Removes temporary files that a killed process left in an inner folder.
    ///
    /// # Errors
    /// [`Error::File`] if one cannot be removed.
    pub fn remove_unfinished_inside(&self, name: &str) -> Result<()> {
        let path = self.path.join(name);
        if !fs::symlink_metadata(&path).is_ok_and(|kind| kind.is_dir()) {
            return Ok(());
        }
        remove_unfinished(&path).map_err(Error::file("tidy", &path))
    }

    /// Removes the files of these names from an inner folder, with what a killed process left there, and the folder if it is then
    /// empty. Folders, and a link in its place, are left alone.
    ///
    /// # Errors
    /// [`Error::File`] if one cannot be removed.
    pub fn clear_inside(&self, name: &str, files: &[String]) -> Result<()> {
        let path = self.path.join(name);
        if !fs::symlink_metadata(&path).is_ok_and(|kind| kind.is_dir()) {
            return Ok(());
        }
        self.remove_unfinished_inside(name)?;
        for file in files.iter().map(|file| path.join(file)) {
            if fs::symlink_metadata(&file).is_ok_and(|kind| !kind.is_dir()) {
                fs::remove_file(&file).map_err(Error::file("remove", &file))?;
            }
        }
        let is_empty = fs::read_dir(&path).map_err(Error::file("read", &path))?.next().is_none();
        if is_empty { fs::remove_dir(&path).map_err(Error::file("remove", &path)) } else { Ok(()) }
    }
}

/// Rejects a name that was read from a file and is to become part of a path, unless it is a plain word of ASCII letters,
/// digits, `-` and `_`: what is written, renamed or removed under this name must be in the intended folder.
///
/// # Errors
/// [`Error::Value`].
pub fn check_name(what: &str, name: &str) -> Result<()> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if !name.is_empty() && name.len() <= LONGEST_NAME && name.chars().all(plain) {
        return Ok(());
    }
    let message = format!("cannot be part of a file name; use up to {LONGEST_NAME} letters, digits, - and _");
    Err(Error::Value { name: what.into(), value: name.into(), message })
}

/// A folder inside an output folder, created if it does not exist. A link in its place could lead anywhere and is rejected.
///
/// # Errors
/// [`Error::Value`] if the name is not a plain word, [`Error::Content`] if there is a link or a file of that name,
/// [`Error::File`] if it cannot be created.
pub fn inner_folder(folder: &Path, name: &str) -> Result<PathBuf> {
    check_name("folder", name)?;
    let path = folder.join(name);
    match fs::symlink_metadata(&path) {
        Ok(kind) if kind.is_dir() => {}
        Ok(kind) if kind.is_symlink() => return Err(Error::content(&path, LINK)),
        Ok(_) => return Err(Error::content(&path, "is a file where a folder is needed; remove it")),
        Err(_) => fs::create_dir_all(&path).map_err(Error::file("create the folder", &path))?,
    }
    Ok(path)
}

/// True if granum wrote the folder: it has the lock file, or one of granum's records where the lock file was not copied with the
/// other files. A lock file that is a link or anything else does not count.
fn is_granums(path: &Path) -> bool {
    let lock = path.join(LOCK);
    is_lock(&lock)
        || (fs::symlink_metadata(&lock).is_err() && RECORDS.iter().any(|name| is_record(&path.join(name))))
}

/// True for a file that names granum as its writer.
fn is_record(path: &Path) -> bool {
    if !fs::symlink_metadata(path).is_ok_and(|kind| kind.is_file()) {
        return false;
    }
    let text = crate::text::read_small(path, LARGEST_RECORD).unwrap_or_default();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let format = value["format"].as_str().is_some_and(|format| format.starts_with("granum "));
    format || value["granum_version"].is_string()
}

/// Refuses to replace the content of a folder through a link, which may point anywhere.
fn refuse_link(path: &Path) -> Result<()> {
    // Without the slash at the end that would make the system follow the link.
    let own: PathBuf = path.components().collect();
    if fs::symlink_metadata(&own).is_ok_and(|kind| kind.is_symlink()) {
        let message =
            "is a symbolic link, which --force does not follow; name the folder itself, or another one";
        return Err(Error::content(path, message));
    }
    Ok(())
}

/// True for a lock file as written by granum; a link, or a file with any other content, does not count as one and would
/// otherwise be lost.
fn is_lock(name: &Path) -> bool {
    let whole = |kind: fs::Metadata| kind.is_file() && kind.len() <= LONGEST_LOCK;
    fs::symlink_metadata(name).is_ok_and(whole)
        && fs::read(name).is_ok_and(|text| text.iter().all(|b| b.is_ascii_digit() || *b == b'\n'))
}

/// Refuses to replace an output file unless `force` is set.
///
/// # Errors
/// [`Error::Exists`], or [`Error::Content`] if it is a folder.
pub fn check_output_file(path: impl AsRef<Path>, force: bool) -> Result<()> {
    let path = path.as_ref();
    if path.is_dir() {
        return Err(Error::content(path, "is a folder; the output must be a file"));
    }
    if !force && path.exists() {
        return Err(Error::Exists(path.to_path_buf()));
    }
    Ok(())
}

/// True if the folder contains nothing except the lock and leftovers of a killed process.
fn is_empty(path: &Path) -> Result<bool> {
    for entry in fs::read_dir(path).map_err(Error::file("read", path))? {
        let name = entry.map_err(Error::file("read", path))?.file_name();
        let name = name.to_string_lossy();
        if name != LOCK && name != aside::GOING && !name.ends_with(UNFINISHED) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// True if a file system answers that it has no locks: `ENOSYS`, `ENOTSUP`, or on Linux `ENOLCK`, as NFS without its lock service does.
fn has_no_locks(error: &std::io::Error) -> bool {
    const NO_LOCKS: i32 = 37;
    error.kind() == std::io::ErrorKind::Unsupported
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
            return format!(" (process {process})");
        }
    }
    String::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn file_systems_without_locks_are_known_by_their_answer() {
        // ENOLCK, ENOSYS, EOPNOTSUPP; EIO and EINTR are errors.
        let known = [37, 38, 95, 5, 4].map(|code| has_no_locks(&std::io::Error::from_raw_os_error(code)));
        assert_eq!(known, [true, true, true, false, false]);
    }

    #[test]
    fn a_new_or_empty_folder_is_taken_and_a_second_user_refused() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("deep").join("run");
        let folder = OutputFolder::create(&path, false).unwrap();
        let error = OutputFolder::create(&path, true).unwrap_err().to_string();
        let process = std::process::id();
        assert!(
            error.contains(&format!("run is in use by another granum process (process {process})")),
            "{error}"
        );
        assert!(matches!(OutputFolder::open(&path), Err(Error::Locked { .. })));
        drop(folder);
        OutputFolder::open(&path).unwrap();
    }

    #[test]
    fn what_is_there_is_replaced_only_with_force() {
        let base = tempfile::tempdir().unwrap();
        let folder = OutputFolder::create(base.path().join("run"), false).unwrap();
        fs::write(folder.file("run.json"), "{}").unwrap();
        let path = folder.path().to_path_buf();
        drop(folder);
        let error = OutputFolder::create(&path, false).unwrap_err().to_string();
        assert!(error.contains("run exists already; give --force to replace it"), "{error}");
        let folder = OutputFolder::create(&path, true).unwrap();
        assert!(folder.file("run.json").exists());
        folder.clear(&["run.json", "snapshots"]).unwrap();
        assert!(!folder.file("run.json").exists());
    }

    #[test]
    fn a_foreign_folder_stays_as_it_is_even_with_force() {
        let base = tempfile::tempdir().unwrap();
        fs::write(base.path().join("thesis.tex"), "mine").unwrap();
        for force in [false, true] {
            let error = OutputFolder::create(base.path(), force).unwrap_err().to_string();
            assert!(error.contains("contains files that granum did not write"), "{error}");
        }
        assert!(!OutputFolder::is_free(base.path()) && !OutputFolder::is_granums(base.path()));
        assert!(OutputFolder::open(base.path()).is_err());
        assert!(OutputFolder::open_or_create(base.path()).is_err());
        assert_eq!(fs::read_dir(base.path()).unwrap().count(), 1);
    }

    #[test]
    fn names_from_files_are_plain_words() {
        for name in ["end", "F1-strain-only", "a_B-9"] {
            check_name("snapshot", name).unwrap();
        }
        for name in
            ["", ".", "..", "../x", "/x", "a/b", "a\\b", "C:", "a.json", "\0", "grün", &"x".repeat(101)]
        {
            let message = check_name("snapshot", name).unwrap_err().to_string();
            assert!(
                message.contains("snapshot = ") && message.contains("cannot be part of a file name"),
                "{message}"
            );
        }
    }

    #[test]
    fn a_process_at_work_is_seen_without_a_trace() {
        let base = tempfile::tempdir().unwrap();
        assert!(!OutputFolder::is_in_use(base.path()));
        let folder = OutputFolder::create(base.path(), false).unwrap();
        assert!(OutputFolder::is_in_use(base.path()));
        drop(folder);
        assert!(!OutputFolder::is_in_use(base.path()));
        assert_eq!(fs::read_dir(base.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_and_strange_locks_lead_nowhere() {
        let base = tempfile::tempdir().unwrap();
        let (outside, path) = (base.path().join("outside"), base.path().join("run"));
        fs::create_dir(&outside).unwrap();
        let folder = OutputFolder::create(&path, false).unwrap();
        std::os::unix::fs::symlink(&outside, path.join("snapshots")).unwrap();
        let message = folder.subfolder("snapshots").unwrap_err().to_string();
        assert!(message.contains("snapshots: is a symbolic link"), "{message}");
        drop(folder);
        fs::write(outside.join("thesis"), "mine").unwrap();
        fs::remove_file(path.join(LOCK)).unwrap();
        std::os::unix::fs::symlink(outside.join("thesis"), path.join(LOCK)).unwrap();
        assert!(OutputFolder::open(&path).is_err() && OutputFolder::create(&path, true).is_err());
        fs::remove_file(path.join(LOCK)).unwrap();
        fs::hard_link(outside.join("thesis"), path.join(LOCK)).unwrap();
        assert!(OutputFolder::open(&path).is_err() && OutputFolder::create(&path, true).is_err());
        assert_eq!(fs::read(outside.join("thesis")).unwrap(), b"mine");
    }

    #[test]
    fn a_folder_copied_without_its_hidden_files_is_known_by_its_record() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path();
        fs::write(path.join("run.json"), "{\"format\": 2}").unwrap();
        let message = OutputFolder::open(path).unwrap_err().to_string();
        assert!(
            message.contains("is not a folder that granum wrote") && message.contains("run.json"),
            "{message}"
        );
        assert!(OutputFolder::create(path, true).is_err() && !OutputFolder::is_granums(path));
        fs::write(path.join("run.json"), "{\"granum_version\": \"0.1.0\"}").unwrap();
        assert!(
            OutputFolder::is_granums(path)
                && matches!(OutputFolder::create(path, false), Err(Error::Exists(_)))
        );
        drop(OutputFolder::open(path).unwrap());
        fs::remove_file(path.join(LOCK)).unwrap();
        drop(OutputFolder::create(path, true).unwrap());
        assert!(path.join(LOCK).exists());
    }

    #[test]
    fn only_files_that_are_named_are_cleared_inside() {
        let base = tempfile::tempdir().unwrap();
        let folder = OutputFolder::create(base.path().join("study"), false).unwrap();
        let sizes = folder.subfolder("sizes").unwrap();
        let left = format!(".F1-1.json.1-0{UNFINISHED}");
        let written = ["F1-1.json", "F1-1.unfinished", "F1-2.json", "absent.json"].map(String::from);
        for name in ["F1-1.json", "F1-1.unfinished", &left, "my.json", "my.unfinished"] {
            fs::write(sizes.join(name), "x").unwrap();
        }
        fs::create_dir(sizes.join("F1-2.json")).unwrap();
        folder.clear_inside("sizes", &written).unwrap();
        let mut names: Vec<String> = fs::read_dir(&sizes)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        assert_eq!(names, ["F1-2.json", "my.json", "my.unfinished"]);
        for name in ["my.json", "my.unfinished"] {
            fs::remove_file(sizes.join(name)).unwrap();
        }
        fs::remove_dir(sizes.join("F1-2.json")).unwrap();
        folder.clear_inside("sizes", &written).unwrap();
        assert!(!sizes.exists());
    }

    #[cfg(unix)]
    #[test]
    fn force_does_not_follow_a_link() {
        let base = tempfile::tempdir().unwrap();
        let (real, link) = (base.path().join("real"), base.path().join("link"));
        drop(OutputFolder::create(&real, false).unwrap());
        std::os::unix::fs::symlink(&real, &link).unwrap();
        for path in [link.clone(), base.path().join("link/")] {
            let message = OutputFolder::create(&path, true).unwrap_err().to_string();
            assert!(message.contains("is a symbolic link, which --force does not follow"), "{message}");
        }
        drop(OutputFolder::create(&link, false).unwrap());
        drop(OutputFolder::create(&real, true).unwrap());
    }

    #[test]
    fn leftovers_of_a_killed_process_do_not_count() {
        let base = tempfile::tempdir().unwrap();
        drop(OutputFolder::create(base.path(), false).unwrap());
        let left = base.path().join(format!(".run.json.1-0{UNFINISHED}"));
        fs::write(&left, "half").unwrap();
        OutputFolder::create(base.path(), false).unwrap();
        assert!(!left.exists());
    }

    #[test]
    fn output_files_need_force_too() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().join("out.csv");
        check_output_file(&path, false).unwrap();
        fs::write(&path, "x").unwrap();
        assert!(check_output_file(&path, false).is_err());
        check_output_file(&path, true).unwrap();
        assert!(check_output_file(base.path(), true).unwrap_err().to_string().contains("is a folder"));
    }
}
