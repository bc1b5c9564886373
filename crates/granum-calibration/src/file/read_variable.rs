//! Reading the variables of a calibration: free ones with their priors, those that each test gives, and expressions.

use granum_campaign::plan::{Draft, Expression, PlanVariable, Reader, Spanned, VariableKind};
use granum_core::quantity::format_number;
use granum_io::Case;
use toml::de::DeValue;

use super::definition::{FreeVariable, TestCondition};
use super::words::word;
use crate::error::CalibrationError;
use crate::inference::prior::Prior;

/// The keys of a variable.
pub(super) const VARIABLE_KEYS: [&str; 12] =
    ["name", "key", "keys", "prior", "from", "to", "mean", "deviation", "step", "own", "test", "expression"];

/// Where a variable gets its value.
pub(super) enum Role {
    Free(FreeVariable),
    OfTest(TestCondition),
    Expression,
}

/// The kinds of prior.
#[derive(Clone, Copy)]
enum Kind {
    Uniform,
    LogUniform,
    Normal,
}

const KINDS: [(Kind, &str); 3] =
    [(Kind::Uniform, "uniform"), (Kind::LogUniform, "log-uniform"), (Kind::Normal, "normal")];

pub(super) fn variable(reader: &mut Reader, draft: Draft, case: &Case) -> Option<(PlanVariable, Role)> {
    let (unit, step) = reader.unit_and_step(&draft, case)?;
    let ways: Vec<&str> =
        ["prior", "test", "expression"].into_iter().filter(|key| draft.table.contains_key(*key)).collect();
    let [way] = ways.as_slice() else {
        let message = match ways.as_slice() {
            [] => format!("the variable {} has no value", draft.name),
            ways => format!("the variable {} is given by {}", draft.name, ways.join(" and by ")),
        };
        let help = "give it one of prior (it is free), test (each test gives it) and expression";
        reader.error(draft.span.clone(), message, help);
        return None;
    };
    if *way != "prior" {
        let of_priors = ["from", "to", "mean", "deviation", "step", "own"];
        if let Some(key) = of_priors.iter().find(|key| draft.table.contains_key(**key)) {
            let span = draft.table.get(*key).map_or(draft.span.clone(), |node| node.span());
            reader.error(span, format!("{key} belongs to a variable with a prior"), "leave it out");
            return None;
        }
    }
    let node = draft.table.get(*way)?;
    let (kind, role) = match *way {
        "prior" => {
            let own = match draft.table.get("own").map(|node| (node.get_ref(), node.span())) {
                None => false,
                Some((DeValue::Boolean(own), _)) => *own,
                Some((_, span)) => {
                    reader.error(span, "own must be true (each test has its value) or false", "");
                    return None;
                }
            };
            let kind = word(reader, node, "prior", &KINDS)?;
            let prior = prior(reader, &draft, kind, &unit)?;
            if let [Some(from), Some(to)] = prior.bounds() {
                reader.check_step(
                    &draft,
                    [from, to],
                    &[from, to].map(|bound| format!("{} {unit}", format_number(bound)).trim_end().to_owned()),
                    step,
                )?;
            }
            let free = FreeVariable { name: draft.name.clone(), unit: unit.clone(), prior, own, step };
            (VariableKind::Given, Role::Free(free))
        }
        "test" => (VariableKind::Given, Role::OfTest(word(reader, node, "test", &TestCondition::ALL)?)),
        _ => {
            let text = reader.text(node, "expression")?;
            match Expression::parse(&text) {
                Ok(value) => {
                    (VariableKind::Expression(Spanned { value, span: node.span() }), Role::Expression)
                }
                Err(why) => {
                    reader.error(node.span(), format!("expression {why}"), "");
                    return None;
                }
            }
        }
    };
    let variable = PlanVariable {
        name: draft.name,
        keys: draft.keys,
        unit,
        kind,
        new_stage: false,
        step,
        span: draft.span,
    };
    Some((variable, role))
}

fn prior(reader: &mut Reader, draft: &Draft, kind: Kind, unit: &str) -> Option<Prior> {
    let before = reader.errors.len();
    let mut number = |key: &str, usual: Option<f64>| match draft.table.get(key) {
        Some(node) => reader.number(node, key, unit),
        None if usual.is_some() => usual,
        None => {
            let message = format!("the prior of {} needs {key}", draft.name);
            reader.error(draft.span.clone(), message, "");
            None
        }
    };
    let prior = match kind {
        Kind::Uniform => Prior::Uniform { from: number("from", None)?, to: number("to", None)? },
        Kind::LogUniform => Prior::LogUniform { from: number("from", None)?, to: number("to", None)? },
        Kind::Normal => Prior::Normal {
            mean: number("mean", None)?,
            deviation: number("deviation", None)?,
            from: number("from", Some(f64::NEG_INFINITY))?,
            to: number("to", Some(f64::INFINITY))?,
        },
    };
    if !matches!(kind, Kind::Normal)
        && let Some(key) = ["mean", "deviation"].iter().find(|key| draft.table.contains_key(**key))
    {
        let message = format!("{key} belongs to a normal prior");
        reader.error(draft.span.clone(), message, "write prior = \"normal\", or leave it out");
    }
    if let Err(error) = prior.check(&draft.name) {
        let message = match error {
            CalibrationError::Prior { name, reason } => format!("prior of {name}: {reason}"),
            other => other.to_string(),
        };
        reader.error(draft.span.clone(), message, "");
    }
    (reader.errors.len() == before).then_some(prior)
}
