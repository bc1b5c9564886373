//! The search: every folder is read once, and no file is opened but those that may be surrogates.

use std::fs::{self, DirEntry};
use std::io::Read;
use std::path::Path;
use std::time::SystemTime;

use granum_campaign::CAMPAIGN_FILE;
use granum_learn::study::{PLAN_FILE, STUDY_FILE};

use super::found::{Found, Kind};

/// Depth to which folders are searched, as commands do that are given a folder of runs.
const DEPTH: usize = 6;
/// Most entries that are looked at.
const MOST_ENTRIES: usize = 3_000_000;
/// Most files whose first words are read.
const MOST_HEADS: usize = 2000;
/// Bytes of the first words of a file.
const HEAD: usize = 256;

/// The file that tells what a folder is, and what it tells.
const TELLING: [(&str, Kind); 6] = [
    (CAMPAIGN_FILE, Kind::Campaign),
    ("run.json", Kind::Run),
    ("reproduction.json", Kind::Reproduction),
    (STUDY_FILE, Kind::Study),
    (PLAN_FILE, Kind::Study),
    ("calibration.json", Kind::Calibration),
];

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    /// What is shown, in the order of the search.
    pub found: Vec<Found>,
    /// True if there was more than a search looks at.
    pub is_cut: bool,
}

/// Searches a folder. Links are not followed; the runs of a campaign belong to it and are not listed by themselves.
pub fn scan(root: &Path) -> Scan {
    let mut search = Search { scan: Scan::default(), entries: 0, heads: 0 };
    search.folder(root, DEPTH);
    search.scan
}

struct Search {
    scan: Scan,
    entries: usize,
    heads: usize,
}

impl Search {
    fn folder(&mut self, folder: &Path, depth: usize) {
        let Ok(read) = fs::read_dir(folder) else { return };
        let (mut inner, mut files): (Vec<DirEntry>, Vec<DirEntry>) = Default::default();
        for entry in read.flatten() {
            self.entries += 1;
            if self.entries > MOST_ENTRIES {
                self.scan.is_cut = true;
                return;
            }
            match entry.file_type() {
                Ok(kind) if kind.is_dir() => inner.push(entry),
                Ok(kind) if kind.is_file() => files.push(entry),
                _ => {}
            }
        }
        let file = |name: &str| files.iter().find(|file| file.file_name().to_str() == Some(name));
        let told = TELLING.iter().find_map(|(name, kind)| Some((file(name)?, *kind)));
        if let Some((file, kind)) = told {
            self.add(kind, folder, modified(file));
            // What is within a run or a campaign is shown with it.
            if [Kind::Run, Kind::Campaign, Kind::Study].contains(&kind) {
                return;
            }
        } else {
            files.sort_by_key(DirEntry::file_name);
            files.iter().for_each(|file| self.file(file));
        }
        if depth == 0 {
            self.scan.is_cut |= !inner.is_empty();
            return;
        }
        inner.sort_by_key(DirEntry::file_name);
        inner.iter().for_each(|entry| self.folder(&entry.path(), depth - 1));
    }

    /// The file of a surrogate or of a family, which tells so in its first words.
    fn file(&mut self, file: &DirEntry) {
        let path = file.path();
        if path.extension().is_none_or(|ending| ending != "json") {
            return;
        }
        self.heads += 1;
        if self.heads > MOST_HEADS {
            self.scan.is_cut = true;
            return;
        }
        let mut head = Vec::new();
        let read =
            granum_core::input::open(&path).and_then(|file| file.take(HEAD as u64).read_to_end(&mut head));
        let text = String::from_utf8_lossy(&head);
        let kind = match read.is_ok() {
            true if text.contains("\"granum surrogate\"") => Kind::Surrogate,
            true if text.contains("\"granum family model\"") => Kind::Family,
            _ => return,
        };
        self.add(kind, &path, modified(file));
    }

    fn add(&mut self, kind: Kind, place: &Path, modified: Option<SystemTime>) {
        self.scan.found.push(Found { kind, place: place.to_path_buf(), modified });
    }
}

fn modified(file: &DirEntry) -> Option<SystemTime> {
    file.metadata().and_then(|about| about.modified()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_known_by_their_files() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        let put = |path: &str, text: &str| {
            fs::create_dir_all(root.join(path).parent().unwrap()).unwrap();
            fs::write(root.join(path), text).unwrap();
        };
        put("runs/a/run.json", "{}");
        put("runs/a/snapshots/run.json", "{}");
        put("study/campaign.json", "{}");
        put("study/runs/x/run.json", "{}");
        put("models/study.json", "{}");
        put("fit/calibration.json", "{}");
        put("fit/rounds/campaign.json", "{}");
        put("own.json", "{ \"format\": \"granum surrogate\" }");
        put("sand.json", "{ \"format\": \"granum family model\" }");
        put("notes.json", "{}");
        put("1/2/3/4/5/6/7/run.json", "{}");
        let scan = scan(root);
        let found: Vec<(Kind, String)> = (scan.found.iter())
            .map(|found| (found.kind, found.place.strip_prefix(root).unwrap().to_string_lossy().into_owned()))
            .collect();
        let expected = [
            (Kind::Surrogate, "own.json"),
            (Kind::Family, "sand.json"),
            (Kind::Calibration, "fit"),
            (Kind::Campaign, "fit/rounds"),
            (Kind::Study, "models"),
            (Kind::Run, "runs/a"),
            (Kind::Campaign, "study"),
        ];
        assert_eq!(found, expected.map(|(kind, path)| (kind, path.to_string())));
        assert!(scan.is_cut);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        let [folder, other] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        fs::write(other.path().join("run.json"), "{}").unwrap();
        std::os::unix::fs::symlink(other.path(), folder.path().join("a")).unwrap();
        std::os::unix::fs::symlink(folder.path(), folder.path().join("b")).unwrap();
        assert_eq!(scan(folder.path()), Scan::default());
    }
}
