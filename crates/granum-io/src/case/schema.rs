//! The JSON schema of a case file, generated from the lists of its keys.

use granum_dem::loading::Measure;
use granum_dem::loading::preset::{self, PathParameter, PathParameterDefault, PathParameterKind};
use granum_dem::servo::COMPONENTS;
use serde_json::{Map, Value, json};

use super::bond;
use super::definition::Case;
use super::field::Field;
use super::fields::{Fields, SECTIONS};
use super::material::{BETWEEN, NAME, SHARE};
use super::shape::{self, FILE, OF_TABLE};
use super::stage::bounds;
use super::stage_control::STAGE_KEYS;
use super::stage_read::DRIVER_KEYS;
use super::stage_values::OTHER_ENDS;
use super::vocabulary::Vocabulary;

impl Case {
    /// The JSON schema (draft 2020-12) of a case file, for editors: every key with its meaning, bounds and default.
    pub fn schema() -> Value {
        Case::schema_with(&Vocabulary::standard())
    }

    /// The same with the contact laws and paths of a program.
    pub fn schema_with(vocabulary: &Vocabulary) -> Value {
        let fields = Fields::new(vocabulary);
        let mut root = object("A granum case: all inputs that determine a result.", Map::new());
        for [section, help] in SECTIONS {
            let mut keys = Map::new();
            for field in fields.iter().filter(|field| field.section == *section) {
                keys.insert(field.key.into(), of_field(field));
            }
            let mut place = &mut root;
            let (outer, last) = section.rsplit_once('.').unwrap_or(("", section));
            for name in outer.split('.').filter(|name| !name.is_empty()) {
                place = &mut place["properties"][name];
            }
            place["properties"][last] = object(help, keys);
        }
        add_shapes(&mut root, &fields);
        root["properties"]["material"] = json!({
            "description": "Several materials; keys that one leaves out are taken from [grains.material] and \
                            [contact].",
            "type": "array",
            "items": material(&fields),
        });
        root["properties"]["pair"] = json!({
            "description": "Values for a pair of materials, instead of those computed from the two.",
            "type": "array",
            "items": pair(&fields),
        });
        root["properties"]["bond"] = json!({
            "description": "Bonds between grains, as of cement, or inside of them.",
            "type": "array",
            "items": bond::schema(vocabulary.laws()),
        });
        root["properties"]["preparation"]["properties"]["stage"] = json!({
            "description": "Loading paths between the compaction of the sample and its relaxation; they record nothing and \
                            start where the one before ended.",
            "type": "array",
            "items": { "$ref": "#/$defs/stage" },
        });
        root["properties"]["stage"] = json!({
            "description": "The test as a sequence of stages, instead of the section [shear].",
            "type": "array",
            "items": { "$ref": "#/$defs/stage" },
        });
        let kinds = vocabulary.paths().all().iter().map(|path| of_path(path)).chain([
            repetition(),
            incremental_driver(),
            written_out(),
        ]);
        root["$defs"] = json!({ "stage": { "anyOf": kinds.collect::<Vec<_>>() } });
        root["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
        root["title"] = json!("granum case");
        root
    }
}

/// The section `[grains.shape]` has a file, and there may be tables of it.
fn add_shapes(root: &mut Value, fields: &Fields) {
    let place = &mut root["properties"]["grains"]["properties"]["shape"];
    let file = json!({ "description": FILE[1], "type": "string" });
    place["properties"][FILE[0]] = file.clone();
    let mut keys: Map<String, Value> = shape::fields(fields).map(|field| without_default(&field)).collect();
    keys.insert(FILE[0].into(), file);
    for [key, help] in OF_TABLE {
        let kind = if key == "material" { json!("string") } else { json!(["number", "string"]) };
        keys.insert(key.into(), json!({ "description": help, "type": kind }));
    }
    place["type"] = json!(["object", "array"]);
    place["items"] = object("One of several shapes.", keys);
}

fn object(help: &str, properties: Map<String, Value>) -> Value {
    json!({ "description": help, "type": "object", "additionalProperties": false, "properties": properties })
}

/// A quantity is a number in SI units or a text with a unit.
fn quantity(help: &str, bounds: &str, unit: &str) -> Value {
    let unit =
        if unit.is_empty() || unit == "1" { String::new() } else { format!(", or a number in {unit}") };
    json!({ "description": format!("{help} ({bounds}{unit})"), "type": ["number", "string"] })
}

fn of_field(field: &Field) -> Value {
    let mut schema = match field.words() {
        _ if field.is_curve() => {
            let point = json!({ "type": "array", "items": { "type": ["number", "string"] }, "minItems": 2, "maxItems": 2 });
            json!({ "anyOf": [{ "type": "array", "items": point }, { "type": "string" }], "description": field.help })
        }
        _ if field.is_spheres() => {
            let sphere =
                json!({ "type": "array", "items": { "type": "number" }, "minItems": 4, "maxItems": 4 });
            json!({ "anyOf": [{ "type": "array", "items": sphere }, { "enum": ["none"] }], "description": field.help })
        }
        _ if field.is_list() => {
            let items = json!({ "type": if field.is_names() { json!("string") } else { json!(["number", "string"]) } });
            let list = json!({ "type": "array", "items": items });
            let words: Vec<&str> = field.words().iter().map(|[word, _]| *word).collect();
            json!({ "anyOf": [list, { "enum": words }], "description": field.help })
        }
        words if field.is_choice() => {
            let names: Vec<&str> = words.iter().map(|[name, _]| *name).collect();
            let meanings: Vec<String> =
                words.iter().map(|[name, meaning]| format!("{name}: {meaning}")).collect();
            json!({ "description": format!("{} {}", field.help, meanings.join("; ")), "enum": names })
        }
        _ => quantity(&field.help, &field.bounds_text(), &field.si_unit()),
    };
    schema["default"] =
        field.example.parse::<f64>().map_or_else(|_| json!(field.example), |number| json!(number));
    schema
}

/// A field in a table that may leave it out, without the default of its section.
fn without_default(field: &Field) -> (String, Value) {
    let mut schema = of_field(field);
    if let Some(map) = schema.as_object_mut() {
        map.remove("default");
    }
    (field.key.to_string(), schema)
}

/// A table `[[material]]`.
fn material(fields: &Fields) -> Value {
    let fields = super::material::fields(fields);
    let mut keys: Map<String, Value> = fields.map(|field| without_default(&field)).collect();
    let name = json!({ "description": NAME, "type": "string", "pattern": "^[A-Za-z0-9_-]+$" });
    keys.insert("name".into(), name);
    keys.insert("share".into(), json!({ "description": SHARE, "type": ["number", "string"] }));
    let mut schema = object("A material.", keys);
    schema["required"] = json!(["name"]);
    schema
}

/// A table `[[pair]]`.
fn pair(fields: &Fields) -> Value {
    let fields = super::material::pair_fields(fields);
    let mut keys: Map<String, Value> = fields.map(|field| without_default(&field)).collect();
    let names = json!({ "type": "array", "items": { "type": "string" }, "minItems": 2, "maxItems": 2 });
    keys.insert("between".into(), names);
    keys["between"]["description"] = json!(BETWEEN);
    let mut schema = object("Values for a pair of materials.", keys);
    schema["required"] = json!(["between"]);
    schema
}

fn of_parameter(parameter: &PathParameter) -> Value {
    let mut schema = match parameter.kind {
        PathParameterKind::Number => quantity(parameter.help, &bounds(parameter), parameter.unit),
        PathParameterKind::Word(words) => {
            let names: Vec<&str> = words.iter().map(|[word, _]| *word).collect();
            let meanings: Vec<String> =
                words.iter().map(|[word, meaning]| format!("{word}: {meaning}")).collect();
            json!({ "description": format!("{} {}", parameter.help, meanings.join("; ")), "enum": names })
        }
        PathParameterKind::List => {
            let items = json!({ "type": ["number", "string"] });
            json!({ "description": parameter.help, "type": "array", "items": items })
        }
        PathParameterKind::History => json!({ "description": parameter.help, "type": "string" }),
    };
    match parameter.default {
        PathParameterDefault::Value(value) => schema["default"] = json!(value),
        PathParameterDefault::Word(word) => schema["default"] = json!(word),
        PathParameterDefault::List(values) => schema["default"] = json!(values),
        PathParameterDefault::Needed => {}
        PathParameterDefault::Absent(meaning) => {
            let text = schema["description"].as_str().unwrap_or_default().to_string();
            schema["description"] = json!(format!("{text} If left out: {meaning}."));
        }
    }
    schema
}

fn of_path(preset: &preset::Preset) -> Value {
    let mut keys = Map::new();
    keys.insert("path".into(), json!({ "const": preset.name, "description": preset.help }));
    keys.extend(preset.parameters().map(|parameter| (parameter.key.to_string(), of_parameter(parameter))));
    keys.insert(
        "resets".into(),
        json!({ "type": "boolean", "description": "False if strain, time and energy continue to count from an earlier stage.", "default": true }),
    );
    let until = json!({ "type": "object", "description": "End conditions in addition to those of the path, as a stage with an explicit control has them, where the path has one stage that is driven, e.g. { mean_stress = \"10 kPa\" }." });
    keys.insert("until".into(), until);
    if preset.parameters().any(|parameter| parameter.kind == PathParameterKind::History) {
        let columns =
            json!({ "type": "array", "description": "Names of the columns, if the case contains the rows." });
        let rows = json!({ "type": "array", "items": { "type": "array" }, "description": "The rows, instead of a file." });
        keys.extend([("columns".to_string(), columns), ("rows".to_string(), rows)]);
    }
    let mut schema = object(preset.help, keys);
    schema["required"] = json!(["path"]);
    schema
}

/// A stage that repeats others.
fn repetition() -> Value {
    let times = json!({ "type": "integer", "minimum": 1, "description": "Number of repetitions." });
    let stages = json!({ "type": "array", "items": { "$ref": "#/$defs/stage" }, "description": "The repeated stages." });
    let keys = [("repeat".to_string(), times), ("stage".to_string(), stages)];
    let mut schema = object("A sequence of stages that is repeated.", Map::from_iter(keys));
    schema["required"] = json!(["stage"]);
    schema
}

/// The steps of a file of the IncrementalDriver.
fn incremental_driver() -> Value {
    let key = |[key, help]: &[&str; 2]| {
        ((*key).to_string(), json!({ "type": ["number", "string"], "description": help }))
    };
    let mut schema = object("The steps of an IncrementalDriver file.", DRIVER_KEYS.iter().map(key).collect());
    schema["required"] = json!(["incremental_driver", "stress_unit"]);
    schema
}

/// A stage with an explicit control: the kinds of its keys.
fn written_out() -> Value {
    let number = json!({ "type": ["number", "string"] });
    let names: Vec<&str> = Measure::ALL.iter().map(|(name, _, _)| *name).collect();
    let mut ends: Map<String, Value> =
        names.iter().map(|name| ((*name).to_string(), number.clone())).collect();
    ends.insert("reversals".into(), json!({ "type": "integer", "minimum": 1 }));
    for key in OTHER_ENDS {
        ends.entry(*key).or_insert_with(|| number.clone());
    }
    ends.insert("ramp_over".into(), json!({ "type": "boolean" }));
    ends.insert("double_amplitude".into(), json!({ "type": "object" }));
    ends.insert("critical_state".into(), json!({ "type": "object" }));
    let kind = |key: &str| match key {
        "name" => json!({ "type": "string" }),
        "settling" | "resets" => json!({ "type": "boolean" }),
        "start" => json!({ "enum": ["here", "kept", "back"] }),
        "kinematics" => json!({ "enum": ["pure-shear", "simple-shear"] }),
        "constraint" => json!({ "type": "array", "items": { "type": "object" }, "maxItems": 6 }),
        "turns" | "record" => {
            json!({ "type": "object", "properties": { "measure": { "enum": names } } })
        }
        "until" => object("", ends.clone()),
        key if COMPONENTS.contains(&key) => {
            let keys = ["rate", "stress", "stress_rate", "strain_to", "strain_by", "stress_to", "stress_by"];
            let keys = keys.map(|key| (key.to_string(), number.clone()));
            json!({ "anyOf": [{ "enum": ["fixed", "free"] }, object("", Map::from_iter(keys))] })
        }
        _ => number.clone(),
    };
    let keys = STAGE_KEYS.iter().map(|[key, help]| {
        let mut schema = kind(key);
        schema["description"] = json!(help);
        ((*key).to_string(), schema)
    });
    // No key must be there: a stage with a ramp ends with it where nothing else is said.
    object("A stage with an explicit control.", Map::from_iter(keys))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The schema contains exactly the keys that the reader accepts.
    #[test]
    fn every_key_of_the_case_and_of_every_path_is_in_the_schema() {
        let schema = Case::schema();
        for field in Fields::standard().iter() {
            let place = field.path().replace('.', "/properties/");
            let found = schema.pointer(&format!("/properties/{place}"));
            assert!(found.is_some_and(|found| found["description"].is_string()), "{}", field.path());
        }
        for field in super::super::material::fields(&Fields::standard()) {
            let found = &schema["properties"]["material"]["items"]["properties"][field.key];
            assert!(found["description"].is_string() && found["default"].is_null(), "{}", field.key);
        }
        let stages = schema["$defs"]["stage"]["anyOf"].as_array().unwrap();
        for preset in preset::ALL {
            let found =
                stages.iter().find(|stage| stage["properties"]["path"]["const"] == preset.name).unwrap();
            for parameter in preset.parameters() {
                assert!(found["properties"][parameter.key].is_object(), "{}", parameter.key);
            }
        }
        let of_preparation = &schema["properties"]["preparation"]["properties"]["stage"];
        assert_eq!(of_preparation["items"], schema["properties"]["stage"]["items"]);
        let written_out = stages.last().unwrap();
        assert!(STAGE_KEYS.iter().all(|[key, _]| written_out["properties"][key].is_object()));
    }
}
