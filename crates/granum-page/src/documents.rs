//! What was made last of folders, for as long as their files stay as they are.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

/// The files by which a change is noticed: each is written anew, or grows, when something new is known.
const TELLING: [&str; 10] = [
    "run.json",
    "states.jsonl",
    "series.parquet",
    "seconds.json",
    "campaign.json",
    "journal.jsonl",
    "study.json",
    "training.json",
    "worth.json",
    "summary.json",
];

type Stamp = Vec<Option<(SystemTime, u64)>>;

/// Something that was made of folders.
struct Made<T> {
    folders: Vec<PathBuf>,
    stamp: Stamp,
    value: Arc<T>,
}

/// What was made last.
pub struct Recent<T> {
    kept: Mutex<VecDeque<Made<T>>>,
    most: usize,
    /// One at a time is made: the same is asked for by several requests at once.
    making: Mutex<()>,
}

impl<T> Recent<T> {
    pub fn new(most: usize) -> Recent<T> {
        Recent { kept: Mutex::default(), most, making: Mutex::new(()) }
    }

    /// What is made of folders, made now if it is not known or their files have changed.
    pub fn get(
        &self,
        folders: &[PathBuf],
        make: impl FnOnce() -> Result<T, String>,
    ) -> Result<Arc<T>, String> {
        let _alone = lock(&self.making);
        let now = stamp(folders);
        let known = |made: &&Made<T>| made.folders == folders && made.stamp == now;
        if let Some(made) = lock(&self.kept).iter().find(known) {
            return Ok(made.value.clone());
        }
        let value = Arc::new(make()?);
        let mut kept = lock(&self.kept);
        kept.retain(|made| made.folders != folders);
        kept.push_front(Made { folders: folders.to_vec(), stamp: now, value: value.clone() });
        kept.truncate(self.most);
        Ok(value)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn stamp(folders: &[PathBuf]) -> Stamp {
    let of_file = |path: &Path| {
        let about = path.metadata().ok()?;
        Some((about.modified().ok()?, about.len()))
    };
    let files = |folder: &PathBuf| {
        let named = TELLING.map(|name| folder.join(name));
        named.into_iter().chain([folder.clone()]).map(|path| of_file(&path)).collect::<Vec<_>>()
    };
    folders.iter().flat_map(files).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_is_made_once_until_a_file_changes() {
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().to_path_buf()];
        let recent = Recent::new(1);
        let made = |value: usize| *recent.get(&folders, || Ok(value)).unwrap();
        assert_eq!([made(1), made(2)], [1, 1]);
        std::fs::write(folder.path().join("states.jsonl"), "{}\n").unwrap();
        assert_eq!([made(3), made(4)], [3, 3]);
        assert!(recent.get(&[], || Err("no".into())).is_err());
        assert_eq!(made(5), 3);
    }
}
