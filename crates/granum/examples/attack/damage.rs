//! One case: a file is damaged, and commands that read it are judged.

use std::collections::{BTreeMap, HashMap};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::edits::damaged;
use crate::files;
use crate::ground::{Ground, words};
use crate::judge;
use crate::process::{Ended, Limits, Program};
use crate::random::Random;
use crate::targets::{ALL, Line, Rule, Target};
use crate::{Case, Fault};

/// Time after which a simulation is asked to end.
const SIMULATE: Duration = Duration::from_millis(1500);

/// What commands say and write about the undamaged files, by command line; computed when it is first needed.
#[derive(Default)]
pub struct Expected(Mutex<HashMap<&'static str, Arc<Known>>>);

struct Known {
    output: String,
    left: BTreeMap<PathBuf, Vec<u8>>,
}

impl Expected {
    fn known(
        &self,
        ground: &Ground,
        program: &Program,
        target: &Target,
        line: &'static str,
        left: &str,
    ) -> Result<Arc<Known>, String> {
        let mut known = self.0.lock().map_err(|_| "another thread has failed".to_string())?;
        if let Some(found) = known.get(line) {
            return Ok(found.clone());
        }
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        lay_out(ground, target, folder.path())?;
        let patient = Program { longest: 20 * program.longest, ..program.clone() };
        let ended = patient
            .run(folder.path(), &words(line), Limits::default())
            .map_err(|error| format!("granum {line}: {error}"))?;
        if !ended.succeeded() {
            return Err(format!("granum {line} fails with undamaged files: {}", ended.error.trim()));
        }
        let left = if left.is_empty() { BTreeMap::new() } else { files::contents(&folder.path().join(left)) };
        let found = Arc::new(Known { output: ended.output, left });
        known.insert(line, found.clone());
        Ok(found)
    }
}

fn lay_out(ground: &Ground, target: &Target, folder: &Path) -> Result<(), String> {
    for name in target.needs {
        files::copy(&ground.folder.join(name), &folder.join(name))
            .map_err(|error| format!("{name}: {error}"))?;
    }
    Ok(())
}

/// A target, each as often as its weight says.
pub fn draw(random: &mut Random) -> &'static Target {
    let weights: Vec<&Target> =
        ALL.iter().flat_map(|target| std::iter::repeat_n(target, target.weight)).collect();
    weights[random.below(weights.len())]
}

/// Runs a case.
pub fn attack(
    ground: &Ground,
    program: &Program,
    expected: &Expected,
    target: &Target,
    case: &mut Case,
) -> Result<Vec<Fault>, String> {
    let folder = case.folder.clone();
    lay_out(ground, target, &folder)?;
    let file = chosen(&folder, target, &mut case.random);
    let told = damage_file(ground, &folder, &file, &mut case.random)?;
    case.told = format!("{}: {told}", file.display());
    let mut faults = Vec::new();
    for _ in 0..2 {
        let line = case.random.pick(target.lines);
        let subject = Subject { ground, program, expected, target, folder: &folder, file: &file };
        faults.extend(subject.judge(line)?);
    }
    Ok(faults)
}

/// The file that is damaged.
fn chosen(folder: &Path, target: &Target, random: &mut Random) -> PathBuf {
    let name = random.pick(target.damaged);
    if folder.join(name).is_file() {
        return PathBuf::from(name);
    }
    let files = files::under(&folder.join(name));
    Path::new(name).join(random.pick(&files))
}

/// Damages a file in a folder, and says how.
fn damage_file(ground: &Ground, folder: &Path, file: &Path, random: &mut Random) -> Result<String, String> {
    let path = folder.join(file);
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    let bytes = fs::read(&path).map_err(failed)?;
    let donor = donor(ground, file, random);
    let other = fs::read(&donor).unwrap_or_default();
    match random.below(24) {
        0 => fs::remove_file(&path).map(|()| "removed".into()).map_err(failed),
        1 => fs::write(&path, "").map(|()| "emptied".into()).map_err(failed),
        2 | 3 if other != bytes && !other.is_empty() => {
            fs::write(&path, other).map_err(failed)?;
            Ok(format!("replaced by {}", donor.strip_prefix(&ground.folder).unwrap_or(&donor).display()))
        }
        4 => {
            fs::remove_file(&path).map_err(failed)?;
            fs::create_dir(&path).map(|()| "a folder in its place".into()).map_err(failed)
        }
        5 => {
            fs::remove_file(&path).map_err(failed)?;
            let device = random.pick(&["/dev/zero", "/dev/full", "/dev/null"]);
            std::os::unix::fs::symlink(device, &path).map_err(failed)?;
            Ok(format!("a link to {device} in its place"))
        }
        6 => {
            fs::remove_file(&path).map_err(failed)?;
            let made = Command::new("mkfifo").arg(&path).status().map_err(failed)?;
            Ok(if made.success() { "a FIFO in its place".into() } else { "removed".into() })
        }
        _ => {
            let (new, told) = damaged(&bytes, &other, random);
            fs::write(&path, new).map(|()| told).map_err(failed)
        }
    }
}

/// Another file of the same kind: that of the other run, or a neighbour.
fn donor(ground: &Ground, file: &Path, random: &mut Random) -> PathBuf {
    let text = file.display().to_string();
    if let Some(rest) = text.strip_prefix("run-1/") {
        return ground.folder.join("run-2").join(rest);
    }
    for folder in ["stopped", "sample", "staged"] {
        if let Some(rest) = text.strip_prefix(&format!("{folder}/"))
            && ground.folder.join("run-2").join(rest).is_file()
        {
            return ground.folder.join("run-2").join(rest);
        }
    }
    let parent = ground.folder.join(file).parent().map(Path::to_path_buf).unwrap_or_default();
    let kind = file.extension();
    let same: Vec<PathBuf> = fs::read_dir(parent)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.is_file() && path.extension() == kind && !path.ends_with(file))
        .collect();
    let mut same = same;
    same.sort();
    if same.is_empty() { ground.folder.join(file) } else { random.pick(&same).clone() }
}

/// A folder with a damaged file.
struct Subject<'a> {
    ground: &'a Ground,
    program: &'a Program,
    expected: &'a Expected,
    target: &'a Target,
    folder: &'a Path,
    file: &'a Path,
}

impl Subject<'_> {
    fn judge(&self, line: &'static Line) -> Result<Vec<Fault>, String> {
        // What the command before has written.
        for out in [
            "out",
            "out.csv",
            "out.data",
            "out.toml",
            "out.gsd",
            "out.parquet",
            "out.svg",
            "out.vtp",
            "out.xyz",
        ] {
            let path = self.folder.join(out);
            let _ = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
        }
        if matches!(line.rule, Rule::Told | Rule::Left(_)) {
            // What fails with undamaged files says nothing about damage.
            let left = if let Rule::Left(out) = line.rule { out } else { "" };
            let known = self.expected.known(self.ground, self.program, self.target, line.words, left);
            if let Err(what) = known {
                return Ok(vec![Fault {
                    kind: "undamaged",
                    what,
                    line: line.words.into(),
                    ended: String::new(),
                }]);
            }
        }
        let stop_after = line.simulates.then_some(SIMULATE).filter(|_| matches!(line.rule, Rule::Calm));
        let ended = self.run(line.words, Limits { stop_after, ..Limits::default() })?;
        let fault = |(kind, what): (&'static str, String)| Fault {
            kind,
            what,
            line: ended.line.clone(),
            ended: ended.error.clone(),
        };
        if let Some(wrong) = judge::wrong(&ended, line.simulates) {
            return Ok(vec![fault(wrong)]);
        }
        let mut faults: Vec<Fault> = judge::wrong_words(&ended)
            .into_iter()
            .chain(judge::left_behind(self.folder))
            .map(fault)
            .collect();
        if ended.succeeded() {
            let claim = self.claim(line, &ended)?;
            faults.extend(claim.map(|what| fault(("claim", what))));
        } else if ended.code() == Some(1) && !self.names_the_file(line, &ended) {
            faults.push(fault(("unnamed", format!("the message does not name {}", self.file.display()))));
        }
        Ok(faults)
    }

    fn run(&self, line: &str, limits: Limits) -> Result<Ended, String> {
        let file = |word: OsString| if word == "FILE" { self.file.as_os_str().to_owned() } else { word };
        let words: Vec<OsString> = words(line).into_iter().map(file).collect();
        self.program.run(self.folder, &words, limits).map_err(|error| format!("granum {line}: {error}"))
    }

    /// What is wrong with a success.
    fn claim(&self, line: &'static Line, ended: &Ended) -> Result<Option<String>, String> {
        let known = |line, left| self.expected.known(self.ground, self.program, self.target, line, left);
        Ok(match line.rule {
            Rule::Calm => None,
            Rule::Told => (known(line.words, "")?.output != ended.output)
                .then(|| "it succeeded, and its output is not that of the undamaged files".into()),
            Rule::Left(out) => {
                let left = files::contents(&self.folder.join(out));
                files::difference_of(&known(line.words, out)?.left, &left).map(|what| {
                    format!("it succeeded, and what it wrote is not that of the undamaged files: {what}")
                })
            }
            Rule::ToldBy(other) => {
                let asked = self.run(other, Limits::default())?;
                (asked.succeeded() && known(other, "")?.output != asked.output)
                    .then(|| format!("it succeeded, and `granum {other}` then tells something else"))
                    .or_else(|| {
                        (!asked.succeeded()).then(|| {
                            format!("it succeeded, and `granum {other}` fails: {}", asked.error.trim())
                        })
                    })
            }
            Rule::Like(out, reference) => {
                files::difference(&self.ground.folder.join(reference), &self.folder.join(out))
                    .map(|what| format!("it succeeded, and {out} is not the undamaged {reference}: {what}"))
            }
        })
    }

    /// Whether a failure names the damaged file; of files that nobody vouches for, that is left to each reader. The file that marks
    /// a folder as one of granum's is hidden, and its folder is named instead.
    fn names_the_file(&self, line: &Line, ended: &Ended) -> bool {
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        let stem = self.file.file_stem().unwrap_or_default().to_string_lossy();
        let named = |part: &str| ended.error.contains(part);
        let folder = self.file.parent().unwrap_or(Path::new("")).display().to_string();
        // Without the file that tells what a folder is, nobody knows that it is missing.
        if !self.folder.join(self.file).exists() && named(&folder) {
            return true;
        }
        matches!(line.rule, Rule::Calm) || name == ".granum-lock" || named(&name) || named(&stem)
    }
}
