//! The command line of the attack.

use std::path::PathBuf;
use std::time::Duration;

use crate::process::Program;

/// What is asked for.
pub struct Options {
    pub seed: u64,
    pub cases: u64,
    pub seconds: u64,
    pub only: Option<u64>,
    pub what: Vec<String>,
    pub jobs: usize,
    pub out: PathBuf,
    pub program: Program,
}

const HELP: &str = "attack [--seed N] [--cases N] [--seconds S] [--only N] [--what KIND,...] [--jobs N] [--limit S] [--memory MIB] \
[--granum PROGRAM] [--out DIR]

  --seed N          seed of the cases (1)
  --cases N         number of cases (until the time is over)
  --seconds S       time for all cases, s (60)
  --only N          run this case alone, and keep its files
  --what KIND,...   only cases of these kinds; their numbers stay the same
  --jobs N          cases at the same time (1)
  --limit S         time in which a command must end, s (10)
  --memory MIB      address space of a command, MiB (1536)
  --granum PROGRAM  the program (beside this one)
  --out DIR         folder for cases that fail (attack-faults)";

impl Options {
    /// Reads the words of the command line.
    pub fn read(mut words: impl Iterator<Item = String>) -> Result<Options, String> {
        let mut options = Options {
            seed: 1,
            cases: u64::MAX,
            seconds: 60,
            only: None,
            what: Vec::new(),
            jobs: 1,
            out: "attack-faults".into(),
            program: Program { path: beside()?, longest: Duration::from_secs(10), memory: 1536 },
        };
        let mut timed = false;
        while let Some(flag) = words.next() {
            if flag == "--help" || flag == "-h" {
                return Err(HELP.into());
            }
            let value = words.next().ok_or_else(|| format!("{flag} needs a value\n\n{HELP}"))?;
            let number =
                || value.parse::<u64>().map_err(|_| format!("{flag} {value}: a whole number is needed"));
            match flag.as_str() {
                "--seed" => options.seed = number()?,
                "--cases" => options.cases = number()?,
                "--seconds" => {
                    options.seconds = number()?;
                    timed = true;
                }
                "--only" => options.only = Some(number()?),
                "--what" => options.what = value.split(',').map(String::from).collect(),
                "--jobs" => options.jobs = number()?.clamp(1, 256) as usize,
                "--limit" => options.program.longest = Duration::from_secs(number()?),
                "--memory" => options.program.memory = number()?,
                "--granum" => options.program.path = value.into(),
                "--out" => options.out = value.into(),
                _ => return Err(format!("{flag} is not known\n\n{HELP}")),
            }
        }
        if options.cases != u64::MAX && !timed {
            options.seconds = u64::MAX;
        }
        let path = &options.program.path;
        options.program.path =
            path.canonicalize().map_err(|error| format!("{}: {error}; build it first", path.display()))?;
        Ok(options)
    }
}

/// The program in the folder of build results to which this example belongs.
fn beside() -> Result<PathBuf, String> {
    let here = std::env::current_exe().map_err(|error| error.to_string())?;
    let folder = here.parent().and_then(|folder| folder.parent());
    Ok(folder.map(|folder| folder.join("granum")).unwrap_or_default())
}
