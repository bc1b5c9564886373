//! What must hold of every end of a command.

use std::path::Path;

use crate::files;
use crate::process::{Ended, signal_of};

/// Exit statuses of a command that ends by itself: success, failure, wrong command line, interruption.
const STATUSES: [i32; 4] = [0, 1, 2, 130];
/// Ends of names of files that are being written.
const UNFINISHED: [&str; 2] = [".granum-unfinished", ".part"];

/// What is wrong with the end of a command, whatever it was to do: a kind and a sentence.
pub fn wrong(ended: &Ended, simulates: bool) -> Option<(&'static str, String)> {
    let told = format!("{}\n{}", ended.output, ended.error);
    let panicked = told.contains("panicked at") || ended.code() == Some(101);
    if panicked {
        return Some((
            "panic",
            first_line_with(&told, "panicked").unwrap_or_else(|| "exit status 101".into()),
        ));
    }
    if ended.hung {
        return Some(("hang", format!("no end after {:.1} s", ended.seconds)));
    }
    let out_of_memory = told.contains("memory allocation of");
    if out_of_memory && simulates {
        // A case may ask for more grains than the limit of the attack has room for.
        return None;
    }
    if out_of_memory {
        return Some(("memory", first_line_with(&told, "memory allocation of").unwrap_or_default()));
    }
    if let Some(signal) = signal_of(ended.status) {
        return Some(("signal", format!("ended by signal {signal}")));
    }
    let code = ended.code().unwrap_or(-1);
    if !STATUSES.contains(&code) || (code == 130 && !ended.stopped) {
        return Some(("status", format!("exit status {code}")));
    }
    None
}

/// A failure must say why, and with `--json` every output is JSON.
pub fn wrong_words(ended: &Ended) -> Option<(&'static str, String)> {
    let failed = !ended.succeeded();
    if failed && ended.error.trim().is_empty() {
        return Some(("silent", "it failed without a message".into()));
    }
    if !ended.line.contains(" --json") {
        return None;
    }
    let is_json = |text: &str| serde_json::from_str::<serde_json::Value>(text).is_ok();
    if failed && !ended.error.lines().all(is_json) {
        return Some(("json", "with --json the error is not JSON".into()));
    }
    if !failed && !is_json(&ended.output) {
        return Some(("json", "with --json the output is not JSON".into()));
    }
    None
}

/// Files that a command which ended by itself has left half-written.
pub fn left_behind(folder: &Path) -> Option<(&'static str, String)> {
    let all = files::under(folder);
    let left = all.iter().find(|file| UNFINISHED.iter().any(|end| file.to_string_lossy().ends_with(end)))?;
    Some(("left", format!("{} was left behind", left.display())))
}

fn first_line_with(text: &str, word: &str) -> Option<String> {
    // The line after that of a panic is its message.
    let mut lines = text.lines().skip_while(|line| !line.contains(word));
    let first = lines.next()?;
    Some(format!("{first} {}", lines.next().unwrap_or_default()))
}
