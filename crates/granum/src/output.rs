//! The output of a command.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use granum_io::formats::csv;
use granum_io::safe_text;
use granum_io::shell::ShowPath;
use granum_io::shell::path_text;
use granum_io::{Table, check_output_file, write_table};
use serde_json::{Map, Value, json};

use crate::context::Context;
use crate::failure::{Failure, Unread};
use crate::messages;

/// Writes a table to a file or to standard output (as CSV, or as columns in JSON).
pub fn put_table(context: &Context, output: Option<&Path>, table: &Table) -> Result<(), Failure> {
    put_table_with(context, output, table, &[], "")
}

/// As [`put_table`], with additional numbers for the JSON output, and with a note for the user unless it is empty.
pub fn put_table_with(
    context: &Context,
    output: Option<&Path>,
    table: &Table,
    more: &[(&str, Value)],
    note: &str,
) -> Result<(), Failure> {
    let more = more.iter().map(|(name, value)| ((*name).to_string(), value.clone()));
    if let Some(path) = output {
        check_output_file(path, context.force)?;
        write_table(path, table)?;
        let mut result =
            Map::from_iter([("output".into(), self::path(path)), ("rows".into(), json!(table.rows()))]);
        result.extend(more);
        return say(context, &Value::Object(result), || {
            let wrote = format!("wrote {} rows to {}", table.rows(), path.shown());
            if note.is_empty() { wrote } else { format!("{wrote}\n{note}") }
        });
    }
    if context.json {
        let mut all = columns(table);
        all.extend(more);
        return print(&format!("{}\n", with_warnings(context, Value::Object(all))));
    }
    if !note.is_empty() {
        messages::line(format_args!("note: {note}"));
    }
    let mut out = BufWriter::new(io::stdout().lock());
    written(csv::write_rows(&mut out, table).and_then(|()| out.flush()))
}

/// A path as JSON, also one that is not UTF-8.
pub fn path(path: &Path) -> Value {
    Value::String(path_text(path))
}

/// The columns of a table by name, as JSON.
pub fn columns(table: &Table) -> Map<String, Value> {
    table.columns().iter().map(|column| (column.name.clone(), json!(column.values))).collect()
}

/// Prints the result of a command as JSON, with the warnings as a list of strings, or as readable text.
pub fn say(context: &Context, result: &Value, text: impl FnOnce() -> String) -> Result<(), Failure> {
    print(&shown(context, result, text))
}

/// Prints a text as it is, e.g. a file that has a format of its own.
pub fn say_as_it_is(text: &str) -> Result<(), Failure> {
    print(&format!("{text}\n"))
}

/// The result of a command with the list `warnings`, which is empty if there are none.
fn with_warnings(context: &Context, mut result: Value) -> Value {
    if let Value::Object(object) = &mut result {
        object.insert("warnings".into(), json!(context.warnings()));
    }
    result
}

/// As [`say`], for a command whose results are in a folder: if the output cannot be written, the message states that the
/// folder is complete.
pub fn say_complete(
    context: &Context,
    folder: &Path,
    result: &Value,
    text: impl FnOnce() -> String,
) -> Result<(), Failure> {
    match to_output(&shown(context, result, text)) {
        Err(error) if !unread(&error) => {
            Err(Failure::new(format!("{}; {} is complete", cannot_write(&error), folder.shown())))
        }
        _ => Ok(()),
    }
}

/// Prints one of several lines at once. If nobody reads them any more, the failure ends the command without a message.
pub fn line(text: &str) -> Result<(), Failure> {
    match to_output(&format!("{text}\n")) {
        Err(error) if unread(&error) => Err(Unread.into()),
        result => written(result),
    }
}

fn shown(context: &Context, result: &Value, text: impl FnOnce() -> String) -> String {
    if context.json {
        format!("{}\n", with_warnings(context, result.clone()))
    } else {
        format!("{}\n", text())
    }
}

fn print(text: &str) -> Result<(), Failure> {
    written(to_output(text))
}

fn to_output(text: &str) -> io::Result<()> {
    // Names of files, tests or values may hold signs that a terminal obeys; escaped as in JSON they have their meaning in JSON.
    let safe = safe_text::terminal(text);
    let mut out = io::stdout().lock();
    out.write_all(safe.as_bytes()).and_then(|()| out.flush())
}

/// The result of writing to standard output, where a closed pipe is not a failure: its reader has ended early, as `| head`
/// does.
pub fn written(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(error) if !unread(&error) => Err(Failure::new(cannot_write(&error))),
        _ => Ok(()),
    }
}

fn unread(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::BrokenPipe
}

fn cannot_write(error: &io::Error) -> String {
    format!("cannot write to standard output: {error}")
}
