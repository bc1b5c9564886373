//! What happens to commands whose files are good: signals at random moments, several starts at once, a full disk, lost outputs.
//! Whatever it is, the work can be completed, and its result is that of an undisturbed command, byte for byte.

use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::files;
use crate::ground::{Ground, TRAIN, words};
use crate::judge;
use crate::process::{Ended, Limits, Lost, Program};
use crate::random::Random;
use crate::{Case, Fault};

/// A work that is disturbed: its command, what it needs, the folder it writes, and the undamaged folder with the same content.
struct Work {
    line: String,
    resume: &'static str,
    needs: &'static [&'static str],
    like: &'static str,
    /// The file whose existence tells that `resume` can continue.
    begun: &'static str,
    whole: Duration,
}

fn works(ground: &Ground) -> Vec<Work> {
    let grains = |line: &str, needs, like| Work {
        line: line.to_string(),
        resume: "resume out --checkpoint-every 0.05",
        needs,
        like,
        begun: "run.json",
        whole: ground.test,
    };
    vec![
        grains("shear case.toml --out out --checkpoint-every 0.05", &["case.toml"], "run-1"),
        grains(
            "shear case.toml --sample sample --out out --checkpoint-every 0",
            &["case.toml", "sample"],
            "run-1",
        ),
        grains("prepare case.toml --out out --checkpoint-every 0.05", &["case.toml"], "sample"),
        grains(
            "shear staged.toml --out out --checkpoint-every 0.05",
            &["staged.toml", "test.inp", "strains.txt", "history.csv"],
            "staged",
        ),
        Work {
            whole: ground.of_clumps,
            ..grains("run dimers.toml --out out --checkpoint-every 0.05", &["dimers.toml"], "clumps")
        },
        grains("run bonds.toml --out out --checkpoint-every 0.05", &["bonds.toml"], "bonded"),
        Work {
            begun: "runs.json",
            whole: 2 * ground.test,
            ..grains(
                "shear case.toml --seed 1,2 --out out --checkpoint-every 0.05",
                &["case.toml"],
                "several",
            )
        },
        Work {
            line: format!("train run-1 --unseen run-2 --out out --checkpoint-every 0.05 {TRAIN}"),
            resume: "resume out --threads 2 --checkpoint-every 0.05",
            needs: &["run-1", "run-2"],
            like: "study",
            begun: "training.json",
            whole: ground.training,
        },
    ]
}

/// What happens.
#[derive(Clone, Copy)]
pub enum Misfortune {
    Kills,
    Starts,
    FullDisk,
    LostOutputs,
}

/// What happens in a case.
pub fn draw(random: &mut Random) -> Misfortune {
    match random.below(8) {
        0..=3 => Misfortune::Kills,
        4 => Misfortune::Starts,
        5 | 6 => Misfortune::FullDisk,
        _ => Misfortune::LostOutputs,
    }
}

impl Misfortune {
    pub fn name(self) -> &'static str {
        match self {
            Misfortune::Kills => "kills",
            Misfortune::Starts => "starts",
            Misfortune::FullDisk => "full-disk",
            Misfortune::LostOutputs => "lost-outputs",
        }
    }
}

/// Runs a case.
pub fn attack(
    ground: &Ground,
    program: &Program,
    what: Misfortune,
    case: &mut Case,
) -> Result<Vec<Fault>, String> {
    let works = works(ground);
    let work = case.random.pick(&works);
    for name in work.needs {
        files::copy(&ground.folder.join(name), &case.folder.join(name))
            .map_err(|error| format!("{name}: {error}"))?;
    }
    let folder = case.folder.clone();
    let place = Place { ground, program, work, folder: &folder };
    match what {
        Misfortune::Kills => place.kills(case),
        Misfortune::Starts => place.starts(case),
        Misfortune::FullDisk => place.full_disk(case),
        Misfortune::LostOutputs => place.lost(case),
    }
}

struct Place<'a> {
    ground: &'a Ground,
    program: &'a Program,
    work: &'a Work,
    folder: &'a Path,
}

fn fault(kind: &'static str, what: impl Into<String>, ended: &Ended) -> Fault {
    Fault { kind, what: what.into(), line: ended.line.clone(), ended: ended.error.clone() }
}

impl Place<'_> {
    fn start(&self, line: &str, limits: Limits) -> Result<Ended, String> {
        // Works may take longer than a reader.
        let patient = Program { longest: 6 * self.program.longest, ..self.program.clone() };
        patient.run(self.folder, &words(line), limits).map_err(|error| format!("granum {line}: {error}"))
    }

    /// The command that goes on from what is there.
    fn next(&self) -> String {
        let begun = self.folder.join("out").join(self.work.begun).is_file();
        if begun { self.work.resume.to_string() } else { self.work.line.clone() }
    }

    /// Completes the work without any disturbance and compares.
    fn complete(&self) -> Result<Vec<Fault>, String> {
        let ended = self.start(&self.next(), Limits::default())?;
        if !ended.succeeded() {
            return Ok(vec![fault("lost-work", "the work cannot be completed", &ended)]);
        }
        let difference =
            files::difference(&self.ground.folder.join(self.work.like), &self.folder.join("out"));
        let mut faults: Vec<Fault> = difference
            .map(|what| fault("other-bytes", format!("not like {}: {what}", self.work.like), &ended))
            .into_iter()
            .collect();
        faults.extend(judge::left_behind(self.folder).map(|(kind, what)| fault(kind, what, &ended)));
        Ok(faults)
    }

    /// Signals at random moments, each followed by a look at the folder and by the next attempt.
    fn kills(&self, case: &mut Case) -> Result<Vec<Fault>, String> {
        let kills = 1 + case.random.below(5);
        let mut told = Vec::new();
        for _ in 0..kills {
            let signal = *case.random.pick(&["KILL", "KILL", "TERM", "INT", "HUP"]);
            let after = self.work.whole.mul_f64(1.1 * case.random.fraction());
            told.push(format!("{signal} after {:.2} s", after.as_secs_f64()));
            case.told = format!("{}: {}", self.work.line, told.join(", "));
            let line = self.next();
            let running = self
                .program
                .start(self.folder, &words(&line), Limits::default())
                .map_err(|error| format!("granum {line}: {error}"))?;
            std::thread::sleep(after);
            running.signal(signal);
            let ended = running.wait(self.program.longest).map_err(|error| error.to_string())?;
            if ended.hung {
                return Ok(vec![fault("hang", format!("no end after {signal}"), &ended)]);
            }
            // It may have been signalled before it could listen.
            let fair = ended.succeeded() || ended.code() == Some(130) || ended.code().is_none();
            if !fair {
                return Ok(vec![fault("status", format!("it ended with status {:?}", ended.code()), &ended)]);
            }
            if self.folder.join("out").join(self.work.begun).is_file() {
                let status = self.start("status out", Limits::default())?;
                if !status.succeeded() {
                    return Ok(vec![fault("lost-work", format!("after {signal}, status fails"), &status)]);
                }
            }
        }
        self.complete()
    }

    /// Several starts at once on one folder: one wins, the others say who is there.
    fn starts(&self, case: &mut Case) -> Result<Vec<Fault>, String> {
        let number = 2 + case.random.below(19);
        case.told = format!("{}: {number} starts at once", self.work.line);
        let starts = (0..number)
            .map(|_| self.program.start(self.folder, &words(&self.work.line), Limits::default()))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|error| error.to_string())?;
        let mut winners = 0;
        let mut faults = Vec::new();
        for running in starts {
            let ended = running.wait(10 * self.program.longest).map_err(|error| error.to_string())?;
            faults.extend(judge::wrong(&ended, false).map(|(kind, what)| fault(kind, what, &ended)));
            if ended.succeeded() {
                winners += usize::from(!ended.output.contains("already"));
            } else if !ended.error.contains("out") {
                faults.push(fault("unnamed", "a start that was refused does not name the folder", &ended));
            }
        }
        if winners != 1 {
            let what = format!("{winners} of {number} starts at once succeeded");
            faults.push(Fault { kind: "starts", what, line: self.work.line.clone(), ended: String::new() });
        }
        let difference =
            files::difference(&self.ground.folder.join(self.work.like), &self.folder.join("out"));
        faults.extend(difference.map(|what| Fault {
            kind: "other-bytes",
            what,
            line: self.work.line.clone(),
            ended: String::new(),
        }));
        Ok(faults)
    }

    /// The disk is full at some size of a file, in the work and in what is made of its results.
    fn full_disk(&self, case: &mut Case) -> Result<Vec<Fault>, String> {
        let blocks = limit(&mut case.random);
        case.told = format!("{}: no file larger than {blocks} blocks of 512 bytes", self.work.line);
        let full = Limits { blocks: Some(blocks), ..Limits::default() };
        let ended = self.start(&self.work.line, full)?;
        let mut faults: Vec<Fault> = judge::wrong(&ended, false)
            .into_iter()
            .chain(judge::wrong_words(&ended))
            .map(|(kind, what)| fault(kind, what, &ended))
            .collect();
        faults.extend(self.complete()?);
        if !faults.is_empty() || self.work.like == "study" {
            return Ok(faults);
        }
        // What was written before stays when there is no room for its successor.
        let outputs = [
            "report out --out page",
            "export out -o out.csv",
            "export out -o out.gsd",
            "export out --to lammps -o deck",
        ];
        // The last is for laws and bonds that LAMMPS has, the first is for any number of runs.
        let number = match self.work.like {
            "several" => 1,
            "staged" | "bonded" => 3,
            _ => 4,
        };
        let line = *case.random.pick(&outputs[..number]);
        let name = line.split(' ').next_back().unwrap_or_default();
        let first = self.start(line, Limits::default())?;
        if !first.succeeded() {
            return Ok(vec![fault("status", "an output of a good run fails", &first)]);
        }
        let before = files::contents(&self.folder.join(name));
        let blocks = limit(&mut case.random);
        case.told += &format!(", then {line} with {blocks} blocks");
        let ended =
            self.start(&format!("{line} --force"), Limits { blocks: Some(blocks), ..Limits::default() })?;
        faults.extend(
            judge::wrong(&ended, false)
                .into_iter()
                .chain(judge::wrong_words(&ended))
                .map(|(kind, what)| fault(kind, what, &ended)),
        );
        faults.extend(judge::left_behind(self.folder).map(|(kind, what)| fault(kind, what, &ended)));
        let difference = files::difference_of(&before, &files::contents(&self.folder.join(name)));
        faults
            .extend(difference.map(|what| {
                fault("lost-work", format!("an output was lost to a full disk: {what}"), &ended)
            }));
        Ok(faults)
    }

    /// Standard output or error cannot be written.
    fn lost(&self, case: &mut Case) -> Result<Vec<Fault>, String> {
        let lost =
            *case.random.pick(&[Lost::OutputFull, Lost::ErrorFull, Lost::OutputUnread, Lost::ErrorUnread]);
        let json = if case.random.chance(0.3) { "--json " } else { "" };
        let line = format!("{json}{}", self.work.line);
        case.told = format!("{line}: {lost:?}");
        let ended = self.start(&line, Limits { lost: Some(lost), ..Limits::default() })?;
        let mut faults: Vec<Fault> =
            judge::wrong(&ended, false).into_iter().map(|(kind, what)| fault(kind, what, &ended)).collect();
        let code = if matches!(lost, Lost::OutputFull) { 1 } else { 0 };
        if ended.code() != Some(code) {
            faults.push(fault(
                "status",
                format!("it ended with status {:?}, not {code}", ended.code()),
                &ended,
            ));
        }
        let difference =
            files::difference(&self.ground.folder.join(self.work.like), &self.folder.join("out"));
        faults.extend(difference.map(|what| fault("other-bytes", what, &ended)));
        if fs::metadata(self.folder.join("out")).is_ok() {
            for line in ["status out", "--json digest out", "export out", "--help"] {
                let ended = self.start(line, Limits { lost: Some(lost), ..Limits::default() })?;
                faults.extend(judge::wrong(&ended, false).map(|(kind, what)| fault(kind, what, &ended)));
            }
        }
        Ok(faults)
    }
}

/// A limit on the size of files, from nothing to more than any file of these works.
fn limit(random: &mut Random) -> u32 {
    (2f64.powf(9.0 * random.fraction()) - 1.0) as u32
}
