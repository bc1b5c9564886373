//! `granum examine paths`: how well surrogates with a state follow any path.

use std::path::PathBuf;

use clap::Args;
use granum_core::json;
use granum_core::words;
use granum_io::check_output_file;
use granum_io::shell::ShowPath;
use granum_learn::LearnError;
use granum_learn::examine::{AnyPath, HeldStates, PathAnswer, PathAnswers};
use granum_learn::runs::RunRole;
use granum_learn::surrogate::{self, Surrogate};

use super::question::{RunFlags, WorkFlags, about, percent, put, table};
use crate::command::records;
use crate::command::train_study::dataset;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Fit surrogates with a state to runs along any paths of strain, such as those of the plan random-paths, and roll them out freely along whole unseen
/// runs, from the state of the sample. Errors are told by kind of path, beside baselines and the scatter between samples on the same path; with them the
/// work in closed cycles of strain, which should not be negative, and errors at the beginning and the end of long runs.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum examine paths paths --unseen unseen --long cycles\n  granum examine paths paths --unseen-share 0.25 --method path-tensor path-tensor:internal=0,hidden=12"
)]
pub struct PathFlags {
    #[command(flatten)]
    runs: RunFlags,
    /// Long runs, on which errors at the beginning and the end are measured.
    #[arg(long, num_args = 1.., value_name = "RUN")]
    long: Vec<PathBuf>,
    /// The methods, with settings after a colon: hidden, internal, window, networks, rotations, epochs, rate.
    #[arg(
        long,
        value_name = "NAME",
        num_args = 1..,
        default_values = ["path-gru", "path-lstm", "path-state-space", "path-window", "path-tensor"]
    )]
    method: Vec<String>,
    /// The volume is an input, as all other strains are, and the mean stress is learned in its place: for paths at changing mean stress, such as those of the plan
    /// sand-step.
    #[arg(long)]
    volume_is_input: bool,
    /// Parameters of the runs that are inputs beside the state of the sample, such as grains.material.friction.
    #[arg(long, num_args = 1.., value_name = "KEY")]
    property: Vec<String>,
    /// Seed of the methods, and of --unseen-share.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Number of threads; all processors by default. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    threads: Option<u64>,
    /// Write the answers to this file, as JSON.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write the surrogate of the only method to this file: for `granum predict`, and for material points.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
}

impl PathFlags {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        self.out.iter().chain(&self.model).try_for_each(|file| check_output_file(file, context.force))?;
        if self.model.is_some() && self.method.len() != 1 {
            let message = format!(
                "--model takes the surrogate of one method, and --method names {}",
                self.method.len()
            );
            return Err(Failure::new(message));
        }
        let (training, unseen) = self.runs.read(context, self.seed)?;
        let long = records::read(context, &self.long, RunRole::Unseen)?;
        let long = match long.is_empty() {
            true => None,
            false => Some(dataset(&long.iter().collect::<Vec<_>>())?),
        };
        let question = AnyPath {
            methods: self.method.clone(),
            volume_is_input: self.volume_is_input,
            properties: self.property.clone(),
            seed: self.seed,
            threads: self.threads.unwrap_or(0) as usize,
        };
        let mut keep = |surrogate: &dyn Surrogate| match &self.model {
            Some(file) => surrogate::save(file, surrogate),
            None => Ok(()),
        };
        let answers = WorkFlags::observed(context, |observer| {
            question.measure(&training, &unseen, long.as_ref(), context.methods(), (&mut keep, observer))
        })?;
        if let Some(file) = &self.out {
            let text = json::readable(&answers).map_err(|error| LearnError::Content(error.to_string()))?;
            put(file, &text)?;
        }
        let mut lines = vec![about(&unseen)];
        lines.extend(errors(&answers));
        lines.extend(work(&answers));
        lines.extend(intervals("states within their intervals, %", &answers.intervals));
        lines.extend(drift(&answers));
        lines.extend(intervals("long runs: states within their intervals, %", &answers.intervals_of_long));
        let result = serde_json::json!({ "answers": answers, "out": self.out.as_deref().map(output::path), "model": self.model.as_deref().map(output::path) });
        output::say(context, &result, || {
            let wrote = self.out.iter().chain(&self.model).map(|file| format!("wrote {}", file.shown()));
            lines.into_iter().chain(wrote).collect::<Vec<_>>().join("\n")
        })
    }
}

/// Each value once, in the order in which they occur.
fn distinct<'a>(values: impl Iterator<Item = &'a String>) -> Vec<&'a String> {
    let mut found: Vec<&String> = Vec::new();
    for value in values {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

/// A table for each quantity: methods by kinds of path.
fn errors(answers: &PathAnswers) -> Vec<String> {
    let all = &answers.errors;
    let kinds = distinct(all.iter().map(|own| &own.kind));
    let mut lines = Vec::new();
    for quantity in distinct(all.iter().map(|own| &own.quantity)) {
        let own: Vec<&PathAnswer> = all.iter().filter(|own| own.quantity == *quantity).collect();
        let head = ["method"].into_iter().chain(kinds.iter().map(|kind| kind.as_str())).map(String::from);
        let mut rows = Vec::new();
        for method in distinct(own.iter().map(|own| &own.method)) {
            let of_kind = |kind: &&String| {
                let found = own.iter().find(|own| own.method == *method && own.kind == **kind);
                found.map_or_else(|| "-".into(), |own| percent(&own.error))
            };
            rows.push([method.clone()].into_iter().chain(kinds.iter().map(of_kind)).collect());
        }
        lines.extend([String::new(), quantity.clone()]);
        lines.extend(table(&head.collect::<Vec<_>>(), &rows));
    }
    lines
}

fn work(answers: &PathAnswers) -> Vec<String> {
    if answers.work.iter().all(|own| own.cycles == 0) {
        return Vec::new();
    }
    let head =
        ["work in closed cycles", "cycles", "negative", "least / mean, %", "error, %"].map(String::from);
    let row = |own: &granum_learn::examine::WorkInCycles| {
        let share = |value: f64| words::fixed(100.0 * value, 1);
        let counts = [own.cycles, own.negative].map(|count| count.to_string());
        [vec![own.method.clone()], counts.to_vec(), vec![share(own.least), share(own.error)]].concat()
    };
    let rows: Vec<Vec<String>> = answers.work.iter().map(row).collect();
    [vec![String::new()], table(&head, &rows)].concat()
}

fn drift(answers: &PathAnswers) -> Vec<String> {
    if answers.drift.is_empty() {
        return Vec::new();
    }
    let head = ["long runs", "quantity", "first tenth", "last tenth"].map(String::from);
    let row = |own: &granum_learn::examine::Drift| {
        let words = vec![own.method.clone(), own.quantity.clone()];
        [words, own.error.iter().map(percent).collect()].concat()
    };
    let rows: Vec<Vec<String>> = answers.drift.iter().map(row).collect();
    [vec![String::new()], table(&head, &rows)].concat()
}

/// The shares of all runs that lie within their intervals, with the least of those by kind, along the path and by void ratio.
fn intervals(title: &str, held: &[HeldStates]) -> Vec<String> {
    let Some(level) = held.first().map(|own| own.level) else { return Vec::new() };
    let share = |value: f64| format!("{:.1}", 100.0 * value);
    let least = |values: &[Option<f64>; 4]| {
        let known = values.iter().flatten().copied();
        known.reduce(f64::min).map_or_else(|| "-".into(), share)
    };
    let of_all = |own: &&HeldStates| own.kind == held[0].kind;
    let row = |own: &HeldStates| {
        let kinds = held.iter().filter(|other| {
            !of_all(other) && (&other.method, &other.quantity) == (&own.method, &own.quantity)
        });
        let least_kind = kinds.min_by(|a, b| a.held.total_cmp(&b.held));
        vec![
            own.method.clone(),
            own.quantity.clone(),
            format!("{} ± {}", share(own.held), share(own.standard_error)),
            least_kind.map_or_else(|| "-".into(), |own| format!("{} ({})", share(own.held), own.kind)),
            least(&own.along_path),
            least(&own.by_void_ratio),
        ]
    };
    let head =
        ["method", "quantity", "all runs", "worst kind", "worst quarter of the path", "of the void ratio"];
    let rows: Vec<Vec<String>> = held.iter().filter(of_all).map(row).collect();
    let title = format!("{title} (intervals of {} %)", (100.0 * level).round());
    [vec![String::new(), title], table(&head.map(String::from), &rows)].concat()
}
