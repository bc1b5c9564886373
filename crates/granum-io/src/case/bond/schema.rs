//! The keys of bonds for editors.

use granum_dem::contact::choice::registry::Laws;
use serde_json::{Map, Value, json};

use super::keys::{KEYS, KeyKind};

/// The schema of a table `[[bond]]`: its keys, and those of all laws.
pub(in crate::case) fn schema(laws: &Laws) -> Value {
    let mut keys = Map::new();
    for key in KEYS {
        let mut schema = match key.kind {
            KeyKind::Number(..) => json!({ "type": ["number", "string"] }),
            KeyKind::Count(least) => json!({ "type": "integer", "minimum": least }),
            KeyKind::Word(words) => {
                json!({ "enum": words.iter().map(|[word, _]| *word).collect::<Vec<_>>() })
            }
            KeyKind::Law => json!({ "enum": laws.bonds().iter().map(|law| law.name()).collect::<Vec<_>>() }),
        };
        schema["description"] = json!(help_of(key.help, key.kind, laws));
        if let Some(default) = key.default {
            schema["default"] =
                default.parse::<f64>().map_or_else(|_| json!(default), |number| json!(number));
        }
        keys.insert(key.key.into(), schema);
    }
    for law in laws.bonds() {
        for parameter in law.law().description().parameters {
            let help = json!({ "description": parameter.meaning, "type": ["number", "string"] });
            keys.entry(parameter.key.to_string()).or_insert(help);
        }
    }
    json!({
        "description": "A set of bonds that is made before a stage.",
        "type": "object",
        "additionalProperties": false,
        "properties": keys,
    })
}

fn help_of(help: &str, kind: KeyKind, laws: &Laws) -> String {
    let options: Vec<String> = match kind {
        KeyKind::Word(words) => words.iter().map(|[word, meaning]| format!("{word}: {meaning}")).collect(),
        KeyKind::Law => laws
            .bonds()
            .iter()
            .map(|law| format!("{}: {}", law.name(), law.law().description().help))
            .collect(),
        _ => return help.to_string(),
    };
    format!("{help} {}", options.join("; "))
}
