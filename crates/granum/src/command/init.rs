//! `granum init`: a case file to start from: every key at its default, or one of the ready cases.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use granum::gallery::{CALIBRATIONS, CASES, PLANS, ReadyCalibration, ReadyCase, ReadyPlan};
use granum_core::input::{self, LARGEST_INPUT};
use granum_core::names::suggestion;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_io::{Case, atomic::write_atomically, check_output_file};
use serde_json::{Value, json};

use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Write a commented case file, every key at its default or one of the ready cases, one of the ready plans of campaigns, or one of the ready
/// files of calibrations.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum init my-sand.toml\n  granum run my-sand.toml\n  granum init --list\n  granum init --case drained-dense \
                  dense.toml\n  granum run dense.toml --out dense\n  granum init --plan friction-pressure-density"
)]
pub struct Init {
    /// Path of the case file; by default case.toml, or the name of the ready case.
    #[arg(value_name = "FILE")]
    path: Option<PathBuf>,
    /// Write this ready case.
    #[arg(long, value_name = "NAME")]
    case: Option<String>,
    /// Write this ready plan, and beside it the case that it starts from.
    #[arg(long, value_name = "NAME", conflicts_with = "case")]
    plan: Option<String>,
    /// Write this ready file of a calibration, and beside it the case that it starts from.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["case", "plan"])]
    calibration: Option<String>,
    /// List the ready cases, plans and calibrations and write nothing.
    #[arg(long, conflicts_with_all = ["path", "case", "plan", "calibration"])]
    list: bool,
}

impl Init {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if self.list {
            return list(context);
        }
        if let Some(name) = &self.plan {
            let ready = ReadyPlan::named(name).ok_or_else(|| {
                let known = PLANS.iter().map(|ready| ready.name);
                Failure::new(format!(
                    "--plan {name}: there is no such ready plan; {}",
                    suggestion(name, known)
                ))
            })?;
            let (text, title) = (ready.text, ready.title());
            return self.write_with_case(
                context,
                name,
                ready.case,
                text,
                title,
                ("plan", "see what it runs: granum campaign {} --dry-run"),
            );
        }
        if let Some(name) = &self.calibration {
            let ready = ReadyCalibration::named(name).ok_or_else(|| {
                let known = CALIBRATIONS.iter().map(|ready| ready.name);
                let help = suggestion(name, known);
                Failure::new(format!(
                    "--calibration {name}: there is no such ready file of a calibration; {help}"
                ))
            })?;
            let (text, title) = (ready.text, ready.title());
            let next = ("calibration", "calibrate on tests of a laboratory: granum calibrate {} LAB.csv");
            return self.write_with_case(context, name, ready.case, text, title, next);
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

impl Init {
    /// Writes a ready file and its base case, both or neither. `next` is the key of the file in JSON, and the command that goes on.
    fn write_with_case(
        &self,
        context: &Context,
        name: &str,
        case: &str,
        text: &str,
        title: &str,
        (what, next): (&str, &str),
    ) -> Result<(), Failure> {
        let base = ReadyCase::named(case)
            .ok_or_else(|| Failure::new(format!("the base case {case} of {name} is missing")))?;
        let path = self.path.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.toml")));
        let case = path.with_file_name(format!("{}.toml", base.name));
        // A case that is there already, as it is, serves.
        let is_there = input::read(&case, LARGEST_INPUT).is_ok_and(|text| text == base.text.as_bytes());
        check_output_file(&path, context.force)?;
        if !is_there {
            write(&case, base.text, context)?;
        }
        write(&path, text, context)?;
        let result = json!({
            what: output::path(&path), "case": output::path(&case), "name": name, "title": title,
        });
        output::say(context, &result, || {
            let next = next.replace("{}", &quoted_path(&path).to_string());
            format!("wrote {} and {}: {title}\n{next}", path.shown(), case.shown())
        })
    }
}

fn write(path: &Path, text: &str, context: &Context) -> Result<(), Failure> {
    check_output_file(path, context.force)?;
    Ok(write_atomically(path, |file| file.write_all(text.as_bytes()))?)
}

fn list(context: &Context) -> Result<(), Failure> {
    let ready = |ready: &ReadyCase| json!({ "name": ready.name, "title": ready.title() });
    let cases: Vec<Value> = CASES.iter().map(ready).collect();
    let plan = |ready: &ReadyPlan| json!({ "name": ready.name, "case": ready.case, "title": ready.title() });
    let plans: Vec<Value> = PLANS.iter().map(plan).collect();
    let calibration =
        |ready: &ReadyCalibration| json!({ "name": ready.name, "case": ready.case, "title": ready.title() });
    let calibrations: Vec<Value> = CALIBRATIONS.iter().map(calibration).collect();
    let result = json!({ "cases": cases, "plans": plans, "calibrations": calibrations });
    output::say(context, &result, || {
        let cases = CASES.iter().map(|ready| format!("{:<20} {}", ready.name, ready.title()));
        let plans = PLANS.iter().map(|ready| format!("{:<27} {}", ready.name, ready.title()));
        let mut lines: Vec<String> = cases.collect();
        lines.push("write one: granum init --case NAME".into());
        lines.push(String::new());
        lines.push("plans of campaigns:".into());
        lines.extend(plans);
        lines.push("write one: granum init --plan NAME".into());
        lines.push(String::new());
        lines.push("calibrations:".into());
        lines.extend(CALIBRATIONS.iter().map(|ready| format!("{:<27} {}", ready.name, ready.title())));
        lines.push("write one: granum init --calibration NAME".into());
        lines.join("\n")
    })
}
