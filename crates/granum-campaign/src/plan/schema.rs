//! The JSON schema of a plan, for editors.

use serde_json::{Map, Value, json};

use super::definition::Plan;
use super::read::MOST_RANKS;

/// A key with what it can hold.
type Key = (&'static str, Value);

impl Plan {
    /// The JSON schema (draft 2020-12) of a plan: every key with its meaning. The keys of `[set]` and of variables are those of a case.
    ///
    /// ```
    /// let schema = granum_campaign::plan::Plan::schema();
    /// assert_eq!(schema["properties"]["keep"]["enum"][1], "dataset");
    /// ```
    pub fn schema() -> Value {
        let mut schema =
            object("A granum plan: a base case, variables over its keys, and a design.", plan_keys());
        schema["required"] = json!(["case", "design"]);
        schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
        schema["title"] = json!("granum plan");
        schema
    }
}

fn object(help: &str, keys: Vec<Key>) -> Value {
    let properties: Map<String, Value> =
        keys.into_iter().map(|(name, schema)| (name.to_string(), schema)).collect();
    json!({ "description": help, "type": "object", "additionalProperties": false, "properties": properties })
}

fn described(help: &str, mut schema: Value) -> Value {
    schema["description"] = json!(help);
    schema
}

fn text(help: &str) -> Value {
    described(help, json!({ "type": "string" }))
}

fn texts(help: &str) -> Value {
    described(help, json!({ "type": "array", "items": { "type": "string" } }))
}

/// A number in SI units, or a text with a unit.
fn quantity(help: &str) -> Value {
    described(help, json!({ "type": ["number", "string"] }))
}

fn count(help: &str, least: u64, most: u64) -> Value {
    described(help, json!({ "type": "integer", "minimum": least, "maximum": most }))
}

fn choice(help: &str, words: &[&str]) -> Value {
    let usual = words.first();
    described(help, json!({ "enum": words, "default": usual }))
}

/// Keys of a case with their values: plain keys in quotes, or tables of them.
fn keys_of_case(help: &str) -> Value {
    described(help, json!({ "type": "object" }))
}

fn plan_keys() -> Vec<Key> {
    let conditions = "Each is a comparison such as \"rolling_friction < friction\".";
    vec![
        ("case", text("File of the base case; the name counts from the folder of the plan.")),
        ("set", keys_of_case("Keys of the case that all runs have, in place of those of the base case.")),
        ("design", design()),
        (
            "variable",
            json!({ "description": "What is varied.", "type": "array", "items": object("A variable.", variable_keys()) }),
        ),
        (
            "constraints",
            texts(&format!(
                "What every run must fulfil; variables and numbers of the base case can be compared. {conditions}"
            )),
        ),
        (
            "accept",
            texts(
                "Checks with the values up to which a run that did not pass them is part of the data set all the same, such as \
                 \"largest_overlap < 0.05\".",
            ),
        ),
        (
            "keep",
            choice(
                "What stays of finished runs. folders: their folders; dataset: their rows in the data set, and the folder of a run goes \
                 once these are on the disk.",
                &["folders", "dataset"],
            ),
        ),
        (
            "engine",
            described(
                "The engine that carries out the tests: granum, or lammps, which must be installed.",
                json!({ "type": "string" }),
            ),
        ),
        (
            "ranks",
            count(
                "With engine = \"lammps\": number of processes of each test, started as mpirun -np N lmp.",
                1,
                MOST_RANKS,
            ),
        ),
        (
            "command",
            text(
                "With engine = \"lammps\": the command that starts it, such as \"mpirun -np 4 lmp\"; words are separated by spaces.",
            ),
        ),
    ]
}

fn design() -> Value {
    let designs: String =
        super::design::ALL.iter().map(|design| format!("{}: {}; ", design.name, design.help)).collect();
    let kinds = format!("{designs}list: the rows of the plan; csv: the rows of a CSV file.");
    let row =
        json!({ "type": "object", "additionalProperties": { "type": ["number", "string", "boolean"] } });
    let mut schema = object(
        "Which points of the space of the variables are run.",
        vec![
            ("kind", described(&kinds, json!({ "enum": super::read_design::kinds() }))),
            (
                "points",
                count(
                    "Number of points of a Sobol sequence or a Latin hypercube.",
                    1,
                    super::design::MOST_POINTS as u64,
                ),
            ),
            ("seed", count("Seed of a design that is drawn; 1 by default.", 0, u64::from(u32::MAX))),
            (
                "replicates",
                count("Runs of each point, which differ in preparation.seed; 1 by default.", 1, 1000),
            ),
            (
                "sample_seeds",
                choice(
                    "same: all points have the same seeds, so that differences between them are those of the variables alone; different: \
                     no two runs have the same seed.",
                    &["same", "different"],
                ),
            ),
            (
                "rows",
                described(
                    "The points of a design of kind list: values by the names of variables.",
                    json!({ "type": "array", "items": row, "minItems": 1 }),
                ),
            ),
            ("file", text("The CSV file of a design of kind csv, whose first line names the variables.")),
        ],
    );
    schema["required"] = json!(["kind"]);
    schema
}

fn variable_keys() -> Vec<Key> {
    let set = object(
        "A value that sets several keys.",
        vec![
            ("name", text("Its name, by which tables and rows know it.")),
            ("set", keys_of_case("The keys of the case that it sets.")),
        ],
    );
    let value = json!({ "anyOf": [{ "type": ["number", "string", "boolean"] }, set] });
    vec![
        (
            "name",
            described(
                "By which expressions, constraints and tables know it; by default the last part of its key.",
                json!({ "type": "string", "pattern": "^[A-Za-z_][A-Za-z0-9_]*$" }),
            ),
        ),
        (
            "key",
            text("The key of the case that takes its value; path stands for the named path of the test."),
        ),
        ("keys", texts("Several keys with one value.")),
        ("from", quantity("The lower end of a range.")),
        ("to", quantity("The upper end of a range.")),
        (
            "scale",
            choice(
                "linear: equal differences are equally likely; log: equal ratios are.",
                &["linear", "log"],
            ),
        ),
        (
            "stage",
            choice(
                "With key = \"path\". kept: parameters that the base case gives to its stage stay where the new path has them; new: the path \
                 has those alone that the plan gives.",
                &["kept", "new"],
            ),
        ),
        ("levels", count("Number of values of a range in a full factorial design.", 2, 1000)),
        (
            "values",
            described(
                "The values that it can take: numbers, quantities, words, or tables that set several keys.",
                json!({ "type": "array", "items": value, "minItems": 1 }),
            ),
        ),
        (
            "expression",
            text("An expression of other variables and of numbers of the base case, in SI units."),
        ),
        ("step", quantity("Numbers are rounded to its multiples.")),
    ]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::read::PLAN_KEYS;
    use super::super::read_design::DESIGN_KEYS;
    use super::super::read_variables::VARIABLE_KEYS;
    use super::*;

    /// The schema has exactly the keys that the reader knows.
    #[test]
    fn the_schema_has_the_keys_of_the_reader() {
        let schema = Plan::schema();
        let keys = |place: &Value| -> BTreeSet<String> {
            place["properties"].as_object().unwrap().keys().cloned().collect()
        };
        let known = |keys: &[&str]| -> BTreeSet<String> { keys.iter().map(ToString::to_string).collect() };
        assert_eq!(keys(&schema), known(&PLAN_KEYS));
        assert_eq!(keys(&schema["properties"]["design"]), known(&DESIGN_KEYS));
        assert_eq!(keys(&schema["properties"]["variable"]["items"]), known(&VARIABLE_KEYS));
    }
}
