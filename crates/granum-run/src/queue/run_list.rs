//! The file in the folder of several runs, from which they can be continued.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use granum_io::case::Vocabulary;
use granum_io::sealed::{unseal_strictly, write_sealed};
use granum_io::shell::ShowPath;
use granum_io::{Case, Error, Reading, RunSource, run};
use serde::{Deserialize, Serialize};

use super::queue_error::QueueError;
use granum_io::run::RunKind;

use super::queued_run::QueuedRun;
use super::runner::Queue;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::source::Source;

/// Name of the file.
pub const RUN_LIST: &str = "runs.json";
/// Layout of the file.
const FORMAT: u32 = 1;
/// A larger file is something else.
const LARGEST: u64 = 1 << 30;

/// The runs that belong to a folder, with all that determines them: cases, samples, names. Their folders are inside that folder.
///
/// ```
/// use granum_io::Case;
/// use granum_io::case::Vocabulary;
/// use granum_run::Source;
/// use granum_run::queue::{Queue, QueuedRun, RunList};
///
/// let base = tempfile::tempdir()?;
/// let queue = Queue::new(vec![QueuedRun::test("a", Case::default(), Source::Case, base.path().join("a"))])?;
/// RunList::from_queue(&queue, base.path())?.write(base.path())?;
/// let read = RunList::read(base.path())?.expect("it was written");
/// assert_eq!(read.queue(base.path(), &Vocabulary::standard())?, queue);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunList {
    format: u32,
    /// The version that wrote it, by which a folder without its lock file is known as granum's.
    #[serde(default)]
    granum_version: String,
    runs: Vec<Listed>,
}

/// A run in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Listed {
    name: String,
    kind: RunKind,
    /// Folder, relative to that of the list.
    folder: PathBuf,
    /// The keys by which it differs, with their values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    values: Vec<(String, String)>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    after: Option<String>,
    source: RunSource,
    /// The resolved case file.
    case: String,
}

impl RunList {
    /// The runs of a queue whose folders are inside `folder`.
    ///
    /// # Errors
    /// If a packing cannot be read.
    pub fn from_queue(queue: &Queue, folder: &Path) -> Result<RunList, LaboratoryError> {
        let listed = |run: &QueuedRun| -> Result<Listed, LaboratoryError> {
            Ok(Listed {
                name: run.name.clone(),
                kind: run.kind,
                folder: inside(&run.folder, folder),
                values: run.values.clone(),
                after: run.after.clone(),
                source: match &run.source {
                    // The folder of all runs may be moved.
                    Source::Folder(path) if run.after.is_some() => RunSource::Sample(inside(path, folder)),
                    source => source.record()?.relative_to(folder)?,
                },
                case: run.case.resolved_toml(),
            })
        };
        let runs = queue.runs().iter().map(listed).collect::<Result<_, _>>()?;
        Ok(RunList { format: FORMAT, granum_version: env!("CARGO_PKG_VERSION").to_owned(), runs })
    }

    /// Reads the list of a folder; `None` if it has none.
    ///
    /// # Errors
    /// If the file cannot be read, is no regular file, is damaged or of a newer version.
    pub fn read(folder: &Path) -> granum_io::Result<Option<RunList>> {
        let path = folder.join(RUN_LIST);
        if !granum_io::is_there(&path)? {
            return Ok(None);
        }
        let size = std::fs::metadata(&path).map_or(0, |file| file.len());
        if size > LARGEST {
            return Err(Error::content(&path, "is too large for a list of runs"));
        }
        let text = granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT)
            .map_err(Error::file("read", &path))?;
        let text = unseal_strictly(&path, &text)?;
        let damaged = |why: String| Error::content(&path, format!("is no list of runs or is damaged: {why}"));
        let list: RunList = serde_json::from_str(&text).map_err(|error| damaged(error.to_string()))?;
        if list.format != FORMAT {
            return Err(damaged(format!("its format is {}, and this version reads {FORMAT}", list.format)));
        }
        let within = |path: &Path| {
            path.components().all(|part| matches!(part, std::path::Component::Normal(_)))
                && path != Path::new("")
        };
        match list.runs.iter().find(|run| !within(&run.folder)) {
            Some(run) => Err(damaged(format!("the folder {:?} is not inside", run.folder.shown()))),
            None => Ok(Some(list)),
        }
    }

    /// Writes the list under a temporary name and renames it.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn write(&self, folder: &Path) -> granum_io::Result<()> {
        write_sealed(&folder.join(RUN_LIST), self)
    }

    /// Adds the runs of an earlier list that are not in this one.
    pub fn with_earlier(mut self, earlier: RunList) -> RunList {
        let names: BTreeSet<String> = self.runs.iter().map(|run| run.name.clone()).collect();
        let folders: BTreeSet<PathBuf> = self.runs.iter().map(|run| run.folder.clone()).collect();
        let is_new = |run: &Listed| !names.contains(&run.name) && !folders.contains(&run.folder);
        self.runs.extend(earlier.runs.into_iter().filter(is_new));
        self
    }

    /// The folders of the runs inside that of the list, with their names. Samples are left out.
    pub fn tests<'a>(&'a self, folder: &'a Path) -> impl Iterator<Item = (&'a str, PathBuf)> {
        let samples: BTreeSet<&str> = self.runs.iter().filter_map(|run| run.after.as_deref()).collect();
        let tests = self.runs.iter().filter(move |run| !samples.contains(run.name.as_str()));
        tests.map(move |run| (run.name.as_str(), folder.join(&run.folder)))
    }

    /// The folders of all runs, with their names.
    pub fn folders<'a>(&'a self, folder: &'a Path) -> impl Iterator<Item = (&'a str, PathBuf)> {
        self.runs.iter().map(move |run| (run.name.as_str(), folder.join(&run.folder)))
    }

    /// The runs as a queue in the folder of the list; their cases can name the laws, paths and sensors of the vocabulary.
    ///
    /// # Errors
    /// If a case cannot be read, a packing has changed, or the runs contradict each other.
    pub fn queue(&self, folder: &Path, vocabulary: &Vocabulary) -> Result<Queue, QueueError> {
        let reading = || Reading::default().with_vocabulary(vocabulary);
        let file = folder.join(RUN_LIST);
        let planned = |run: &Listed| -> Result<QueuedRun, QueueError> {
            let in_run = |error| QueueError::Run { run: run.name.clone(), source: Box::new(error) };
            let name = format!("{} (case of {})", file.shown(), run.name);
            let source = match (&run.source, run.source.in_folder(folder, None)) {
                (RunSource::Sample(path), _) if run.after.is_some() => Source::Folder(folder.join(path)),
                (_, RunSource::Packing { file, sha256 }) if run::file_digest(&file)? != sha256 => {
                    return Err(Error::content(&file, "was changed since the runs were planned").into());
                }
                (_, source) => Source::recorded(&source).map_err(in_run)?,
            };
            Ok(QueuedRun {
                name: run.name.clone(),
                kind: run.kind,
                case: Case::parse_as(&run.case, &name, reading())?,
                source,
                folder: folder.join(&run.folder),
                values: run.values.clone(),
                after: run.after.clone(),
            })
        };
        Queue::new(self.runs.iter().map(planned).collect::<Result<_, _>>()?)
    }
}

/// A path relative to a folder, if it is inside.
fn inside(path: &Path, folder: &Path) -> PathBuf {
    path.strip_prefix(folder).unwrap_or(path).to_path_buf()
}
