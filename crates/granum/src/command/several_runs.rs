//! Several runs in one folder: all combinations of the values that the flags give.

use std::collections::BTreeSet;
use std::path::Path;

use granum::contents::{FolderKind, check_free};
use granum_io::OutputFolder;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_run::Laboratory;
use granum_run::laboratory::Source;
use granum_run::queue::{Outcome, Queue, QueueError, QueuedRun, RUN_LIST, RunKind, RunList};
use granum_run::runs_table::{RunEntry, RunsTable, Selection};
use serde_json::{Value, json};

use super::case_flags::Combination;
use super::foreseen::Foreseen;
use super::show_queue::ShowQueue;
use super::text_table;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::output;

/// Folder of the samples that several tests share.
const SAMPLES: &str = "samples";

/// Executes the runs in folders below `out`, or continues them, and prints a table of their results.
pub fn run(
    context: &Context,
    laboratory: &Laboratory,
    kind: RunKind,
    cases: Vec<Combination>,
    source: &Source,
    out: &Path,
) -> Result<(), Failure> {
    check_free(out, FolderKind::Runs, true, context.vocabulary())?;
    let runs = cases.into_iter().map(|case| planned(kind, case, source, out)).collect();
    let queue = Queue::with_shared_samples(runs, &out.join(SAMPLES))?;
    // A mistake in any run leaves nothing behind.
    check(&queue, laboratory, context.force)?;
    // With --json nothing is printed before the runs have ended, when their checks tell.
    if !context.json {
        Foreseen::of_queue(&queue).tell(context, "");
    }
    let folder = OutputFolder::open_or_create(out)?;
    folder.refuse_links(&[SAMPLES])?;
    let list = RunList::from_queue(&queue, out)?;
    let list = match RunList::read(out)? {
        Some(earlier) => list.with_earlier(earlier),
        None => list,
    };
    list.write(out)?;
    execute(context, laboratory, &queue, &folder)
}

/// Continues the runs of a folder.
pub fn resume(context: &Context, laboratory: &Laboratory, list: &RunList, out: &Path) -> Result<(), Failure> {
    let queue = list.queue(out, context.vocabulary())?;
    check(&queue, laboratory, false)?;
    let folder = OutputFolder::open(out)?;
    folder.refuse_links(&[SAMPLES])?;
    execute(context, laboratory, &queue, &folder)
}

fn planned(kind: RunKind, case: Combination, source: &Source, out: &Path) -> QueuedRun {
    let folder = out.join(&case.name);
    let run = QueuedRun::test(case.name, case.case, source.clone(), folder);
    QueuedRun { kind, values: case.values, ..run }
}

fn check(queue: &Queue, laboratory: &Laboratory, force: bool) -> Result<(), Failure> {
    queue.check(laboratory, force).map_err(|error| match error {
        QueueError::OtherRun { .. } => {
            Failure::new(format!("{error}; give --force to replace it, or another folder with --out"))
        }
        other => other.into(),
    })
}

fn execute(
    context: &Context,
    laboratory: &Laboratory,
    queue: &Queue,
    folder: &OutputFolder,
) -> Result<(), Failure> {
    if context.force {
        queue.replace_others(laboratory)?;
    }
    let samples = shared_samples(queue).len();
    let tests = format!("{} runs", queue.runs().len() - samples);
    let phase = match samples {
        0 => tests,
        1 => format!("{tests}, 1 shared sample"),
        _ => format!("{tests}, {samples} shared samples"),
    };
    let labels = queue.runs().iter().map(|run| run.name.clone()).collect();
    let show = ShowQueue::new(context, queue, &phase, labels);
    let outcomes = queue.run(laboratory, &show);
    let finished = outcomes.iter().filter(|outcome| outcome.is_finished()).count();
    if outcomes.iter().any(Outcome::is_stopped) {
        let (out, quoted) = (folder.path().shown(), quoted_path(folder.path()));
        let all = outcomes.len();
        let left =
            format!("{finished} of {all} runs in {out} are finished; continue with `granum resume {quoted}`");
        return Err(Interrupted { left }.into());
    }
    show.end(|| match outcomes.len() - finished {
        0 => "finished".into(),
        failed => format!("{failed} failed"),
    });
    print(context, queue, &outcomes, folder.path())?;
    let failed: Vec<String> = queue
        .runs()
        .iter()
        .zip(&outcomes)
        .filter_map(|(run, outcome)| Some(format!("{}: {}", run.name, outcome.failure()?)))
        .collect();
    if failed.is_empty() {
        return Ok(());
    }
    let all = outcomes.len();
    Err(Failure::new(format!("{} of {all} runs failed:\n  {}", failed.len(), failed.join("\n  "))))
}

/// The names of the samples that were added for the tests which share them.
fn shared_samples(queue: &Queue) -> BTreeSet<&str> {
    queue.runs().iter().filter_map(|run| run.after.as_deref()).collect()
}

/// Prints the runs with their results.
fn print(context: &Context, queue: &Queue, outcomes: &[Outcome], out: &Path) -> Result<(), Failure> {
    let runs = queue.runs().iter().zip(outcomes);
    let shared = shared_samples(queue);
    let (samples, tests): (Vec<_>, Vec<_>) = runs.partition(|(run, _)| shared.contains(run.name.as_str()));
    let result = json!({
        "folder": output::path(out),
        "list": output::path(&out.join(RUN_LIST)),
        "runs": tests.iter().map(|(run, outcome)| as_json(context, run, outcome)).collect::<Vec<_>>(),
        "samples": samples.iter().map(|(run, outcome)| as_json(context, run, outcome)).collect::<Vec<_>>(),
    });
    let entries: Vec<RunEntry> = tests
        .iter()
        .filter_map(|(run, outcome)| {
            let record = outcome.record()?.clone();
            Some(RunEntry::new(run.name.clone(), run.folder.clone(), run.case.clone(), record))
        })
        .collect();
    let table = RunsTable::from_runs(&entries).select(Selection::Main);
    output::say_complete(context, out, &result, || {
        let reused =
            outcomes.iter().filter(|outcome| matches!(outcome, Outcome::Finished { reused: true, .. }));
        let mut lines = text_table::lines(&table);
        match reused.count() {
            0 => {}
            count if count == outcomes.len() => {
                lines.push("all were already finished; nothing was left to do".into());
            }
            count => lines.push(format!("{count} were already finished")),
        }
        lines.push(format!("wrote {}; all columns: granum table {}", out.shown(), quoted_path(out)));
        lines.join("\n")
    })
}

fn as_json(context: &Context, run: &QueuedRun, outcome: &Outcome) -> Value {
    let values: serde_json::Map<String, Value> =
        run.values.iter().map(|(key, value)| (key.clone(), json!(value))).collect();
    let record = outcome.record();
    let unpassed = record.into_iter().flat_map(|record| &record.quality).filter(|flag| !flag.passed);
    let failed_checks: Vec<&str> = unpassed.map(|flag| flag.name.as_str()).collect();
    if !failed_checks.is_empty() {
        context.warn_in_json(&format!("{}: checks not passed: {}", run.name, failed_checks.join(", ")));
    }
    json!({
        "name": run.name,
        "folder": output::path(&run.folder),
        "values": values,
        "status": outcome.word(),
        "reused": matches!(outcome, Outcome::Finished { reused: true, .. }),
        "failure": outcome.failure(),
        "case_digest": record.map(|record| &record.case_digest),
        "measures": record.map(|record| &record.measures),
        "failed_checks": failed_checks,
    })
}
