//! Reading a plan: all mistakes are reported at once, each with its place and what would be right.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use granum_core::input::read_text;
use granum_core::names::suggestion;
use granum_io::case::Value;
use granum_io::shell::ShowPath;
use granum_io::{Case, Error, InputError, Reading, Result, named_file};
use toml::Spanned as TomlSpanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::definition::{
    Choice, DesignKind, DesignTable, FixedKey, Plan, PlanSource, Row, RowPlace, SampleSeeds, Spanned,
    Variable, VariableKind,
};
use super::design::rows;
use super::expression::{Condition, Expression};
use super::units;

/// A plan is a page or two long, but for long lists of runs; a larger file is something else.
const LARGEST_FILE: u64 = 1 << 24;
/// The key that stands for the named path of the test.
pub(super) const PATH: &str = "path";
/// Names that a variable cannot have.
const RESERVED: [&str; 6] = ["min", "max", "abs", "sqrt", "exp", "name"];
/// The keys of a plan, of its design and of a variable.
const PLAN_KEYS: [&str; 6] = ["case", "set", "design", "variable", "constraints", "accept"];
const DESIGN_KEYS: [&str; 7] = ["kind", "points", "seed", "replicates", "sample_seeds", "rows", "file"];
const VARIABLE_KEYS: [&str; 10] =
    ["name", "key", "keys", "from", "to", "scale", "levels", "values", "expression", "step"];
/// The kinds of design as a plan names them.
const KINDS: [&str; 5] = ["sobol", "latin-hypercube", "full-factorial", "list", "csv"];

type Node<'a> = TomlSpanned<DeValue<'a>>;

impl Plan {
    /// Reads a plan and its base case.
    ///
    /// # Errors
    /// [`Error::Inputs`] with all mistakes of the plan, and as [`Case::read`] for the base case.
    pub fn read(path: &Path, reading: Reading) -> Result<Plan> {
        let text = read_text(path, LARGEST_FILE).map_err(Error::file("read", path))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Plan::parse(PlanSource { file: path.shown(), folder, text: Arc::from(text) }, reading)
    }

    /// Reads the text of a plan and the base case that it names.
    ///
    /// # Errors
    /// As [`Plan::read`].
    pub fn parse(source: PlanSource, reading: Reading) -> Result<Plan> {
        let text = source.text.clone();
        let document = DeTable::parse(&text).map_err(|error| {
            let message = format!("this is not TOML: {}", error.message().replace('\n', "; "));
            Error::Inputs(vec![source.error(&error.span().unwrap_or(0..0), message)])
        })?;
        let mut reader = Reader { source, reading, errors: Vec::new() };
        let plan = reader.plan(document.get_ref());
        reader.errors.sort_by_key(|error| error.span.start);
        match plan {
            Ok(Some(plan)) if reader.errors.is_empty() => Ok(plan),
            Err(error) if reader.errors.is_empty() => Err(error),
            _ => Err(Error::Inputs(reader.errors)),
        }
    }
}

struct Reader {
    source: PlanSource,
    reading: Reading,
    errors: Vec<InputError>,
}

/// A variable whose values have not been read yet: their reading needs the unit of its keys.
struct Draft<'a> {
    name: String,
    keys: Vec<Spanned<String>>,
    table: &'a DeTable<'a>,
    span: Range<usize>,
}

impl Reader {
    fn error(&mut self, span: Range<usize>, message: impl Into<String>, help: &str) {
        let error = self.source.error(&span, message);
        self.errors.push(if help.is_empty() { error } else { error.with_help(help) });
    }

    fn plan(&mut self, table: &DeTable<'_>) -> Result<Option<Plan>> {
        self.refuse_unknown(table, &PLAN_KEYS, "plan");
        let Some(node) = table.get("case") else {
            self.error(
                0..0,
                "the plan names no base case",
                "write e.g. case = \"sand.toml\" in its first line",
            );
            return Ok(None);
        };
        let Some(name) = self.text(node, "case") else { return Ok(None) };
        let case_file = match named_file(&self.source.folder, &name, self.reading.outside) {
            Ok(path) => path,
            Err(why) => {
                self.error(node.span(), format!("case = {name:?} {why}"), "");
                return Ok(None);
            }
        };
        if !case_file.is_file() {
            let message = format!("case = {name:?}: there is no file {}", case_file.shown());
            self.error(node.span(), message, "the name counts from the folder of the plan");
            return Ok(None);
        }
        let case = Case::read_as(&case_file, self.reading.clone())?;
        let fixed = table.get("set").map_or_else(Vec::new, |node| self.fixed(node));
        let drafts = self.drafts(table.get("variable"));
        let Some(reference) = self.reference(&case, &fixed, &drafts) else { return Ok(None) };
        let variables: Vec<Variable> =
            drafts.into_iter().filter_map(|draft| self.variable(draft, &reference)).collect();
        let constraints = self.conditions(table, "constraints");
        let accept = self.conditions(table, "accept");
        let design = match table.get("design") {
            Some(node) => self.design(node)?,
            None => {
                let help = format!("add [design] with kind = one of {}", KINDS.join(", "));
                self.error(0..0, "the plan has no design", &help);
                None
            }
        };
        let Some(design) = design else { return Ok(None) };
        let source = self.source.clone();
        let plan = Plan { source, case_file, case, fixed, variables, design, constraints, accept };
        self.check_names(&plan, &reference);
        self.check_design(&plan);
        Ok(Some(plan))
    }

    fn refuse_unknown(&mut self, table: &DeTable<'_>, known: &[&str], what: &str) {
        for key in table.keys().filter(|key| !known.contains(&key.get_ref().as_ref())) {
            let help = suggestion(key.get_ref(), known.iter().copied());
            self.error(key.span(), format!("{:?} is no key of a {what}", key.get_ref()), &help);
        }
    }

    /// A text.
    fn text(&mut self, node: &Node, key: &str) -> Option<String> {
        if let DeValue::String(text) = node.get_ref() {
            return Some(text.to_string());
        }
        self.error(node.span(), format!("{key} must be a text in quotes"), "");
        None
    }

    /// The text of a single value: a number, a word, true or false.
    fn scalar(&mut self, node: &Node, key: &str) -> Option<String> {
        match node.get_ref() {
            DeValue::String(text) => Some(text.trim().to_string()),
            DeValue::Float(number) => Some(number.as_str().replace('_', "")),
            DeValue::Integer(number) if number.radix() == 10 => Some(number.as_str().replace('_', "")),
            DeValue::Boolean(yes) => Some(yes.to_string()),
            other => {
                let message =
                    format!("{key} must be a number or a text, and not of type {}", other.type_str());
                self.error(node.span(), message, "");
                None
            }
        }
    }

    fn count(&mut self, table: &DeTable, key: &str, least: u64, most: u64) -> Option<u64> {
        let node = table.get(key)?;
        let text = self.scalar(node, key)?;
        let count = text.parse().ok().filter(|count| (least..=most).contains(count));
        if count.is_none() {
            self.error(
                node.span(),
                format!("{key} = {text} must be a whole number from {least} to {most}"),
                "",
            );
        }
        count
    }

    fn array<'a>(&mut self, node: &'a Node<'a>, key: &str) -> Option<&'a DeArray<'a>> {
        if let DeValue::Array(items) = node.get_ref() {
            return Some(items);
        }
        self.error(node.span(), format!("{key} must be a list in brackets"), "");
        None
    }

    /// Keys that all runs have: `"grains.count" = 300`, or tables of them.
    fn fixed(&mut self, node: &Node) -> Vec<FixedKey> {
        let mut found = Vec::new();
        match node.get_ref() {
            DeValue::Table(table) => self.flatten("", table, &mut found),
            _ => self.error(node.span(), "set must be a table", "write [set] with keys below it"),
        }
        found
    }

    fn flatten(&mut self, place: &str, table: &DeTable, found: &mut Vec<FixedKey>) {
        for (key, node) in table {
            let path = if place.is_empty() {
                key.get_ref().to_string()
            } else {
                format!("{place}.{}", key.get_ref())
            };
            match node.get_ref() {
                DeValue::Table(inner) => self.flatten(&path, inner, found),
                DeValue::Array(items) => {
                    let cells = items.iter().map(|item| self.scalar(item, &path)).collect::<Option<Vec<_>>>();
                    let text = cells.map(|cells| cells.join(","));
                    found.extend(text.map(|text| FixedKey { key: path, text, span: key.span() }));
                }
                _ => {
                    let text = self.scalar(node, &path);
                    found.extend(text.map(|text| FixedKey { key: path, text, span: key.span() }));
                }
            }
        }
    }

    fn drafts<'a>(&mut self, node: Option<&'a Node<'a>>) -> Vec<Draft<'a>> {
        let Some(node) = node else { return Vec::new() };
        let DeValue::Array(items) = node.get_ref() else {
            self.error(node.span(), "variable must be a list of tables", "write [[variable]]");
            return Vec::new();
        };
        items.iter().filter_map(|item| self.draft(item)).collect()
    }

    fn draft<'a>(&mut self, item: &'a Node<'a>) -> Option<Draft<'a>> {
        let DeValue::Table(table) = item.get_ref() else {
            self.error(item.span(), "a variable must be a table", "write [[variable]]");
            return None;
        };
        self.refuse_unknown(table, &VARIABLE_KEYS, "variable");
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
            && name.value.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if !is_word || RESERVED.contains(&name.value.as_str()) {
            let message = format!("{:?} cannot be the name of a variable", name.value);
            self.error(
                name.span,
                message,
                "use letters, digits and _, and neither name nor the name of a function",
            );
            return None;
        }
        Some(Draft { name: name.value, keys, table, span: item.span() })
    }

    /// The base case with the fixed keys and the first of the named paths, by which the units of keys are known.
    fn reference(&mut self, case: &Case, fixed: &[FixedKey], drafts: &[Draft]) -> Option<Case> {
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

    fn variable(&mut self, draft: Draft, case: &Case) -> Option<Variable> {
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
        let kind = self.kind(&draft, &unit)?;
        Some(Variable { name: draft.name, keys: draft.keys, unit, kind, step, span: draft.span })
    }

    /// A number in the SI unit of a key.
    fn number(&mut self, node: &Node, key: &str, unit: &str) -> Option<f64> {
        let text = self.scalar(node, key)?;
        match units::quantity(&text, unit) {
            Ok(number) => Some(number),
            Err(why) => {
                self.error(node.span(), format!("{key} = {text} {why}"), "");
                None
            }
        }
    }

    fn kind(&mut self, draft: &Draft, unit: &str) -> Option<VariableKind> {
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

    fn range(&mut self, draft: &Draft, [from, to]: [&Node; 2], unit: &str) -> Option<VariableKind> {
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

    fn choices(&mut self, node: &Node, draft: &Draft, unit: &str) -> Option<Vec<Choice>> {
        let items = self.array(node, "values")?;
        let mut found: Vec<Choice> = Vec::new();
        for item in items.iter() {
            let choice = match item.get_ref() {
                DeValue::Table(table) => self.set_of_keys(item.span(), table)?,
                _ => self.plain_choice(item, draft, unit)?,
            };
            if found.iter().any(|known| known.name == choice.name) {
                self.error(item.span(), format!("the value {:?} is given twice", choice.name), "");
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

    fn plain_choice(&mut self, item: &Node, draft: &Draft, unit: &str) -> Option<Choice> {
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
    fn set_of_keys(&mut self, span: Range<usize>, table: &DeTable) -> Option<Choice> {
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

    fn conditions(&mut self, table: &DeTable, key: &str) -> Vec<Spanned<Condition>> {
        let Some(node) = table.get(key) else { return Vec::new() };
        let mut found = Vec::new();
        for item in self.array(node, key).into_iter().flat_map(|items| items.iter()) {
            let Some(text) = self.text(item, key) else { continue };
            match Condition::parse(&text) {
                Ok(value) => found.push(Spanned { value, span: item.span() }),
                Err(why) => self.error(item.span(), format!("{key}: {why}"), ""),
            }
        }
        found
    }

    fn design(&mut self, node: &Node) -> Result<Option<DesignTable>> {
        let DeValue::Table(table) = node.get_ref() else {
            self.error(node.span(), "design must be a table", "write [design] with its keys below");
            return Ok(None);
        };
        self.refuse_unknown(table, &DESIGN_KEYS, "design");
        let Some(kind_node) = table.get("kind") else {
            self.error(
                node.span(),
                "the design has no kind",
                &format!("kind is one of {}", KINDS.join(", ")),
            );
            return Ok(None);
        };
        let Some(word) = self.text(kind_node, "kind") else { return Ok(None) };
        let kind = match word.as_str() {
            "sobol" => DesignKind::Sobol,
            "latin-hypercube" => DesignKind::LatinHypercube,
            "full-factorial" => DesignKind::FullFactorial,
            "list" => match self.listed_rows(node, table) {
                Some(rows) => DesignKind::Rows(rows),
                None => return Ok(None),
            },
            "csv" => match self.csv_rows(node, table)? {
                Some(rows) => DesignKind::Rows(rows),
                None => return Ok(None),
            },
            other => {
                let help = suggestion(other, KINDS.iter().copied());
                self.error(kind_node.span(), format!("kind = {other:?} is no kind of design"), &help);
                return Ok(None);
            }
        };
        let points = self.count(table, "points", 1, super::design::MOST_POINTS as u64);
        let is_drawn = matches!(kind, DesignKind::Sobol | DesignKind::LatinHypercube);
        match (is_drawn, points, table.get("points")) {
            (true, None, None) => {
                self.error(kind_node.span(), format!("{word} needs points, the number of points"), "")
            }
            (false, Some(_), Some(node)) => {
                self.error(
                    node.span(),
                    format!("points has no effect on a design of kind {word}"),
                    "leave it out",
                );
            }
            _ => {}
        }
        for (key, of) in [("rows", "list"), ("file", "csv")] {
            if let Some(node) = table.get(key).filter(|_| word != of) {
                self.error(node.span(), format!("{key} belongs to a design of kind {of}"), "leave it out");
            }
        }
        let sample_seeds = match table.get("sample_seeds") {
            None => SampleSeeds::Same,
            Some(node) => match self.text(node, "sample_seeds").as_deref() {
                Some("same") => SampleSeeds::Same,
                Some("different") => SampleSeeds::Different,
                Some(other) => {
                    let message = format!("sample_seeds = {other:?} must be \"same\" or \"different\"");
                    self.error(node.span(), message, "");
                    SampleSeeds::Same
                }
                None => SampleSeeds::Same,
            },
        };
        let seed = self.count(table, "seed", 0, u64::from(u32::MAX)).unwrap_or(1) as u32;
        let replicates = self.count(table, "replicates", 1, 1000).unwrap_or(1) as usize;
        let points = points.map(|count| count as usize);
        Ok(Some(DesignTable { kind, points, seed, replicates, sample_seeds, span: kind_node.span() }))
    }

    fn listed_rows(&mut self, design: &Node, table: &DeTable) -> Option<Vec<Row>> {
        let Some(node) = table.get("rows") else {
            let help = "write rows = [{ friction = 0.2 }, { friction = 0.4 }]";
            self.error(design.span(), "a design of kind list needs rows", help);
            return None;
        };
        let mut rows = Vec::new();
        for item in self.array(node, "rows")?.iter() {
            let DeValue::Table(cells) = item.get_ref() else {
                self.error(item.span(), "a row must be a table", "write { friction = 0.2 }");
                return None;
            };
            let cell = |(key, node): (&TomlSpanned<_>, &Node)| -> Option<(String, String)> {
                let key: &std::borrow::Cow<str> = key.get_ref();
                Some((key.to_string(), self.scalar(node, key)?))
            };
            let cells = cells.iter().map(cell).collect::<Option<Vec<_>>>()?;
            rows.push(Row { cells, place: RowPlace::Plan(item.span()) });
        }
        if rows.is_empty() {
            self.error(node.span(), "rows must have one row or more", "");
            return None;
        }
        Some(rows)
    }

    fn csv_rows(&mut self, design: &Node, table: &DeTable) -> Result<Option<Vec<Row>>> {
        let Some(node) = table.get("file") else {
            self.error(design.span(), "a design of kind csv needs file, the name of a CSV file", "");
            return Ok(None);
        };
        let Some(name) = self.text(node, "file") else { return Ok(None) };
        match named_file(&self.source.folder, &name, self.reading.outside) {
            Ok(path) if path.is_file() => rows::read_csv(&path).map(Some),
            Ok(path) => {
                let message = format!("file = {name:?}: there is no file {}", path.shown());
                self.error(node.span(), message, "the name counts from the folder of the plan");
                Ok(None)
            }
            Err(why) => {
                self.error(node.span(), format!("file = {name:?} {why}"), "");
                Ok(None)
            }
        }
    }

    /// Checks that names are unique and that expressions and constraints use names that exist, and not each other in a circle.
    fn check_names(&mut self, plan: &Plan, reference: &Case) {
        let names: Vec<&str> = plan.variables.iter().map(|variable| variable.name.as_str()).collect();
        for (k, variable) in plan.variables.iter().enumerate() {
            if names[..k].contains(&variable.name.as_str()) {
                let message = format!("two variables have the name {}", variable.name);
                self.error(variable.span.clone(), message, "give one of them another name");
            }
            let own: Vec<&Spanned<String>> = variable.keys.iter().collect();
            let earlier = || plan.variables[..k].iter().flat_map(|other| &other.keys);
            for key in own {
                if earlier().any(|other| other.value == key.value) {
                    self.error(key.span.clone(), format!("{} is set by two variables", key.value), "");
                }
                if plan.fixed.iter().any(|fixed| fixed.key == key.value) {
                    self.error(
                        key.span.clone(),
                        format!("{} is set by [set] and by a variable", key.value),
                        "",
                    );
                }
            }
        }
        let parameters = reference.parameters();
        let is_number =
            |name: &str| parameters.iter().any(|known| known.key == name && known.number().is_some());
        let mut unknown = Vec::new();
        for variable in &plan.variables {
            let VariableKind::Expression(expression) = &variable.kind else { continue };
            for name in expression.value.names().filter(|name| !names.contains(name) && !is_number(name)) {
                unknown.push((expression.span.clone(), name.to_string()));
            }
        }
        for constraint in &plan.constraints {
            for name in constraint.value.names().filter(|name| !names.contains(name) && !is_number(name)) {
                unknown.push((constraint.span.clone(), name.to_string()));
            }
        }
        for (span, name) in unknown {
            let help = suggestion(&name, names.iter().copied());
            self.error(span, format!("{name} is neither a variable nor a number of the base case"), &help);
        }
        if let Some(variable) = super::runs::in_a_circle(&plan.variables) {
            let message = format!("the expression of {} depends on itself", variable.name);
            self.error(variable.span.clone(), message, "");
        }
        for condition in &plan.accept {
            if condition.value.names().count() == 0 {
                let help = "write e.g. accept = [\"largest_overlap < 0.05\"]";
                self.error(condition.span.clone(), "accept names no check", help);
            }
        }
    }

    /// Checks that the design and the variables fit together.
    fn check_design(&mut self, plan: &Plan) {
        let seeds = |variable: &Variable| variable.keys.iter().any(|key| key.value == granum_io::case::SEED);
        let has_seeds = plan.design.replicates > 1 || plan.design.sample_seeds == SampleSeeds::Different;
        if let Some(variable) = plan.variables.iter().find(|variable| seeds(variable) && has_seeds) {
            let message = "preparation.seed is set by a variable and by the design";
            self.error(
                variable.span.clone(),
                message,
                "leave out the variable, or replicates and sample_seeds",
            );
        }
        match &plan.design.kind {
            DesignKind::Rows(rows) => self.check_rows(plan, rows),
            kind => {
                for variable in &plan.variables {
                    if variable.kind == VariableKind::Given {
                        let message = format!("the variable {} has no values", variable.name);
                        self.error(
                            variable.span.clone(),
                            message,
                            "give it from and to, values, or expression",
                        );
                    }
                    let needs_levels = *kind == DesignKind::FullFactorial
                        && matches!(variable.kind, VariableKind::Range { levels: None, .. });
                    if needs_levels {
                        let message =
                            format!("the variable {} needs levels in a full factorial design", variable.name);
                        self.error(variable.span.clone(), message, "give it levels = 3, or values = [...]");
                    }
                }
                if plan.variables.iter().filter(|variable| variable.kind.is_free()).count()
                    > super::design::MOST_AXES
                {
                    self.error(plan.design.span.clone(), "the plan has more than 256 variables", "");
                }
            }
        }
    }

    fn check_rows(&mut self, plan: &Plan, rows: &[Row]) {
        for row in rows {
            let known = |name: &str| {
                plan.variables.iter().any(|variable| variable.name == name && variable.kind.is_free())
            };
            let unknown = row
                .cells
                .iter()
                .find(|(name, _)| !known(name))
                .map(|(name, _)| format!("{name} is no variable of the plan that a row can give"));
            let missing = plan.variables.iter().filter(|variable| variable.kind.is_free());
            let missing = missing
                .filter(|variable| !row.cells.iter().any(|(name, _)| *name == variable.name))
                .map(|variable| format!("the row has no value of {}", variable.name))
                .next();
            if let Some(message) = unknown.or(missing) {
                let names = plan.variables.iter().filter(|variable| variable.kind.is_free());
                let names: Vec<&str> = names.map(|variable| variable.name.as_str()).collect();
                let help = format!("a row has {}", names.join(", "));
                self.errors.push(row.place.error(&self.source, message).with_help(help));
                // The other rows of a CSV file have the same names.
                return;
            }
        }
    }
}

impl RowPlace {
    /// A mistake in the row.
    pub(super) fn error(&self, source: &PlanSource, message: String) -> InputError {
        match self {
            RowPlace::Plan(span) => source.error(span, message),
            RowPlace::Csv { file, line, text } => {
                InputError::in_line(file, *line, text, 0..text.len(), message)
            }
        }
    }
}
