//! `granum run`: the test of a case along an arbitrary path.

use std::path::PathBuf;

use clap::Args;
use granum_core::quantity::format_number;
use granum_dem::loading::preset::{PathParameter, PathParameterDefault, PathParameterKind, Preset};
use serde_json::{Value, json};

use super::test_run::TestRun;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Prepare or read a sample, test it along the path of its case or along a named path, and write a run folder.
///
/// Several values of a key or parameter, between commas, make several runs: all combinations, in folders below --out that are named
/// by their values. Samples that several runs share are prepared once, and as many runs as there are processors go on at once. The
/// same command continues what is unfinished. A key whose value is a list takes several lists in brackets:
/// --set recording.strains="[[0.01, 0.1], [0.02, 0.2]]".
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum run my-sand.toml --path drained-triaxial --out drained\n  granum run my-sand.toml --path undrained-triaxial \
                  --with axial_strain=0.1 --out undrained\n  granum run my-stages.toml --set stage.1.axial_strain=0.05 --out run-2\n  \
                  granum run my-sand.toml --path drained-triaxial --with lateral_stress=\"50 kPa,100 kPa\" --seed 1,2,3 --out study\n  \
                  granum run --list"
)]
pub struct Run {
    /// The case file.
    #[arg(required_unless_present = "list")]
    case: Option<PathBuf>,
    /// Use this named path instead of the test of the case.
    #[arg(long, value_name = "NAME")]
    path: Option<String>,
    /// A parameter of the path, e.g. --with axial_strain=0.1; can be repeated. Several values, e.g. --with lateral_stress="50
    /// kPa,100 kPa", make several runs.
    #[arg(long, value_name = "KEY=VALUE", requires = "path")]
    with: Vec<String>,
    /// List the named paths with their parameters, without running anything.
    #[arg(long, conflicts_with_all = ["case", "path"])]
    list: bool,
    #[command(flatten)]
    test: TestRun,
}

impl Run {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let Some(file) = self.case.as_ref().filter(|_| !self.list) else { return list(context) };
        let parameters = parameters(&self.with)?;
        let path = self.path.as_deref().map(|name| (name, parameters.as_slice()));
        self.test.run(context, file, path)
    }
}

/// Keys and values of `--with`.
pub fn parameters(with: &[String]) -> Result<Vec<(&str, &str)>, Failure> {
    let needed = |text: &String| {
        Failure::new(format!(
            "--with {text:?}: a parameter and its value are needed, e.g. --with axial_strain=0.1"
        ))
    };
    let pair = |text| str::split_once(text, '=').map(|(key, value)| (key.trim(), value.trim()));
    with.iter().map(|text| pair(text.as_str()).ok_or_else(|| needed(text))).collect()
}

/// The named paths with their parameters.
fn list(context: &Context) -> Result<(), Failure> {
    let known = context.vocabulary().paths();
    let paths: Vec<Value> = known.all().iter().map(|path| described(path)).collect();
    output::say(context, &json!({ "paths": paths }), || {
        let paths = known.all();
        let common = common(paths);
        let mut parts: Vec<String> = paths.iter().map(|path| text(path, &common)).collect();
        parts.push(
            std::iter::once("Every path also takes".to_string())
                .chain(lines_of(common.iter()))
                .collect::<Vec<_>>()
                .join("\n"),
        );
        parts.join("\n\n")
    })
}

/// The parameters that every path takes in the same way.
fn common(paths: &[&'static Preset]) -> Vec<&'static PathParameter> {
    let Some(first) = paths.first() else { return Vec::new() };
    let everywhere = |p: &&PathParameter| paths.iter().all(|path| path.parameters().any(|other| other == *p));
    first.parameters().filter(everywhere).collect()
}

fn described(path: &Preset) -> Value {
    let parameter = |p: &PathParameter| {
        let default = match p.default {
            PathParameterDefault::Value(value) => json!(value),
            PathParameterDefault::Word(word) => json!(word),
            PathParameterDefault::List(values) => json!(values),
            PathParameterDefault::Absent(_) | PathParameterDefault::Needed => Value::Null,
        };
        let mut found = json!({ "key": p.key, "help": p.help, "default": default });
        match p.kind {
            PathParameterKind::Number | PathParameterKind::List => {
                found["unit"] = json!(p.unit);
                found["bounds"] = json!(p.bounds);
            }
            PathParameterKind::Word(words) => {
                found["words"] =
                    words.iter().map(|[word, meaning]| json!({ "word": word, "meaning": meaning })).collect()
            }
            PathParameterKind::History => {}
        }
        found
    };
    let parameters: Vec<Value> = path.parameters().map(parameter).collect();
    json!({ "name": path.name, "help": path.help, "parameters": parameters })
}

fn text(path: &'static Preset, common: &[&PathParameter]) -> String {
    let mut lines = vec![path.name.to_string(), format!("  {}", path.help)];
    let own: Vec<&PathParameter> = path.parameters().filter(|p| !common.contains(p)).collect();
    lines.extend(lines_of(own.iter()));
    lines.join("\n")
}

/// Parameters with what they mean, their defaults and words, a line each.
fn lines_of<'a>(parameters: impl Iterator<Item = &'a &'a PathParameter>) -> Vec<String> {
    let mut lines = Vec::new();
    for p in parameters {
        let unit = if p.unit == "1" { String::new() } else { format!(" {}", p.unit) };
        let default = match p.default {
            PathParameterDefault::Value(value) => format!("Default: {}{unit}.", format_number(value)),
            PathParameterDefault::Word(word) => format!("Default: {word}."),
            PathParameterDefault::List(values) => {
                let values: Vec<String> = values.iter().copied().map(format_number).collect();
                format!("Default: {}.", values.join(","))
            }
            PathParameterDefault::Absent(meaning) => format!("Default: {meaning}."),
            PathParameterDefault::Needed => "Required.".to_string(),
        };
        lines.push(format!("  {}: {} {default}", p.key, p.help));
        if let PathParameterKind::Word(words) = p.kind {
            lines.extend(words.iter().map(|[word, meaning]| format!("    {word}: {meaning}.")));
        }
    }
    lines
}
