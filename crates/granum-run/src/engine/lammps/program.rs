//! The program of LAMMPS: which it is, and one process of it.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::time::Duration;

use granum_io::Error;

use super::place::{LOG, OUTPUT, Place};
use crate::lammps_deck::SCRIPT;
use crate::task::engine_error::EngineError;
use crate::task::laboratory_error::LaboratoryError;

/// Name of the engine that is LAMMPS.
pub const NAME: &str = "lammps";
/// The package of LAMMPS that a deck needs.
const PACKAGE: &str = "GRANULAR";
/// Number of lines of a log that are shown.
const LINES_SHOWN: usize = 12;

/// How long to wait before a program that failed is asked again.
const PAUSES: [Duration; 2] = [Duration::from_millis(200), Duration::from_millis(1000)];

/// What `lmp -h` says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct About {
    /// Version, e.g. `29 Sep 2021 - Update 2`.
    pub(super) version: String,
    has_package: bool,
}

/// The command as it would be typed.
pub(super) fn shown(command: &[String]) -> String {
    command.join(" ")
}

fn refused(what: String) -> EngineError {
    EngineError::Refused { engine: NAME.into(), what }
}

/// Asks a command which LAMMPS it is.
///
/// # Errors
/// [`EngineError::Refused`] if there is no such program, or it is no LAMMPS that can run a deck.
pub(super) fn about(command: &[String]) -> Result<About, EngineError> {
    let Some((program, arguments)) = command.split_first() else {
        return Err(refused("its command is empty; give one, e.g. --command \"mpirun -np 4 lmp\"".into()));
    };
    let name = shown(command);
    let output = asked(program, arguments).map_err(|error| match error.kind() {
        ErrorKind::NotFound => refused(format!(
            "there is no program {program:?} on the PATH. Install LAMMPS with its package {PACKAGE}, on Debian and Ubuntu with `apt \
             install lammps`, with conda with `conda install -c conda-forge lammps`; or say how it is started here, e.g. --command \
             \"mpirun -np 4 lmp_mpi\""
        )),
        _ => refused(format!("{program:?} cannot be started: {error}")),
    })?;
    let text = String::from_utf8_lossy(&output.stdout);
    let Some(about) = parsed(&text) else {
        let told = String::from_utf8_lossy(&output.stderr);
        let told = last_lines(&format!("{text}\n{told}"), LINES_SHOWN);
        return Err(refused(format!(
            "`{name} -h` does not say that it is LAMMPS; give the command of LAMMPS by --command. It says:\n{told}"
        )));
    };
    if !about.has_package {
        let version = about.version;
        return Err(refused(format!(
            "LAMMPS {version} of `{name}` lacks the package {PACKAGE}, which contacts of grains need; build or install one that has it"
        )));
    }
    Ok(about)
}

/// The help of a program. MPI of several processes that begin at the same moment can fail to start, so that a program that fails is asked again.
fn asked(program: &str, arguments: &[String]) -> std::io::Result<Output> {
    let ask = || Command::new(program).args(arguments).arg("-h").stdin(Stdio::null()).output();
    let mut output = ask()?;
    for pause in PAUSES {
        if output.status.success() {
            break;
        }
        std::thread::sleep(pause);
        output = ask()?;
    }
    Ok(output)
}

/// Reads what `lmp -h` prints.
fn parsed(help: &str) -> Option<About> {
    let line = help.lines().find(|line| line.contains("Massively Parallel Simulator"))?;
    let version = line.split_once("Simulator")?.1.trim_start_matches([' ', '-']).trim().to_string();
    let packages = help.split_once("Installed packages:")?.1;
    let packages = packages.split("List of individual style options").next().unwrap_or(packages);
    Some(About { version, has_package: packages.split_whitespace().any(|word| word == PACKAGE) })
}

/// One process of LAMMPS, with those that it starts.
#[derive(Debug)]
pub(super) struct Program {
    child: Child,
    log: String,
}

impl Program {
    /// Starts LAMMPS on the deck of a folder, from a restart file of a step or from the beginning. The process holds `lock`, so
    /// that a later process can tell whether it still runs; if this process ends before it, it is asked to stop.
    pub(super) fn start(
        command: &[String],
        place: &Place,
        restart: Option<u64>,
        lock: File,
    ) -> Result<Program, LaboratoryError> {
        let log = format!("{LOG}{}", restart.unwrap_or(0));
        let path = place.file(OUTPUT);
        let output = File::create(&path).map_err(Error::file("create", &path))?;
        let errors = output.try_clone().map_err(Error::file("open", &path))?;
        let (program, arguments) = command.split_first().map_or(("", &[][..]), |(p, a)| (p.as_str(), a));
        let mut started = Command::new(program);
        started.args(arguments).args(["-in", SCRIPT, "-log", log.as_str(), "-screen", "none"]);
        if let Some(step) = restart {
            started.args(["-var", "resume"]).arg(step.to_string());
        }
        if std::env::var_os("OMP_NUM_THREADS").is_none() {
            started.env("OMP_NUM_THREADS", "1");
        }
        started.current_dir(place.path()).stdin(lock).stdout(output).stderr(errors);
        apart(&mut started);
        let child = started.spawn().map_err(|error| EngineError::Failed {
            engine: NAME.into(),
            what: format!("`{}` cannot be started: {error}", shown(command)),
        })?;
        watch(place.path(), child.id());
        Ok(Program { child, log })
    }

    /// How it ended, if it has.
    pub(super) fn ended(&mut self) -> Result<Option<ExitStatus>, LaboratoryError> {
        let failed =
            |error: std::io::Error| EngineError::Failed { engine: NAME.into(), what: error.to_string() };
        Ok(self.child.try_wait().map_err(failed)?)
    }

    /// The last lines of what it printed and of its log.
    pub(super) fn last_words(&self, place: &Place) -> String {
        let text =
            |name: &str| fs::read(place.file(name)).map(|text| String::from_utf8_lossy(&text).into_owned());
        let log = last_lines(&text(&self.log).unwrap_or_default(), LINES_SHOWN);
        let output = last_lines(&text(OUTPUT).unwrap_or_default(), LINES_SHOWN);
        let (name, folder) = (&self.log, place.path().display());
        let log =
            if log.is_empty() { String::new() } else { format!("\nthe end of {folder}/{name}:\n{log}") };
        let output = if output.is_empty() {
            String::new()
        } else {
            format!("\nthe end of {folder}/{OUTPUT}:\n{output}")
        };
        format!("{log}{output}")
    }
}

impl Drop for Program {
    /// A process that nobody follows any more is asked to stop by the watch, or ends here.
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Ctrl-C is for granum alone, which asks LAMMPS to stop in good order.
#[cfg(unix)]
fn apart(command: &mut Command) {
    std::os::unix::process::CommandExt::process_group(command, 0);
}

#[cfg(not(unix))]
fn apart(_: &mut Command) {}

/// A shell that asks LAMMPS to stop if this process ends before it, as when it is killed.
#[cfg(unix)]
fn watch(place: &Path, lammps: u32) {
    let script = format!(
        "while kill -0 {lammps} 2>/dev/null; do kill -0 {own} 2>/dev/null || {{ echo variable request string stop > request.new && mv request.new request; \
         break; }}; sleep 1; done",
        own = std::process::id()
    );
    let mut command = Command::new("sh");
    command.args(["-c", &script]).current_dir(place);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    apart(&mut command);
    // Without a shell a run goes on until its end, as a later process notices.
    if let Ok(mut shell) = command.spawn() {
        std::thread::spawn(move || shell.wait());
    }
}

#[cfg(not(unix))]
fn watch(_: &Path, _: u32) {}

/// The last lines of a text that are not blank.
fn last_lines(text: &str, count: usize) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim_end).filter(|line| !line.is_empty()).collect();
    lines[lines.len().saturating_sub(count)..]
        .iter()
        .map(|line| format!("  {line}"))
        .collect::<Vec<_>>()
        .join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    const HELP: &str = "\nLarge-scale Atomic/Molecular Massively Parallel Simulator - 29 Sep 2021 - Update 2\n\nInstalled packages:\n\n\
                        ASPHERE GRANULAR KIM\n\nList of individual style options included\n\n* Atom styles:\n";

    #[test]
    fn version_and_packages_are_those_of_the_help() {
        let about = parsed(HELP).unwrap();
        assert_eq!(about, About { version: "29 Sep 2021 - Update 2".into(), has_package: true });
        assert!(!parsed(&HELP.replace("GRANULAR ", "")).unwrap().has_package);
        assert_eq!(parsed("usage: lmp [file]"), None);
        let error = about_nothing(&["no-such-program-of-lammps"]);
        assert!(error.contains("apt install lammps") && error.contains("--command"), "{error}");
        let error = about_nothing(&["true"]);
        assert!(error.contains("`true -h` does not say that it is LAMMPS"), "{error}");
        assert!(about_nothing(&[]).contains("its command is empty"));
    }

    #[cfg(unix)]
    #[test]
    fn a_program_that_fails_once_is_asked_again() {
        let folder = tempfile::tempdir().unwrap();
        let (seen, help) = (folder.path().join("seen"), folder.path().join("help"));
        fs::write(&help, HELP).unwrap();
        let script = format!("[ -e {0:?} ] && exec cat {1:?}; touch {0:?}; exit 1", seen, help);
        let command = ["sh", "-c", &script].map(String::from);
        assert_eq!(super::about(&command).unwrap().version, "29 Sep 2021 - Update 2");
    }

    fn about_nothing(command: &[&str]) -> String {
        let command: Vec<String> = command.iter().map(ToString::to_string).collect();
        super::about(&command).unwrap_err().to_string()
    }

    #[test]
    fn the_last_lines_of_a_log_are_shown() {
        assert_eq!(last_lines("a\n\nb\nERROR: Lost atoms\n\n", 2), "  b\n  ERROR: Lost atoms");
        assert_eq!(last_lines("", 5), "");
    }
}
