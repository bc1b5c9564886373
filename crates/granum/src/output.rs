//! What a command prints or writes in the end.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use granum_io::{Table, check_output_file, csv, write_table};
use serde_json::{Map, Value, json};

use crate::context::Context;
use crate::failure::Failure;

/// Writes a table to a file, or to the standard output (CSV, or columns as JSON).
pub fn put_table(context: &Context, output: Option<&Path>, table: &Table) -> Result<(), Failure> {
    if let Some(path) = output {
        check_output_file(path, context.force)?;
        write_table(path, table)?;
        return say(context, &json!({ "output": path, "rows": table.rows() }), || {
            format!("wrote {} rows to {}", table.rows(), path.display())
        });
    }
    if context.json {
        let columns: Map<String, Value> =
            table.columns().iter().map(|column| (column.name.clone(), json!(column.values))).collect();
        return print(&format!("{}\n", Value::Object(columns)));
    }
    let mut out = BufWriter::new(io::stdout().lock());
    unless_closed(csv::write_rows(&mut out, table).and_then(|()| out.flush()))
}

/// Prints the result of a command: as JSON, or as a sentence for people.
pub fn say(context: &Context, result: &Value, text: impl FnOnce() -> String) -> Result<(), Failure> {
    print(&if context.json { format!("{result}\n") } else { format!("{}\n", text()) })
}

fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    unless_closed(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// A reader that has seen enough (`| head`) is no failure.
fn unless_closed(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(format!("cannot write to the standard output: {error}")))
        }
        _ => Ok(()),
    }
}
