//! All cases: which kind each is, its folder, what is kept of it, and the summary.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::damage::{self, Expected};
use crate::files;
use crate::ground::Ground;
use crate::names;
use crate::options::Options;
use crate::random::Random;
use crate::targets::{self, Target};
use crate::unlucky::{self, Misfortune};

/// A case in its folder.
pub struct Case {
    pub random: Random,
    pub folder: PathBuf,
    /// What was done.
    pub told: String,
}

/// Something that must not be.
pub struct Fault {
    pub kind: &'static str,
    pub what: String,
    pub line: String,
    /// What the command said on standard error.
    pub ended: String,
}

/// The kind of a case.
enum RoundKind {
    Damage(&'static Target),
    Misfortune(Misfortune),
    Names,
}

impl RoundKind {
    fn draw(random: &mut Random) -> RoundKind {
        match random.below(20) {
            0..=15 => RoundKind::Damage(damage::draw(random)),
            16..=18 => RoundKind::Misfortune(unlucky::draw(random)),
            _ => RoundKind::Names,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            RoundKind::Damage(target) => target.name,
            RoundKind::Misfortune(what) => what.name(),
            RoundKind::Names => "names",
        }
    }
}

/// Counts of one kind of case.
#[derive(Default)]
struct Count {
    cases: u64,
    faults: BTreeMap<&'static str, u64>,
}

/// What all threads share.
struct Attack<'a> {
    options: &'a Options,
    ground: &'a Ground,
    base: &'a Path,
    expected: Expected,
    next: AtomicU64,
    until: Instant,
    counts: Mutex<BTreeMap<&'static str, Count>>,
}

/// Runs all cases, prints the summary, and returns the number of cases that failed.
pub fn all(options: &Options) -> Result<u64, String> {
    check_names(&options.what)?;
    let base = tempfile::tempdir().map_err(|error| error.to_string())?;
    let place = base.path().join("ground");
    fs::create_dir(&place).map_err(|error| error.to_string())?;
    let begun = Instant::now();
    let ground = Ground::make(&place, &options.program)?;
    println!("seed {}; undamaged files made in {:.1} s", options.seed, begun.elapsed().as_secs_f64());
    let seconds = Duration::from_secs(options.seconds.min(1 << 31));
    let attack = Attack {
        options,
        ground: &ground,
        base: base.path(),
        expected: Expected::default(),
        next: AtomicU64::new(options.only.unwrap_or(0)),
        until: Instant::now() + seconds,
        counts: Mutex::default(),
    };
    let jobs = if options.only.is_some() { 1 } else { options.jobs };
    let failed = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..jobs).map(|_| scope.spawn(|| attack.work())).collect();
        threads
            .into_iter()
            .try_for_each(|thread| thread.join().unwrap_or_else(|_| Err("the attack itself panicked".into())))
    });
    let faults = attack.summary(begun.elapsed());
    failed.map(|()| faults)
}

fn check_names(wanted: &[String]) -> Result<(), String> {
    let others = ["kills", "starts", "full-disk", "lost-outputs", "names"];
    let known: Vec<&str> = targets::ALL.iter().map(|target| target.name).chain(others).collect();
    match wanted.iter().find(|name| !known.contains(&name.as_str())) {
        Some(name) => Err(format!("--what {name}: known are {}", known.join(", "))),
        None => Ok(()),
    }
}

impl Attack<'_> {
    /// Cases one after another, until there are enough or the time is over.
    fn work(&self) -> Result<(), String> {
        loop {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            let over = match self.options.only {
                Some(only) => number > only,
                None => number >= self.options.cases || Instant::now() > self.until,
            };
            if over {
                return Ok(());
            }
            self.case(number)?;
        }
    }

    fn case(&self, number: u64) -> Result<(), String> {
        let kind = RoundKind::draw(&mut Random::new(self.options.seed, number));
        let name = kind.name();
        let wanted = &self.options.what;
        if !wanted.is_empty() && !wanted.iter().any(|what| what == name) {
            return Ok(());
        }
        let (mut case, mut faults) = self.attempt(number)?;
        // Another process may have kept this machine busy: what hangs must hang twice.
        if faults.iter().any(|find| find.kind == "hang") {
            (case, faults) = self.attempt(number)?;
        }
        let mut counts = self.counts.lock().map_err(|_| "another thread has failed")?;
        let count = counts.entry(name).or_default();
        count.cases += 1;
        for find in &faults {
            *count.faults.entry(find.kind).or_default() += 1;
            println!(
                "case {number} ({name}) {}: {}\n    {}\n    {}",
                find.kind, case.told, find.line, find.what
            );
        }
        drop(counts);
        if !faults.is_empty() || self.options.only.is_some() {
            self.keep(number, name, &mut case, &faults)?;
        }
        let _ = fs::remove_dir_all(&case.folder);
        Ok(())
    }

    fn attempt(&self, number: u64) -> Result<(Case, Vec<Fault>), String> {
        let mut random = Random::new(self.options.seed, number);
        let kind = RoundKind::draw(&mut random);
        let folder = self.base.join(format!("case-{number}"));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let mut case = Case { random, folder, told: String::new() };
        let program = &self.options.program;
        let faults = match kind {
            RoundKind::Damage(target) => {
                damage::attack(self.ground, program, &self.expected, target, &mut case)
            }
            RoundKind::Misfortune(what) => unlucky::attack(self.ground, program, what, &mut case),
            RoundKind::Names => names::attack(self.ground, program, &mut case),
        };
        Ok((case, faults.map_err(|why| format!("case {number}: {why}"))?))
    }

    /// Keeps the files of a case, with an account of it.
    fn keep(&self, number: u64, name: &str, case: &mut Case, faults: &[Fault]) -> Result<(), String> {
        let kept = self.options.out.join(format!("seed-{}-case-{number}", self.options.seed));
        let _ = fs::remove_dir_all(&kept);
        let mut text = format!("seed {}, case {number}, {name}\n{}\n", self.options.seed, case.told);
        for find in faults {
            let _ = write!(text, "\n{}: {}\n$ {}\n{}\n", find.kind, find.what, find.line, find.ended);
        }
        // Devices and FIFOs are not copied.
        let copied = fs::create_dir_all(&kept).and_then(|()| {
            for file in files::under(&case.folder) {
                files::copy(&case.folder.join(&file), &kept.join(&file))?;
            }
            fs::write(kept.join("account.txt"), text)
        });
        copied.map_err(|error| format!("{}: {error}", kept.display()))?;
        if self.options.only.is_some() {
            println!("case {number} ({name}): {}\nkept in {}", case.told, kept.display());
        }
        Ok(())
    }

    fn summary(&self, time: Duration) -> u64 {
        let Ok(counts) = self.counts.lock() else { return 1 };
        let mut total = 0;
        for (name, count) in counts.iter() {
            let faults: Vec<String> =
                count.faults.iter().map(|(kind, number)| format!("{number} {kind}")).collect();
            let faults = if faults.is_empty() { "nothing".into() } else { faults.join(", ") };
            println!("{name:<22} {:>6} cases  found: {faults}", count.cases);
            total += count.faults.values().sum::<u64>();
        }
        let cases: u64 = counts.values().map(|count| count.cases).sum();
        println!("seed {}: {cases} cases in {:.0} s, {total} faults", self.options.seed, time.as_secs_f64());
        total
    }
}
