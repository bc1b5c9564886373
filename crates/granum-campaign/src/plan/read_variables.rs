//! Reading the variables of a plan.

use std::collections::BTreeSet;
use std::ops::Range;

use granum_core::quantity::format_number;
use granum_io::case::Value;
use granum_io::safe_text::quoted;
use granum_io::{Case, Error};
use toml::Spanned as TomlSpanned;
use toml::de::{DeTable, DeValue};

use super::definition::{Choice, FixedKey, PATH, PlanVariable, Spanned, VariableKind};
use super::expression::Expression;
use super::reader::{Node, Reader};
use super::units;
use super::values::{multiples, rounded};

/// Most variables of a plan or a calibration, expressions included.
const MOST_VARIABLES: usize = 1000;
/// Most values of a variable.
const MOST_VALUES: usize = 100_000;
/// Longest name of a variable.
const LONGEST_NAME: usize = 100;
/// Names that a variable cannot have.
const RESERVED: [&str; 6] = ["min", "max", "abs", "sqrt", "exp", "name"];
/// The keys of a variable.
pub(super) const VARIABLE_KEYS: [&str; 11] =
    ["name", "key", "keys", "from", "to", "scale", "levels", "values", "expression", "step", "stage"];

/// A variable whose values have not been read yet: their reading needs the unit of its keys.
pub struct Draft<'a> {
    /// Its name.
    pub name: String,
    /// The keys that take its value.
    pub keys: Vec<Spanned<String>>,
    /// Its table.
    pub table: &'a DeTable<'a>,
    /// Where it stands.
    pub span: Range<usize>,
}

impl Reader {
    /// The variables of a list of tables that may have the keys `known`.
    pub fn drafts<'a>(&mut self, node: Option<&'a Node<'a>>, known: &[&str]) -> Vec<Draft<'a>> {
        let Some(node) = node else { return Vec::new() };
        let DeValue::Array(items) = node.get_ref() else {
            self.error(node.span(), "variable must be a list of tables", "write [[variable]]");
            return Vec::new();
        };
        if items.len() > MOST_VARIABLES {
            let message =
                format!("there are {} variables; at most {MOST_VARIABLES} are possible", items.len());
            self.error(node.span(), message, "");
            return Vec::new();
        }
        items.iter().filter_map(|item| self.draft(item, known)).collect()
    }

    fn draft<'a>(&mut self, item: &'a Node<'a>, known: &[&str]) -> Option<Draft<'a>> {
        let DeValue::Table(table) = item.get_ref() else {
            self.error(item.span(), "a variable must be a table", "write [[variable]]");
            return None;
        };
        self.refuse_unknown(table, known, "variable");
        let mut keys = Vec::new();
        if let Some(node) = table.get("key") {
            keys.extend(self.text(node, "key").map(|value| Spanned { value, span: node.span() }));
        }
        if let Some(node) = table.get("keys") {
            for item in self.array(node, "keys")?.iter() {
                keys.extend(self.text(item, "keys").map(|value| Spanned { value, span: item.span() }));
            }
        }
        let name = match table.get("name") {
            Some(node) => Spanned { value: self.text(node, "name")?, span: node.span() },
            None => match keys.first() {
                Some(key) => {
                    let last = key.value.rsplit('.').next().unwrap_or_default();
                    Spanned { value: last.to_string(), span: key.span.clone() }
                }
                None => {
                    let help = "give it a key of the case, and a name of its own if you like";
                    self.error(item.span(), "a variable needs a key or a name", help);
                    return None;
                }
            },
        };
        let is_word = name.value.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && name.value.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && name.value.len() <= LONGEST_NAME;
        if !is_word || RESERVED.contains(&name.value.as_str()) {
            let message = format!("\"{}\" cannot be the name of a variable", quoted(&name.value));
            let help = format!(
                "use up to {LONGEST_NAME} letters, digits and _, and neither name nor the name of a function"
            );
            self.error(name.span, message, &help);
            return None;
        }
        Some(Draft { name: name.value, keys, table, span: item.span() })
    }

    /// The base case with the fixed keys and the first of the named paths, by which the units of keys are known.
    pub fn reference(&mut self, case: &Case, fixed: &[FixedKey], drafts: &[Draft]) -> Option<Case> {
        let paths = drafts.iter().find(|draft| draft.keys.iter().any(|key| key.value == PATH));
        let first = paths.and_then(|draft| match draft.table.get("values").map(TomlSpanned::get_ref) {
            Some(DeValue::Array(items)) => {
                items.iter().next().and_then(|item| item.get_ref().as_str().map(str::to_string))
            }
            _ => None,
        });
        let mut case = case.clone();
        if let Some(name) = first {
            // A wrong name is told with its run.
            case = case.with_path(&name, &[]).unwrap_or(case);
        }
        let before = self.errors.len();
        for key in fixed {
            match case.set(&key.key, &key.text) {
                Ok(()) => {}
                Err(error) => self.error(key.span.clone(), format!("[set] {error}"), ""),
            }
        }
        (self.errors.len() == before).then_some(case)
    }

    pub(super) fn variable(&mut self, draft: Draft, case: &Case) -> Option<PlanVariable> {
        let (unit, step) = self.unit_and_step(&draft, case)?;
        let kind = self.kind(&draft, &unit)?;
        if let VariableKind::Range { between, texts, .. } = &kind {
            self.check_step(&draft, *between, texts, step)?;
        }
        let new_stage = self.new_stage(&draft)?;
        Some(PlanVariable {
            name: draft.name,
            keys: draft.keys,
            unit,
            kind,
            new_stage,
            step,
            span: draft.span,
        })
    }

    /// True if the variable says that a named path has its own parameters only.
    fn new_stage(&mut self, draft: &Draft) -> Option<bool> {
        let Some(node) = draft.table.get("stage") else { return Some(false) };
        if draft.keys.iter().all(|key| key.value != PATH) && !draft.table.contains_key("values") {
            let message = "stage belongs to a variable that sets path";
            self.error(node.span(), message, "leave it out");
            return None;
        }
        match self.text(node, "stage")?.as_str() {
            "kept" => Some(false),
            "new" => Some(true),
            other => {
                let message = format!("stage = {other:?} must be \"kept\" or \"new\"");
                self.error(node.span(), message, "");
                None
            }
        }
    }

    /// Refuses a step that leaves a range fewer than two values; `texts` are its bounds as they were written.
    pub fn check_step(
        &mut self,
        draft: &Draft,
        between: [f64; 2],
        texts: &[String; 2],
        step: Option<f64>,
    ) -> Option<()> {
        let Some(step) = step else { return Some(()) };
        let [from, to] = texts;
        let message = match multiples(between, step) {
            None => format!(
                "no multiple of the step {} lies in the range from {from} to {to}",
                format_number(step)
            ),
            Some([first, last]) if first == last => format!(
                "only one multiple of the step {}, {}, lies in the range from {from} to {to}",
                format_number(step),
                format_number(rounded(first * step, Some(step)))
            ),
            Some(_) => return Some(()),
        };
        let span = draft.table.get("step").map_or_else(|| draft.span.clone(), |node| node.span());
        self.error(
            span,
            format!("{} has too few values: {message}", draft.name),
            "numbers are rounded to multiples of the step; give a smaller step, or a wider range",
        );
        None
    }

    /// The unit of the keys of a variable, and the step to which its numbers are rounded, if there is one.
    pub fn unit_and_step(&mut self, draft: &Draft, case: &Case) -> Option<(String, Option<f64>)> {
        let mut unit: Option<String> = None;
        for key in draft.keys.iter().filter(|key| key.value != PATH) {
            let Some(own) = case.unit_of(&key.value) else {
                let why =
                    case.clone().set(&key.value, "").err().map_or_else(String::new, |error| match error {
                        Error::Value { message, .. } => message,
                        other => other.to_string(),
                    });
                self.error(key.span.clone(), format!("{} {why}", key.value), "");
                return None;
            };
            match &unit {
                Some(first) if *first != own => {
                    let message = format!(
                        "{} is in {:?} and the first key of the variable is in {first:?}: they cannot have one value",
                        key.value, own
                    );
                    self.error(key.span.clone(), message, "make it a variable of its own with an expression");
                    return None;
                }
                _ => unit = Some(own),
            }
        }
        let unit = unit.unwrap_or_default();
        let counts = |key: &Spanned<String>| {
            let field = case.fields().named(&key.value);
            field.is_some_and(|field| matches!(field.value(case), Some(Value::Count(_))))
        };
        let step = match draft.table.get("step") {
            Some(node) => Some(self.number(node, "step", &unit)?),
            None => draft.keys.iter().any(counts).then_some(1.0),
        };
        if let (Some(step), Some(node)) = (step, draft.table.get("step"))
            && step <= 0.0
        {
            self.error(node.span(), "step must be above 0", "");
            return None;
        }
        Some((unit, step))
    }

    pub(super) fn kind(&mut self, draft: &Draft, unit: &str) -> Option<VariableKind> {
        let table = draft.table;
        let ways = [("from", "from and to"), ("values", "values"), ("expression", "expression")];
        let given: Vec<&str> =
            ways.iter().filter(|(key, _)| table.contains_key(*key)).map(|(_, way)| *way).collect();
        if given.len() > 1 {
            let message = format!("the variable {} is given by {}", draft.name, given.join(" and by "));
            self.error(draft.span.clone(), message, "keep one of them");
            return None;
        }
        if let Some(node) = table.get("expression") {
            let text = self.text(node, "expression")?;
            return match Expression::parse(&text) {
                Ok(value) => Some(VariableKind::Expression(Spanned { value, span: node.span() })),
                Err(why) => {
                    self.error(node.span(), format!("expression {why}"), "");
                    None
                }
            };
        }
        if let Some(node) = table.get("values") {
            return self.choices(node, draft, unit).map(VariableKind::Choice);
        }
        match (table.get("from"), table.get("to")) {
            (Some(from), Some(to)) => self.range(draft, [from, to], unit),
            (None, None) => Some(VariableKind::Given),
            _ => {
                let message = format!("the variable {} needs both from and to", draft.name);
                self.error(draft.span.clone(), message, "");
                None
            }
        }
    }

    pub(super) fn range(
        &mut self,
        draft: &Draft,
        [from, to]: [&Node; 2],
        unit: &str,
    ) -> Option<VariableKind> {
        let between = [self.number(from, "from", unit)?, self.number(to, "to", unit)?];
        let texts = [self.scalar(from, "from")?, self.scalar(to, "to")?];
        if between[0] >= between[1] {
            let message = format!("from = {} must be below to = {}", texts[0], texts[1]);
            self.error(from.span(), message, "");
            return None;
        }
        let logarithmic = match draft.table.get("scale") {
            None => false,
            Some(node) => match self.text(node, "scale")?.as_str() {
                "linear" => false,
                "log" => true,
                other => {
                    self.error(node.span(), format!("scale = {other:?} must be \"linear\" or \"log\""), "");
                    return None;
                }
            },
        };
        if logarithmic && between[0] <= 0.0 {
            let message = format!("from = {} must be above 0 on a logarithmic scale", texts[0]);
            self.error(from.span(), message, "give it a small value above 0, or scale = \"linear\"");
            return None;
        }
        let levels = self.count(draft.table, "levels", 2, 1000).map(|count| count as usize);
        Some(VariableKind::Range { between, texts, logarithmic, levels })
    }

    pub(super) fn choices(&mut self, node: &Node, draft: &Draft, unit: &str) -> Option<Vec<Choice>> {
        let items = self.array(node, "values")?;
        if items.len() > MOST_VALUES {
            let message = format!("values has {} values; at most {MOST_VALUES} are possible", items.len());
            self.error(node.span(), message, "");
            return None;
        }
        let mut found: Vec<Choice> = Vec::new();
        let mut names = BTreeSet::new();
        for item in items.iter() {
            let choice = match item.get_ref() {
                DeValue::Table(table) => self.set_of_keys(item.span(), table)?,
                _ => self.plain_choice(item, draft, unit)?,
            };
            if !names.insert(choice.name.clone()) {
                self.error(item.span(), format!("the value \"{}\" is given twice", quoted(&choice.name)), "");
                return None;
            }
            found.push(choice);
        }
        if found.is_empty() {
            self.error(node.span(), "values must have one value or more", "");
            return None;
        }
        Some(found)
    }

    pub(super) fn plain_choice(&mut self, item: &Node, draft: &Draft, unit: &str) -> Option<Choice> {
        let name = self.scalar(item, "values")?;
        let is_written_as_number = name.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        let number = match units::quantity(&name, unit) {
            Ok(number) => Some(number),
            Err(why) if is_written_as_number => {
                self.error(item.span(), format!("{} = {name} {why}", draft.name), "");
                return None;
            }
            Err(_) => None,
        };
        if draft.keys.is_empty() && number.is_none() {
            let help = "give the variable a key, or write { name = \"...\", set = { KEY = VALUE } }";
            self.error(item.span(), format!("the value {name:?} sets no key"), help);
            return None;
        }
        Some(Choice { name, number, set: Vec::new(), span: item.span() })
    }

    /// `{ name = "dense", set = { "preparation.friction" = 0 } }`.
    pub(super) fn set_of_keys(&mut self, span: Range<usize>, table: &DeTable) -> Option<Choice> {
        self.refuse_unknown(table, &["name", "set"], "value");
        let name = table.get("name").and_then(|node| self.text(node, "name"));
        let set = table.get("set").map_or_else(Vec::new, |node| self.fixed(node));
        let Some(name) = name.filter(|_| !set.is_empty()) else {
            let help = "write { name = \"dense\", set = { \"preparation.friction\" = 0 } }";
            self.error(span, "a value that sets several keys needs a name and set", help);
            return None;
        };
        let set = set.into_iter().map(|key| (key.key, key.text)).collect();
        Some(Choice { name, number: None, set, span })
    }
}
