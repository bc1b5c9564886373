//! The contents of a folder, and the command line that continues from it. All commands use this module.

use granum_io::RunKind;

use std::path::{Path, PathBuf};

use granum_io::case::Vocabulary;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_io::{OutputFolder, Run, RunRecord, RunStatus};

use granum_antony2006::reproduction::{RUNS, Reproduction, SUMMARY_FILE};
use granum_campaign::Campaign;
use granum_learn::study::{PLAN_FILE, STUDY_FILE};
use granum_learn::{LearnError, Result};
use granum_run::laboratory::{CHECKPOINT, PREVIOUS_CHECKPOINT};
use granum_run::queue::RunList;

/// The page of a report.
const REPORT_FILE: &str = "report.html";

/// The purpose of a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FolderKind {
    /// A sample or a test, whose record does not say which.
    Run,
    /// A sample.
    Sample,
    /// A test.
    Test,
    /// A training.
    Training,
    /// A reproduction of the paper.
    Reproduction,
    /// Several runs.
    Runs,
    /// The runs of a plan.
    Campaign,
}

impl FolderKind {
    /// Description with an article.
    pub fn name(self) -> &'static str {
        match self {
            FolderKind::Run => "a sample or test",
            FolderKind::Sample => "a sample",
            FolderKind::Test => "a test",
            FolderKind::Training => "a training",
            FolderKind::Reproduction => "a reproduction",
            FolderKind::Runs => "several runs",
            FolderKind::Campaign => "a campaign",
        }
    }
}

/// The contents of a folder.
///
/// ```
/// use granum::contents::Contents;
/// use granum_io::case::Vocabulary;
///
/// let nowhere = std::path::Path::new("there is no such folder");
/// assert_eq!(Contents::read(nowhere, &Vocabulary::standard())?.name(), "nothing");
/// # Ok::<(), granum_learn::LearnError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Contents {
    /// The folder does not exist or is empty.
    Nothing,
    /// The folder contains files of another kind.
    Other,
    /// A sample or a test, with its record if it can be read.
    Run(Option<Box<RunRecord>>),
    /// Networks.
    Training {
        /// True if all networks have been trained.
        finished: bool,
    },
    /// A reproduction.
    Reproduction {
        /// Its description; `None` if it was created by an earlier version, which did not write one.
        of: Option<Reproduction>,
        /// True if all runs are finished and the summary has been written.
        finished: bool,
    },
    /// Several runs that belong together.
    Runs {
        /// Their list.
        list: RunList,
        /// True if all runs are finished.
        finished: bool,
    },
    /// The runs of a plan.
    Campaign(Box<Campaign>),
}

/// The next action for a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Next {
    /// A sentence for the user, including the command line.
    pub text: String,
    /// The command line that continues from the folder, if there is one.
    pub command: Option<String>,
}

impl Next {
    fn new(what: &str, command: String) -> Next {
        Next { text: format!("{what}: {command}"), command: Some(command) }
    }

    fn only(text: impl Into<String>) -> Next {
        Next { text: text.into(), command: None }
    }
}

impl Contents {
    /// Determines the contents of a folder, whose cases can name these laws, paths and sensors, without locking or changing anything.
    ///
    /// # Errors
    /// If the description of a reproduction or a list of runs cannot be read, or a folder, a pipe, a device or a broken link is in the
    /// place of the file that tells what the folder is.
    pub fn read(folder: &Path, vocabulary: &Vocabulary) -> Result<Contents> {
        let has = |name: &str| folder.join(name).is_file();
        if let Some(campaign) = Campaign::read(folder, vocabulary).map_err(LearnError::from)? {
            return Ok(Contents::Campaign(Box::new(campaign)));
        }
        let of = Reproduction::read(folder)?;
        let unsaid = || OutputFolder::is_granums(folder) && is_real_folder(&folder.join(RUNS));
        if of.is_some() || (!has("run.json") && !has(PLAN_FILE) && unsaid()) {
            let finished =
                granum_io::is_there(&folder.join(SUMMARY_FILE))? && runs_are_finished(folder, of.as_ref());
            return Ok(Contents::Reproduction { of, finished });
        }
        if let Some(list) = RunList::read(folder).map_err(LearnError::from)? {
            let finished = list.tests(folder).all(|(_, run)| run_is_finished(&run));
            return Ok(Contents::Runs { list, finished });
        }
        let [planned, finished] = [PLAN_FILE, STUDY_FILE].map(|name| granum_io::is_there(&folder.join(name)));
        let (planned, finished) = (planned?, finished?);
        if planned || finished {
            return Ok(Contents::Training { finished });
        }
        if has("run.json") {
            let record = Run::at(folder).and_then(|run| run.record()).ok();
            return Ok(Contents::Run(record.map(Box::new)));
        }
        Ok(if OutputFolder::is_free(folder) { Contents::Nothing } else { Contents::Other })
    }

    /// The purpose of the folder, if it was written by granum.
    pub fn kind(&self) -> Option<FolderKind> {
        match self {
            Contents::Nothing | Contents::Other => None,
            Contents::Run(None) => Some(FolderKind::Run),
            Contents::Run(Some(record)) if record.kind == RunKind::Sample => Some(FolderKind::Sample),
            Contents::Run(Some(_)) => Some(FolderKind::Test),
            Contents::Training { .. } => Some(FolderKind::Training),
            Contents::Reproduction { .. } => Some(FolderKind::Reproduction),
            Contents::Runs { .. } => Some(FolderKind::Runs),
            Contents::Campaign(_) => Some(FolderKind::Campaign),
        }
    }

    /// A description such as "an interrupted test".
    pub fn name(&self) -> String {
        let ended = |finished: bool| if finished { "a finished" } else { "an unfinished" };
        match self {
            Contents::Nothing => "nothing".into(),
            Contents::Other => "files that granum did not write".into(),
            Contents::Run(None) => "a sample or test whose run.json cannot be read".into(),
            Contents::Run(Some(record)) => {
                let word = match record.status {
                    RunStatus::Running => "a killed",
                    RunStatus::Interrupted => "an interrupted",
                    RunStatus::Finished => "a finished",
                    RunStatus::Failed => "a failed",
                };
                format!(
                    "{word} {}",
                    if record.kind == RunKind::Sample { "preparation of a sample" } else { "test" }
                )
            }
            Contents::Training { finished } => format!("{} training", ended(*finished)),
            Contents::Reproduction { finished, .. } => format!("{} reproduction", ended(*finished)),
            Contents::Runs { list, finished } => {
                format!("{} list of {} runs", ended(*finished), list.tests(Path::new("")).count())
            }
            Contents::Campaign(campaign) => format!("a campaign of {} runs", campaign.runs().len()),
        }
    }

    /// The folders of the runs of a reproduction or a list, some of which may not exist yet. Links are omitted.
    pub fn runs(&self, folder: &Path) -> Vec<PathBuf> {
        let is_link = |path: &Path| std::fs::symlink_metadata(path).is_ok_and(|kind| kind.is_symlink());
        let of = match self {
            Contents::Reproduction { of, .. } => of,
            Contents::Campaign(campaign) => {
                return campaign.runs().iter().map(|run| campaign.folder_of(&run.name)).collect();
            }
            Contents::Runs { list, .. } => {
                let folders = list.folders(folder).map(|(_, path)| path);
                return folders.filter(|path| !is_link(path)).collect();
            }
            _ => return Vec::new(),
        };
        let mut folders = runs_of(folder, of.as_ref());
        folders.retain(|path| !is_link(path) && !is_link(&folder.join(RUNS)));
        folders
    }

    /// The next action for the folder with these contents.
    pub fn next(&self, folder: &Path) -> Next {
        let name = quoted_path(folder);
        if OutputFolder::is_in_use(folder) {
            return Next::only("another process is using it; wait");
        }
        let resume = || format!("granum resume {name}");
        match self {
            Contents::Nothing | Contents::Other => Next::only("nothing to continue"),
            Contents::Run(None) => {
                Next::only("its run.json cannot be read; run its case again, with --force")
            }
            Contents::Run(Some(record)) => next_of_run(record, folder),
            Contents::Runs { finished: true, .. } => {
                Next::new("their results in a table", format!("granum table {name}"))
            }
            Contents::Runs { .. } => Next::new("continue them", resume()),
            Contents::Campaign(_) => Next::new("see how far it is", format!("granum campaign status {name}")),
            Contents::Training { finished: true } => {
                Next::new("evaluate it", format!("granum evaluate {name} RUN..."))
            }
            Contents::Training { .. } => Next::new("continue it", resume()),
            Contents::Reproduction { of: None, .. } => Next::only(
                "there is no reproduction.json with its options; reproduce in another folder, or replace it with \
                 --force",
            ),
            Contents::Reproduction { of: Some(of), finished } => {
                let line = of.options.command_line(Some(folder));
                if *finished {
                    let page = folder.join(REPORT_FILE);
                    return Next { text: format!("done; see {}", page.shown()), command: Some(line) };
                }
                if of.is_of_this_version() {
                    return Next::new("continue it", line);
                }
                Next::new(
                    &format!("it was started by granum {}; continue it with that version", of.granum_version),
                    line,
                )
            }
        }
    }
}

fn next_of_run(record: &RunRecord, folder: &Path) -> Next {
    let name = quoted_path(folder);
    let resume = format!("granum resume {name}");
    let checkpoint = [CHECKPOINT, PREVIOUS_CHECKPOINT].iter().any(|file| folder.join(file).is_file());
    match record.status {
        RunStatus::Finished if record.kind == RunKind::Sample => {
            Next::new("test it", format!("granum run CASE --sample {name}"))
        }
        RunStatus::Finished if folder.join(REPORT_FILE).is_file() => {
            let what = format!("its report is {}; write it again", folder.join(REPORT_FILE).shown());
            Next::new(&what, format!("granum report {name} --force"))
        }
        RunStatus::Finished => Next::new("write its report", format!("granum report {name}")),
        RunStatus::Failed => {
            let why = record.notes.last().map_or("it failed", String::as_str);
            Next {
                text: format!(
                    "{why}; once the cause is removed, continue it: {resume}; or change the case and run it again with \
                     --force"
                ),
                command: Some(resume),
            }
        }
        _ if checkpoint => Next::new("continue it", resume),
        _ => Next::new("there is no checkpoint yet; start again from its case", resume),
    }
}

/// Refuses a folder in which a command would replace existing results: those of its own kind unless `force` is set, and
/// those of another kind in any case. A folder that is in use by a process is protected by its lock instead.
///
/// # Errors
/// [`LearnError::Taken`] with the command line that continues from the existing results.
pub fn check_free(folder: &Path, wanted: FolderKind, force: bool, vocabulary: &Vocabulary) -> Result<()> {
    let contents = Contents::read(folder, vocabulary)?;
    let Some(kind) = contents.kind() else { return Ok(()) };
    // Where the record cannot be read, states are those of a test.
    let unknown = kind == FolderKind::Run
        && (wanted == FolderKind::Test
            || wanted == FolderKind::Sample && !folder.join("series.parquet").exists());
    let same = kind == wanted || unknown;
    if (same && force) || OutputFolder::is_in_use(folder) {
        return Ok(());
    }
    Err(taken(folder, &contents, wanted.name(), same))
}

/// The error for a folder that is refused because of its contents; `replaceable` is true if `--force` would replace them.
pub fn taken(folder: &Path, contents: &Contents, wanted: &str, replaceable: bool) -> LearnError {
    let go_on = match contents.next(folder) {
        Next { command: Some(command), .. } => {
            format!("to continue from that: `{command}`; otherwise choose")
        }
        Next { text, .. } => format!("{text}; otherwise choose"),
    };
    let replace = if replaceable {
        "another name, or give --force to replace it".to_string()
    } else {
        format!("another name for {wanted}")
    };
    LearnError::Taken {
        folder: folder.to_path_buf(),
        holds: contents.name(),
        advice: format!("{go_on} {replace}"),
    }
}

/// The existing run folders of a reproduction, sorted. Links are not followed, since they may point anywhere.
fn run_folders(folder: &Path) -> Vec<PathBuf> {
    let runs = folder.join(RUNS);
    let Some(read) = is_real_folder(&runs).then(|| std::fs::read_dir(&runs).ok()).flatten() else {
        return Vec::new();
    };
    let paths = read.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    let mut folders: Vec<PathBuf> = paths.filter(|path| is_real_folder(path)).collect();
    folders.sort();
    folders
}

/// The folders of all runs of a reproduction, including those that do not exist yet.
fn runs_of(folder: &Path, of: Option<&Reproduction>) -> Vec<PathBuf> {
    match of {
        Some(of) => of.runs.iter().map(|name| folder.join(RUNS).join(name)).collect(),
        None => run_folders(folder),
    }
}

fn run_is_finished(path: &Path) -> bool {
    let record = Run::at(path).and_then(|run| run.record());
    is_real_folder(path) && record.is_ok_and(|record| record.status == RunStatus::Finished)
}

fn runs_are_finished(folder: &Path, of: Option<&Reproduction>) -> bool {
    let folders = runs_of(folder, of);
    !folders.is_empty() && folders.iter().all(|path| run_is_finished(path))
}

fn is_real_folder(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|kind| kind.is_dir())
}

#[cfg(test)]
mod tests {
    use granum_antony2006::reproduction::REPRODUCTION_FILE;

    use super::*;

    /// Without its description nothing tells a training, a list of runs or a reproduction from a run, so that the file itself must be named.
    #[test]
    fn a_description_that_is_no_file_is_named() {
        let names = [PLAN_FILE, STUDY_FILE, granum_run::queue::RUN_LIST, REPRODUCTION_FILE];
        for name in names {
            let folder = tempfile::tempdir().unwrap();
            std::fs::create_dir(folder.path().join(name)).unwrap();
            let error = Contents::read(folder.path(), &Vocabulary::standard()).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains("is not a regular file"), "{error}");
        }
    }
}
