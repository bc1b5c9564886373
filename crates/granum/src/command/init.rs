//! `granum init`: a case file to start from: every key at its default, or one of the ready cases.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use granum::gallery::{CASES, ReadyCase};
use granum_core::names::suggestion;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_io::{Case, atomic::write_atomically, check_output_file};
use serde_json::{Value, json};

use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Write a commented case file: every key at its default, or one of the ready cases.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum init my-sand.toml\n  granum run my-sand.toml\n  granum init --list\n  granum init --case drained-dense \
                  dense.toml\n  granum run dense.toml --out dense"
)]
pub struct Init {
    /// Path of the case file; by default case.toml, or the name of the ready case.
    #[arg(value_name = "FILE")]
    path: Option<PathBuf>,
    /// Write this ready case.
    #[arg(long, value_name = "NAME")]
    case: Option<String>,
    /// List the ready cases and write nothing.
    #[arg(long, conflicts_with_all = ["path", "case"])]
    list: bool,
}

impl Init {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if self.list {
            return list(context);
        }
        let Some(name) = &self.case else {
            let path = self.path.clone().unwrap_or_else(|| PathBuf::from("case.toml"));
            write(&path, &Case::template(), context)?;
            return output::say(context, &json!({ "case": output::path(&path) }), || {
                let (shown, quoted) = (path.shown(), quoted_path(&path));
                format!(
                    "wrote {shown}, with every key at its default; change values in it and run it: granum run {quoted}"
                )
            });
        };
        let ready = ReadyCase::named(name).ok_or_else(|| {
            let known = CASES.iter().map(|ready| ready.name);
            Failure::new(format!("--case {name}: there is no such ready case; {}", suggestion(name, known)))
        })?;
        let path = self.path.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.toml")));
        write(&path, ready.text, context)?;
        output::say(
            context,
            &json!({ "case": output::path(&path), "name": name, "title": ready.title() }),
            || {
                let quoted = quoted_path(&path);
                format!("wrote {}: {}\nrun it: granum run {quoted} --out {name}", path.shown(), ready.title())
            },
        )
    }
}

fn write(path: &Path, text: &str, context: &Context) -> Result<(), Failure> {
    check_output_file(path, context.force)?;
    Ok(write_atomically(path, |file| file.write_all(text.as_bytes()))?)
}

fn list(context: &Context) -> Result<(), Failure> {
    let ready = |ready: &ReadyCase| json!({ "name": ready.name, "title": ready.title() });
    let cases: Vec<Value> = CASES.iter().map(ready).collect();
    output::say(context, &json!({ "cases": cases }), || {
        let lines: Vec<String> =
            CASES.iter().map(|ready| format!("{:<20} {}", ready.name, ready.title())).collect();
        format!("{}\nwrite one: granum init --case NAME", lines.join("\n"))
    })
}
