//! Soak test: runs random valid cases one after another for a given time. It checks that there are no panics and no NaN,
//! that results do not depend on threads, instruction set or interruptions, that the energy balance closes, and that
//! memory does not grow.
//!
//! ```text
//! cargo run --release -p granum-run --example soak -- --seconds 3600 --seed 1
//! cargo run --release -p granum-run --example soak -- --case soak-failures/case-17.toml
//! ```

mod draw;
mod trial;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use granum_io::Case;
use granum_io::case::{CaseStage, CaseTest};

use draw::{Draws, Way};
use trial::{Outcome, trial};

/// Options of the command line.
struct Wanted {
    seconds: u64,
    seed: u64,
    out: PathBuf,
    case: Option<PathBuf>,
}

const FLAGS: [&str; 4] = ["--seconds", "--seed", "--out", "--case"];

fn wanted() -> Result<Wanted, String> {
    let mut wanted = Wanted { seconds: 600, seed: 1, out: "soak-failures".into(), case: None };
    let mut arguments = std::env::args().skip(1);
    while let Some(flag) = arguments.next() {
        if !FLAGS.contains(&flag.as_str()) {
            return Err(format!("{flag}: known are {}", FLAGS.join(", ")));
        }
        let value = arguments.next().ok_or_else(|| format!("{flag} needs a value"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("{flag} {value}: a whole number"));
        match flag.as_str() {
            "--seconds" => wanted.seconds = number()?,
            "--seed" => wanted.seed = number()?,
            "--out" => wanted.out = value.into(),
            _ => wanted.case = Some(value.into()),
        }
    }
    Ok(wanted)
}

/// Results of all cases.
#[derive(Default)]
struct Totals {
    cases: u64,
    runs: u64,
    grain_steps: f64,
    ways: BTreeMap<&'static str, u64>,
    laws: BTreeMap<String, u64>,
    paths: BTreeMap<String, u64>,
    /// Number of cases that were given up because they took too long.
    given_up: u64,
    /// Numbers of cases that ended with an error message instead of a result, by message.
    reported: BTreeMap<String, u64>,
    /// Numbers of quality flags that were not passed, by name.
    flags: BTreeMap<String, u64>,
    quasi_static: u64,
    /// Largest gap of the energy balance among the quasi-static tests and among the others.
    gap: [f64; 2],
    failures: Vec<String>,
    memory: Vec<f64>,
}

impl Totals {
    fn add(&mut self, outcome: Outcome) {
        self.runs += outcome.runs;
        self.grain_steps += outcome.grain_steps;
        self.given_up += u64::from(outcome.given_up);
        if let Some(text) = outcome.reported {
            *self.reported.entry(text).or_default() += 1;
        }
        for flag in outcome.flags {
            *self.flags.entry(flag).or_default() += 1;
        }
        if let Some(gap) = outcome.energy_gap {
            self.quasi_static += u64::from(outcome.quasi_static);
            let place = usize::from(!outcome.quasi_static);
            self.gap[place] = self.gap[place].max(gap);
        }
    }

    fn print(&self, seconds: f64) {
        let list = |all: &BTreeMap<String, u64>| {
            let each: Vec<String> = all.iter().map(|(name, count)| format!("{name} {count}")).collect();
            if each.is_empty() { "none".to_string() } else { each.join(", ") }
        };
        let ways = self.ways.iter().map(|(name, count)| (name.to_string(), *count)).collect();
        println!(
            "\n{:.0} s: {} cases, {} runs, {:.3e} grain-steps",
            seconds, self.cases, self.runs, self.grain_steps
        );
        println!("laws: {}", list(&self.laws));
        println!("paths: {}", list(&self.paths));
        println!("ways: {}", list(&ways));
        println!(
            "energy gap: at most {:.2e} in {} quasi-static tests, {:.2e} in the others",
            self.gap[0], self.quasi_static, self.gap[1]
        );
        println!("judgements not good: {}", list(&self.flags));
        println!(
            "ended with a message: {}; longer than {} s: {}",
            list(&self.reported),
            trial::LONGEST.as_secs(),
            self.given_up
        );
        // Memory grows during the first cases, while the caches of the allocator are filled.
        let settled = self.memory.get(self.memory.len() / 4).copied().unwrap_or(0.0);
        let last = self.memory.last().copied().unwrap_or(0.0);
        println!("memory between cases: {settled:.0} MB after a quarter of them, {last:.0} MB at the end");
        println!("failures: {}", self.failures.len());
        for failure in &self.failures {
            println!("  {failure}");
        }
    }
}

/// Memory of this process, MB, where the system reports it.
fn memory() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("VmRSS"));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok()).unwrap_or(0.0) / 1024.0
}

/// Stores a case that failed, with everything that is needed to run it again.
fn keep(out: &Path, name: &str, case: &Case, ways: &str, why: &str) -> String {
    let file = out.join(format!("{name}.toml"));
    let comment: String = why.lines().map(|line| format!("# {line}\n")).collect();
    let text = format!("# {ways}\n{comment}{}", case.resolved_toml());
    let written = std::fs::create_dir_all(out).and_then(|()| std::fs::write(&file, text));
    let place = written.map_or_else(|error| error.to_string(), |()| file.display().to_string());
    format!("{place} ({ways}): {why}")
}

fn main() {
    let wanted = wanted().unwrap_or_else(|why| {
        eprintln!("{why}");
        std::process::exit(2);
    });
    let start = Instant::now();
    let mut totals = Totals::default();
    let mut draws = Draws::new(wanted.seed);
    let given = wanted.case.as_ref().map(|file| {
        Case::read(file).unwrap_or_else(|error| {
            eprintln!("{error}");
            std::process::exit(2);
        })
    });
    while start.elapsed() < Duration::from_secs(wanted.seconds) {
        let ways = match &given {
            Some(_) => Way::ALL.get(totals.cases as usize).copied(),
            None => Some(draws.way()),
        };
        let Some(way) = ways else { break };
        let case = given.clone().unwrap_or_else(|| draws.case());
        let name = format!("seed-{}-case-{}", wanted.seed, totals.cases);
        totals.cases += 1;
        *totals.ways.entry(way.name()).or_default() += 1;
        let contact = &case.contact;
        for law in [
            contact.normal.name(),
            contact.tangential.name(),
            contact.rolling.name(),
            contact.adhesion.name(),
        ] {
            *totals.laws.entry(law.to_string()).or_default() += 1;
        }
        let stages = if let CaseTest::Stages(stages) = &case.test { stages.as_slice() } else { &[] };
        for (stages, of) in [(stages, ""), (&case.preparation_stages, " (preparation)")] {
            for stage in stages {
                if let CaseStage::Path { path, .. } = stage {
                    *totals.paths.entry(format!("{}{of}", path.name)).or_default() += 1;
                }
            }
        }
        let began = Instant::now();
        let outcome = trial(&case, way, draws.fraction());
        eprintln!(
            "{name} {} {} grains: {:.1} s{}",
            way.name(),
            case.grains.count,
            began.elapsed().as_secs_f64(),
            outcome.reported.as_ref().map_or(String::new(), |text| format!(", {text}"))
        );
        if let Some(why) = &outcome.failure {
            let line = keep(&wanted.out, &name, &case, way.name(), why);
            eprintln!("FAILURE {line}");
            totals.failures.push(line);
        }
        totals.add(outcome);
        totals.memory.push(memory());
    }
    totals.print(start.elapsed().as_secs_f64());
    std::process::exit(i32::from(!totals.failures.is_empty()));
}
